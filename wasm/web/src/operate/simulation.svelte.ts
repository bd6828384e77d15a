// The worker with the bench, and what it has told.

import type { MotorName } from "narx";
import type { Replay } from "narx/core";
import type { Answer, Now, Request, Rows } from "./messages";

export interface Replayed {
    name: string;
    found?: Replay;
    reason?: string;
}

class Simulation {
    motors = $state.raw<{ name: MotorName; title: string }[]>([]);
    range = $state.raw<{ min: number; max: number; notes: string[] }>();
    now = $state.raw<Now>();
    problem = $state<string>();
    replays = $state.raw<Replayed[]>([]);
    /** Called with every piece of the curves. */
    handleRows: ((rows: Rows) => void) | undefined;
    #worker = new Worker(new URL("./worker.ts", import.meta.url), { type: "module" });

    constructor() {
        this.#worker.addEventListener("message", ({ data }: MessageEvent<Answer>) => this.#handle(data));
        this.#worker.addEventListener("error", ({ message }) => {
            this.problem = `The simulation cannot run here: ${message}`;
        });
        document.addEventListener("visibilitychange", () => this.ask({ kind: "pause", paused: document.hidden }));
    }

    ask(request: Request): void {
        if (request.kind !== "replay" && request.kind !== "pause") {
            this.problem = undefined;
        }
        this.#worker.postMessage(request);
    }

    #handle(answer: Answer): void {
        switch (answer.kind) {
            case "motors":
                this.motors = answer.motors;
                return;
            case "opened": {
                const { speedMin, speedMax, notes } = answer;
                this.range = { min: Math.ceil(speedMin / 10) * 10, max: Math.floor(speedMax / 10) * 10, notes };
                return;
            }
            case "ran":
                this.now = answer.now;
                if (answer.now.fault !== undefined) {
                    this.problem = `The drive has stopped: ${answer.now.fault}. Stop acknowledges it.`;
                }
                return this.handleRows?.(answer.rows);
            case "replayed":
                this.replays = [...this.replays, { name: answer.name, found: answer.found }];
                return;
            case "refused":
                if (answer.name === undefined) {
                    this.problem = answer.reason;
                } else {
                    this.replays = [...this.replays, { name: answer.name, reason: answer.reason }];
                }
        }
    }
}

export const simulation = new Simulation();
