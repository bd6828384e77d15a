// A file of parameters: one object of names and values, the format of `narx.Drive.parameters.save` in the
// Python package.

import type { ParameterName } from "narx/core";

export type Values = Partial<Record<ParameterName, number>>;

/** Returns the values of a file. Throws an Error that describes the problem of an invalid one. */
export function parse(name: string, text: string): Values {
    let values: unknown;
    try {
        values = JSON.parse(text);
    } catch {
        throw new Error(`"${name}" is not a parameter file: it is not JSON.`);
    }
    if (typeof values !== "object" || values === null || Array.isArray(values)) {
        throw new Error(`"${name}" is not a parameter file: it must contain one object of names and values.`);
    }
    for (const [parameter, value] of Object.entries(values)) {
        if (typeof value !== "number") {
            throw new Error(`"${name}" is not a parameter file: the value of "${parameter}", ${JSON.stringify(value)}, is not a number.`);
        }
    }
    return values as Values;
}
