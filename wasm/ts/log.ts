// The external log memory of a drive: records of chosen values, written periodically.

import {
    logRecords,
    type LogRecord,
    type MeasurementName,
    type ParameterName,
    type Progress,
} from "./core.js";
import type { Link } from "./link.js";
import { Parameters } from "./parameters.js";
import type { Tables } from "./description.js";
import type { Table } from "./table.js";

const [SLOT_FIRST, SLOT_LAST, NOTHING] = [29, 65, 0xffff];
const [RECORD_BYTES, INDEX_MAX, WRITE_INDEX, PERIOD, FULL] = [69, 70, 71, 72, 77];
const SIGNAL_FIRST = 0x2000;

/** Kind of the kept value of a slot: the present one, or one over the time since the previous record. */
export type Keep = "live" | "min" | "max" | "mean";
const KEEP: readonly Keep[] = ["live", "min", "max", "mean"];

/** Names that a slot can have. */
export type LogName = MeasurementName | ParameterName;

interface What {
    readonly number: number;
    readonly unit: string;
    readonly scale: number;
}

/** Returns, by name, the number in a slot, the unit, and the value of a raw 1. A measurement that is also a
 * parameter of the same name has two numbers for the same value; slots use that of the measurement. */
function what({ parameters, measurements }: Tables): Map<string, What> {
    const rows = parameters.map(({ name, number, unit, scale }) => [name, { number, unit, scale }] as const);
    const signals = measurements.map(
        ({ name, opcode, word, unit, scale }) => [name, { number: SIGNAL_FIRST + 4 * opcode + word, unit, scale }] as const,
    );
    return new Map<string, What>([...rows, ...signals]);
}

/** Returns the name of every number, including the parameter numbers of values that are also measurements. */
function names(tables: Tables): Map<number, string> {
    const known = [...what(tables)].map(([name, { number }]) => [number, name] as const);
    return new Map([...tables.parameters.map(({ number, name }) => [number, name] as const), ...known]);
}

/** Sets up, reads and erases the log. */
export class Log {
    #link: Link;
    #parameters: Parameters;

    constructor(link: Link) {
        this.#link = link;
        this.#parameters = new Parameters(link);
    }

    /** Returns the number of records in the memory. */
    length(): Promise<number> {
        return this.#parameters.get(WRITE_INDEX);
    }

    /** Returns the number of records that the memory can hold; 0 without a memory. */
    capacity(): Promise<number> {
        return this.#parameters.get(INDEX_MAX);
    }

    /** Returns whether the memory is full: nothing more is written until it is erased. */
    async full(): Promise<boolean> {
        return (await this.#parameters.get(FULL)) !== 0;
    }

    /** Logging state (Table 8) of the last STATUS_WORD. */
    get state(): string {
        return String(this.#link.master.status?.["Logging state"] ?? "unknown");
    }

    /** Returns the logged values. */
    async slots(): Promise<Partial<Record<LogName, Keep>>> {
        const known = names(this.#link.tables);
        const found: Record<string, Keep> = {};
        for (let number = SLOT_FIRST; number <= SLOT_LAST; number++) {
            const slot = await this.#parameters.get(number);
            if ((slot & 0xffff) !== NOTHING) {
                found[known.get(slot & 0xffff) ?? `parameter ${slot & 0xffff}`] = KEEP[(slot >> 16) & 3]!;
            }
        }
        return found;
    }

    /** Selects the logged values (up to 37), and the period of the records in seconds, 0.001 to 3600.
     * `parameters.store` stores the settings. */
    async configure(values: readonly LogName[] | Partial<Record<LogName, Keep>>, period: number): Promise<void> {
        const chosen = Array.isArray(values) ? values.map((name) => [name, "live"] as const) : Object.entries(values);
        const known = what(this.#link.tables);
        const slots = chosen.map(([name, keep]) => {
            const found = [...known].find(([other]) => other.toLowerCase() === name.toLowerCase())?.[1];
            if (found === undefined) {
                throw new TypeError(`there is no parameter or measurement "${name}"`);
            }
            const kind = KEEP.indexOf(keep as Keep);
            if (kind < 0) {
                throw new TypeError(`kept value "${keep}": must be one of ${KEEP.join(", ")}`);
            }
            return found.number + kind * 0x10000;
        });
        const count = SLOT_LAST + 1 - SLOT_FIRST;
        if (slots.length > count) {
            throw new RangeError(`values: ${slots.length} exceed the ${count} slots of the log`);
        }
        await this.#parameters.set(PERIOD, period * 1000);
        for (let at = 0; at < count; at++) {
            await this.#parameters.set(SLOT_FIRST + at, slots[at] ?? NOTHING);
        }
    }

    /** Downloads the records from index `first` on, to the last one or `count` of them: `time` in s since
     * power-up, `index`, and the values. A value that a record does not have is NaN; a record that the drive
     * cannot read any more is left out. */
    async download(first = 0, count?: number, progress?: (progress: Progress) => void): Promise<Table> {
        const length = await this.length();
        const records = count ?? Math.max(length - first, 0);
        if (!(first >= 0 && records >= 0 && first + records <= length)) {
            throw new RangeError(`records ${first} to ${first + records}: the log has ${length} records`);
        }
        if (records === 0) {
            return table([], this.#link.tables);
        }
        const size = await this.#parameters.get(RECORD_BYTES);
        const bytes = await this.#link.download(() => this.#link.master.download("log", records, first), progress);
        return table(logRecords(bytes, size), this.#link.tables);
    }

    /** Erases every record; refused while driving. With `wait`, resolves when that is done, which takes
     * minutes for a full memory. */
    async erase(wait = true): Promise<void> {
        await (wait ? this.#link.record("erase log") : this.#link.ask(() => this.#link.master.request("erase log")));
    }
}

function table(records: LogRecord[], tables: Tables): Table {
    const known = names(tables);
    const worth = what(tables);
    const columns: Record<string, Float64Array> = { index: Float64Array.from(records, ({ index }) => index) };
    const units: Record<string, string> = { index: "" };
    records.forEach(({ values }, row) => {
        for (const [slot, raw] of values) {
            const name = known.get(slot & 0x3fff) ?? `parameter ${slot & 0x3fff}`;
            const keep = KEEP[slot >> 14]!;
            const { unit, scale } = worth.get(name) ?? { unit: "", scale: 1 };
            const label = keep === "live" ? name : `${name} ${keep}`;
            const column = (columns[label] ??= new Float64Array(records.length).fill(NaN));
            units[label] ??= unit;
            column[row] = raw * scale;
        }
    });
    return { time: Float64Array.from(records, ({ time }) => time), columns, units };
}
