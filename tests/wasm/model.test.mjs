// What the explainer's pictures know of a motor is what the drive does and the bench shows.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { test } from "node:test";
import { fileURLToPath, pathToFileURL } from "node:url";
import { Bench, Motor } from "../../wasm/pkg/node/narx.js";

const { runnerImport } = await import(pathToFileURL(createRequire(new URL("../../wasm/web/package.json", import.meta.url)).resolve("vite")));

async function source(name) {
    const path = fileURLToPath(new URL(`../../wasm/web/src/learn/${name}`, import.meta.url));
    return (await runnerImport(path, { configFile: false, logLevel: "error" })).module;
}

const model = await source("model.ts");
const { MOTOR } = await source("motors.ts");

/** A motor that turns slowly under load, as columns. */
function run() {
    const bench = new Bench(new Motor(MOTOR), { supplyVoltage: 24, mode: "hall", load: { constant: 0.05 } });
    bench.run(0.6);
    bench.start(500);
    bench.run(1);
    const trace = bench.run(0.2);
    return Object.fromEntries(Bench.signals().map(({ name }) => [name, trace.column(name)]));
}

test("sectors, steps and hall codes are the drive's", () => {
    const { angle, sector, step, hall } = run();
    let agree = 0;
    for (let row = 1; row < angle.length; row++) {
        assert.equal(model.sectorOf(angle[row]), sector[row], `${angle[row]} degrees`);
        // The drive has read them in the tick before.
        const lines = [angle[row - 1], angle[row]].map((degrees) => model.hallOf(degrees));
        assert.ok(lines.includes(hall[row]), `${angle[row]} degrees`);
        agree += Number(model.stepFor(sector[row]) === step[row]);
    }
    // The one or two ticks of a sector's 50 in which the drive is just about to commutate.
    assert.ok(agree > 0.95 * angle.length, `${agree} of ${angle.length}`);
});

/** Rows around which the step has not changed: ten ticks after a commutation the winding that was left has given up its energy. */
function settled(step) {
    return [...step.keys()].filter((row) => row >= 10 && row + 2 < step.length && step.slice(row - 10, row + 3).every((number) => number === step[row]));
}

test("a floating phase carries no current, the switched one takes it in, the low one gives it out", () => {
    const { step, current_a, current_b, current_c } = run();
    const currents = [current_a, current_b, current_c];
    for (const row of settled(step)) {
        for (const [phase, role] of model.legs(step[row]).entries()) {
            const current = currents[phase][row];
            const expected = { floating: Math.abs(current) < 0.02, switched: current > 0.5, low: current < -0.5 }[role];
            assert.ok(expected, `row ${row}: ${current} A in a ${role} leg`);
        }
    }
    assert.ok(settled(step).length > 1000);
});

test("the torque of a step follows from the trapezoids", () => {
    const { step, angle, torque, current_a, current_b, current_c } = run();
    for (const row of settled(step)) {
        const e = model.trapezoid(angle[row]);
        const expected = (MOTOR.torqueConstant / 2) * (e[0] * current_a[row] + e[1] * current_b[row] + e[2] * current_c[row]);
        // Currents of an instant against the mean torque of the period before, which the ripple parts.
        assert.ok(Math.abs(torque[row] - expected) < 0.15 * expected, `row ${row}: ${torque[row]} N m, ${expected}`);
    }
});

test("the currents that the chapter on hall sensors quotes", () => {
    const peak = (hallOffset) => {
        const bench = new Bench(new Motor(MOTOR), { supplyVoltage: 24, mode: "hall", load: { constant: 0.05 }, hallOffset });
        bench.run(0.6);
        bench.start(2000);
        bench.run(1.2);
        return Math.max(...bench.run(0.05).column("peak_current"));
    };
    const text = readFileSync(new URL("../../wasm/web/src/learn/chapters/HallSensors.svelte", import.meta.url), "utf8");
    const quoted = /At 30° late the peak is ([\d.]+) A, at 30° early ([\d.]+) A, aligned ([\d.]+) A/.exec(text.replaceAll(/\s+/g, " ")).slice(1).map(Number);
    assert.deepEqual([30, -30, 0].map(peak).map((current) => Number(current.toFixed(1))), quoted);
});
