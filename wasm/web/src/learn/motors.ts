// The motor of most chapters.

import type { MotorOptions } from "narx";
import type { Action, Setup } from "./messages";

/** A 24 V motor of four pole pairs with a trapezoidal back-EMF, typical of a 50 W fan or pump. */
export const MOTOR: MotorOptions = {
    polePairs: 4,
    resistance: 0.36,
    inductance: 2e-4,
    torqueConstant: 0.036,
    inertia: 4.8e-6,
    // The drive's own limit of 6 A: the chapters show the limits of the drive, not those of a small winding.
    ratedCurrent: 6,
};

export const SUPPLY = 24;

/** Time until the drive has booted, s. */
export const BOOT = 0.6;

/** Returns the flat top of one phase's back-EMF, V a rpm of the shaft: half of the voltage between two
 * lines. */
export function perRpm({ torqueConstant }: MotorOptions): number {
    return ((torqueConstant / 2) * 2 * Math.PI) / 60;
}

/** Control ticks a second of the chapters' drives. */
const RATE = 10_000;

/** Returns the number of samples of the floating phase in a sector, at a speed of the shaft. */
export function samplesPerSector(rpm: number): number {
    return Math.floor(sectorTime(rpm) * RATE);
}

/** Returns the duration of a sector at a speed of the shaft, s. */
export function sectorTime(rpm: number): number {
    return 60 / (6 * MOTOR.polePairs * rpm);
}

/** Boots, starts in hall mode with `load` N m on the shaft, and runs until the speed is steady. */
export function turning(rpm: number, load: number, more: Partial<Setup> = {}): Setup {
    const before: Action[] = [
        { run: BOOT },
        { call: "start", rpm },
        { run: 1.2 },
    ];
    return { motor: MOTOR, options: { supplyVoltage: SUPPLY, mode: "hall", load: { constant: load } }, before, ...more };
}
