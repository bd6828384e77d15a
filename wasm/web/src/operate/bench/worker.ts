// The bench in a worker: it runs in step with the clock, and the page only draws.

import init, { Bench, Motor, type BusFrame } from "narx";
import initFull, * as full from "narx/full";
import { pack } from "./frames";
import { JournalledBench, type Kit } from "./journal";
import type { Answer, MotorEntry, Request, Rows, Setup } from "./messages";
import type { Run } from "./run";

/** Time between two pieces of a run, ms. */
const PERIOD = 8;
/** Ticks of a piece in real time. Inputs come at the ends of pieces, so their ticks are round numbers, which
 * keeps a link short. */
const PIECE = 50;
/** Longest run at once, s. A computer that is too slow for more falls behind the clock. */
const BEHIND_MAX = 0.05;
/** Largest number of reports that the page has not processed yet. A busy page stops the time of the bench, so
 * that its set-points do not come too late. */
const UNACKNOWLEDGED_MAX = 2;
/** Length of the rows and frames that are sent before an instant to which a run returns, s: enough for the
 * rolling plots, and for a new master. */
const BEFORE = 8;
/** Time from power-up that is simulated at once, s: nobody waits for the boot of a virtual drive. */
const BOOT = 0.55;
/** Opcode of answers about parameters, in the low bits of an identifier. */
const [OPCODE, PARAMETER] = [0x1ff, 110];

/** The run that is being repeated; a request that changes its course ends this. */
let repeated: JournalledBench | undefined;
let journal: JournalledBench | undefined;
let pace = 1;
let before = 0;
let unacknowledged = 0;
/** Ticks that are due, with their fraction. */
let due = 0;

function answer(message: Answer, transfer: Transferable[] = []): void {
    postMessage(message, { transfer });
}

function report(journal: JournalledBench, ticks: number): void {
    const { rows, frames } = journal.advance(ticks);
    unacknowledged += 1;
    answer({ kind: "ran", now: journal.now(pace), rows, frames: pack(frames) }, buffers(rows));
}

function buffers(rows: Rows): Transferable[] {
    return Object.values(rows).map((column) => column.buffer);
}

/** Returns the bindings with such a bench. */
function kit(setup: Setup): Kit {
    return setup.full ? full : { Bench, Motor };
}

function open(request: Request & { kind: "open" }): void {
    const powered = new JournalledBench(request.setup, kit(request.setup));
    request.actions.forEach((action) => powered.act(action));
    pace = 1;
    begin(powered);
    report(powered, Math.ceil((BOOT * powered.bench.tickRate) / PIECE) * PIECE);
}

function begin(opened: JournalledBench): void {
    journal?.free();
    repeated = undefined;
    journal = opened;
    due = 0;
    const { speedMin, speedMax, notes, tickRate } = opened.bench;
    answer({ kind: "opened", setup: opened.setup, speedMin, speedMax, notes, tickRate });
}

/** Repeats a run as fast as possible, and stops the time at its end; ends early if another drive is
 * opened. */
async function reproduce(run: Run): Promise<void> {
    const made = new JournalledBench(run.setup, kit(run.setup), run);
    pace = 0;
    begin(made);
    repeated = made;
    const begins = run.ticks - BEFORE * made.bench.tickRate;
    const parameters: BusFrame[] = [];
    while (made.bench.ticks < begins) {
        parameters.push(...made.skip(begins).filter(({ id, extended }) => extended && (id & OPCODE) === PARAMETER));
        answer({ kind: "repeating", now: made.now(pace) });
        // Lets requests be handled in between.
        await new Promise((resolve) => setTimeout(resolve));
        if (repeated !== made) {
            return;
        }
    }
    seek(run.ticks, parameters);
    const { digest } = await made.run();
    if (repeated === made) {
        answer({ kind: "reproduced", digest, expected: run.digest });
    }
}

/** Returns to a tick. `earlier`: frames from before those that the page gets. */
function seek(tick: number, earlier: readonly BusFrame[] = []): void {
    const sought = opened();
    const { rows, frames } = sought.seek(tick, BEFORE * sought.bench.tickRate);
    [pace, due] = [0, 0];
    answer({ kind: "sought", now: sought.now(pace), rows, frames: pack([...earlier, ...frames]) }, buffers(rows));
}

function turn(): void {
    const now = performance.now();
    const elapsed = Math.min((now - before) / 1000, BEHIND_MAX);
    before = now;
    if (journal && pace > 0 && unacknowledged < UNACKNOWLEDGED_MAX) {
        due += elapsed * pace * journal.bench.tickRate;
        const piece = pace < 0.5 ? 1 : PIECE;
        const ticks = Math.floor(due / piece) * piece;
        if (ticks > 0) {
            due -= ticks;
            report(journal, ticks);
        }
    }
    setTimeout(turn, PERIOD);
}

function opened(): JournalledBench {
    if (!journal) {
        throw new Error("no virtual drive is powered up");
    }
    return journal;
}

function handle(request: Request): void | Promise<void> {
    if (["act", "step", "seek"].includes(request.kind) || (request.kind === "pace" && request.pace > 0)) {
        repeated = undefined;
    }
    switch (request.kind) {
        case "begin":
            return initialise(request.narx);
        case "full":
            return initFull({ module_or_path: request.module }).then(() => undefined);
        case "open":
            return open(request);
        case "act":
            return request.actions.forEach((action) => opened().act(action));
        case "received":
            unacknowledged -= 1;
            return;
        case "pace":
            pace = request.pace;
            due = 0;
            return report(opened(), 0);
        case "step":
            return report(opened(), request.ticks);
        case "seek":
            return seek(request.tick);
        case "reproduce":
            return reproduce(request.run);
        case "run":
            return opened().run().then((run) => answer({ kind: "run", run }));
        case "recording":
            return opened().recording().then((bytes) => answer({ kind: "recording", bytes }));
    }
}

addEventListener("message", async ({ data }: MessageEvent<Request>) => {
    try {
        await handle(data);
    } catch (error) {
        const reason = error instanceof Error ? error.message : String(error);
        answer({ kind: "refused", request: data.kind, reason });
    }
});

function entry(name: MotorEntry["name"]): MotorEntry {
    const motor = Motor.preset(name);
    const { polePairs, resistance, inductance, torqueConstant, inertia, staticFriction, viscousFriction } = motor;
    const data = { polePairs, resistance, inductance, torqueConstant, inertia, staticFriction, viscousFriction };
    const found = { name, title: `${motor.maker} ${motor.part}`, nominalVoltage: motor.nominalVoltage ?? 24, data };
    motor.free();
    return found;
}

async function initialise(narx: WebAssembly.Module): Promise<void> {
    await init({ module_or_path: narx });
    answer({ kind: "ready", motors: Motor.presets().map(entry), inputs: Bench.inputs(), injections: Bench.injections() });
    before = performance.now();
    turn();
}
