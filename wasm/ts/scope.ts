// The virtual scope of a drive: it records signals of the control tick, tick by tick.

import type { Progress, RecordSetup, ScopeSignal, ScopeSignalName } from "./core.js";
import type { ScopeRecording } from "./lab.js";
import { failure, type Link } from "./link.js";
import { Parameters } from "./parameters.js";
import type { Table } from "./table.js";

const [CHANNELS, SAMPLING_TIME, BEFORE, STATE, INPUTS, WORDS] = [22, 25, 26, 260, 300, 301];

/** State of the scope (parameter 260). */
export type ScopeState = "idle" | "armed" | "recording" | "done";
const STATES: readonly ScopeState[] = ["idle", "armed", "recording", "done"];

/** Condition that begins a record (parameters 290 to 292). An armed scope can also be forced, whatever its
 * trigger is. */
export type Trigger =
    | { readonly kind: "forced" | "state change" | "fault" }
    | {
          readonly kind: "above" | "below" | "rising" | "falling";
          readonly signal: ScopeSignalName;
          /** Threshold, in the signal's unit. */
          readonly value: number;
      };
const KINDS: readonly Trigger["kind"][] = ["forced", "above", "below", "rising", "falling", "state change", "fault"];

/** Settings of a record. */
export interface ScopeSetup {
    /** Samples of each signal; all signals together fill at most the drive's memory (parameter 305). Default
     * 256. For a record of inputs: control ticks, limited by the memory; default 400. */
    samples?: number;
    /** Control ticks from one sample to the next, at least one for every four signals; default 1. */
    prescaler?: number;
    /** Condition that begins the record; by default only `force` does. */
    trigger?: Trigger;
    /** Samples from before the trigger, fewer than `samples`; default 0. */
    before?: number;
}

/** Arms, forces and reads the scope. A record survives faults and further starts until the scope is armed
 * again. */
export class Scope {
    #link: Link;
    #parameters: Parameters;

    constructor(link: Link) {
        this.#link = link;
        this.#parameters = new Parameters(link);
    }

    /** Signals that can be recorded. */
    get signals(): readonly ScopeSignal[] {
        return this.#link.tables.signals;
    }

    /** Returns the present state. */
    async state(): Promise<ScopeState> {
        return STATES[await this.#parameters.get(STATE)] ?? "idle";
    }

    /** Sets the scope up and arms it. Rejects with a "RefusedError" while it is armed or recording, with a
     * RangeError for settings that the drive does not support. */
    async arm(signals: readonly ScopeSignalName[], setup: ScopeSetup = {}): Promise<void> {
        await this.#link.record("arm scope", this.#settings(setup, 256, this.#channels(signals)));
    }

    /** Sets the scope up to record the inputs of every control tick, and arms it; `downloadRecording` makes a
     * recording of them. At 10 kHz the memory holds 34 to 68 ms. */
    async armInputs(setup: Omit<ScopeSetup, "prescaler"> = {}): Promise<void> {
        await this.#link.record("arm scope", this.#settings(setup, 400, 0));
    }

    /** Returns the sum of the signals' bits. */
    #channels(signals: readonly ScopeSignalName[]): number {
        const known = this.signals;
        const bits = new Set(signals.map((name) => find(known, name).bit));
        if (bits.size === 0) {
            throw new TypeError("signals: must name at least one signal");
        }
        return [...bits].reduce((sum, bit) => sum + 2 ** bit, 0);
    }

    /** Returns the settings of a record of signals, or without channels of inputs. */
    #settings(setup: ScopeSetup, samples: number, channels: number): RecordSetup {
        const trigger = setup.trigger ?? { kind: "forced" };
        const kind = KINDS.indexOf(trigger.kind);
        if (kind < 0) {
            throw new TypeError(`trigger "${trigger.kind}": must be one of ${KINDS.join(", ")}`);
        }
        const common = {
            channels,
            samples: setup.samples ?? samples,
            prescaler: setup.prescaler ?? 1,
            before: setup.before ?? 0,
            trigger: kind,
        };
        if (!("signal" in trigger)) {
            return common;
        }
        const { bit, base } = find(this.signals, trigger.signal);
        return { ...common, signal: bit, level: trigger.value / base };
    }

    /** Triggers the armed scope now. Rejects with a "RefusedError" if it is not armed. */
    async force(): Promise<void> {
        if (!this.#link.records) {
            return this.#link.record("force scope");
        }
        // A record is awaited: it is forced beside that job, unless its trigger has just occurred.
        if ((await this.state()) === "armed") {
            await this.#link.ask(() => this.#link.master.request("trigger scope"));
        }
    }

    /** Waits until the record is complete, at most `timeout` s. */
    async wait(timeout = 10): Promise<void> {
        await this.#link.record("await scope", undefined, timeout);
    }

    /** Downloads the record: a row per sample, `time` in s from the trigger. Rejects with a "RefusedError"
     * while there is none. */
    async download(progress?: (progress: Progress) => void): Promise<Table<ScopeSignalName>> {
        await this.#expectRecord(false);
        const channels = await this.#parameters.get(CHANNELS);
        const chosen = this.signals.filter(({ bit }) => Math.floor(channels / 2 ** bit) % 2 === 1);
        const step = await this.#parameters.get(SAMPLING_TIME);
        const before = await this.#parameters.get(BEFORE);
        const bytes = await this.#read(progress);
        const samples = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
        const rows = Math.floor(bytes.length / 2 / chosen.length);
        const column = ({ base }: ScopeSignal, at: number) =>
            Float64Array.from({ length: rows }, (_, row) => (samples.getInt16(2 * (row * chosen.length + at)) / 4096) * base);
        return {
            time: Float64Array.from({ length: rows }, (_, row) => (row - Math.min(before, rows)) * step),
            columns: Object.fromEntries(chosen.map((signal, at) => [signal.name, column(signal, at)])),
            units: Object.fromEntries(chosen.map(({ name, unit }) => [name, unit])),
        };
    }

    /** Downloads the record of inputs, as a recording that `replay` runs again bit for bit. */
    async downloadRecording(progress?: (progress: Progress) => void): Promise<ScopeRecording> {
        await this.#expectRecord(true);
        const bytes = await this.#read(progress);
        // Imported here, because that module contains the control code, which nothing else in this file
        // needs.
        const lab = await import("./lab.js");
        // Only the module for browsers has a function that loads it.
        if (typeof lab.default === "function") {
            await lab.default();
        }
        return lab.scopeRecording(bytes, "recorded by the scope");
    }

    /** Arms the scope, waits for the trigger at most `timeout` s, or forces it without one, and downloads the
     * record. */
    async capture(
        signals: readonly ScopeSignalName[],
        setup: ScopeSetup = {},
        timeout = 10,
    ): Promise<Table<ScopeSignalName>> {
        await this.#capture(this.#settings(setup, 256, this.#channels(signals)), setup.trigger, timeout);
        return this.download();
    }

    /** Records inputs, waits for the trigger as `capture` does, and downloads the recording. */
    async record(setup: Omit<ScopeSetup, "prescaler"> = {}, timeout = 10): Promise<ScopeRecording> {
        await this.#capture(this.#settings(setup, 400, 0), setup.trigger, timeout);
        return this.downloadRecording();
    }

    async #capture(settings: RecordSetup, trigger: Trigger | undefined, timeout: number): Promise<void> {
        if (trigger?.kind === "forced") {
            // Something else forces the scope.
            await this.#link.record("arm scope", settings);
            await this.#link.record("await scope", undefined, timeout);
        } else {
            await this.#link.record("capture scope", settings, timeout);
        }
    }

    async #read(progress?: (progress: Progress) => void): Promise<Uint8Array> {
        const words = await this.#parameters.get(WORDS);
        return this.#link.download(() => this.#link.master.download("scope", words), progress);
    }

    async #expectRecord(inputs: boolean): Promise<void> {
        const state = await this.state();
        if (state !== "done") {
            throw failure("RefusedError", `the scope is ${state}: no record is stored`);
        }
        if (Boolean(await this.#parameters.get(INPUTS)) !== inputs) {
            const [kind, call] = inputs ? ["signals", "download"] : ["inputs", "downloadRecording"];
            throw failure("RefusedError", `the scope has recorded ${kind}: ${call}() reads it`);
        }
    }
}

function find(known: readonly ScopeSignal[], name: ScopeSignalName): ScopeSignal {
    const found = known.find((signal) => signal.name.toLowerCase() === name.toLowerCase());
    if (found === undefined) {
        throw new TypeError(`there is no scope signal "${name}"`);
    }
    return found;
}
