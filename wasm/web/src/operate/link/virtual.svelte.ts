// The bench in its worker, as a link, with the functions that only a bench has.

import type { Frame, InjectionKind, Input } from "narx";
import { unpack } from "../bench/frames";
import { motorName, type Action, type Answer, type MotorEntry, type Now, type Request, type Rows, type Setup } from "../bench/messages";
import type { Run } from "../bench/run";
import BenchWorker from "../bench/worker?worker&inline";
import { module } from "../../modules";
import { History } from "../../plot/history";
import { Pulse } from "../../plot/pulse.svelte";
import type { Link, Listener } from "./link";

/** Motors, inputs and faults that the worker offers. */
export interface Known {
    motors: MotorEntry[];
    inputs: Input[];
    injections: InjectionKind[];
}

/** A run that was repeated. */
export interface Reproduced {
    digest: string;
    expected: string;
}

/** A run before its first tick. */
const BEGIN: Now = { time: 0, ticks: 0, end: 0, pace: 1, truth: { state: 0, speed: 0, angle: 0, bus_current: 0 }, acting: { load: {}, faults: [] } };

class VirtualDrive {
    known = $state.raw<Known>();
    opened = $state.raw<Answer & { kind: "opened" }>();
    #now = BEGIN;
    readonly #pulse = new Pulse();
    /** Simulated seconds in a second while time runs. */
    pace = $state(1);
    reproduced = $state.raw<Reproduced>();
    /** Reason why the last request was refused. */
    problem = $state<string>();
    /** The true signals of the run. */
    readonly rows = new History();
    #worker: Worker | undefined;
    /** Settles once the worker has got its module. */
    #begun: Promise<void> = Promise.resolve();
    #hasFull = false;
    #listener: Listener | undefined;
    #queue: Action[] = [];
    /** True while the past is shown: a run is being repeated, or has returned to an instant. Its journal
     * contains the frames that were sent then, so no others may be sent. */
    #repeats = false;
    /** Tick to which the run returns, and the next one, which is used once that is done. */
    #sought: { tick: number; next?: number } | undefined;
    #waiting: ((answer: Answer) => boolean)[] = [];

    /** Present time; its effects run a few times a second. */
    get now(): Now {
        this.#pulse.read();
        return this.#now;
    }

    /** Powers a virtual drive up, with actions before its first tick. Rejects with an Error for an invalid
     * set-up. */
    async open(setup: Setup, actions: Action[], listener: Listener): Promise<Link> {
        this.reproduced = undefined;
        this.#repeats = false;
        return this.#connect({ kind: "open", setup, actions }, listener);
    }

    /** Repeats a run; the time stops at its end. */
    async reproduce(run: Run, listener: Listener): Promise<Link> {
        this.reproduced = undefined;
        this.#repeats = true;
        return this.#connect({ kind: "reproduce", run }, listener);
    }

    act(action: Action): void {
        this.#repeats = false;
        this.#ask({ kind: "act", actions: [action] });
    }

    pause(): void {
        this.#ask({ kind: "pace", pace: 0 });
    }

    /** Lets the time run at `pace`. */
    resume(): void {
        this.#repeats = false;
        this.#ask({ kind: "pace", pace: this.pace });
    }

    step(ticks: number): void {
        this.#repeats = false;
        this.#ask({ kind: "step", ticks });
    }

    /** Returns to a tick of the run and stops the time there. The later part of the run is removed once time
     * runs or an action is carried out. */
    seek(tick: number): void {
        this.#repeats = true;
        if (this.#sought) {
            this.#sought.next = tick;
        } else {
            this.#sought = { tick };
            this.#ask({ kind: "seek", tick });
        }
    }

    /** Returns everything that determines the run so far. */
    async run(): Promise<Run> {
        return (await this.#answer({ kind: "run" }, "run")).run;
    }

    /** Returns the recording of the drive since it last booted. */
    async recording(): Promise<Uint8Array> {
        return (await this.#answer({ kind: "recording" }, "recording")).bytes;
    }

    /** Starts the worker, which reports the known motors. */
    start(): void {
        if (this.#worker) {
            return;
        }
        const worker = (this.#worker = new BenchWorker());
        this.#worker.addEventListener("message", ({ data }: MessageEvent<Answer>) => this.#handle(data));
        this.#worker.addEventListener("error", ({ message }) => {
            this.problem = `The simulation cannot run in this browser: ${message}`;
        });
        this.#begun = module("narx").then((narx) => worker.postMessage({ kind: "begin", narx } satisfies Request));
        this.#begun.catch(({ message }: Error) => (this.problem = message));
    }

    async #connect(request: Request & { kind: "open" | "reproduce" }, listener: Listener): Promise<Link> {
        // Frames of the previous bench are dropped.
        this.#listener = undefined;
        this.start();
        await this.#begun;
        if ((request.kind === "open" ? request.setup : request.run.setup).full && !this.#hasFull) {
            this.#ask({ kind: "full", module: await module("full") });
            this.#hasFull = true;
        }
        const { setup } = await this.#answer(request, "opened");
        this.#listener = listener;
        const now = () => this.#now.time;
        return {
            name: `Virtual drive, ${motorName(setup)}`,
            readOnly: false,
            get now() {
                return now();
            },
            send: (frame) => this.#send(frame),
            close: () => {
                this.#listener = undefined;
                this.#ask({ kind: "pace", pace: 0 });
            },
        };
    }

    #return({ now, rows, frames }: Answer & { kind: "sought" }): void {
        const next = this.#sought?.next;
        this.#sought = undefined;
        if (next !== undefined && this.#repeats) {
            return this.seek(next);
        }
        this.#tell(now);
        // What is known of later instants stays until time runs from here.
        if (this.rows.end < now.time) {
            this.#append(rows);
        }
        this.#listener?.handleReturn(now.time, unpack(frames));
    }

    #tell(now: Now): void {
        this.#now = now;
        this.#pulse.change();
    }

    #append({ time, ...columns }: Rows): void {
        this.rows.append(time, columns);
    }

    #send(frame: Frame): void {
        if (this.#repeats) {
            return;
        }
        if (this.#queue.length === 0) {
            queueMicrotask(() => this.#worker?.postMessage({ kind: "act", actions: this.#queue.splice(0) } satisfies Request));
        }
        const { id, extended, remote, data } = frame;
        this.#queue.push({ call: "send", id, extended, remote, data: [...data] });
    }

    #ask(request: Request): void {
        this.start();
        this.problem = undefined;
        this.#worker?.postMessage(request);
    }

    #answer<K extends Answer["kind"]>(request: Request, kind: K): Promise<Answer & { kind: K }> {
        return new Promise((resolve, reject) => {
            this.#waiting.push((answer) => {
                if (answer.kind === kind) {
                    resolve(answer as Answer & { kind: K });
                    return true;
                }
                if (answer.kind === "refused" && answer.request === request.kind) {
                    reject(new Error(answer.reason));
                    return true;
                }
                return false;
            });
            this.#ask(request);
        });
    }

    #handle(answer: Answer): void {
        switch (answer.kind) {
            case "ready":
                this.known = answer;
                break;
            case "opened":
                this.opened = answer;
                this.#tell(BEGIN);
                this.pace = 1;
                this.rows.clear();
                break;
            case "ran":
                this.#tell(answer.now);
                this.#append(answer.rows);
                this.#listener?.handle(answer.now.time, unpack(answer.frames));
                // In a microtask, so that it follows the frames that the page sends in reaction to the
                // report.
                return queueMicrotask(() => this.#worker?.postMessage({ kind: "received" } satisfies Request));
            case "repeating":
                this.#tell(answer.now);
                return;
            case "sought":
                return this.#return(answer);
            case "reproduced":
                this.reproduced = answer;
                this.#repeats = false;
                break;
            case "refused":
                this.problem = answer.reason;
                this.#sought = answer.request === "seek" ? undefined : this.#sought;
        }
        this.#waiting = this.#waiting.filter((done) => !done(answer));
    }
}

export const virtualDrive = new VirtualDrive();
