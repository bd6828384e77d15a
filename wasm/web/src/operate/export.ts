// Columns as files.

import type { Table } from "narx/drive";

/** Returns a line of names with units, then a line for each time; NaN is an empty field. */
export function csv(table: Table): string {
    const [header, ...rows] = cells(table);
    return [header.map((name) => (/[",]/.test(String(name)) ? `"${String(name).replaceAll('"', '""')}"` : name)), ...rows].map((row) => `${row.map((cell) => cell ?? "").join(",")}\n`).join("");
}

/** Returns a workbook with one sheet. */
export async function xlsx(table: Table): Promise<Blob> {
    // Loaded only when it is needed.
    const { default: write } = await import("write-excel-file/browser");
    const [header, ...rows] = cells(table);
    const bold = header.map((value) => ({ value: String(value), fontWeight: "bold" as const }));
    return write([bold, ...rows]).toBlob();
}

function cells({ time, columns, units }: Table): (string | number | null)[][] {
    const names = Object.keys(columns);
    const header = ["time [s]", ...names.map((name) => (units[name] ? `${name} [${units[name]}]` : name))];
    const number = (value: number | undefined) => (value === undefined || Number.isNaN(value) ? null : value);
    return [header, ...Array.from(time, (t, row) => [t, ...names.map((name) => number(columns[name]?.[row]))])];
}
