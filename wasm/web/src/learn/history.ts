// The control ticks that a chapter keeps. Pictures are drawn from them, of the newest tick or an earlier one.

import { KEPT, type Kept, type Row, type Rows } from "./messages";

/** Number of rows that are kept: three seconds at 10 kHz. */
const CAPACITY = 30_000;

const INDEX = Object.fromEntries(KEPT.map((name, index) => [name, index])) as Record<Kept, number>;

/** A state of the drive, and the time at which it was entered, s. */
export interface Entered {
    state: number;
    time: number;
}

/** Reads a signal of the present row, or of the row `before` rows earlier. */
export type Read = (name: Kept, before?: number) => number;

/** Returns the mean of a signal over this row and those before it: of a signal that swings faster than rows are
 * read, single rows show another curve. */
export function mean(name: Kept, rows: number): (read: Read) => number {
    return (read) => {
        let sum = 0;
        for (let before = 0; before < rows; before++) {
            sum += read(name, before);
        }
        return sum / rows;
    };
}

export class History {
    #columns = KEPT.map(() => new Float64Array(CAPACITY));
    /** Number of all rows that were appended. */
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
        // A row has the step at the beginning of its period, but voltages and currents at its end.
        // Commutations within the period show only in the next row, so its step is used.
        const steps = this.#columns[INDEX.step];
        for (let row = Math.max(1, this.#appended); row < this.#appended + count; row++) {
            steps[(row - 1) % CAPACITY] = steps[row % CAPACITY];
        }
        this.#appended += count;
    }

    /** Returns the states up to the row `age` before the newest one, oldest first. */
    entered(age: number): Entered[] {
        return this.#entered.filter(({ row }) => row <= this.#appended - 1 - age);
    }

    /** Number of rows that are kept. */
    get length(): number {
        return Math.min(this.#appended, CAPACITY);
    }

    /** Returns a signal `age` rows before the newest one. */
    at(age: number, name: Kept): number {
        return this.#columns[INDEX[name]][(this.#appended - 1 - age) % CAPACITY];
    }

    /** Returns all signals of a row. */
    row(age: number): Row {
        return Object.fromEntries(KEPT.map((name) => [name, this.at(age, name)])) as Row;
    }

    /** Returns the values of each function in `count` rows that end `age` rows before the newest, every
     * `stride`th of them, oldest first. */
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
