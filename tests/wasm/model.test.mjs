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
const { LISTENING, STARTING } = await source("pictures/states.ts");
const motors = await source("motors.ts");
const history = await source("history.ts");
const { MOTOR } = motors;

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

/** A bench of the chapters that turns. */
function turning(options = {}, rpm = 2000) {
    const bench = new Bench(new Motor(MOTOR), { supplyVoltage: 24, mode: "hall", load: { constant: 0.03 }, ...options });
    bench.run(0.6);
    bench.start(rpm);
    bench.run(1.2);
    return bench;
}

/** Time until a bench is in a state, s. */
function until(bench, state, limit = 4) {
    const began = bench.time;
    while (bench.state !== state && bench.time < began + limit) {
        bench.step();
        bench.takeTrace().free();
    }
    assert.equal(bench.state, state);
    return bench.time - began;
}

test("the times that the chapter on faults tells are the drive's", () => {
    const blocked = turning();
    blocked.inject("blocked-rotor");
    // Half a second of torque at speed 0, which takes a moment to be known.
    const stall = until(blocked, 6);
    assert.ok(stall > 0.5 && stall < 0.65, `${stall} s`);
    // Half a second from the fault until Standby is accepted.
    blocked.clear();
    blocked.stop();
    const acknowledged = until(blocked, 1);
    assert.ok(Math.abs(acknowledged - 0.5) < 0.06, `${acknowledged} s`);
    // In the tick that detects it.
    const driver = turning();
    driver.inject("driver", { phase: "A" });
    assert.ok(until(driver, 6) < 3e-4);
    // Without sensors it listens.
    const sensorless = turning({ mode: "sensorless" });
    assert.equal(sensorless.state, 4);
    sensorless.inject("blocked-rotor");
    until(sensorless, 7);
    const listened = until(sensorless, 1);
    assert.ok(Math.abs(listened - LISTENING) < 1e-3, `${listened} s`);
});

test("the sensorless start of the chapter needs six crossings, and knows no inertia", () => {
    for (const flywheel of [0, 10]) {
        const bench = new Bench(new Motor(MOTOR), { supplyVoltage: 24, mode: "sensorless", load: { constant: 0.01, inertia: flywheel * MOTOR.inertia } });
        bench.run(0.6);
        bench.start(1500);
        until(bench, 3);
        const began = bench.time;
        let [crossings, step, margin, known] = [0, bench.value("step"), bench.value("crossing_margin"), 0];
        // Times from an accepted crossing to the next step, s; undefined if there was none.
        const waits = [];
        let crossed;
        while (bench.state === 3) {
            bench.step();
            if (bench.value("crossing") === 1 && bench.value("crossing_margin") !== margin) {
                [margin, crossed] = [bench.value("crossing_margin"), bench.time];
                crossings += 1;
            }
            if (bench.value("step") !== step) {
                step = bench.value("step");
                waits.push(crossed === undefined ? undefined : bench.time - crossed);
                crossed = undefined;
            }
            known ||= bench.value("speed_estimated") > 0 ? crossings : 0;
        }
        bench.takeTrace().free();
        assert.equal(bench.state, 4);
        // The speed is controlled after six; the state goes on until its time is over.
        assert.ok(known >= model.PREPARED && known <= model.PREPARED + 1, `${known} crossings with ${flywheel} inertias`);
        assert.ok(crossings > known, `${crossings} crossings with ${flywheel} inertias`);
        assert.ok(Math.abs(bench.time - began - 0.12) < 1e-3, `${bench.time - began} s`);
        // At once at first, later half a sector behind the crossing.
        const [first, last] = [waits.find((wait) => wait !== undefined), waits.at(-1)];
        assert.ok(first <= 2e-4 && last > 1.5e-3, waits.join());
    }
});

test("the curves of a long run are means: a signal that swings within a sector is no slow one", () => {
    const row = (at) => (at % 21 < 10 ? 1 : 0);
    const read = (at) => (_, before = 0) => row(at - before);
    const single = [...Array(50).keys()].map((point) => row(20 * point + 100));
    assert.ok(single.includes(0) && single.includes(1), "rows of their own show a swing that is not there");
    for (let point = 0; point < 50; point++) {
        assert.ok(Math.abs(history.mean("speed", 20)(read(20 * point + 100)) - 0.5) < 0.06);
    }
});

test("the drive bears the largest load and inductance of the chapter on demagnetisation, and no more load", () => {
    const chapter = readFileSync(new URL("../../wasm/web/src/learn/chapters/Demagnetisation.svelte", import.meta.url), "utf8");
    const most = Number(/const LOAD_MAX = (\d+);/.exec(chapter)[1]);
    for (const [load, restarts] of [[most, false], [most + 20, true]]) {
        const bench = new Bench(new Motor({ ...MOTOR, inductance: 2e-3 }), { supplyVoltage: 24, mode: "sensorless", load: { constant: load / 1000 } });
        bench.run(0.6);
        bench.start(1500);
        until(bench, 4);
        bench.run(1);
        const trace = bench.run(5);
        assert.equal(trace.column("state").includes(7), restarts, `${load} mN m`);
        trace.free();
    }
});

test("a sector has the samples that the chapter on back-EMF tells", () => {
    assert.equal(motors.samplesPerSector(4000), 6);
    const trace = turning({}, 4000).run(0.05);
    const [step, { time }] = [trace.column("step"), trace];
    const changes = [...step.keys()].filter((row) => row > 0 && step[row] !== step[row - 1]).map((row) => time[row]);
    const sector = (changes.at(-1) - changes[0]) / (changes.length - 1);
    assert.ok(Math.abs(sector - motors.sectorTime(4000)) < 0.05 * sector, `${sector} s`);
});

test("the boot time and the crossings of a sensorless start are the drive's", () => {
    const bench = new Bench(new Motor(MOTOR), { supplyVoltage: 24, mode: "hall" });
    const booted = until(bench, 1);
    assert.ok(Math.abs(booted - STARTING) < 1e-3, `${booted} s`);
    const core = readFileSync(new URL("../../core/src/motor/rotor/zero_crossing.rs", import.meta.url), "utf8");
    assert.equal(model.PREPARED, Number(/const PREPARED: u8 = (\d+);/.exec(core)[1]));
});
