// The bench of a chapter, in a worker: time runs at the pace that the reader has chosen, and every control
// tick is reported.

import init, { Bench, Motor, type BusFrame, type Trace } from "narx";
import initCore, { decode } from "narx/core";
import { apply, perform, type Input } from "narx/script";
import { KEPT, type Action, type Answer, type Received, type Request, type Rows, type Setup } from "./messages";

/** Time between two runs, ms: one picture of a common screen. */
const PERIOD = 16;
/** Longest run at once, s. A computer that is too slow for more falls behind the clock. */
const RUN_MAX = 0.05;
/** Largest number of ticks in one report: as many as a page keeps. */
const TOLD_MAX = 30_000;

let bench: Bench | undefined;
let setup: Setup | undefined;
/** Every call of the bench, for a copy of its run. */
let inputs: Input[] = [];
let pace = 0;
let before = 0;
/** Requested time that was not simulated yet, less than a tick, s. */
let owed = 0;

function answer(message: Answer, transfer: Transferable[] = []): void {
    postMessage(message, { transfer });
}

function tell(rows: Rows, acted?: number): void {
    const fault = bench?.state === 6 ? bench.fault?.meaning : undefined;
    const frames = (bench?.takeFrames() ?? []).map(read);
    answer({ kind: "ran", rows, frames, acted, fault }, rows.map((column) => column.buffer));
}

function read(frame: BusFrame): Received {
    return setup?.decoded ? { ...frame, message: decode(frame) } : frame;
}

function rowsOf(trace: Trace): Rows {
    const rows = KEPT.map((name) => Float64Array.from(trace.column(name)));
    trace.free();
    return rows;
}

/** Joins rows, and keeps the last `TOLD_MAX` ticks of them. */
function joined(parts: Rows[]): Rows {
    return KEPT.map((_, column) => {
        const length = parts.reduce((sum, part) => sum + part[column].length, 0);
        const all = new Float64Array(length);
        let at = 0;
        for (const part of parts) {
            all.set(part[column], at);
            at += part[column].length;
        }
        return all.slice(-TOLD_MAX);
    });
}

function act(bench: Bench, actions: Action[]): void {
    // Reports earlier frames first: they are no effect of these actions.
    tell(joined([]));
    const began = bench.time;
    const parts: Rows[] = [];
    for (const action of actions) {
        if ("run" in action) {
            parts.push(rowsOf(bench.run(action.run)));
        } else if ("until" in action) {
            const value = bench.value(action.until);
            for (let left = action.seconds * bench.tickRate; left > 0 && bench.value(action.until) === value; left--) {
                bench.step();
            }
            parts.push(rowsOf(bench.takeTrace()));
        } else {
            const input = { ...action, tick: bench.ticks } as Input;
            apply(bench, input);
            inputs.push(input);
        }
    }
    tell(joined(parts), began);
}

function open(wanted: Setup): void {
    const { motor, options, before } = wanted;
    const made = typeof motor === "string" ? Motor.preset(motor) : new Motor(motor);
    try {
        // Without a recording, which would only grow and is not used.
        const fresh = new Bench(made, { ...options, recording: false });
        bench?.free();
        [bench, setup, inputs] = [fresh, wanted, []];
    } finally {
        made.free();
    }
    owed = 0;
    answer({ kind: "opened", tick: 1 / bench.tickRate });
    act(bench, before);
}

/** Answers with the run up to the tick `age` before the newest; its digest is that of the run made again. */
function run(bench: Bench, { motor, options }: Setup, age: number): void {
    const ticks = bench.ticks - age;
    const past = inputs.filter(({ tick }) => tick <= ticks);
    const again = perform({ motor, options, inputs: past, ticks });
    const { digest } = again;
    again.free();
    // The bench of the panels passes to the page's master when time runs on.
    answer({ kind: "run", run: { setup: { motor, options: { ...options, operator: true } }, inputs: past, ticks, digest } });
}

function pass(): void {
    const now = performance.now();
    owed += Math.min(((now - before) / 1000) * pace, RUN_MAX);
    before = now;
    const ticks = bench ? Math.floor(owed * bench.tickRate) : 0;
    if (bench && ticks > 0) {
        const seconds = ticks / bench.tickRate;
        owed -= seconds;
        tell(rowsOf(bench.run(seconds)));
    }
    setTimeout(pass, PERIOD);
}

async function begin(narx: WebAssembly.Module, core?: WebAssembly.Module): Promise<void> {
    await Promise.all([init({ module_or_path: narx }), core && initCore({ module_or_path: core })]);
    answer({ kind: "ready" });
    before = performance.now();
    pass();
}

function handle(request: Request): void | Promise<void> {
    switch (request.kind) {
        case "begin":
            return begin(request.narx, request.core);
        case "open":
            return open(request.setup);
        case "pace":
            pace = request.pace;
            owed = 0;
            return;
        case "act":
            if (bench) {
                act(bench, request.actions);
            }
            return;
        case "run":
            if (bench && setup) {
                run(bench, setup, request.age);
            }
            return;
    }
}

addEventListener("message", async ({ data }: MessageEvent<Request>) => {
    try {
        await handle(data);
    } catch (error) {
        answer({ kind: "refused", reason: error instanceof Error ? error.message : String(error) });
    }
});
