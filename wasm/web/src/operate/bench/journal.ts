// A bench with a journal of its inputs, which can return to an earlier instant of its run.

import type { Bench, BusFrame, Trace } from "narx";
import { apply, type Input } from "narx/script";
import { ROW, type Action, type Now, type Rows, type Setup } from "./messages";
import type { Run } from "./run";

/** A module with a bench: "narx" or "narx/full". */
export type Kit = Pick<typeof import("narx"), "Bench" | "Motor">;

/** Rows a second, at most. */
const ROWS = 1000;
/** Largest number of copies of the bench, and their first distance in ticks. Copies are expensive: each holds
 * the recording up to its instant. */
const [COPIES_MAX, COPIES_APART] = [12, 50_000];
/** Longest run at once if its rows are not needed, ticks. */
const PIECE = 1_000_000;

interface Copy {
    bench: Bench;
    tick: number;
    /** Number of inputs that it has had. */
    applied: number;
}

export class JournalledBench {
    readonly setup: Setup;
    #kit: Kit;
    #bench: Bench;
    /** All inputs of the run, including those after an instant to which it has returned. */
    #inputs: Input[] = [];
    #applied = 0;
    /** The furthest tick of the run. */
    #end = 0;
    #copies: Copy[] = [];
    #apart = COPIES_APART;

    /** Throws for an invalid set-up. */
    constructor(setup: Setup, kit: Kit) {
        this.setup = setup;
        this.#kit = kit;
        this.#bench = this.#powered();
    }

    get bench(): Bench {
        return this.#bench;
    }

    /** Carries out an action and records it. Throws if the bench refuses it; it is then not recorded. */
    act(action: Action): void {
        const input = { ...action, tick: this.#bench.ticks } as Input;
        apply(this.#bench, input);
        this.#forget();
        this.#inputs.push(input);
        this.#applied += 1;
    }

    /** Runs the bench for some ticks; returns new rows and frames. If the run had returned to an instant, its
     * later inputs are removed. */
    advance(ticks: number): { rows: Rows; frames: BusFrame[] } {
        if (ticks > 0) {
            this.#forget();
            this.#keep();
        }
        const seen = this.#see(ticks);
        this.#end = Math.max(this.#end, this.#bench.ticks);
        return seen;
    }

    /** Returns to an instant of the run; returns the rows and frames of the `before` ticks before it. */
    seek(tick: number, before: number): { rows: Rows; frames: BusFrame[] } {
        const instant = Math.min(Math.max(tick, 0), this.#end);
        const first = Math.max(instant - before, 0);
        const copy = this.#copies.findLast((copy) => copy.tick <= first);
        this.#bench.free();
        [this.#bench, this.#applied] = copy ? [copy.bench.copy(), copy.applied] : [this.#powered(), 0];
        this.#repeat(first, (ticks) => this.#bench.run(ticks / this.#bench.tickRate, false).free());
        this.#bench.takeFrames();
        const seen: { rows: Rows; frames: BusFrame[] }[] = [];
        this.#repeat(instant, (ticks) => seen.push(this.#see(ticks)));
        return { rows: joined(seen.map(({ rows }) => rows)), frames: seen.flatMap(({ frames }) => frames) };
    }

    now(pace: number): Now {
        return { time: this.#bench.time, ticks: this.#bench.ticks, end: this.#end, pace };
    }

    /** Returns everything that determines the run so far. */
    run(): Run {
        return { setup: this.setup, inputs: this.#inputs.slice(0, this.#applied), ticks: this.#bench.ticks, digest: this.#bench.digest };
    }

    free(): void {
        this.#bench.free();
        this.#copies.splice(0).forEach(({ bench }) => bench.free());
    }

    #powered(): Bench {
        const motor = this.#kit.Motor.preset(this.setup.motor);
        try {
            // The master on the page is the operator.
            return new this.#kit.Bench(motor, { ...this.setup.options, operator: false });
        } finally {
            motor.free();
        }
    }

    #see(ticks: number): { rows: Rows; frames: BusFrame[] } {
        const { ticks: before, tickRate } = this.#bench;
        const trace = this.#bench.run(ticks / tickRate);
        const rows = thin(trace, before, Math.ceil(tickRate / ROWS));
        trace.free();
        return { rows, frames: this.#bench.takeFrames() };
    }

    /** Runs up to `tick`, with the inputs of the journal at their ticks; `run` runs the bench for some
     * ticks. */
    #repeat(tick: number, run: (ticks: number) => void): void {
        for (;;) {
            while ((this.#inputs[this.#applied]?.tick ?? Infinity) <= this.#bench.ticks) {
                apply(this.#bench, this.#inputs[this.#applied]);
                this.#applied += 1;
            }
            const next = Math.min(tick, this.#inputs[this.#applied]?.tick ?? tick, this.#bench.ticks + PIECE);
            if (next <= this.#bench.ticks) {
                return;
            }
            run(next - this.#bench.ticks);
        }
    }

    /** Removes later inputs and copies: the run continues differently from here. */
    #forget(): void {
        const now = this.#bench.ticks;
        if (this.#applied < this.#inputs.length || now < this.#end) {
            this.#inputs.length = this.#applied;
            this.#end = now;
            this.#copies.filter(({ tick }) => tick > now).forEach(({ bench }) => bench.free());
            this.#copies = this.#copies.filter(({ tick }) => tick <= now);
        }
    }

    /** Makes a copy from time to time; the longer the run, the greater their distance. */
    #keep(): void {
        const tick = this.#bench.ticks;
        if (tick < (this.#copies.at(-1)?.tick ?? 0) + this.#apart) {
            return;
        }
        this.#copies.push({ bench: this.#bench.copy(), tick, applied: this.#applied });
        if (this.#copies.length > COPIES_MAX) {
            this.#apart *= 2;
            this.#copies.filter((_, index) => index % 2 === 0).forEach(({ bench }) => bench.free());
            this.#copies = this.#copies.filter((_, index) => index % 2 === 1);
        }
    }
}

/** Selects the rows of each `stride`-th tick of the run, whatever the beginning of this piece of it. */
function thin(trace: Trace, before: number, stride: number): Rows {
    const first = (stride - (before % stride)) % stride;
    const every = <T extends Float32Array | Float64Array>(column: T) => column.filter((_, row) => (row - first) % stride === 0) as T;
    const rows = { time: every(trace.time) } as Rows;
    for (const name of ROW) {
        rows[name] = every(trace.column(name)) as Float32Array;
    }
    return rows;
}

/** Joins rows. */
function joined(pieces: readonly Rows[]): Rows {
    const rows = { time: Float64Array.from(pieces.flatMap(({ time }) => [...time])) } as Rows;
    for (const name of ROW) {
        rows[name] = Float32Array.from(pieces.flatMap((piece) => [...piece[name]]));
    }
    return rows;
}
