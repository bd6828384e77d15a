// Downloaded data, as columns.

/** Columns of the same length: plain data, which can be passed from a worker to its page. */
export interface Table<Name extends string = string> {
    /** Time of each row, s. */
    readonly time: Float64Array;
    readonly columns: Readonly<Partial<Record<Name, Float64Array>>>;
    /** Units by column; empty for plain numbers. */
    readonly units: Readonly<Partial<Record<Name, string>>>;
}
