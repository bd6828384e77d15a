// Motors, the bench and its traces in Node.

import assert from "node:assert/strict";
import { test } from "node:test";
import { Bench, Motor } from "../../wasm/pkg/node/narx.js";

const DATA = { polePairs: 4, resistance: 0.36, inductance: 2e-4, torqueConstant: 0.036, inertia: 4.8e-6 };

function bench(options) {
    return new Bench(Motor.preset("bly172s-24v"), { supplyVoltage: 24, ...options });
}

function mean(values) {
    return values.reduce((sum, value) => sum + value, 0) / values.length;
}

test("a preset starts, holds its speed and stops", () => {
    const drive = bench();
    drive.run(0.6);
    assert.equal(drive.state, 1);
    drive.start(2000);
    drive.run(1.4);
    const trace = drive.run(0.5);
    assert.equal(trace.length, 5000);
    assert.equal(drive.state, 5);
    assert.equal(drive.stateName, "Closed-loop Hall Effect Sensors");
    const speed = mean(trace.column("speed"));
    assert.ok(Math.abs(speed - 2000) < 10, `${speed} rpm`);
    drive.setSpeed(1000);
    drive.run(1);
    assert.ok(Math.abs(drive.value("speed") - 1000) < 20);
    drive.stop();
    drive.run(0.1);
    assert.equal(drive.state, 1);
    assert.deepEqual(drive.faults, []);
    assert.equal(drive.fault, undefined);
});

test("every preset reaches the middle of its range", () => {
    for (const name of Motor.presets()) {
        const motor = Motor.preset(name);
        const drive = new Bench(motor, { supplyVoltage: motor.nominalVoltage ?? 24 });
        const rpm = Math.round((drive.speedMin + drive.speedMax) / 2);
        drive.run(0.6, false).free();
        drive.start(rpm);
        drive.run(2.5, false).free();
        const speed = mean(drive.run(0.5).column("speed"));
        assert.ok(Math.abs(speed - rpm) < 0.01 * rpm, `${name}: ${speed} of ${rpm} rpm`);
    }
});

test("without its operator a bench goes on in the same way, until the drive's time-out", () => {
    const [kept, left] = [bench(), bench()];
    for (const drive of [kept, left]) {
        drive.run(0.6);
        drive.start(2000);
        drive.run(1.2);
    }
    left.dismiss();
    assert.throws(() => left.stop(), /no operator/);
    assert.deepEqual(left.run(0.15).column("angle"), kept.run(0.15).column("angle"));
    left.run(0.15);
    assert.equal(left.state, 6);
    assert.equal(kept.state, 5);
    left.dismiss();
    assert.equal(left.state, 6, "once is enough");
});

test("reverse is a negative speed", () => {
    const drive = bench();
    drive.run(0.6);
    drive.start(-1500);
    drive.run(1.4);
    assert.ok(Math.abs(drive.value("speed") + 1500) < 20);
});

test("at a PWM rate of 20 kHz the drive holds the same speed, in finer steps of time", () => {
    assert.equal(bench().tickRate, 10_000);
    const speeds = [10_000, 20_000].map((pwmRate) => {
        const drive = bench({ pwmRate });
        assert.equal(drive.tickRate, pwmRate);
        drive.run(0.6, false).free();
        drive.start(2000);
        drive.run(1.4, false).free();
        const trace = drive.run(0.5);
        assert.equal(trace.length, pwmRate / 2);
        const { time } = trace;
        assert.ok(Math.abs(time[1] - time[0] - 1 / pwmRate) < 1e-9, `${time[1] - time[0]} s`);
        assert.ok(Math.abs(time.at(-1) - 2.5) < 1e-9);
        assert.equal(drive.state, 5);
        return mean(trace.column("speed"));
    });
    for (const speed of speeds) {
        assert.ok(Math.abs(speed - 2000) < 10, `${speed} rpm`);
    }
    assert.ok(Math.abs(speeds[0] - speeds[1]) < 10, `${speeds} rpm`);
});

test("a run has its ticks exactly, also where a period is no whole number of nanoseconds", () => {
    const drive = bench({ pwmRate: 44_100 });
    drive.run(1, false).free();
    assert.equal(drive.ticks, 44_100);
    assert.equal(drive.run(30_000 / drive.tickRate).length, 30_000);
});

test("a trace has an array for each signal, and each run its own rows", () => {
    const drive = bench();
    drive.run(0.1);
    const trace = drive.run(0.01);
    assert.equal(trace.length, 100);
    assert.deepEqual(trace.signals, Bench.signals());
    assert.ok(trace.time instanceof Float64Array);
    assert.ok(trace.column("speed") instanceof Float32Array);
    assert.ok(Math.abs(trace.time.at(-1) - drive.time) < 1e-9);
    assert.equal(trace.column("bus_voltage").at(-1), Math.fround(drive.value("bus_voltage")));
    assert.deepEqual([...drive.values()], trace.signals.map(({ name }) => drive.value(name)));
    assert.throws(() => trace.column("sped"), { name: "TypeError", message: /signal "sped": no such signal; one of time, setpoint/ });
});

test("same options, same bits; another seed, other noise", () => {
    const [one, two, three] = [{}, {}, { seed: 2 }].map((options) => {
        const drive = bench(options);
        drive.run(0.2);
        return drive.recording();
    });
    assert.deepEqual(one, two);
    assert.notDeepEqual(one, three);
});

test("a fault has a name and a meaning", () => {
    const drive = bench({ parameters: { "Over-voltage HV threshold": 20 } });
    drive.run(0.6);
    assert.equal(drive.state, 6);
    assert.deepEqual(drive.faults, ["over_voltage"]);
    assert.equal(drive.fault.code, 0x0201);
    assert.match(drive.fault.meaning, /bus voltage above/);
});

test("a motor of one's own", () => {
    const motor = new Motor({ ...DATA, backEmf: "sinusoidal", ratedCurrent: 4 });
    assert.equal(motor.polePairs, 4);
    assert.equal(motor.maker, undefined);
    const drive = new Bench(motor, { supplyVoltage: 24, load: { constant: 0.01 } });
    assert.ok(drive.speedMin < drive.speedMax);
    drive.run(0.6);
    drive.start(1000);
    drive.run(1);
    assert.ok(Math.abs(drive.value("speed") - 1000) < 20);
});

test("options that cannot be are named with what can", () => {
    const cases = [
        [() => new Motor(), "TypeError", "Motor: polePairs is missing"],
        [() => new Motor(7), "TypeError", "Motor: options must be an object, not 7"],
        [() => new Motor({ ...DATA, polePairs: 2.5 }), "RangeError", "Motor: polePairs 2.5: must be a whole number from 1 to 255"],
        [() => new Motor({ ...DATA, inertia: "heavy" }), "TypeError", 'Motor: inertia "heavy": must be a finite number'],
        [() => new Motor({ ...DATA, staticFriction: -1 }), "RangeError", "Motor: staticFriction -1: must be 0 or more"],
        [() => new Motor({ ...DATA, backEmf: "square" }), "TypeError", 'Motor: backEmf "square": must be one of trapezoidal, sinusoidal'],
        [() => new Motor({ ...DATA, poles: 4 }), "TypeError", /^Motor: no option poles; one of polePairs, resistance/],
        [() => Motor.preset("mn7005"), "TypeError", /^motor "mn7005": no such preset; one of ec45-flat-50w-18v/],
        [() => bench({ supplyVoltage: 12 }), "RangeError", "supply voltage 12 V is outside 18 to 60 V"],
        [() => new Bench(new Motor({ ...DATA, resistance: 0 }), { supplyVoltage: 24 }), "RangeError", "motor resistance 0 must be greater than 0"],
        [() => bench({ mode: "foc" }), "TypeError", 'Bench: mode "foc": must be one of hall, sensorless, open-loop'],
        [() => bench({ seed: -1 }), "RangeError", "Bench: seed -1: must be a whole number from 0 to 9007199254740991"],
        [() => bench({ pwmRate: 7999 }), "RangeError", "Bench: pwmRate 7999: must be a whole number from 8000 to 50000"],
        [() => bench({ pwmRate: 50_001 }), "RangeError", /^Bench: pwmRate 50001: must be/],
        [() => bench({ pwmRate: 9999.5 }), "RangeError", /^Bench: pwmRate 9999.5: must be/],
        [() => bench({ pwmRate: "fast" }), "TypeError", 'Bench: pwmRate "fast": must be a finite number'],
        [() => bench({ load: 1 }), "TypeError", "load: options must be an object, not 1"],
        [() => bench({ parameters: { 9999: 1 } }), "RangeError", "there is no parameter 9999"],
        [() => bench({ parameters: { speed: 1 } }), "TypeError", 'there is no parameter "speed"'],
        [() => bench({ parameters: { 118: -1 } }), "RangeError", /^parameter 118 ".*": -1.* is outside /],
        [() => bench().start(1.5), "RangeError", "start 1.5: must be a whole number from -65535 to 65535"],
        [() => bench().setSpeed(-1), "RangeError", "setSpeed -1: must be a whole number from 0 to 65535"],
        [() => bench().run(NaN), "RangeError", "run NaN: must be 0 to 3600 s"],
    ];
    for (const [call, name, message] of cases) {
        assert.throws(call, { name, message });
    }
});
