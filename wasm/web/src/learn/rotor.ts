// A rotor that the reader holds, or releases in the field of one step. It has one pole pair, so electrical
// and mechanical angle are equal.

import { torqueOf, wrap } from "./model";

/** Largest torque over inertia, deg/s2: a swing takes about a second, slow enough to see. */
const STIFFNESS = 4000;
/** Damping, 1/s: the rotor rests after two swings. */
const DAMPING = 6;
/** Time step, s; small against a swing. */
const STRIDE = 1 / 500;

export class Rotor {
    /** Angle, electrical degrees, not wrapped. */
    angle: number;
    /** Speed, degrees a second. */
    speed = 0;

    constructor(angle: number) {
        this.angle = angle;
    }

    /** Holds the rotor at an angle. */
    hold(angle: number): void {
        // Moves the shorter way round.
        this.angle += wrap(angle - this.angle + 180) - 180;
        this.speed = 0;
    }

    /** Moves the free rotor for `seconds` with current in `step`. */
    swing(step: number, seconds: number): void {
        for (let left = Math.min(seconds, 0.1); left > 0; left -= STRIDE) {
            this.speed += (STIFFNESS * torqueOf(step, this.angle) - DAMPING * this.speed) * STRIDE;
            this.angle += this.speed * STRIDE;
        }
    }
}
