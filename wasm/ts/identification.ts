// A motor that its drive has measured.

import { commission, type Commissioned, type Identified } from "./core.js";
import { failure } from "./link.js";

/** Figures of a motor, by the names of a motor file and of `Motor` in Python. */
const NAMES = {
    pole_pairs: "polePairs",
    resistance: "resistance",
    inductance: "inductance",
    torque_constant: "torqueConstant",
    inertia: "inertia",
    static_friction: "staticFriction",
    viscous_friction: "viscousFriction",
    rated_current: "ratedCurrent",
} as const;

/** Returns the figures of a motor that has turned, for `Motor` of `narx` and for `commission`. Throws a "RefusedError" for one
 * that was held. */
export function motorOf({ polePairs, current, resistance, inductance, turned }: Identified) {
    if (turned === undefined) {
        throw failure("RefusedError", "the rotor was not allowed to turn: torque constant and inertia were not measured");
    }
    return {
        polePairs,
        resistance: resistance.value,
        inductance: inductance.value,
        torqueConstant: turned.torqueConstant.value,
        inertia: turned.inertia.value,
        staticFriction: turned.staticFriction,
        viscousFriction: turned.viscousFriction,
        ratedCurrent: current,
    };
}

/** Returns the figures of a motor that has turned as a motor file (TOML), the form of `narx identify`. Throws a "RefusedError"
 * for one that was held. */
export function motorFile(found: Identified): string {
    const motor = motorOf(found);
    const lines = Object.entries(NAMES).map(([name, key]) => `${name} = ${motor[key]}`);
    return ["# Measured by the drive.", ...lines, ""].join("\n");
}

/** Supply, mode and board for which a drive is commissioned. */
export interface Operation {
    /** V. */
    supplyVoltage: number;
    mode: "hall" | "sensorless" | "open-loop";
    /** PWM frequency of the drive's board, Hz. */
    pwmRate: number;
    /** Rated DC current, A; default the largest current of the identification. */
    ratedCurrent?: number;
}

/** Returns the parameters for a motor that has turned. Throws a "RefusedError" for one that was held, and a `RangeError` for a
 * motor or a supply that the drive cannot run. */
export function commissionFor(found: Identified, operation: Operation): Commissioned {
    return commission({ ...motorOf(found), ...operation });
}
