// What may happen to a bench: frames, faults, loads, inputs; copies of it, and scripts that make it again.

import assert from "node:assert/strict";
import { test } from "node:test";
import { replay } from "../../wasm/pkg/node/lab.js";
import { Bench, Motor } from "../../wasm/pkg/node/narx.js";
import { Recorder, perform } from "../../wasm/pkg/node/script.js";

const MOTOR = "bly172s-24v";

function bench(options) {
    return new Bench(Motor.preset(MOTOR), { supplyVoltage: 24, ...options });
}

function turning(options) {
    const drive = bench(options);
    drive.start(1500);
    drive.run(1.5, false);
    assert.equal(drive.state, 5);
    return drive;
}

test("without an operator a drive accepts frames alone", () => {
    const drive = bench({ operator: false });
    drive.run(0.6, false);
    assert.ok(drive.takeFrames().every(({ sent }) => !sent), "a drive alone tells its state");
    // MOTOR_CMD and REQUEST_WORD with Standby and Drive, as the operator sends them.
    const other = bench({ frames: true });
    other.start(1500);
    other.run(1, false);
    const sent = other.takeFrames().filter(({ sent }) => sent);
    assert.ok(sent.length > 20);
    for (const { id, data } of sent) {
        drive.send({ id, data });
        drive.run(0.025, false);
    }
    assert.equal(drive.state, 5);
    const answers = drive.takeFrames();
    assert.equal(answers.filter(({ sent }) => sent).length, sent.length);
    assert.ok(answers.some(({ sent }) => !sent));
    assert.ok(answers.every(({ time }, at) => at === 0 || time > answers[at - 1].time));
    assert.deepEqual(drive.takeFrames(), []);
    const refused = { name: "TypeError", message: /^start: this bench has no operator/ };
    assert.throws(() => drive.start(100), refused);
});

test("the host's queue is bounded, and says so", () => {
    const drive = bench({ operator: false });
    const frame = { id: 1, data: new Uint8Array(8) };
    for (let count = 0; count < 64; count++) {
        drive.send(frame);
    }
    assert.throws(() => drive.send(frame), { name: "RangeError", message: "the node's queue is full" });
});

test("whatever can break ends in a fault of its own, and is mended", () => {
    const cases = [
        ["ambient", { value: 200 }, "over_temperature"],
        ["supply", { value: 70 }, "over_voltage"],
        ["supply", { value: 12 }, "under_voltage"],
        ["driver", { phase: "B" }, "legs_driver"],
        ["hall-supply-lost", undefined, "hall_sensors"],
        ["break", undefined, "emergency_shutdown"],
    ];
    for (const [fault, options, bit] of cases) {
        const drive = turning();
        drive.inject(fault, options);
        drive.run(2, false);
        assert.ok(drive.faults.includes(bit), `${fault}: ${drive.faults}`);
        drive.clear(fault, options);
        drive.run(0.3, false);
        drive.stop();
        drive.run(0.3, false);
        assert.equal(drive.state, 1, `${fault}: ${drive.faults}`);
    }
    const refusals = [
        ["flood", undefined, /^fault "flood": unknown; one of ambient, supply/],
        ["supply", undefined, 'fault "supply": needs a value: must be a number from 0 to 80 V'],
        ["supply", { value: 100 }, 'fault "supply": value 100: must be a number from 0 to 80 V'],
        ["driver", undefined, 'fault "driver": needs a phase, one of A, B, C'],
        ["driver", { phase: "D" }, /phase "D": must be one of A, B, C/],
        ["driver", { leg: "A" }, /no option leg/],
    ];
    for (const [fault, options, message] of refusals) {
        assert.throws(() => bench().inject(fault, options), { message });
    }
});

test("every fault can be injected with the options that its kind says it takes", () => {
    const drive = bench();
    for (const { name, value, phase, high } of Bench.injections()) {
        const options = { ...(value && { value: value.example }), ...(phase && { phase: "A" }), ...(high && { high }) };
        drive.inject(name, options);
        drive.clear(name, options);
        if (value || phase) {
            assert.throws(() => drive.inject(name), RangeError, name);
        }
    }
});

test("a load slows the motor until control makes up for it", () => {
    const drive = turning();
    const before = drive.value("bus_current");
    drive.setLoad({ constant: 0.05 });
    drive.run(2, false);
    assert.ok(Math.abs(drive.value("speed") - 1500) < 15);
    assert.ok(drive.value("bus_current") > before + 0.2);
    assert.throws(() => drive.setLoad({ constant: -1 }), { name: "RangeError", message: "load: constant -1: must be 0 or more" });
});

test("inputs of the board within what their wires can carry", () => {
    const drive = bench();
    for (const { name, unit, min, max } of Bench.inputs()) {
        drive.setInput(name, max);
        const refused = { name: "RangeError", message: `input "${name}" ${max + 1} ${unit}: must be ${min} to ${max} ${unit}` };
        assert.throws(() => drive.setInput(name, max + 1), refused);
    }
    assert.throws(() => drive.setInput("rail5", 1), { name: "TypeError", message: /^input "rail5": no such input; one of asi, asi_source/ });
});

test("single ticks, and a picture of each", () => {
    const drive = turning();
    drive.takeTrace().free();
    const duty = [];
    for (let tick = 0; tick < 20; tick++) {
        drive.step();
        duty.push(Math.fround(drive.value("duty")));
    }
    const trace = drive.takeTrace();
    assert.deepEqual([...trace.column("duty")], duty);
    assert.equal(drive.takeTrace().length, 0);
    const seen = drive.observe();
    assert.ok(Math.abs(seen.speed - 1500) < 20);
    assert.equal(seen.time, drive.time);
    assert.ok(Math.abs(seen.backEmf.reduce((sum, volts) => sum + volts)) < 0.5);
    assert.ok(Math.max(...seen.backEmf) > 1);
    assert.equal(seen.gates.length, 3);
    assert.ok(seen.gates.includes(0), "one leg floats");
    assert.deepEqual([...seen.current], ["a", "b", "c"].map((phase) => drive.value(`current_${phase}`)));
    assert.equal(drive.ticks, Math.round(drive.time * drive.tickRate));
});

test("a copy goes on as the original does", () => {
    const drive = turning();
    const copy = drive.copy();
    for (const one of [drive, copy]) {
        one.setSpeed(900);
        one.run(0.5, false);
    }
    assert.equal(copy.digest, drive.digest);
    assert.deepEqual(copy.recording(), drive.recording());
    copy.run(0.1, false);
    assert.notEqual(copy.digest, drive.digest);
    assert.equal(replay(drive.recording()).digest, drive.digest);
});

test("without rows and recording a bench is the same", () => {
    const [one, other] = [turning(), turning({ recording: false })];
    assert.deepEqual([...one.values()], [...other.values()]);
    assert.equal(other.recording().length, 0);
    assert.equal(other.digest, "0000000000000000");
});

test("a script through JSON makes the same bits, whole and up to any tick", () => {
    const recorder = new Recorder(MOTOR, { supplyVoltage: 24, mode: "sensorless", seed: 7 });
    const at = (seconds, input) => {
        recorder.bench.run(seconds, false).free();
        recorder.do(input);
    };
    at(0.7, { call: "start", rpm: 1800 });
    at(1.5, { call: "setLoad", load: { constant: 0.02 } });
    at(0.2, { call: "inject", fault: "open-phase", options: { phase: "A" } });
    const middle = recorder.bench.copy();
    at(0.3, { call: "clear" });
    at(0.1, { call: "stop" });
    recorder.bench.run(0.2, false).free();
    assert.throws(() => recorder.do({ call: "inject", fault: "flood" }), RangeError);
    const script = JSON.parse(JSON.stringify(recorder.script));
    assert.equal(script.inputs.length, 5);
    const again = perform(script);
    assert.equal(again.digest, recorder.bench.digest);
    assert.equal(again.ticks, recorder.bench.ticks);
    assert.ok(again.faults.length > 0 || again.state === 1);
    assert.equal(perform(script, middle.ticks).digest, middle.digest);
    recorder.rewind(middle.ticks);
    assert.equal(recorder.bench.digest, middle.digest);
    assert.equal(recorder.script.inputs.length, 3);
    assert.notEqual(perform({ ...script, options: { ...script.options, seed: 8 } }).digest, again.digest);
});
