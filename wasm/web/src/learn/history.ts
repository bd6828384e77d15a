// The control ticks that a chapter remembers: pictures are drawn from them, the newest or an earlier one.

import { KEPT, type Kept, type Row, type Rows } from "./messages";

/** Three seconds of simulated time. */
const CAPACITY = 30_000;

const INDEX = Object.fromEntries(KEPT.map((name, index) => [name, index])) as Record<Kept, number>;

/** Reads a signal of the row in question. */
export type Read = (name: Kept) => number;

export class History {
    #columns = KEPT.map(() => new Float64Array(CAPACITY));
    /** Rows ever appended. */
    #appended = 0;

    clear(): void {
        this.#appended = 0;
    }

    append(rows: Rows): void {
        const count = rows[0].length;
        for (const [column, values] of rows.entries()) {
            for (let row = 0; row < count; row++) {
                this.#columns[column][(this.#appended + row) % CAPACITY] = values[row];
            }
        }
        this.#appended += count;
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
        const read: Read = (name) => this.at(here, name);
        for (; here >= age; here -= stride) {
            for (const [index, value] of reads.entries()) {
                found[index].push(value(read));
            }
        }
        return found;
    }
}
