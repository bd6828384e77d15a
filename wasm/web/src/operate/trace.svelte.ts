// The frames of the bus, as they passed.

import type { BusFrame } from "narx";

/** Frames that are kept; the oldest go first. */
const KEPT = 200_000;
/** Frames that are thrown away at once. */
const DROPPED = 20_000;

class Trace {
    /** Counts up with every change: what is drawn from `frames` depends on it. */
    version = $state(0);
    /** Not reactive: thousands come in a second. */
    readonly frames: BusFrame[] = [];
    /** Frames that were forgotten. */
    dropped = 0;

    append(frames: readonly BusFrame[]): void {
        if (frames.length === 0) {
            return;
        }
        for (const frame of frames) {
            this.frames.push(frame);
        }
        if (this.frames.length > KEPT) {
            this.frames.splice(0, DROPPED);
            this.dropped += DROPPED;
        }
        this.version += 1;
    }

    clear(): void {
        this.frames.length = 0;
        this.dropped = 0;
        this.version += 1;
    }
}

export const trace = new Trace();
