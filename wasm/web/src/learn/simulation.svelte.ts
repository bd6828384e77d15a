// One simulation for all pictures of a chapter. It runs in a worker; the newest tick, or an earlier one, is
// in view.

import { module } from "../modules";
import type { Run } from "../operate/bench/run";
import { History, type Entered } from "./history";
import type { Source } from "./pictures/Waveforms.svelte";
import { KEPT, type Action, type Answer, type Received, type Request, type Row, type Setup } from "./messages";
import BenchWorker from "./worker?worker&inline";

/** Time between two updates of the figures, ms. */
const READING = 200;

const NOTHING = Object.fromEntries(KEPT.map((name) => [name, 0])) as Row;

export class Simulation {
    /** The tick in view. */
    row = $state.raw<Row>(NOTHING);
    /** The tick of the figures: while time runs, it changes only a few times a second, so that they can be
     * read. */
    reading = $state.raw<Row>(NOTHING);
    /** The states up to the tick in view, oldest first. */
    entered = $state.raw<Entered[]>([]);
    /** Increases with every new picture. */
    shown = $state(0);
    /** Number of ticks from the one in view to the newest. */
    age = $state(0);
    /** Number of ticks that are kept. */
    length = $state(0);
    playing = $state(false);
    /** Simulated over real time. */
    pace = $state(1);
    /** Cause of the drive's stop, at the newest tick. */
    fault = $state<string>();
    /** Reason why the simulation cannot run. */
    problem = $state<string>();
    /** True once a bench was opened and the actions of its set-up are done. */
    open = $state(false);
    readonly history = new History();
    /** A control tick of the bench, s. */
    tick = $state(1e-4);
    /** Called when actions are done, with the time at which they began, s. */
    handleActed: (time: number) => void = () => {};
    /** Called with every frame of the bus, if the bench keeps them; `acted` marks frames that the last
     * actions caused. */
    handleFrames: (frames: Received[], acted: boolean) => void = () => {};

    #worker = new BenchWorker();
    #ready = false;
    /** Set-up that is opened as soon as the worker has opened the previous one; a later set-up replaces
     * it. */
    #wanted: Setup | undefined;
    #busy = false;
    #changed = false;
    #frame = 0;
    #told: (run: Run) => void = () => {};
    #read = 0;
    #hidden = () => this.#tellPace();

    constructor(setup: Setup, pace: number, playing: boolean) {
        this.pace = pace;
        this.playing = playing && !matchMedia("(prefers-reduced-motion: reduce)").matches;
        this.#wanted = setup;
        this.#worker.addEventListener("message", ({ data }: MessageEvent<Answer>) => this.#handle(data));
        this.#worker.addEventListener("error", ({ message }) => {
            this.problem = `The simulation cannot run in this browser: ${message}`;
        });
        document.addEventListener("visibilitychange", this.#hidden);
        Promise.all([module("narx"), setup.decoded ? module("core") : undefined]).then(
            ([narx, core]) => this.#ask({ kind: "begin", narx, core }),
            ({ message }: Error) => (this.problem = message),
        );
        this.#draw();
    }

    /** Replaces the bench. */
    reopen(setup: Setup): void {
        this.#wanted = setup;
        this.#openWanted();
    }

    /** Carries out actions now, at the newest tick. */
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

    /** Returns the run up to the tick in view. */
    moment(): Promise<Run> {
        return new Promise((resolve) => {
            this.#told = resolve;
            this.#ask({ kind: "run", age: this.age });
        });
    }

    /** Phase currents of the tick in view, A. */
    get currents(): number[] {
        return [this.row.current_a, this.row.current_b, this.row.current_c];
    }

    /** Goes this many ticks forward, or back if negative, and stops the time. */
    go(count: number): void {
        if (this.playing) {
            this.play(false);
        }
        const age = this.age - count;
        if (age < 0) {
            this.act({ run: -age * this.tick });
        }
        this.look(age);
    }

    /** Brings the tick `age` before the newest into view. */
    look(age: number): void {
        this.age = Math.max(0, Math.min(Math.round(age), this.history.length - 1));
        this.#changed = true;
    }

    /** Returns the number of rows from a time of the run to the newest row. */
    ageOf(time: number): number {
        const { history, tick } = this;
        return history.length === 0 ? 0 : Math.max(0, Math.min(history.length - 1, Math.round((history.at(0, "time") - time) / tick)));
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
            // The state of a component is a proxy, which messages cannot contain.
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
                this.tick = answer.tick;
                this.age = 0;
                this.problem = undefined;
                return;
            case "ran":
                this.#ran(answer);
                return this.#openWanted();
            case "run":
                return this.#told(answer.run);
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
            // While looking back, the tick in view stays the same.
            this.age = Math.min(this.age + rows[0].length, this.history.length - 1);
        }
    }

    #draw(): void {
        if (this.#changed && this.history.length > 0) {
            this.#changed = false;
            this.length = this.history.length;
            this.row = this.history.row(this.age);
            const entered = this.history.entered(this.age);
            // The array is replaced only when it has changed, so that its pictures are not drawn again in
            // vain.
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

/** Returns the waveforms that end at a time of the run. */
export function until(simulation: Simulation, time: () => number): Source {
    const { history } = simulation;
    return {
        history,
        get shown() {
            return simulation.shown;
        },
        get age() {
            return simulation.ageOf(time());
        },
        get row() {
            return history.length === 0 ? simulation.row : history.row(simulation.ageOf(time()));
        },
        get tick() {
            return simulation.tick;
        },
    };
}
