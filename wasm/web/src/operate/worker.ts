// The bench in a worker: it runs in step with the wall clock, and the page only draws.

import init, { Bench, Motor, type MotorName, type Trace } from "narx";
import initCore, { replay } from "narx/core";
import type { Answer, Now, Request, Rows } from "./messages";

/** Between two runs, ms: a picture of a usual screen. */
const PERIOD = 16;
/** What is simulated at once, s. A computer that is too slow for more falls behind the clock. */
const RUN_MAX = 0.1;
/** Rows between two that are drawn: 1 ms at 10 kHz. */
const STRIDE = 10;

let bench: Bench | undefined;
let paused = false;
let before = 0;

function answer(message: Answer, transfer: Transferable[] = []): void {
    postMessage(message, { transfer });
}

function title(name: MotorName): string {
    const motor = Motor.preset(name);
    const text = `${motor.maker} ${motor.part}`;
    motor.free();
    return text;
}

function open(name: MotorName): void {
    const motor = Motor.preset(name);
    bench?.free();
    bench = new Bench(motor, { supplyVoltage: motor.nominalVoltage ?? 24 });
    motor.free();
    const { speedMin, speedMax, notes } = bench;
    answer({ kind: "opened", speedMin, speedMax, notes });
}

/** Every tenth row. */
function thin(trace: Trace): Rows {
    const every = (column: Float32Array | Float64Array) => column.filter((_, row) => row % STRIDE === 0);
    return {
        time: every(trace.time) as Float64Array,
        speed: every(trace.column("speed")) as Float32Array,
        setpoint: every(trace.column("setpoint")) as Float32Array,
    };
}

function latest(bench: Bench): Now {
    return {
        time: bench.time,
        state: bench.state,
        stateName: bench.stateName,
        speed: bench.value("speed"),
        current: bench.value("bus_current"),
        voltage: bench.value("bus_voltage"),
        fault: bench.state === 6 ? bench.fault?.meaning : undefined,
    };
}

function run(): void {
    const now = performance.now();
    const elapsed = Math.min((now - before) / 1000, RUN_MAX);
    before = now;
    if (bench && !paused) {
        const trace = bench.run(elapsed);
        const rows = thin(trace);
        trace.free();
        answer({ kind: "ran", rows, now: latest(bench) }, [rows.time.buffer, rows.speed.buffer, rows.setpoint.buffer]);
    }
    setTimeout(run, PERIOD);
}

function handle(request: Request): void {
    switch (request.kind) {
        case "open":
            return open(request.motor);
        case "start":
            return bench?.start(request.rpm);
        case "setSpeed":
            return bench?.setSpeed(request.rpm);
        case "stop":
            return bench?.stop();
        case "pause":
            paused = request.paused;
            return;
        case "replay":
            return answer({ kind: "replayed", name: request.name, found: replay(request.bytes) });
    }
}

addEventListener("message", ({ data }: MessageEvent<Request>) => {
    try {
        handle(data);
    } catch (error) {
        const reason = error instanceof Error ? error.message : String(error);
        answer({ kind: "refused", reason, name: data.kind === "replay" ? data.name : undefined });
    }
});

await Promise.all([init(), initCore()]);
answer({ kind: "motors", motors: Motor.presets().map((name) => ({ name, title: title(name) })) });
before = performance.now();
run();
