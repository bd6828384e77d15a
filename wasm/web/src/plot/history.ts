// Columns of signals over a run of any length, in bounded memory.

import type { Table } from "narx/drive";
import type uPlot from "uplot";
import { Pulse } from "./pulse.svelte";
import { firstAt, thinned } from "./rows";

/** Largest number of rows. */
const ROWS = 65_536;

export class History {
    readonly #time = new Float64Array(ROWS);
    readonly #columns = new Map<string, Float32Array>();
    #length = 0;
    readonly #pulse = new Pulse();

    /** Names of the columns. */
    get names(): readonly string[] {
        return [...this.#columns.keys()];
    }

    get length(): number {
        return this.#length;
    }

    /** Time of the first row and of the last, s; 0 without rows. Its effect runs a few times a second. */
    get begin(): number {
        this.#pulse.read();
        return this.#length > 0 ? this.#time[0] : 0;
    }

    get end(): number {
        this.#pulse.read();
        return this.#length > 0 ? this.#time[this.#length - 1] : 0;
    }

    /** Appends rows of ascending times. Rows that are not earlier than the first are removed before. Signals
     * that are not given get NaN. */
    append(time: ArrayLike<number>, columns: Readonly<Record<string, ArrayLike<number>>>): void {
        if (time.length === 0) {
            return;
        }
        this.cut(time[0]);
        for (const name of Object.keys(columns)) {
            if (!this.#columns.has(name)) {
                this.#columns.set(name, new Float32Array(ROWS).fill(NaN));
            }
        }
        for (let row = 0; row < time.length; row += 1) {
            if (this.#length === ROWS) {
                this.#thin();
            }
            this.#time[this.#length] = time[row];
            for (const [name, column] of this.#columns) {
                column[this.#length] = columns[name]?.[row] ?? NaN;
            }
            this.#length += 1;
        }
        this.#pulse.change();
    }

    /** Removes the rows that are not earlier than an instant. */
    cut(time: number): void {
        if (this.#length > 0 && this.#time[this.#length - 1] >= time) {
            this.#length = this.#first(time);
            this.#pulse.change();
        }
    }

    clear(): void {
        this.#length = 0;
        this.#columns.clear();
        this.#pulse.change();
    }

    /** Returns time and columns between two instants for a plot. Of many rows it returns those with the
     * smallest and the largest value of each column in each of `points` equal pieces. */
    window(names: readonly string[], from: number, to: number, points: number): uPlot.AlignedData {
        this.#pulse.read();
        const columns = names.map((name) => this.#columns.get(name));
        // One more row on each side, so that curves reach the edges.
        const [first, last] = [Math.max(this.#first(from) - 1, 0), Math.min(this.#first(to) + 1, this.#length)];
        return thinned(this.#time, columns, first, last, points);
    }

    /** Returns the rows between two instants as they were kept. */
    table(names: readonly string[], units: Readonly<Record<string, string>>, from: number, to: number): Table {
        const [first, last] = [this.#first(from), this.#first(to)];
        const columns = names.map((name) => [name, Float64Array.from(this.#columns.get(name)?.subarray(first, last) ?? [])]);
        return { time: this.#time.slice(first, last), columns: Object.fromEntries(columns), units } as Table;
    }

    /** Returns the value of a signal at an instant: that of the last row that is not later. */
    at(name: string, time: number): number {
        this.#pulse.read();
        const row = this.#first(time + 1e-9) - 1;
        return row < 0 ? NaN : (this.#columns.get(name)?.[row] ?? NaN);
    }

    #first(instant: number): number {
        return firstAt(this.#time, instant, this.#length);
    }

    /** Removes every second row of the older half. */
    #thin(): void {
        const half = ROWS / 2;
        for (const column of [this.#time, ...this.#columns.values()]) {
            for (let row = 0; row < half / 2; row += 1) {
                column[row] = column[2 * row];
            }
            column.copyWithin(half / 2, half);
        }
        this.#length -= half / 2;
    }
}
