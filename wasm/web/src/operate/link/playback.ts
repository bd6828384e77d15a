// A bus log as a read-only link, played at its original speed, or at once.

import type { BusFrame } from "narx";
import type { Link, Listener } from "./link";

/** Number of frames that are passed on at once. */
const PIECE = 2000;

/** Plays frames whose times are in s. */
export function play(name: string, frames: readonly BusFrame[], listener: Listener): Link {
    let at = 0;
    let timer: ReturnType<typeof setTimeout>;
    let now = frames[0]?.time ?? 0;
    const turn = () => {
        const piece = frames.slice(at, at + PIECE);
        at += piece.length;
        now = piece.at(-1)?.time ?? now;
        listener.handle(now, piece);
        if (at < frames.length) {
            timer = setTimeout(turn, 0);
        }
    };
    timer = setTimeout(turn, 0);
    return {
        name: `Log ${name}`,
        readOnly: true,
        get now() {
            return now;
        },
        send: () => {},
        close: () => clearTimeout(timer),
    };
}
