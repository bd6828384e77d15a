// What the page must load and compute: compressed bytes of each module, and how long the bench takes in Node for a sixtieth of a second of motor.
// Prints `NAME FIGURE` a line, bytes and ms; `cargo xtask bench --only page` reads them.

import { readFileSync } from "node:fs";
import { performance } from "node:perf_hooks";
import { gzipSync } from "node:zlib";
import { Bench, Motor } from "../../wasm/pkg/node/narx.js";

const FRAMES = 300;

for (const module of ["narx", "core", "lab"]) {
    const bytes = readFileSync(new URL(`../../wasm/pkg/web/${module}_bg.wasm`, import.meta.url));
    console.log(`${module}.gzip ${gzipSync(bytes, { level: 9 }).length}`);
}

for (const mode of ["hall", "sensorless"]) {
    const bench = new Bench(Motor.preset("bly172s-24v"), { supplyVoltage: 24, mode });
    bench.run(0.6);
    bench.start(3000);
    bench.run(2);
    const times = Array.from({ length: FRAMES }, () => {
        const begun = performance.now();
        bench.run(1 / 60);
        return performance.now() - begun;
    }).sort((a, b) => a - b);
    if (Math.abs(bench.value("speed") - 3000) > 60) throw new Error(`${mode}: ${bench.value("speed")} rpm`);
    console.log(`${mode}.median ${times[FRAMES / 2].toFixed(3)}`);
    console.log(`${mode}.p99 ${times[Math.floor(FRAMES * 0.99)].toFixed(3)}`);
}
