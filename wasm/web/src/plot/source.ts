// Signals that plots show: those of the connected drive as they come, or the columns of a file.

import type { Table } from "narx/drive";
import type uPlot from "uplot";
import { firstAt, thinned } from "./rows";

export interface Signal {
    /** Name of its column. */
    key: string;
    /** Plain name. */
    name: string;
    unit: string;
    group?: string;
    /** Name in the manual. */
    manual?: string;
    dashed?: boolean;
    /** True if each value holds until the next. */
    stepped?: boolean;
    /** Names of its values. */
    names?: ReadonlyMap<number, string>;
    /** Zero and this value are always in view, so that noise at rest does not fill the picture. */
    atLeast?: number;
}

/** An event of the run. */
export interface Event {
    time: number;
    text: string;
    tone: "state" | "fault" | "command";
}

export interface Source {
    readonly signals: readonly Signal[];
    /** Time range of the data, s. */
    readonly begin: number;
    readonly end: number;
    /** True if `end` moves on. */
    readonly live: boolean;
    readonly events: readonly Event[];
    /** Returns time and columns between two instants, with at most a few rows for each of `points`. */
    window(keys: readonly string[], from: number, to: number, points: number): uPlot.AlignedData;
    /** Returns the value of a signal at an instant: that of the last row that is not later; NaN without one. */
    at(key: string, time: number): number;
    /** Returns every row between two instants. */
    table(keys: readonly string[], from: number, to: number): Table;
}

/** A table of a file or a download as a source. */
export class TableSource implements Source {
    readonly signals: readonly Signal[];
    readonly begin: number;
    readonly end: number;
    readonly live = false;
    readonly events: readonly Event[];
    readonly #table: Table;

    /** `title` returns the plain name of a column. */
    constructor(table: Table, events: readonly Event[], title: (key: string) => string) {
        this.#table = table;
        this.events = events;
        this.signals = Object.keys(table.columns).map((key) => ({ key, name: title(key), unit: table.units[key] ?? "", manual: title(key) === key ? undefined : key }));
        this.begin = table.time[0] ?? 0;
        this.end = table.time.at(-1) ?? 0;
    }

    window(keys: readonly string[], from: number, to: number, points: number): uPlot.AlignedData {
        const { time, columns } = this.#table;
        const [first, last] = [Math.max(firstAt(time, from) - 1, 0), Math.min(firstAt(time, to) + 1, time.length)];
        return thinned(time, keys.map((key) => columns[key]), first, last, points);
    }

    at(key: string, instant: number): number {
        return this.#table.columns[key]?.[rowAt(this.#table.time, instant)] ?? NaN;
    }

    table(keys: readonly string[], from: number, to: number): Table {
        const { time, columns, units } = this.#table;
        const [first, last] = [firstAt(time, from), rowAt(time, to) + 1];
        return { time: time.slice(first, last), columns: Object.fromEntries(keys.map((key) => [key, columns[key]?.slice(first, last)])), units };
    }
}

/** Returns the last row that is not later than an instant, or the first. */
export function rowAt(time: ArrayLike<number>, instant: number): number {
    return Math.max(0, firstAt(time, instant + 1e-9) - 1);
}
