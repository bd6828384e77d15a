// A bench with a journal of its inputs, which can return to an earlier instant of its run.

import type { Bench, BusFrame, Trace } from "narx";
import { apply, type Input } from "narx/script";
import { ROW, TRUTH, type Acting, type Action, type Now, type Rows, type Setup, type Truth } from "./messages";
import type { Run } from "./run";

/** A module with a bench: "narx" or "narx/full". */
export type Kit = Pick<typeof import("narx"), "Bench" | "Motor">;

/** Rows a second, at most. */
const ROWS = 1000;
/** Largest number of copies of the bench, and their first distance in ticks. */
const [COPIES_MAX, COPIES_APART] = [12, 50_000];
/** Inputs that change load and faults. */
const CHANGES: ReadonlySet<Input["call"]> = new Set(["setLoad", "inject", "clear"]);
/** Longest run at once if its rows are not needed, ticks: requests are handled in between. */
const PIECE = 50_000;

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
    /** Places among the inputs of those that change load and faults; most inputs are frames. */
    #changes: number[] = [];
    #applied = 0;
    /** The furthest tick of the run. */
    #end = 0;
    #copies: Copy[] = [];
    #apart = COPIES_APART;

    /** Throws for an invalid set-up. With a run, `skip` and `seek` repeat it. */
    constructor(setup: Setup, kit: Kit, run?: Run) {
        this.setup = setup;
        this.#kit = kit;
        // Without a recording: it grows by 50 KB in a second, in every copy of the bench.
        this.#bench = this.#powered(false);
        run?.inputs.forEach((input) => this.#note(input));
        this.#end = run?.ticks ?? 0;
    }

    get bench(): Bench {
        return this.#bench;
    }

    /** Carries out an action and records it. Throws if the bench refuses it; it is then not recorded. */
    act(action: Action): void {
        if (action.call !== "dismiss") {
            this.#takeOver();
        }
        const input = { ...action, tick: this.#bench.ticks } as Input;
        apply(this.#bench, input);
        this.#forget();
        this.#note(input);
        this.#applied += 1;
    }

    #note(input: Input): void {
        if (CHANGES.has(input.call)) {
            this.#changes.push(this.#inputs.length);
        }
        this.#inputs.push(input);
    }

    /** Runs the bench for some ticks; returns new rows and frames. If the run had returned to an instant, its
     * later inputs are removed. */
    advance(ticks: number): { rows: Rows; frames: BusFrame[] } {
        if (ticks > 0) {
            this.#forget();
            this.#takeOver();
            this.#keep();
        }
        const seen = this.#see(ticks);
        this.#end = Math.max(this.#end, this.#bench.ticks);
        return seen;
    }

    /** Repeats a piece of the run, at most up to a tick; returns its frames. */
    skip(tick: number): BusFrame[] {
        this.#repeat(Math.min(tick, this.#bench.ticks + PIECE), (ticks) => this.#bench.run(ticks / this.#bench.tickRate, false).free());
        this.#keep();
        return this.#bench.takeFrames();
    }

    /** Returns to an instant of the run; returns the rows and frames of the `before` ticks before it. */
    seek(tick: number, before: number): { rows: Rows; frames: BusFrame[] } {
        const instant = Math.min(Math.max(tick, 0), this.#end);
        const first = Math.max(instant - before, 0);
        const copy = this.#copies.findLast((copy) => copy.tick <= first);
        this.#bench.free();
        [this.#bench, this.#applied] = copy ? [copy.bench.copy(), copy.applied] : [this.#powered(false), 0];
        this.#repeat(first, (ticks) => this.#bench.run(ticks / this.#bench.tickRate, false).free());
        this.#bench.takeFrames();
        const seen: { rows: Rows; frames: BusFrame[] }[] = [];
        this.#repeat(instant, (ticks) => seen.push(this.#see(ticks)));
        return { rows: joined(seen.map(({ rows }) => rows)), frames: seen.flatMap(({ frames }) => frames) };
    }

    now(pace: number): Now {
        const truth = Object.fromEntries(TRUTH.map((name) => [name, this.#bench.value(name)])) as Truth;
        return { time: this.#bench.time, ticks: this.#bench.ticks, end: this.#end, pace, truth, acting: this.#acting() };
    }

    #acting(): Acting {
        const acting: Acting = { load: this.setup.options.load ?? {}, faults: [] };
        for (const place of this.#changes) {
            const input = this.#inputs[place];
            if (place >= this.#applied) {
                break;
            }
            if (input.call === "setLoad") {
                acting.load = input.load;
            } else if (input.call === "inject") {
                acting.faults.push(input.fault);
            } else if (input.call === "clear") {
                acting.faults = acting.faults.filter((fault) => input.fault !== undefined && fault !== input.fault);
            }
        }
        return acting;
    }

    /** Returns everything that determines the run so far. */
    async run(): Promise<Run> {
        const [inputs, ticks] = [this.#inputs.slice(0, this.#applied), this.#bench.ticks];
        return { setup: this.setup, inputs, ticks, digest: await this.#recorded(({ digest }) => digest) };
    }

    /** Returns the recording of the drive since it last booted. */
    recording(): Promise<Uint8Array> {
        return this.#recorded((bench) => bench.recording());
    }

    free(): void {
        this.#bench.free();
        this.#copies.splice(0).forEach(({ bench }) => bench.free());
    }

    /** Runs the run so far again, with a recording. */
    async #recorded<T>(result: (bench: Bench) => T): Promise<T> {
        const [bench, inputs, end] = [this.#powered(true), this.#inputs.slice(0, this.#applied), this.#bench.ticks];
        try {
            let applied = 0;
            do {
                applied = repeat(bench, inputs, applied, Math.min(end, bench.ticks + PIECE), (ticks) => bench.run(ticks / bench.tickRate, false).free());
                bench.takeFrames();
                await new Promise((resolve) => setTimeout(resolve));
            } while (bench.ticks < end);
            return result(bench);
        } finally {
            bench.free();
        }
    }

    #powered(recording: boolean): Bench {
        const { motor: chosen, options } = this.setup;
        const motor = typeof chosen === "string" ? this.#kit.Motor.preset(chosen) : new this.#kit.Motor(chosen);
        try {
            return new this.#kit.Bench(motor, { ...options, operator: options.operator ?? false, frames: true, recording });
        } finally {
            motor.free();
        }
    }

    /** Dismisses the bench's own operator, if it has one, before anything new: from here the master on the page
     * commands. */
    #takeOver(): void {
        if (this.setup.options.operator) {
            const dismissed = this.#inputs.findIndex(({ call }) => call === "dismiss");
            if (dismissed < 0 || dismissed >= this.#applied) {
                this.act({ call: "dismiss" });
            }
        }
    }

    #see(ticks: number): { rows: Rows; frames: BusFrame[] } {
        const { ticks: before, tickRate } = this.#bench;
        const trace = this.#bench.run(ticks / tickRate);
        const rows = thin(trace, before, Math.ceil(tickRate / ROWS));
        trace.free();
        return { rows, frames: this.#bench.takeFrames() };
    }

    /** Runs up to `tick`, with the inputs of the journal. */
    #repeat(tick: number, run: (ticks: number) => void): void {
        this.#applied = repeat(this.#bench, this.#inputs, this.#applied, tick, run);
    }

    /** Removes later inputs and copies: the run continues differently from here. */
    #forget(): void {
        const now = this.#bench.ticks;
        if (this.#applied < this.#inputs.length || now < this.#end) {
            this.#inputs.length = this.#applied;
            this.#changes = this.#changes.filter((place) => place < this.#applied);
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

/** Runs a bench up to `tick`, with the inputs at their ticks, and returns the number of inputs that it has had.
 * `applied`: the number before; `run` runs the bench for some ticks. */
function repeat(bench: Bench, inputs: readonly Input[], applied: number, tick: number, run: (ticks: number) => void): number {
    for (;;) {
        while ((inputs[applied]?.tick ?? Infinity) <= bench.ticks) {
            apply(bench, inputs[applied]);
            applied += 1;
        }
        const next = Math.min(tick, inputs[applied]?.tick ?? tick);
        if (next <= bench.ticks) {
            return applied;
        }
        run(next - bench.ticks);
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
