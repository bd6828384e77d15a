// CSV of numbers with a header, as written by the scope, the log and `cargo xtask demo`.

import type { Table } from "narx/drive";

/** Returns the columns of a text whose first one is the time; `undefined` if the text is no such table. An
 * empty field is NaN. */
export function columns(text: string): Table | undefined {
    const [header, ...lines] = text.split(/\r?\n/).filter((line) => line.trim() !== "");
    const names = fields(header ?? "").map((field) => /^(.*?)(?:\s*\[(.*)\])?$/.exec(field)?.slice(1) ?? [field]);
    if (names.length < 2 || lines.length === 0 || names[0][0]?.toLowerCase() !== "time") {
        return undefined;
    }
    const rows = lines.map((line) => line.split(",").map((field) => (field.trim() === "" ? NaN : Number(field))));
    if (rows.some((row) => row.length !== names.length || Number.isNaN(row[0]))) {
        return undefined;
    }
    const column = (index: number) => Float64Array.from(rows, (row) => row[index]);
    const rest = names.slice(1).map(([name], index) => [name, column(index + 1)] as const);
    return {
        time: column(0),
        // A column of words cannot be plotted.
        columns: Object.fromEntries(rest.filter(([, values]) => values.some((value) => !Number.isNaN(value)))),
        units: Object.fromEntries(names.slice(1).map(([name, unit]) => [name, unit ?? ""])),
    };
}

/** Returns the fields of a line, some of them in quotes. */
function fields(line: string): string[] {
    return [...line.matchAll(/"((?:[^"]|"")*)"|([^",]+)/g)].map(([, quoted, plain]) => (quoted ?? plain ?? "").replaceAll('""', '"').trim());
}
