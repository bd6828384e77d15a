// Rows of columns over ascending times.

import type uPlot from "uplot";

/** Returns the first row that is not earlier than an instant, of the first `length` rows. */
export function firstAt(time: ArrayLike<number>, instant: number, length = time.length): number {
    let [low, high] = [0, length];
    while (low < high) {
        const middle = (low + high) >> 1;
        [low, high] = time[middle] < instant ? [middle + 1, high] : [low, middle];
    }
    return low;
}

/** Returns the rows from `first` to before `last`, or of many rows those with the extremes of `points` pieces.
 * NaN becomes null, which is a gap in the curve. */
export function thinned(
    time: ArrayLike<number>,
    columns: readonly (ArrayLike<number> | undefined)[],
    first: number,
    last: number,
    points: number,
): uPlot.AlignedData {
    const rows: number[] = [];
    const piece = (last - first) / points;
    if (piece <= 2 + 2 * columns.length) {
        for (let row = first; row < last; row += 1) {
            rows.push(row);
        }
    } else {
        for (let at = 0; at < points; at += 1) {
            const [begin, end] = [first + Math.floor(at * piece), first + Math.floor((at + 1) * piece)];
            const kept = new Set([begin]);
            for (const column of columns) {
                let [low, high] = [begin, begin];
                for (let row = begin; column && row < end; row += 1) {
                    low = column[row] < column[low] || Number.isNaN(column[low]) ? row : low;
                    high = column[row] > column[high] || Number.isNaN(column[high]) ? row : high;
                }
                kept.add(low).add(high);
            }
            rows.push(...[...kept].sort((one, two) => one - two));
        }
        rows.push(last - 1);
    }
    const picked = (column?: ArrayLike<number>) => rows.map((row) => (column === undefined || Number.isNaN(column[row]) ? null : column[row]));
    return [rows.map((row) => time[row]), ...columns.map(picked)] as uPlot.AlignedData;
}
