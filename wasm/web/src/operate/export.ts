// Columns as files.

import type { Table } from "narx/drive";

/** Step of columns, by their names. */
type Steps = Readonly<Record<string, number>>;

/** Returns a line of names with units, then a line for each time; NaN is an empty field. */
export function csv(table: Table, steps: Steps): string {
    const [header, ...rows] = cells(table, steps);
    return [header.map((name) => (/[",]/.test(String(name)) ? `"${String(name).replaceAll('"', '""')}"` : name)), ...rows].map((row) => `${row.map((cell) => cell ?? "").join(",")}\n`).join("");
}

/** Returns a workbook with one sheet. */
export async function xlsx(table: Table, steps: Steps): Promise<Blob> {
    // Loaded only when it is needed.
    const { default: write } = await import("write-excel-file/browser");
    const [header, ...rows] = cells(table, steps);
    const bold = header.map((value) => ({ value: String(value), fontWeight: "bold" as const }));
    return write([bold, ...rows]).toBlob();
}

function cells({ time, columns, units }: Table, steps: Steps): (string | number | null)[][] {
    const names = Object.keys(columns);
    const header = ["time [s]", ...names.map((name) => (units[name] ? `${name} [${units[name]}]` : name))];
    const number = (value: number | undefined, step?: number) => (value === undefined || Number.isNaN(value) ? null : rounded(value, step));
    return [header, ...Array.from(time, (t, row) => [number(t), ...names.map((name) => number(columns[name]?.[row], steps[name]))])];
}

/** Returns a number without the digits that its signal does not have: decimals below its step, those that a
 * value of 32 bits gets as one of 64, and the error of a product. */
function rounded(value: number, step?: number): number {
    if (step !== undefined) {
        return Number(value.toFixed(Math.max(0, Math.ceil(-Math.log10(step)))));
    }
    if (Math.fround(value) !== value) {
        return Number(value.toPrecision(12));
    }
    return [6, 7, 8, 9].map((digits) => Number(value.toPrecision(digits))).find((short) => Math.fround(short) === value) ?? value;
}
