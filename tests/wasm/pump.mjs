// A drive's master on a bench that has no operator: time passes while somebody waits.

import * as narx from "../../wasm/pkg/node/narx.js";
import { Drive } from "../../wasm/pkg/node/drive.js";

/** Simulated time between two looks of the master at its frames, s. */
const PERIOD = 0.001;

export class Pump {
    /** `kit`: the module of the bench. */
    constructor(options = {}, master = {}, motor = "bly172s-24v", { Bench, Motor } = narx) {
        this.bench = new Bench(Motor.preset(motor), { supplyVoltage: 24, operator: false, ...options });
        this.drive = new Drive(master);
        this.others = [];
    }

    /** One period: what is due goes out, what arrives comes in. */
    step() {
        const masters = [this.drive, ...this.others];
        for (const master of masters) {
            for (const frame of master.poll(this.bench.time)) {
                this.bench.send(frame);
            }
        }
        this.bench.run(PERIOD, false).free();
        for (const frame of this.bench.takeFrames()) {
            for (const master of frame.sent ? [] : masters) {
                master.handleFrame(frame, frame.time);
            }
        }
    }

    /** Lets time pass until a promise settles; calls `look` each time. */
    async run(promise, look = () => {}) {
        let settled = false;
        const end = () => {
            settled = true;
        };
        promise.then(end, end);
        for (let periods = 0; !settled && periods < 120_000; periods++) {
            this.step();
            look();
            // What waits for an answer may ask the next question.
            await new Promise(setImmediate);
        }
        return promise;
    }

    /** Lets time pass, s. */
    pass(seconds) {
        for (let left = Math.round(seconds / PERIOD); left > 0; left--) {
            this.step();
        }
    }
}
