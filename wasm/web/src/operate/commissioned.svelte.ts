// The values of a drive's commissioning, with which its present values are compared.

import type { View } from "./view";

/** Number of the parameter "Device number", by which the values of real drives are kept. */
const DEVICE_NUMBER = 1;
const PREFIX = "narx-commissioned-";
/** Time between two looks at what was read, ms. */
const LOOK = 250;

class Commissioned {
    /** Values by number, in the units of the parameters. */
    values = $state.raw<ReadonlyMap<number, number>>(new Map());
    /** Day on which the user has kept the values; absent for those that were read first. */
    kept = $state<string>();
    #looked = -Infinity;
    #complete = false;

    /** Takes each value that the drive reports for the first time, but not those of an identification. Values of
     * real drives that this browser has kept come before them. */
    look({ parameters, parameter, toRead, connected, identifies }: View, real: boolean): void {
        const now = performance.now();
        if (this.#complete || !connected || identifies || now < this.#looked + LOOK) {
            return;
        }
        this.#looked = now;
        const device = parameter(DEVICE_NUMBER);
        if (device === undefined) {
            return;
        }
        const kept = real ? load(device) : undefined;
        if (kept) {
            [this.values, this.kept, this.#complete] = [new Map(kept.values), kept.day, true];
            return;
        }
        const found = new Map(this.values);
        for (const { number } of parameters) {
            const value = found.has(number) ? undefined : parameter(number);
            if (value !== undefined) {
                found.set(number, value);
            }
        }
        if (found.size > this.values.size) {
            this.values = found;
        }
        this.#complete = toRead === 0;
    }

    /** Makes the present values those of the commissioning; of a real drive they are kept in this browser. */
    keep({ parameters, parameter }: View, real: boolean): void {
        this.values = new Map(parameters.flatMap(({ number }) => ((value) => (value === undefined ? [] : [[number, value] as const]))(parameter(number))));
        [this.kept, this.#complete] = [new Date().toISOString().slice(0, 10), true];
        const device = parameter(DEVICE_NUMBER);
        if (real && device !== undefined) {
            save(device, { day: this.kept, values: [...this.values] });
        }
    }

    clear(): void {
        [this.values, this.kept, this.#looked, this.#complete] = [new Map(), undefined, -Infinity, false];
    }
}

interface Kept {
    day: string;
    values: [number, number][];
}

function load(device: number): Kept | undefined {
    try {
        return JSON.parse(localStorage.getItem(PREFIX + device) ?? "null") ?? undefined;
    } catch {
        return undefined;
    }
}

function save(device: number, kept: Kept): void {
    try {
        localStorage.setItem(PREFIX + device, JSON.stringify(kept));
    } catch {
        // A browser without storage: they are known until the connection ends.
    }
}

export const commissioned = new Commissioned();
