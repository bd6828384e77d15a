// Speed and set-point over the last seconds.

import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { colour } from "../theme.svelte";
import type { Rows } from "./messages";

/** Seconds in view. */
const VIEW = 6;

export class Plot {
    #chart: uPlot;
    #time: number[] = [];
    #speed: number[] = [];
    #setpoint: number[] = [];
    #place: HTMLElement;

    constructor(place: HTMLElement) {
        this.#place = place;
        this.#chart = this.#draw();
        new ResizeObserver(() => this.#chart.setSize(this.#size())).observe(place);
    }

    /** In the colours of now. */
    redraw(): void {
        this.#chart.destroy();
        this.#chart = this.#draw();
    }

    clear(): void {
        this.#time = [];
        this.#speed = [];
        this.#setpoint = [];
    }

    append({ time, speed, setpoint }: Rows): void {
        this.#time.push(...time);
        this.#speed.push(...speed);
        this.#setpoint.push(...setpoint);
        const oldest = (this.#time.at(-1) ?? 0) - VIEW;
        const kept = this.#time.findIndex((t) => t >= oldest);
        for (const column of [this.#time, this.#speed, this.#setpoint]) {
            column.splice(0, kept);
        }
    }

    /** Draws what was appended. */
    show(): void {
        this.#chart.setData([this.#time, this.#speed, this.#setpoint], false);
        const end = Math.max(this.#time.at(-1) ?? 0, VIEW);
        this.#chart.setScale("x", { min: end - VIEW, max: end });
    }

    #size(): { width: number; height: number } {
        return { width: this.#place.clientWidth, height: 320 };
    }

    #draw(): uPlot {
        const line = { stroke: colour("--line") };
        const axis = { stroke: colour("--text"), grid: line, ticks: line };
        return new uPlot(
            {
                ...this.#size(),
                legend: { live: false },
                cursor: { show: false },
                scales: { x: { time: false, auto: false }, y: { range: bounds } },
                axes: [
                    { ...axis, label: "simulated time, s" },
                    { ...axis, label: "rpm", size: 64 },
                ],
                series: [
                    {},
                    { label: "speed", stroke: colour("--speed"), width: 2, points: { show: false } },
                    { label: "set-point", stroke: colour("--setpoint"), width: 2, dash: [6, 4], points: { show: false } },
                ],
            },
            [this.#time, this.#speed, this.#setpoint],
            this.#place,
        );
    }
}

/** Zero is always in view, and a resting motor does not fill the picture with its noise. */
function bounds(_: uPlot, min: number, max: number): uPlot.Range.MinMax {
    return [Math.min(0, 1.1 * min), Math.max(100, 1.1 * max)];
}
