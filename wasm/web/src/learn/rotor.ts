// A rotor in the reader's hand: held, or let go in the field of one step. One pole pair, so that electrical and mechanical angle are one.

import { torqueOf, wrap } from "./model";

/** Largest torque over inertia, deg/s2: a swing of about a second, for the eye. */
const STIFFNESS = 4000;
/** Per second: it rests after two swings. */
const DAMPING = 6;
/** s. Small against a swing. */
const STRIDE = 1 / 500;

export class Rotor {
    /** Electrical degrees, not wrapped. */
    angle: number;
    /** Degrees a second. */
    speed = 0;

    constructor(angle: number) {
        this.angle = angle;
    }

    /** A hand puts it there. */
    hold(angle: number): void {
        // The shorter way round.
        this.angle += wrap(angle - this.angle + 180) - 180;
        this.speed = 0;
    }

    /** Nobody holds it while `seconds` pass with current in `step`. */
    swing(step: number, seconds: number): void {
        for (let left = Math.min(seconds, 0.1); left > 0; left -= STRIDE) {
            this.speed += (STIFFNESS * torqueOf(step, this.angle) - DAMPING * this.speed) * STRIDE;
            this.angle += this.speed * STRIDE;
        }
    }
}
