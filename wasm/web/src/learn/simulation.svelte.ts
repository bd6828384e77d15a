// One simulation for all pictures of a chapter: it runs in a worker, and the newest tick, or an earlier one, is in view.

import { History, type Entered } from "./history";
import { KEPT, type Action, type Answer, type Heard, type Request, type Row, type Setup } from "./messages";

/** From one figure to the next, ms. */
const READING = 200;

const NOTHING = Object.fromEntries(KEPT.map((name) => [name, 0])) as Row;

export class Simulation {
    /** The tick in view. */
    row = $state.raw<Row>(NOTHING);
    /** The same for figures that are read: while time runs, a few a second. */
    reading = $state.raw<Row>(NOTHING);
    /** The states that led to it, oldest first. */
    entered = $state.raw<Entered[]>([]);
    /** Rises with every new picture. */
    shown = $state(0);
    /** Ticks from the one in view to the newest. */
    age = $state(0);
    /** Ticks that can be looked back at. */
    length = $state(0);
    playing = $state(false);
    /** Simulated over real time. */
    pace = $state(1);
    /** Why the drive has stopped, at the newest tick. */
    fault = $state<string>();
    /** Why the simulation cannot be. */
    problem = $state<string>();
    /** A bench has been opened and what came before has been done. */
    open = $state(false);
    readonly history = new History();
    /** A control tick, s. */
    readonly tick = 1e-4;
    /** Hears when actions have begun, s. */
    handleActed: (time: number) => void = () => {};
    /** Hears every frame of the bus, where the bench keeps them; `acted`: what the last actions have brought forth. */
    handleFrames: (frames: Heard[], acted: boolean) => void = () => {};

    #worker = new Worker(new URL("./worker.ts", import.meta.url), { type: "module" });
    #ready = false;
    /** Opened as soon as the worker has done with the one before; of several the last. */
    #wanted: Setup | undefined;
    #busy = false;
    #changed = false;
    #frame = 0;
    #read = 0;
    #hidden = () => this.#tellPace();

    constructor(setup: Setup, pace: number, playing: boolean) {
        this.pace = pace;
        this.playing = playing && !matchMedia("(prefers-reduced-motion: reduce)").matches;
        this.#wanted = setup;
        this.#worker.addEventListener("message", ({ data }: MessageEvent<Answer>) => this.#handle(data));
        this.#worker.addEventListener("error", ({ message }) => {
            this.problem = `The simulation cannot run here: ${message}`;
        });
        document.addEventListener("visibilitychange", this.#hidden);
        this.#draw();
    }

    /** Another bench in place of this one. */
    reopen(setup: Setup): void {
        this.#wanted = setup;
        this.#openWanted();
    }

    /** Done now, at the newest tick. */
    act(...actions: Action[]): void {
        this.age = 0;
        this.#ask({ kind: "act", actions });
    }

    play(playing: boolean): void {
        this.playing = playing;
        if (playing) {
            this.look(0);
        }
        this.#tellPace();
    }

    setPace(pace: number): void {
        this.pace = pace;
        this.#tellPace();
    }

    /** Time passes, as fast as it can be computed. */
    run(seconds: number): void {
        this.act({ kind: "run", seconds });
    }

    /** So many ticks forward, or back where negative; time stands still then. */
    go(count: number): void {
        if (this.playing) {
            this.play(false);
        }
        const age = this.age - count;
        if (age < 0) {
            this.run(-age * this.tick);
        }
        this.look(age);
    }

    /** Brings the tick `age` before the newest into view. */
    look(age: number): void {
        this.age = Math.max(0, Math.min(Math.round(age), this.history.length - 1));
        this.#changed = true;
    }

    close(): void {
        cancelAnimationFrame(this.#frame);
        document.removeEventListener("visibilitychange", this.#hidden);
        this.#worker.terminate();
    }

    #ask(request: Request): void {
        this.#worker.postMessage(request);
    }

    #tellPace(): void {
        this.#ask({ kind: "pace", pace: this.playing && !document.hidden ? this.pace : 0 });
    }

    #openWanted(): void {
        if (this.#ready && !this.#busy && this.#wanted) {
            this.#busy = true;
            // What a component keeps is a proxy, which no message can carry.
            this.#ask({ kind: "open", setup: $state.snapshot(this.#wanted) as Setup });
            this.#wanted = undefined;
        }
    }

    #handle(answer: Answer): void {
        switch (answer.kind) {
            case "ready":
                this.#ready = true;
                this.#tellPace();
                return this.#openWanted();
            case "opened":
                this.history.clear();
                this.age = 0;
                this.problem = undefined;
                return;
            case "ran":
                this.#ran(answer);
                return this.#openWanted();
            case "refused":
                this.problem = answer.reason;
                this.#busy = false;
                return this.#openWanted();
        }
    }

    #ran({ rows, frames, acted, fault }: Answer & { kind: "ran" }): void {
        const done = acted !== undefined;
        this.#busy &&= !done;
        this.history.append(rows);
        if (frames.length > 0) {
            this.handleFrames(frames, done);
        }
        this.fault = fault;
        this.open ||= done;
        if (done) {
            this.handleActed(acted);
        }
        this.#changed = true;
        if (this.age > 0) {
            // Whoever looks back keeps looking at the same tick.
            this.age = Math.min(this.age + rows[0].length, this.history.length - 1);
        }
    }

    #draw(): void {
        if (this.#changed && this.history.length > 0) {
            this.#changed = false;
            this.length = this.history.length;
            this.row = this.history.row(this.age);
            const entered = this.history.entered(this.age);
            // The same array as long as nothing has changed: what depends on it is not drawn anew then.
            if (entered.length !== this.entered.length || entered.at(-1)?.time !== this.entered.at(-1)?.time) {
                this.entered = entered;
            }
            const now = performance.now();
            if (!this.playing || now - this.#read > READING || this.row.state !== this.reading.state) {
                this.#read = now;
                this.reading = this.row;
            }
            this.shown += 1;
        }
        this.#frame = requestAnimationFrame(() => this.#draw());
    }
}
