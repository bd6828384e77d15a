// The parameters of a drive.

import type { Parameter, ParameterName } from "./core.js";
import type { Link } from "./link.js";

/** A parameter by its name (case does not matter) or number. */
export type ParameterKey = ParameterName | number;

const DEVICE_NUMBER = 1;

/** Reads and writes parameters; values are in their units. Every call that sends a request to the drive
 * rejects with a `MasterError`, or with a `RangeError` that names parameter, value and range. */
export class Parameters {
    #link: Link;

    constructor(link: Link) {
        this.#link = link;
    }

    /** Properties of every parameter, by the drive's own description once it was read. */
    get rows(): readonly Parameter[] {
        return this.#link.tables.parameters;
    }

    /** Returns the properties of a parameter; `undefined` if it does not exist. */
    row(key: ParameterKey): Parameter | undefined {
        const folded = String(key).toLowerCase();
        return this.rows.find(({ number, name }) => number === key || name.toLowerCase() === folded);
    }

    /** Returns the parameters whose name, category or description contains the text; case does not matter. */
    find(text: string): Parameter[] {
        const folded = text.toLowerCase();
        return this.rows.filter(({ name, category, description }) =>
            `${name} ${category} ${description}`.toLowerCase().includes(folded),
        );
    }

    /** Returns the value as last received; `undefined` before. Sends no request. */
    known(key: ParameterKey): number | undefined {
        return this.#link.master.parameter(key);
    }

    /** Reads the value from the drive. */
    get(key: ParameterKey): Promise<number> {
        return this.#link.ask(() => this.#link.master.read(key));
    }

    /** Writes a value, rounded to the nearest step of its scale, and returns the value that the drive has
     * now. Rejects NaN, and a fraction for a parameter without decimals. */
    set(key: ParameterKey, value: number): Promise<number> {
        return this.#link.ask(() => this.#link.master.write(key, value));
    }

    /** Returns every parameter that can be written and is not a command, by name, for `load`. */
    async toObject(): Promise<Partial<Record<ParameterName, number>>> {
        const rows = this.rows.filter(({ access, command }) => access !== "read-only" && !command);
        const values = await Promise.all(rows.map(({ number }) => this.get(number)));
        return Object.fromEntries(rows.map(({ name }, at) => [name, values[at]]));
    }

    /** Writes the values that differ from the drive's; returns their names. All names and values are checked
     * before the first is written. The device number is not written. */
    async load(values: Partial<Record<ParameterName, number>>): Promise<ParameterName[]> {
        const wanted = Object.entries(values).map(([name, value]) => {
            const row = this.row(name as ParameterName);
            if (row === undefined) {
                throw new TypeError(`there is no parameter "${name}"`);
            }
            if (row.access === "read-only") {
                throw new TypeError(`parameter ${row.number} "${row.name}": read-only`);
            }
            const problem = misfit(row, value);
            if (problem !== undefined) {
                throw new RangeError(problem);
            }
            return { row, value };
        });
        const changed: ParameterName[] = [];
        for (const { row, value } of wanted) {
            const differs = Math.abs((await this.get(row.number)) - value) > row.scale / 2;
            if (differs && row.number !== DEVICE_NUMBER) {
                await this.set(row.number, value);
                changed.push(row.name);
            }
        }
        return changed;
    }

    /** Stores every parameter except the device number and the calibration in the drive's memory now. */
    async store(): Promise<void> {
        await this.#link.ask(() => this.#link.master.request("store"));
    }

    /** Stores the device number and the calibration (category 02). */
    async storeOnce(): Promise<void> {
        await this.#link.ask(() => this.#link.master.request("store once"));
    }

    /** Sets the calibration (category 02) to its factory values. */
    async resetCalibration(): Promise<void> {
        await this.#link.ask(() => this.#link.master.request("reset calibration"));
    }

    /** Stores factory values for everything except the device number and the calibration (category 02). It is
     * allowed at any time, also while driving. The values take effect at the next reboot. */
    async restoreFactory(): Promise<void> {
        // The drive checks the serial number of its power-up; parameter 1 may have been written since.
        await this.#link.ask(() => this.#link.master.request("device info"));
        const { device } = this.#link.master;
        if (device === undefined) {
            throw new Error("The drive does not report its device number.");
        }
        await this.#link.ask(() => this.#link.master.restoreFactory(device.deviceNumber));
    }
}

/** Returns the reason why a parameter cannot have a value, with its range; `undefined` if it can. */
export function misfit({ number, name, unit, scale, min, max }: Parameter, value: number): string | undefined {
    const [steps, space] = [value / scale, unit && ` ${unit}`];
    const inside = value >= min && value <= max;
    if (inside && (scale < 1 || Math.abs(steps - Math.round(steps)) < 1e-6)) {
        return undefined;
    }
    return `parameter ${number} "${name}": ${value}${space} is ${inside ? "not a whole number from" : "outside"} ${min} to ${max}${space}`;
}
