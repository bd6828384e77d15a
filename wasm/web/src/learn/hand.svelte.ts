// A rotor that a hand spins, with all switches off: what its windings show.

import { History } from "./history";
import { KEPT, type Row } from "./messages";
import { trapezoid, wrap } from "./model";

/** From row to row, s. */
const FRAME = 1 / 60;

export class Hand {
    row = $state.raw(Object.fromEntries(KEPT.map((name) => [name, 0])) as Row);
    shown = $state(0);
    /** Electrical turns a second, while nobody holds the rotor. */
    spin = $state(0.5);
    held = $state(false);
    readonly age = 0;
    readonly tick = FRAME;
    readonly history = new History();

    #polePairs: number;
    #time = 0;
    /** Less than a row, s. */
    #owed = 0;
    #angle = 60;
    /** Where the hand has put it. */
    #wanted = 60;

    constructor(polePairs: number) {
        this.#polePairs = polePairs;
    }

    /** A hand puts the rotor at an electrical angle. */
    hold(angle: number): void {
        this.held = true;
        this.#wanted = this.#angle + wrap(angle - this.#angle + 180) - 180;
    }

    release(): void {
        this.held = false;
    }

    /** Time passes. */
    step(seconds: number): void {
        // A page that was hidden does not catch up.
        for (this.#owed += Math.min(seconds, 0.1); this.#owed >= FRAME; this.#owed -= FRAME) {
            this.#move();
        }
        this.shown += 1;
    }

    #move(): void {
        const before = this.#angle;
        if (this.held) {
            // A hand is not as jerky as a pointer.
            this.#angle += 0.25 * (this.#wanted - this.#angle);
        } else {
            this.#angle += 360 * this.spin * FRAME;
        }
        this.#time += FRAME;
        const now = trapezoid(this.#angle);
        const crossed = trapezoid(before).findIndex((shape, phase) => shape * now[phase] < 0);
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
