// Messages between the page and the worker with the bench.

import type { BenchOptions, InjectionKind, InjectionName, LoadOptions, Input as BoardInput, MotorName, MotorOptions } from "narx";
import type { Call } from "narx/script";
import type { Frames } from "./frames";
import type { Run } from "./run";

/** Set-up of the bench: everything that determines a run, except its inputs. */
export interface Setup {
    motor: MotorName | MotorOptions;
    /** With `operator`, the run begins with the bench's own operator, until something new happens. */
    options: BenchOptions;
    /** True if the drive has a log memory, its description and a bootloader ("narx/full"). */
    full?: boolean;
}

/** Returns the name of a motor: that of a preset, or one for the data of a chapter's motor. */
export function motorName({ motor }: Setup): string {
    return typeof motor === "string" ? motor : "motor of a chapter";
}

/** Action on the bench: an input of a script, carried out now. */
export type Action = Call;

/** Message from the page. */
export type Request =
    /** The module of the bench; it comes first. */
    | { kind: "begin"; narx: WebAssembly.Module }
    /** The module of a bench with all functions, before the first set-up that has `full`. */
    | { kind: "full"; module: WebAssembly.Module }
    /** Powers a drive up; the actions come before its first tick. */
    | { kind: "open"; setup: Setup; actions: Action[] }
    | { kind: "act"; actions: Action[] }
    /** Confirms that a report was processed. */
    | { kind: "received" }
    /** Sets the simulated seconds in a second; 0 stops the time. */
    | { kind: "pace"; pace: number }
    | { kind: "step"; ticks: number }
    /** Returns to an instant of the run and stops the time there. */
    | { kind: "seek"; tick: number }
    | { kind: "reproduce"; run: Run }
    | { kind: "run" }
    | { kind: "recording" };

/** Message from the worker. */
export type Answer =
    | { kind: "ready"; motors: MotorEntry[]; inputs: BoardInput[]; injections: InjectionKind[] }
    | { kind: "opened"; setup: Setup; speedMin: number; speedMax: number; notes: string[]; tickRate: number }
    | { kind: "ran"; now: Now; rows: Rows; frames: Frames }
    /** A run is being repeated; the time that it has reached. */
    | { kind: "repeating"; now: Now }
    /** Answer to "seek", and the end of a repeated run: rows and frames just before that instant. */
    | { kind: "sought"; now: Now; rows: Rows; frames: Frames }
    | { kind: "reproduced"; digest: string; expected: string }
    | { kind: "run"; run: Run }
    | { kind: "recording"; bytes: Uint8Array }
    | { kind: "refused"; request: Request["kind"]; reason: string };

export interface MotorEntry {
    name: MotorName;
    title: string;
    /** Nominal voltage, V. */
    nominalVoltage: number;
    /** Figures of its data sheet. */
    data: MotorOptions;
}

/** The plant's signals that a row has. */
export const ROW = ["speed", "setpoint", "bus_current", "bus_voltage", "torque", "duty"] as const;
export type RowName = (typeof ROW)[number];

/** True values of the plant, a row about each millisecond: `time` in s since power-up. */
export type Rows = Record<RowName, Float32Array> & { time: Float64Array };

/** Present time of the bench. */
export interface Now {
    /** Time since power-up, s. */
    time: number;
    ticks: number;
    /** The last tick of the run: later than `ticks` if the run has returned to an instant. */
    end: number;
    /** Requested simulated seconds in a second. */
    pace: number;
    /** True values of the last tick. */
    truth: Truth;
    acting: Acting;
}

/** Load and injected faults that act on the bench. */
export interface Acting {
    load: LoadOptions;
    faults: InjectionName[];
}

/** True values of an instant: state, speed, rpm, electrical angle of the rotor, degrees, and bus current, A. */
export const TRUTH = ["state", "speed", "angle", "bus_current"] as const;
export type Truth = Record<(typeof TRUTH)[number], number>;
