// A rotor that is turned by hand, with all switches off, and the voltages of its windings.

import { History } from "./history";
import { KEPT, type Row } from "./messages";
import { trapezoid, wrap } from "./model";

/** Time between two rows, s. */
const FRAME = 1 / 60;

export class Hand {
    row = $state.raw(Object.fromEntries(KEPT.map((name) => [name, 0])) as Row);
    shown = $state(0);
    /** Electrical turns a second, while the rotor is not held. */
    spin = $state(0.5);
    held = $state(false);
    readonly age = 0;
    readonly tick = FRAME;
    readonly history = new History();

    #polePairs: number;
    #time = 0;
    /** Time that has not become a row yet, s. */
    #owed = 0;
    #angle = 60;
    /** Angle at which the rotor is held. */
    #wanted = 60;

    constructor(polePairs: number) {
        this.#polePairs = polePairs;
    }

    /** Holds the rotor at an electrical angle. */
    hold(angle: number): void {
        this.held = true;
        this.#wanted = this.#angle + wrap(angle - this.#angle + 180) - 180;
    }

    release(): void {
        this.held = false;
    }

    /** Advances the time. */
    step(seconds: number): void {
        // A page that was hidden does not make up for that time.
        for (this.#owed += Math.min(seconds, 0.1); this.#owed >= FRAME; this.#owed -= FRAME) {
            this.#move();
        }
        this.shown += 1;
    }

    #move(): void {
        const before = this.#angle;
        if (this.held) {
            // The rotor follows the pointer smoothly, because pointers move in jumps.
            this.#angle += 0.25 * (this.#wanted - this.#angle);
        } else {
            this.#angle += 360 * this.spin * FRAME;
        }
        this.#time += FRAME;
        const now = trapezoid(this.#angle);
        // A row may lie on the zero itself: it is the crossing, the next one is not.
        const crossed = trapezoid(before).findIndex((shape, phase) => shape !== 0 && shape * now[phase] <= 0);
        const values: Partial<Row> = {
            time: this.#time,
            angle: wrap(this.#angle),
            speed: ((this.#angle - before) / FRAME / 360 / this.#polePairs) * 60,
            crossing: crossed + 1,
        };
        this.row = { ...this.row, ...values };
        this.history.append(KEPT.map((name) => Float64Array.of(this.row[name])));
    }
}
