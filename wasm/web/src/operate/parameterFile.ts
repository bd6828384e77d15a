// A file of parameters: one object of names and values, as `narx.Drive.parameters.save` of the Python package writes it, too.

import type { ParameterName } from "narx/core";

export type Values = Partial<Record<ParameterName, number>>;

/** The values of a file. Throws an Error that says what it is instead. */
export function parse(name: string, text: string): Values {
    let values: unknown;
    try {
        values = JSON.parse(text);
    } catch {
        throw new Error(`"${name}" is no file of parameters: it is not JSON.`);
    }
    if (typeof values !== "object" || values === null || Array.isArray(values)) {
        throw new Error(`"${name}" is no file of parameters: it must hold one object of names and values.`);
    }
    for (const [parameter, value] of Object.entries(values)) {
        if (typeof value !== "number") {
            throw new Error(`"${name}" is no file of parameters: "${parameter}" has ${JSON.stringify(value)}, which is no number.`);
        }
    }
    return values as Values;
}
