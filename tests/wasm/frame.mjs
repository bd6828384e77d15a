// What the page must load and compute: compressed bytes of each module, and processor time of 16.7 ms of a turning motor, a picture's worth, in Node.
// Prints `NAME FIGURE` a line, bytes and ms; `cargo xtask bench --only page` reads them. It asserts nothing about time: how fast a machine is, is no
// property of the code. `node --no-turbo-inline-js-wasm-calls tests/wasm/frame.mjs [FRAMES]`; profile with `node --cpu-prof`.

import { readFileSync } from "node:fs";
import { argv, cpuUsage } from "node:process";
import { gzipSync } from "node:zlib";
import { Bench, Motor } from "../../wasm/pkg/node/narx.js";

const frames = Number(argv[2] ?? 500);

for (const module of ["narx", "core", "lab"]) {
    const bytes = readFileSync(new URL(`../../wasm/pkg/web/${module}_bg.wasm`, import.meta.url));
    console.log(`${module}.gzip ${gzipSync(bytes, { level: 9 }).length}`);
}

/** A motor that turns at its speed. */
function running(mode) {
    const bench = new Bench(Motor.preset("bly172s-24v"), { supplyVoltage: 24, mode });
    const speed = mode === "open-loop" ? Math.ceil(bench.speedMin) : 2000;
    bench.start(speed);
    bench.run(2, false).free();
    const error = bench.value("speed") / speed - 1;
    if (mode !== "open-loop" && Math.abs(error) > 0.02) throw new Error(`${mode}: ${bench.value("speed")} rpm`);
    return bench;
}

/** Processor time of each frame, ms, from the smallest. The clock of the process counts microseconds, and what others do does not count. */
function measure(bench, rows) {
    const times = [];
    for (let frame = 0; frame < frames; frame++) {
        const before = cpuUsage();
        bench.run(1 / 60, rows).free();
        const { user, system } = cpuUsage(before);
        times.push((user + system) / 1000);
    }
    return times.sort((one, other) => one - other);
}

for (const mode of ["hall", "sensorless", "open-loop"]) {
    for (const [rows, name] of [[false, mode], [true, `${mode}.rows`]]) {
        const bench = running(mode);
        // The engine's compilers are done with it then.
        measure(bench, rows);
        const times = measure(bench, rows);
        console.log(`${name}.median ${times[times.length >> 1].toFixed(3)}`);
        console.log(`${name}.p99 ${times[Math.floor(times.length * 0.99)].toFixed(3)}`);
        bench.free();
    }
}
