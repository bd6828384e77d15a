// The last frames of the bus, in the order in which they passed.

import type { BusFrame } from "narx";
import { flagsOf, restored } from "./bench/frames";

/** Largest number of frames that are kept; newer ones replace the oldest. */
const KEPT = 100_000;

class Trace {
    /** Increases with every change: effects that read the frames depend on it. */
    version = $state(0);
    // Columns instead of objects, which would take 30 times the memory: a frame here has 21 bytes.
    readonly #time = new Float64Array(KEPT);
    readonly #id = new Uint32Array(KEPT);
    readonly #flags = new Uint8Array(KEPT);
    readonly #data = new Uint8Array(8 * KEPT);
    /** Number of frames so far, removed ones included. */
    #total = 0;
    /** Number of those until the instant that is shown. */
    #shown = 0;

    /** Number of frames until the instant that is shown. */
    get total(): number {
        return this.#shown;
    }

    /** Number of removed frames: that of the first that is kept. */
    get dropped(): number {
        return Math.min(this.#shown, Math.max(0, this.#total - KEPT));
    }

    /** Shows the frames until an instant, s. Later ones are kept until the next frame comes. */
    show(time: number): void {
        let [from, to] = [Math.max(0, this.#total - KEPT), this.#total];
        while (from < to) {
            const middle = (from + to) >> 1;
            [from, to] = this.#time[middle % KEPT] <= time ? [middle + 1, to] : [from, middle];
        }
        this.#shown = from;
        this.version += 1;
    }

    append(frames: readonly BusFrame[]): void {
        this.#total = this.#shown;
        for (const frame of frames) {
            const at = this.#total % KEPT;
            this.#time[at] = frame.time;
            this.#id[at] = frame.id;
            this.#flags[at] = flagsOf(frame);
            this.#data.set(frame.data, 8 * at);
            this.#total += 1;
        }
        this.#shown = this.#total;
        this.version += frames.length > 0 ? 1 : 0;
    }

    /** Returns a frame that is kept, by its number since the beginning. */
    frame(number: number): BusFrame {
        const at = number % KEPT;
        return restored(this.#time[at], this.#id[at], this.#flags[at], this.#data.slice(8 * at, 8 * at + 8));
    }

    /** Returns the frames that are kept, oldest first. */
    *frames(): Generator<BusFrame> {
        for (let number = this.dropped; number < this.#shown; number += 1) {
            yield this.frame(number);
        }
    }

    clear(): void {
        this.#total = this.#shown = 0;
        this.version += 1;
    }
}

export const trace = new Trace();
