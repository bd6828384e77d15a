// A bench with the journal of its inputs.

import { Bench, Motor, type BusFrame, type Trace } from "narx";
import { apply, type Input } from "narx/script";
import { ROW, type Action, type Now, type Rows, type Setup } from "./messages";
import type { Run } from "./run";

/** Ticks from one row to the next: 1 ms at 10 kHz. */
const STRIDE = 10;

export class JournalledBench {
    readonly setup: Setup;
    readonly bench: Bench;
    #inputs: Input[] = [];

    /** Throws where the setup cannot be. */
    constructor(setup: Setup) {
        const motor = Motor.preset(setup.motor);
        try {
            // The master on the page is the operator.
            this.bench = new Bench(motor, { ...setup.options, operator: false });
        } finally {
            motor.free();
        }
        this.setup = setup;
    }

    /** Throws where the bench refuses; then nothing has happened. */
    act(action: Action): void {
        const input = { ...action, tick: this.bench.ticks } as Input;
        apply(this.bench, input);
        this.#inputs.push(input);
    }

    /** Lets ticks pass: what has been heard and seen meanwhile. */
    advance(ticks: number): { rows: Rows; frames: BusFrame[] } {
        const { ticks: before, tickRate } = this.bench;
        const trace = this.bench.run(ticks / tickRate);
        const rows = thin(trace, before);
        trace.free();
        return { rows, frames: this.bench.takeFrames() };
    }

    now(pace: number): Now {
        return { time: this.bench.time, ticks: this.bench.ticks, pace };
    }

    /** All that decides what the drive has done so far. */
    run(): Run {
        return { setup: this.setup, inputs: this.#inputs, ticks: this.bench.ticks, digest: this.bench.digest };
    }

    free(): void {
        this.bench.free();
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
