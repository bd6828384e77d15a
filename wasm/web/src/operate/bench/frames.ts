// Frames as columns, for messages between the worker and the page: copies of thousands of small objects take
// longer, and leave more to collect, than the frames' processing.

import type { BusFrame } from "narx";

export interface Frames {
    time: Float64Array;
    id: Uint32Array;
    flags: Uint8Array;
    /** Eight bytes for each frame. */
    data: Uint8Array;
}

const [EXTENDED, REMOTE, SENT, LENGTH] = [1, 2, 4, 4];

/** Returns everything of a frame but time, identifier and data; length included. */
export function flagsOf({ extended, remote, sent, data }: BusFrame): number {
    return (extended ? EXTENDED : 0) | (remote ? REMOTE : 0) | (sent ? SENT : 0) | (data.length << LENGTH);
}

/** Returns the frame with such flags; `data` has eight bytes. */
export function restored(time: number, id: number, flags: number, data: Uint8Array): BusFrame {
    return {
        time,
        id,
        extended: (flags & EXTENDED) !== 0,
        remote: (flags & REMOTE) !== 0,
        sent: (flags & SENT) !== 0,
        data: data.subarray(0, flags >> LENGTH),
    };
}

export function pack(frames: readonly BusFrame[]): Frames {
    const data = new Uint8Array(8 * frames.length);
    frames.forEach((frame, at) => data.set(frame.data, 8 * at));
    return {
        time: Float64Array.from(frames, ({ time }) => time),
        id: Uint32Array.from(frames, ({ id }) => id),
        flags: Uint8Array.from(frames, flagsOf),
        data,
    };
}

export function unpack({ time, id, flags, data }: Frames): BusFrame[] {
    return Array.from(time, (time, at) => restored(time, id[at], flags[at], data.subarray(8 * at, 8 * at + 8)));
}
