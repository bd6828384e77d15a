// Plots as one picture.

import { colour } from "../theme.svelte";
import type { Curve } from "./Chart.svelte";

/** Height of a caption, CSS px. */
const CAPTION = 24;

interface Lane {
    unit: string;
    curves: readonly Curve[];
}

/** Returns the open plots below an element as a PNG, each below the names of its curves in their colours. */
export async function picture(place: HTMLElement, lanes: readonly Lane[]): Promise<Blob> {
    const plots = [...place.querySelectorAll("canvas")].map((canvas, index) => ({ canvas, lane: lanes[index] })).filter(({ canvas }) => canvas.checkVisibility());
    const caption = CAPTION * devicePixelRatio;
    const width = Math.max(1, ...plots.map(({ canvas }) => canvas.width));
    const drawn = new OffscreenCanvas(width, Math.max(1, plots.reduce((sum, { canvas }) => sum + canvas.height + caption, 0)));
    const context = drawn.getContext("2d")!;
    context.fillStyle = colour("--panel");
    context.fillRect(0, 0, drawn.width, drawn.height);
    context.font = `${13 * devicePixelRatio}px system-ui`;
    context.textBaseline = "middle";
    let top = 0;
    for (const { canvas, lane } of plots) {
        let left = 8 * devicePixelRatio;
        for (const { label, colour: name } of lane.curves) {
            const text = `${label}${lane.unit && `, ${lane.unit}`}`;
            context.fillStyle = colour(name);
            context.fillText(text, left, top + caption / 2);
            left += context.measureText(text).width + 16 * devicePixelRatio;
        }
        context.drawImage(canvas, 0, top + caption);
        top += canvas.height + caption;
    }
    return drawn.convertToBlob({ type: "image/png" });
}
