// What a chapter and its simulation in the worker say to each other.

import type { BenchOptions, MotorName, MotorOptions, SignalName } from "narx";

/** The signals that pictures are drawn from. */
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

/** What is done to a bench. */
export type Action =
    | { kind: "run"; seconds: number }
    | { kind: "start"; rpm: number }
    | { kind: "setSpeed"; rpm: number }
    | { kind: "stop" };

/** A motor on a bench, and what is done before anybody looks. */
export interface Setup {
    motor: MotorName | MotorOptions;
    options: BenchOptions;
    before: Action[];
}

/** From the page. `pace` is simulated over real time; 0 stands still. */
export type Request = { kind: "open"; setup: Setup } | { kind: "pace"; pace: number } | { kind: "act"; actions: Action[] };

/** From the worker. */
export type Answer =
    | { kind: "ready" }
    | { kind: "opened"; speedMin: number; speedMax: number; notes: string[] }
    | { kind: "ran"; rows: Rows; fault?: string }
    | { kind: "refused"; reason: string };
