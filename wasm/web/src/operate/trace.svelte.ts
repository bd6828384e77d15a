// The frames of the bus, in the order in which they passed.

import type { BusFrame } from "narx";

/** Largest number of frames that are kept; the oldest are removed. */
const KEPT = 100_000;
/** Number of frames that are removed at once. */
const DROPPED = 10_000;

class Trace {
    /** Increases with every change: effects that read `frames` depend on it. */
    version = $state(0);
    /** Not reactive: there are thousands of frames a second. */
    readonly frames: BusFrame[] = [];
    /** Number of removed frames. */
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
