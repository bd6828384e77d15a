// What a picture's worth of simulation costs: processor time of 16.7 ms of a turning motor, `node tests/wasm/bench_frame.mjs [FRAMES]`. Aim: 0.5 ms.
// It measures and asserts nothing: how fast a machine is, is no property of the code. Profile with `node --cpu-prof tests/wasm/bench_frame.mjs`.

import { argv, cpuUsage } from "node:process";
import { Bench, Motor } from "../../wasm/pkg/node/narx.js";

/** Between two pictures, s. */
const FRAME = 1 / 60;
const MODES = ["hall", "sensorless", "open-loop"];
const frames = Number(argv[2] ?? 500);

/** A motor that turns at its speed. */
function running(mode) {
    const bench = new Bench(Motor.preset("bly172s-24v"), { supplyVoltage: 24, mode });
    bench.start(mode === "open-loop" ? Math.ceil(bench.speedMin) : 2000);
    bench.run(2, false).free();
    return bench;
}

/** Processor time of each frame, ms, from the smallest. The clock of the process counts microseconds, and what others do does not count. */
function measure(bench, rows) {
    const times = [];
    for (let frame = 0; frame < frames; frame++) {
        const before = cpuUsage();
        bench.run(FRAME, rows).free();
        const { user, system } = cpuUsage(before);
        times.push((user + system) / 1000);
    }
    return times.sort((one, other) => one - other);
}

console.log(`${frames} frames of ${(FRAME * 1000).toFixed(1)} ms each: processor time, ms\n`);
console.log("mode         rows     minimum    median   maximum");
for (const mode of MODES) {
    for (const rows of [false, true]) {
        const bench = running(mode);
        // The engine's compilers are done with it then.
        measure(bench, rows);
        const times = measure(bench, rows);
        const [least, middle, most] = [times[0], times[times.length >> 1], times.at(-1)].map((time) => time.toFixed(3).padStart(10));
        console.log(`${mode.padEnd(12)} ${(rows ? "with" : "without").padEnd(7)}${least}${middle}${most}`);
        bench.free();
    }
}
