// Set-up and record of the virtual scope. They outlast the panel, which is made anew at every visit.

import type { ScopeSignalName } from "narx/core";
import type { Table, Trigger } from "narx/drive";
import type { Link } from "./link/link";

export const setup = $state({
    /** Signals to record; at first those that the drive names first. */
    chosen: undefined as ScopeSignalName[] | undefined,
    samples: 512,
    /** Control ticks from one sample to the next. */
    prescaler: 1,
    /** Samples before the trigger. */
    before: 0,
    /** True to record the inputs of the control instead of signals. */
    inputs: false,
    trigger: "forced" as Trigger["kind"],
    /** Signal and level of a trigger that compares. */
    signal: undefined as ScopeSignalName | undefined,
    level: 0,
});

class Recorded {
    table = $state.raw<Table>();
    /** Step of each column. */
    steps: Readonly<Record<string, number>> = {};
    /** Times of the cursors A and B, s. */
    cursors = $state.raw<readonly [number, number]>();
    /** Result of the last action. */
    told = $state<string>();
    /** True from arming to the end of the record. */
    armed = false;
    #link: Link | undefined;

    /** Tells the link to the present drive: the record of another one is removed. */
    belongsTo(link: Link | undefined): void {
        if (link !== this.#link) {
            [this.#link, this.table, this.cursors, this.told, this.armed] = [link, undefined, undefined, undefined, false];
        }
    }
}

export const recorded = new Recorded();
