// A bus log as a read-only link, played at its own speed or another.

import type { BusFrame } from "narx";
import type { Timed } from "../timed";
import type { Link, Listener } from "./link";

/** Time between two turns, ms. */
const PERIOD = 20;
/** Length of the log that a new master receives before an earlier instant, s: that of the rolling plots. */
const BEFORE = 8;

const PACES = [
    [0.1, "1/10"],
    [1, "real time"],
    [10, "10 times"],
    [100, "100 times"],
] as const;

export class Playback implements Link, Timed {
    readonly name: string;
    readonly readOnly = true;
    readonly paces = PACES;
    /** Times of the first and of the last frame, s. */
    readonly begin: number;
    readonly end: number;
    now = $state(0);
    /** Seconds of the log in a second. */
    pace = $state(1);
    playing = $state(true);
    readonly #frames: readonly BusFrame[];
    readonly #listener: Listener;
    readonly #timer: ReturnType<typeof setInterval>;
    /** Number of frames that were passed on. */
    #passed = 0;
    #before = performance.now();

    /** Plays frames whose times are in s. */
    constructor(name: string, frames: readonly BusFrame[], listener: Listener) {
        this.name = `Log ${name}`;
        this.#frames = frames;
        this.#listener = listener;
        this.begin = frames[0]?.time ?? 0;
        this.end = frames.at(-1)?.time ?? 0;
        this.now = this.begin;
        this.#timer = setInterval(() => this.#turn(), PERIOD);
    }

    send(): void {}

    play(playing: boolean): void {
        this.playing = playing;
    }

    setPace(pace: number): void {
        this.pace = pace;
    }

    close(): void {
        clearInterval(this.#timer);
    }

    /** Goes to an instant of the log. */
    seek(time: number): void {
        if (time >= this.now) {
            return this.#advance(time);
        }
        this.now = time;
        this.#passed = this.#count(time);
        this.#listener.handleReturn(time, this.#frames.slice(this.#count(time - BEFORE), this.#passed));
    }

    #turn(): void {
        const now = performance.now();
        const elapsed = (now - this.#before) / 1000;
        this.#before = now;
        if (this.playing && this.now < this.end) {
            this.#advance(Math.min(this.now + elapsed * this.pace, this.end));
        }
    }

    #advance(time: number): void {
        const first = this.#passed;
        this.now = time;
        this.#passed = this.#count(time);
        this.#listener.handle(time, this.#frames.slice(first, this.#passed));
    }

    /** Returns the number of frames up to an instant. */
    #count(time: number): number {
        const later = this.#frames.findIndex((frame) => frame.time > time);
        return later < 0 ? this.#frames.length : later;
    }
}
