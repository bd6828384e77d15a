// The control ticks that a chapter remembers: pictures are drawn from them, the newest or an earlier one.

import { KEPT, type Kept, type Row, type Rows } from "./messages";

/** Three seconds of simulated time. */
const CAPACITY = 30_000;

const INDEX = Object.fromEntries(KEPT.map((name, index) => [name, index])) as Record<Kept, number>;

/** A state of the drive, and when it was entered, s. */
export interface Entered {
    state: number;
    time: number;
}

/** Reads a signal of the row in question, or of so many rows before it. */
export type Read = (name: Kept, before?: number) => number;

export class History {
    #columns = KEPT.map(() => new Float64Array(CAPACITY));
    /** Rows ever appended. */
    #appended = 0;
    /** Every change of the drive's state, with the number of its row. */
    #entered: (Entered & { row: number })[] = [];

    clear(): void {
        this.#appended = 0;
        this.#entered = [];
    }

    append(rows: Rows): void {
        const count = rows[0].length;
        for (const [column, values] of rows.entries()) {
            for (let row = 0; row < count; row++) {
                this.#columns[column][(this.#appended + row) % CAPACITY] = values[row];
            }
        }
        const [times, states] = [rows[INDEX.time], rows[INDEX.state]];
        for (let row = 0; row < count; row++) {
            if (states[row] !== this.#entered.at(-1)?.state) {
                this.#entered.push({ state: states[row], time: times[row], row: this.#appended + row });
            }
        }
        // A row tells the step at the beginning of its period, and voltages and currents at its end: commutations between are told by the next one.
        const steps = this.#columns[INDEX.step];
        for (let row = Math.max(1, this.#appended); row < this.#appended + count; row++) {
            steps[(row - 1) % CAPACITY] = steps[row % CAPACITY];
        }
        this.#appended += count;
    }

    /** The states up to the row `age` before the newest one, oldest first. */
    entered(age: number): Entered[] {
        return this.#entered.filter(({ row }) => row <= this.#appended - 1 - age);
    }

    /** Rows that are kept. */
    get length(): number {
        return Math.min(this.#appended, CAPACITY);
    }

    /** A signal `age` rows before the newest one. */
    at(age: number, name: Kept): number {
        return this.#columns[INDEX[name]][(this.#appended - 1 - age) % CAPACITY];
    }

    /** All signals of a row. */
    row(age: number): Row {
        return Object.fromEntries(KEPT.map((name) => [name, this.at(age, name)])) as Row;
    }

    /** What each function reads in `count` rows that end `age` rows before the newest, every `stride`th of them, oldest first. */
    window(reads: ((read: Read) => number)[], count: number, age: number, stride = 1): number[][] {
        const oldest = Math.min(age + count, this.length) - 1;
        const found = reads.map((): number[] => []);
        let here = oldest;
        const read: Read = (name, before = 0) => this.at(Math.min(here + before, this.length - 1), name);
        for (; here >= age; here -= stride) {
            for (const [index, value] of reads.entries()) {
                found[index].push(value(read));
            }
        }
        return found;
    }
}
