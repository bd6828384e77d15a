// What a chapter and its simulation in the worker say to each other.

import type { BenchOptions, BusFrame, Frame, InjectionName, InjectionOptions, LoadOptions, MotorName, MotorOptions, SignalName } from "narx";
import type { DriveMessage, NodeMessage } from "narx/core";

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

/** A frame of the bus, and the message that it is. */
export type Heard = BusFrame & { message?: DriveMessage | NodeMessage };

/** What is done to a bench. */
export type Action =
    | { kind: "run"; seconds: number }
    /** Until the drive is in another state, but no longer than `seconds`. */
    | { kind: "nextState"; seconds: number }
    | { kind: "start"; rpm: number }
    | { kind: "setSpeed"; rpm: number }
    | { kind: "stop" }
    | { kind: "load"; load: LoadOptions }
    | { kind: "inject"; fault: InjectionName; options?: InjectionOptions }
    | { kind: "clear" }
    | { kind: "send"; frame: Frame };

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
    | { kind: "opened" }
    /** `acted`: when the actions began whose consequences these are, s; else they are of time alone. */
    | { kind: "ran"; rows: Rows; frames: Heard[]; acted?: number; fault?: string }
    | { kind: "refused"; reason: string };
