// Columns of the last seconds, for rolling plots.

import type uPlot from "uplot";

/** Seconds in view. */
const VIEW = 8;

export class Rolling {
    readonly #columns = new Map<string, number[]>();
    readonly #seconds: number;
    #version = $state(0);
    #drawn = true;

    /** Keeps the last `seconds`. */
    constructor(seconds = VIEW) {
        this.#seconds = seconds;
    }

    /** Appends rows; one of the columns is "time". Rows that are older than the kept seconds are removed. If
     * time goes back, all earlier rows are removed. */
    append(rows: Readonly<Record<string, ArrayLike<number>>>): void {
        const time = this.#column("time");
        const first = rows.time[0];
        if (first !== undefined && first < (time.at(-1) ?? -Infinity)) {
            this.clear();
        }
        for (const [name, values] of Object.entries(rows)) {
            const column = this.#column(name);
            for (let row = 0; row < values.length; row += 1) {
                column.push(values[row]);
            }
        }
        const oldest = (time.at(-1) ?? 0) - this.#seconds;
        // Not at every row, because moving the rest costs more than keeping a few old rows.
        if (time.length > 0 && time[0] < oldest - this.#seconds / 4) {
            const kept = time.findIndex((t) => t >= oldest);
            for (const column of this.#columns.values()) {
                column.splice(0, kept);
            }
        }
        this.#draw();
    }

    clear(): void {
        for (const column of this.#columns.values()) {
            column.length = 0;
        }
        this.#draw();
    }

    /** Returns the columns of these names, for a plot; its effect runs at most once a picture. */
    data(names: readonly string[]): uPlot.AlignedData {
        void this.#version;
        return names.map((name) => this.#column(name)) as unknown as uPlot.AlignedData;
    }

    /** Time range of the last seconds. */
    get view(): { min: number; max: number } {
        void this.#version;
        const max = Math.max(this.#column("time").at(-1) ?? 0, this.#seconds);
        return { min: max - this.#seconds, max };
    }

    #column(name: string): number[] {
        const found = this.#columns.get(name) ?? [];
        this.#columns.set(name, found);
        return found;
    }

    #draw(): void {
        if (this.#drawn) {
            this.#drawn = false;
            requestAnimationFrame(() => {
                this.#drawn = true;
                this.#version += 1;
            });
        }
    }
}
