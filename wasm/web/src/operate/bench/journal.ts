// A bench with the journal of its inputs, which can return to an instant of its run.

import type { Bench, BusFrame, Trace } from "narx";
import { apply, type Input } from "narx/script";
import { ROW, type Action, type Now, type Rows, type Setup } from "./messages";
import type { Run } from "./run";

/** A module with a bench: "narx" or "narx/full". */
export type Kit = Pick<typeof import("narx"), "Bench" | "Motor">;

/** Ticks from one row to the next: 1 ms at 10 kHz. */
const STRIDE = 10;
/** Copies of the bench that are kept at most, at first so many ticks apart: a copy holds the recording up to its instant, too. */
const [COPIES_MAX, COPIES_APART] = [12, 50_000];
/** What is run at once where nobody waits for its rows, ticks. */
const PIECE = 1_000_000;

interface Copy {
    bench: Bench;
    tick: number;
    /** Inputs that it has had. */
    applied: number;
}

export class JournalledBench {
    readonly setup: Setup;
    #kit: Kit;
    #bench: Bench;
    /** All of the run, also those that lie beyond an instant to which it has returned. */
    #inputs: Input[] = [];
    #applied = 0;
    /** The furthest tick of the run. */
    #end = 0;
    #copies: Copy[] = [];
    #apart = COPIES_APART;

    /** Throws where the setup cannot be. */
    constructor(setup: Setup, kit: Kit) {
        this.setup = setup;
        this.#kit = kit;
        this.#bench = this.#powered();
    }

    get bench(): Bench {
        return this.#bench;
    }

    /** Throws where the bench refuses; then nothing has happened. */
    act(action: Action): void {
        const input = { ...action, tick: this.#bench.ticks } as Input;
        apply(this.#bench, input);
        this.#forget();
        this.#inputs.push(input);
        this.#applied += 1;
    }

    /** Lets ticks pass: what has been heard and seen meanwhile. What came later in a run that has returned to an instant is forgotten. */
    advance(ticks: number): { rows: Rows; frames: BusFrame[] } {
        if (ticks > 0) {
            this.#forget();
            this.#keep();
        }
        const seen = this.#see(ticks);
        this.#end = Math.max(this.#end, this.#bench.ticks);
        return seen;
    }

    /** Returns to an instant of the run, and tells what was heard and seen in the `before` ticks before it. */
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

    /** All that decides what the drive has done so far. */
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
        const rows = thin(trace, before);
        trace.free();
        return { rows, frames: this.#bench.takeFrames() };
    }

    /** Up to `tick`, with the inputs of the journal at their ticks; `run` lets ticks pass. */
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

    /** The run goes another way from here on. */
    #forget(): void {
        const now = this.#bench.ticks;
        if (this.#applied < this.#inputs.length || now < this.#end) {
            this.#inputs.length = this.#applied;
            this.#end = now;
            this.#copies.filter(({ tick }) => tick > now).forEach(({ bench }) => bench.free());
            this.#copies = this.#copies.filter(({ tick }) => tick <= now);
        }
    }

    /** Keeps a copy now and then; the longer the run, the further apart. */
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

/** Rows at whole milliseconds, wherever the pieces of a run begin. */
function thin(trace: Trace, before: number): Rows {
    const first = (STRIDE - (before % STRIDE)) % STRIDE;
    const every = <T extends Float32Array | Float64Array>(column: T) => column.filter((_, row) => (row - first) % STRIDE === 0) as T;
    const rows = { time: every(trace.time) } as Rows;
    for (const name of ROW) {
        rows[name] = every(trace.column(name)) as Float32Array;
    }
    return rows;
}

/** Rows one after another. */
function joined(pieces: readonly Rows[]): Rows {
    const rows = { time: Float64Array.from(pieces.flatMap(({ time }) => [...time])) } as Rows;
    for (const name of ROW) {
        rows[name] = Float32Array.from(pieces.flatMap((piece) => [...piece[name]]));
    }
    return rows;
}
