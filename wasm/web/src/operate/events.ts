// Changes of state, and new faults, in the columns of a file.

import type { Table } from "narx/drive";
import type { Event } from "../plot/source";
import { FAULT, FAULT_BITS, STATES } from "./states";

/** Largest number of marks in a plot. */
const MOST = 500;

/** Returns the events of a table with the columns `state` or `faults`. */
export function events({ time, columns: { state, faults } }: Table): Event[] {
    const found: Event[] = [];
    for (let row = 0; row < time.length && found.length < MOST; row += 1) {
        const [now, before] = [state?.[row] ?? NaN, state?.[row - 1] ?? NaN];
        if (!Number.isNaN(now) && now !== before) {
            found.push({ time: time[row], text: STATES[now] ?? String(now), tone: now === FAULT ? "fault" : "state" });
        }
        const risen = (faults?.[row] ?? 0) & ~(faults?.[row - 1] ?? 0);
        if (risen !== 0) {
            const names = Object.entries(FAULT_BITS).flatMap(([name, bit]) => ((risen >>> bit) & 1 ? [name] : []));
            found.push({ time: time[row], text: names.join(", ").replaceAll("_", " "), tone: "fault" });
        }
    }
    return found;
}
