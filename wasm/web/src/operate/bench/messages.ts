// What the page and the worker with the bench say to each other.

import type { BenchOptions, BusFrame, InjectionName, Input as BoardInput, MotorName } from "narx";
import type { Input } from "narx/script";
import type { Run } from "./run";

/** What is on the bench: everything that decides a run, but its inputs. */
export interface Setup {
    motor: MotorName;
    options: BenchOptions;
    /** The drive has a log memory, its description and a bootloader ("narx/full"). */
    full?: boolean;
}

/** What is done to the bench: an input of a script, now. */
export type Action = Untimed<Input>;
type Untimed<One> = One extends unknown ? Omit<One, "tick"> : never;

/** From the page. */
export type Request =
    /** Powers a drive up; the actions come before its first tick. */
    | { kind: "open"; setup: Setup; actions: Action[] }
    | { kind: "act"; actions: Action[] }
    /** A report was taken. */
    | { kind: "heard" }
    /** Simulated seconds in a second; 0 stands still. */
    | { kind: "pace"; pace: number }
    | { kind: "step"; ticks: number }
    /** Returns to an instant of the run and stands still there. */
    | { kind: "seek"; tick: number }
    | { kind: "reproduce"; run: Run }
    | { kind: "run" }
    | { kind: "recording" };

/** From the worker. */
export type Answer =
    | { kind: "ready"; motors: MotorEntry[]; inputs: BoardInput[]; injections: InjectionName[] }
    | { kind: "opened"; setup: Setup; speedMin: number; speedMax: number; notes: string[]; tickRate: number }
    | { kind: "ran"; now: Now; rows: Rows; frames: BusFrame[] }
    /** After "seek": what was heard and seen just before that instant. */
    | { kind: "sought"; now: Now; rows: Rows; frames: BusFrame[] }
    | { kind: "reproduced"; digest: string; expected: string }
    | { kind: "run"; run: Run }
    | { kind: "recording"; bytes: Uint8Array }
    | { kind: "refused"; request: Request["kind"]; reason: string };

export interface MotorEntry {
    name: MotorName;
    title: string;
    /** V. */
    nominalVoltage: number;
}

/** The plant's signals that a row has. */
export const ROW = ["speed", "setpoint", "bus_current", "bus_voltage", "torque", "duty"] as const;
export type RowName = (typeof ROW)[number];

/** True values of the plant, a row each millisecond: `time` in s since power-up. */
export type Rows = Record<RowName, Float32Array> & { time: Float64Array };

/** Where the bench is. */
export interface Now {
    /** s since power-up. */
    time: number;
    ticks: number;
    /** The furthest tick of the run: later than `ticks` where it has returned to an instant. */
    end: number;
    /** Simulated seconds in a second that were asked for. */
    pace: number;
}
