// Model of a motor for the pictures, with the same numbers as core/src/motor/commutate/commutation.rs.
// Electrical degrees; 0 is the rising zero crossing of phase A's back-EMF.

export type Leg = "floating" | "low" | "switched";

export const PHASES = ["A", "B", "C"] as const;

/** Actions of the legs A, B, C in each step, in the order of the signal `step`. */
const LEGS = ["---", "SL-", "S-L", "-SL", "LS-", "L-S", "-LS", "SLL", "SSL", "LSL", "LSS", "LLS", "SLS"];
const KINDS: Record<string, Leg> = { "-": "floating", L: "low", S: "switched" };

export const STEP_NAMES = [
    "all floating", "AB", "AC", "BC", "BA", "CA", "CB", "lock A", "lock A+B", "lock B", "lock B+C", "lock C", "lock C+A",
];

/** The numbers of the six running steps. */
export const RUNNING = [1, 2, 3, 4, 5, 6];

/** Number of consistent crossings in a row that end a sensorless start, as in
 * core/src/motor/rotor/zero_crossing.rs. */
export const PREPARED = 6;

/** Returns the actions of the legs A, B, C in a step. */
export function legs(step: number): Leg[] {
    return [...(LEGS[step] ?? LEGS[0])].map((letter) => KINDS[letter]);
}

/** Returns the phase that floats in a running step, 0 to 2, or none. */
export function floating(step: number): number | undefined {
    const found = RUNNING.includes(step) ? legs(step).indexOf("floating") : -1;
    return found < 0 ? undefined : found;
}

/** Wraps an angle to 0 up to 360. */
export function wrap(degrees: number): number {
    return ((degrees % 360) + 360) % 360;
}

/** Returns the sector of a rotor, 0 to 5: 0 spans 30 to 90 degrees. */
export function sectorOf(angle: number): number {
    return Math.floor(wrap(angle - 30) / 60);
}

/** Returns the step that gives forward torque in a sector. */
export function stepFor(sector: number): number {
    return 1 + sector;
}

/** Returns the angle to which a running step pulls a free rotor. */
export function restOf(step: number): number {
    return wrap(150 + 60 * (step - 1));
}

/** Returns the back-EMF of the phases over their peak: a trapezoid with a flat top of 120 degrees. */
export function trapezoid(angle: number): number[] {
    return [0, 120, 240].map((lag) => {
        const x = wrap(angle - lag);
        const ramp = x < 90 ? x : x < 270 ? 180 - x : x - 360;
        return Math.max(-1, Math.min(1, ramp / 30));
    });
}

/** Returns the torque of a step over its largest, with constant current, from the back-EMF of the two
 * conducting phases. */
export function torqueOf(step: number, angle: number): number {
    const shape = trapezoid(angle);
    const roles = legs(step);
    const sum = (role: Leg) => roles.reduce((total, leg, phase) => total + (leg === role ? shape[phase] : 0), 0);
    return RUNNING.includes(step) ? (sum("switched") - sum("low")) / 2 : 0;
}

/** Returns the hall code, bit 0 = A: A is high from 330 to 150 degrees, B and C 120 later each, all of them
 * `offset` later. */
export function hallOf(angle: number, offset = 0): number {
    const high = (phase: number) => wrap(angle + 30 - offset - 120 * phase) < 180;
    return [0, 1, 2].reduce((code, phase) => code | (Number(high(phase)) << phase), 0);
}

/** Returns the direction of the rotor's north pole: at A's opposite tooth at 0 degrees, and at A's own when
 * the back-EMF of A falls through zero. */
export function northOf(angle: number): number {
    return angle - 180;
}
