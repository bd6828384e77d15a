// What is downloaded, as columns.

/** Columns of the same length: plain data, which passes from a worker to its page. */
export interface Table<Name extends string = string> {
    /** s. */
    readonly time: Float64Array;
    readonly columns: Readonly<Partial<Record<Name, Float64Array>>>;
    /** By column; empty for plain numbers. */
    readonly units: Readonly<Partial<Record<Name, string>>>;
}
