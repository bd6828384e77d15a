// Frames in the text format of can-utils (`candump -L`).

import type { BusFrame } from "narx";

/** Name of the interface in the lines, which a page does not have. */
const INTERFACE = "can0";

/** Returns a line for each frame. */
export function candump(frames: Iterable<BusFrame>): string {
    return Array.from(frames, (frame) => `${line(frame)}\n`).join("");
}

/** Returns ID#DATA of a frame. */
export function compact({ id, extended, remote, data }: BusFrame): string {
    const number = id.toString(16).toUpperCase().padStart(extended ? 8 : 3, "0");
    return `${number}#${remote ? `R${data.length}` : hex(data)}`;
}

export function hex(data: Uint8Array, between = ""): string {
    return Array.from(data, (byte) => byte.toString(16).toUpperCase().padStart(2, "0")).join(between);
}

function line(frame: BusFrame): string {
    return `(${frame.time.toFixed(6).padStart(17, "0")}) ${INTERFACE} ${compact(frame)}`;
}
