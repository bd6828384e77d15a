// What the page and its worker say to each other.

import type { MotorName } from "narx";
import type { Replay } from "narx/core";

/** From the page. */
export type Request =
    | { kind: "open"; motor: MotorName }
    | { kind: "start"; rpm: number }
    | { kind: "setSpeed"; rpm: number }
    | { kind: "stop" }
    | { kind: "pause"; paused: boolean }
    | { kind: "replay"; name: string; bytes: Uint8Array };

/** From the worker. */
export type Answer =
    | { kind: "motors"; motors: { name: MotorName; title: string }[] }
    | { kind: "opened"; speedMin: number; speedMax: number; notes: string[] }
    | { kind: "ran"; rows: Rows; now: Now }
    | { kind: "replayed"; name: string; found: Replay }
    | { kind: "refused"; reason: string; name?: string };

/** One row a millisecond: time in s, speeds in rpm. */
export interface Rows {
    time: Float64Array;
    speed: Float32Array;
    setpoint: Float32Array;
}

/** Latest values. */
export interface Now {
    time: number;
    state: number;
    stateName: string;
    speed: number;
    /** A */
    current: number;
    /** V */
    voltage: number;
    /** Why the drive stopped. */
    fault?: string;
}
