// Messages between a chapter and its simulation in the worker.

import type { BenchOptions, BusFrame, MotorName, MotorOptions, SignalName } from "narx";
import type { DriveMessage, NodeMessage } from "narx/core";
import type { Call } from "narx/script";
import type { Run } from "../operate/bench/run";

/** The signals from which pictures are drawn. */
export const KEPT = [
    "time", "setpoint", "speed", "speed_estimated", "state", "sector", "duty", "current_a", "current_b", "current_c",
    "bus_current", "bus_voltage", "torque", "voltage_a", "voltage_b", "voltage_c", "angle", "hall", "step", "limiter", "faults",
    "position", "peak_current", "crossing", "crossing_margin",
] as const satisfies readonly SignalName[];

export type Kept = (typeof KEPT)[number];

/** One control tick. */
export type Row = Record<Kept, number>;

/** Consecutive control ticks, an array for each signal in the order of `KEPT`. */
export type Rows = Float64Array[];

/** A frame of the bus, decoded if the set-up wants it. */
export type Received = BusFrame & { message?: DriveMessage | NodeMessage };

/** Action on a bench. */
export type Action =
    | { run: number }
    /** Runs until a signal changes, but no longer than `seconds`. */
    | { until: "state" | "step"; seconds: number }
    | Call;

/** A motor on a bench, and the actions before it is shown. */
export interface Setup {
    motor: MotorName | MotorOptions;
    options: BenchOptions;
    before: Action[];
    /** True if the chapter shows decoded messages, for which a second module is loaded. */
    decoded?: true;
}

/** Message from the page. `pace` is simulated over real time; 0 stops the time. */
export type Request =
    /** The modules; `core` decodes frames. */
    | { kind: "begin"; narx: WebAssembly.Module; core?: WebAssembly.Module }
    | { kind: "open"; setup: Setup }
    | { kind: "pace"; pace: number }
    | { kind: "act"; actions: Action[] }
    /** Asks for the run up to the tick `age` before the newest. */
    | { kind: "run"; age: number };

/** Message from the worker. */
export type Answer =
    | { kind: "ready" }
    /** `tick`: a control tick, s. */
    | { kind: "opened"; tick: number }
    /** New rows. `acted`: the time at which the actions began that caused them, s; absent if only time has
     * passed. */
    | { kind: "ran"; rows: Rows; frames: Received[]; acted?: number; fault?: string }
    | { kind: "run"; run: Run }
    | { kind: "refused"; reason: string };
