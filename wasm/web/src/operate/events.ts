// Changes of state, and new faults, in the columns of a file.

import { decode } from "narx/core";
import type { Table } from "narx/drive";
import type { Event } from "../plot/source";
import { FAULT, STATES } from "./states";

/** Largest number of marks in a plot. */
const MOST = 500;
/** Identifier of FAULT_WORD with the factory addresses. */
const FAULT_WORD = 0x1552a804;

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
            found.push({ time: time[row], text: names(risen), tone: "fault" });
        }
    }
    return found;
}

/** Returns the names of the bits of a fault word, as the message that carries it is decoded. */
function names(word: number): string {
    const data = new Uint8Array(8);
    new DataView(data.buffer).setUint32(0, word);
    const message = decode({ id: FAULT_WORD, extended: true, remote: false, data });
    return message?.name === "FAULT_WORD" ? message.values.Faults.join(", ").replaceAll("_", " ") : "";
}
