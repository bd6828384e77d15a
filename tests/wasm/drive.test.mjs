// A drive commanded, asked and read over the bus of a bench, by the master of `narx/core` and what waits over it.

import assert from "node:assert/strict";
import { test } from "node:test";
import { Master, measurementSignals, parameters, scopeSignals } from "../../wasm/pkg/node/core.js";
import { Drive } from "../../wasm/pkg/node/drive.js";
import { replay } from "../../wasm/pkg/node/lab.js";
import { Pump } from "./pump.mjs";

test("a drive starts, changes its speed, turns round and stops", async () => {
    const pump = new Pump();
    const { bench, drive } = pump;
    await pump.run(drive.start(2000));
    assert.equal(drive.stateName, "Closed-loop Hall Effect Sensors");
    await pump.run(drive.waitFor(() => Math.abs(drive.speed - 2000) < 20, 3));
    assert.ok(Math.abs(bench.value("speed") - drive.speed) < 20);
    drive.setSpeed(1200);
    assert.ok(await pump.run(drive.waitFor(() => Math.abs(drive.speed - 1200) < 20, 3)));
    drive.stop();
    await pump.run(drive.wait(1.5));
    assert.equal(drive.state, 1);
    await pump.run(drive.start(-1000));
    await pump.run(drive.wait(1));
    assert.ok(Math.abs(bench.value("speed") + 1000) < 20, `${bench.value("speed")} rpm`);
    assert.ok(drive.speed < -900);
    assert.deepEqual(drive.faults, []);
    assert.equal(drive.fault, undefined);
});

test("what a drive measures has SI units and the names of Figure 14", async () => {
    const { bench, drive } = await running();
    const voltage = drive.measurement("HV Voltage");
    assert.ok(Math.abs(voltage - bench.value("bus_voltage")) < 0.5, `${voltage} V`);
    const names = drive.measurements.map(({ name }) => name);
    assert.ok(names.length > 15);
    const known = new Map(measurementSignals().map(({ name, unit }) => [name, unit]));
    for (const { name, unit, time } of drive.measurements) {
        assert.equal(unit, known.get(name));
        assert.ok(bench.time - time < 0.5, `${name} at ${time} s`);
    }
    assert.throws(() => drive.measurement("HV Pressure"), { name: "TypeError", message: 'there is no measurement "HV Pressure"' });
    assert.deepEqual(drive.status["Motor mode"], "Drive");
});

test("parameters are read, written, stored, and refused in words", async () => {
    const pump = booted();
    const { drive } = pump;
    const { parameters: table } = drive;
    const poles = "Motor pair poles";
    assert.equal(table.row(poles).unit, "");
    assert.ok(table.find("pole pairs").some(({ name }) => name === poles));
    const before = await pump.run(table.get(poles));
    assert.equal(await pump.run(table.set(poles, before + 1)), before + 1);
    assert.equal(table.known(poles), before + 1);
    assert.equal(await pump.run(table.get(poles.toUpperCase())), before + 1);
    await pump.run(table.store());
    await pump.run(drive.reboot());
    assert.equal(await pump.run(table.get(poles)), before + 1);
    assert.deepEqual(await pump.run(table.load({ [poles]: before })), [poles]);
    assert.deepEqual(await pump.run(table.load({ [poles]: before })), []);
    const row = table.row(poles);
    const refusals = [
        [() => table.set(poles, row.max + 1), "RangeError", /^parameter \d+ "Motor pair poles": \d+ is outside /],
        [() => table.get("Poles"), "TypeError", 'there is no parameter "Poles"'],
        [() => table.get(9999), "TypeError", "there is no parameter 9999"],
        [() => table.set("Drive state", 3), "ParameterError", /^parameter 261 "Drive state": /],
        [() => table.load({ [poles]: before, Poles: 1 }), "TypeError", 'there is no parameter "Poles"'],
        [() => table.load({ [poles]: 1e9 }), "RangeError", /is outside/],
    ];
    for (const [call, name, message] of refusals) {
        await assert.rejects(pump.run(call()), { name, message });
    }
    assert.equal(await pump.run(table.get(poles)), before);
});

test("every parameter is read in the background, and what it is stands in a table", async () => {
    const pump = new Pump();
    pump.pass(2.5);
    assert.equal(pump.drive.master.parametersToRead, 0);
    const rows = parameters();
    assert.ok(rows.length > 150);
    for (const { name, number, min, max, factory, description, scale } of rows) {
        const value = pump.drive.parameters.known(number);
        assert.ok(value >= min && value <= max, `${name}: ${value} of ${min} to ${max}`);
        assert.ok(factory >= min && factory <= max && scale > 0, name);
        assert.ok(description.length > 5, name);
    }
});

test("a drive says what it is", async () => {
    const pump = new Pump();
    const { build, device } = await pump.run(pump.drive.info());
    assert.deepEqual(build, { number: 1, modified: false, date: 20261120 });
    assert.equal(device.software, "0.1");
    assert.equal(device.address, 170);
});

test("a start that fails says why", async () => {
    const pump = new Pump();
    pump.bench.inject("break");
    await assert.rejects(pump.run(pump.drive.start(1000)), { name: "StartError", message: /^the drive is in Fault: .+\(.*emergency_shutdown.*\)$/ });
    assert.ok(pump.drive.faults.includes("emergency_shutdown"));
    assert.ok(pump.drive.fault.length > 5);
    pump.bench.clear("break");
    pump.drive.stop();
    await pump.run(pump.drive.wait(0.5));
    await pump.run(pump.drive.start(1000));
    const other = new Pump({}, { slave: 7 });
    await assert.rejects(other.run(other.drive.start(100)), { name: "StartError", message: /no frames were received/ });
});

test("the scope records signals around its trigger", async () => {
    const pump = await running();
    const { drive, bench } = pump;
    assert.deepEqual(drive.scope.signals.map(({ name }) => name), scopeSignals().map(({ name }) => name));
    const bus = drive.scope.signals.find(({ name }) => name === "HV Voltage");
    const taken = await pump.run(drive.scope.capture(["Duty", bus.name], { samples: 64, prescaler: 2 }));
    assert.equal(taken.time.length, 64);
    assert.ok(Math.abs(taken.time[1] - 2e-4) < 1e-12);
    assert.deepEqual(taken.units, { Duty: "%", [bus.name]: "V" });
    assert.ok(taken.columns[bus.name].every((volts) => Math.abs(volts - bench.value("bus_voltage")) < 1));
    await pump.run(drive.scope.arm(["Hall code"], { samples: 50, before: 10, trigger: { kind: "state change" } }));
    assert.equal(await pump.run(drive.scope.state()), "armed");
    await assert.rejects(pump.run(drive.scope.arm(["Duty"])), { name: "RefusedError", message: /^the scope is armed: force it/ });
    await assert.rejects(pump.run(drive.scope.download()), { name: "RefusedError", message: "the scope is armed: no record is stored" });
    drive.stop();
    await pump.run(drive.scope.wait(2));
    const stopped = await pump.run(drive.scope.download());
    assert.ok(Math.abs(stopped.time[0] + 1e-3) < 1e-12);
    await assert.rejects(pump.run(drive.scope.arm(["Dutty"])), { name: "TypeError", message: 'there is no scope signal "Dutty"' });
    // Nothing is cut or stretched in silence.
    const nine = drive.scope.signals.slice(0, 9).map(({ name }) => name);
    for (const [setup, message] of [
        [{ samples: 2000 }, /^samples 2000: must be 1 to 455 for 9 signals, .* 4096 words; prescaler 3 or more$/],
        [{ samples: 455 }, /^prescaler 1: must be at least 3 for 9 signals: the drive reads 4 signals per control tick$/],
        [{ samples: 10, prescaler: 3, before: 10 }, /^before 10: must be 0 to 9, fewer than samples 10$/],
    ]) {
        await assert.rejects(pump.run(drive.scope.capture(nine, setup)), { name: "RangeError", message });
    }
});

test("a record is awaited beside a start, and forced by hand", async () => {
    const pump = await running();
    const { drive } = pump;
    drive.stop();
    await pump.run(drive.wait(1));
    const setup = { samples: 50, before: 10, trigger: { kind: "state change" } };
    const [taken] = await pump.run(Promise.all([drive.scope.capture(["Drive state"], setup, 5), drive.start(1500)]));
    assert.equal(taken.time.length, 50);
    const waiting = drive.scope.capture(["Duty"], { samples: 20, trigger: { kind: "forced" } });
    await pump.run(drive.wait(0.3));
    await pump.run(drive.scope.force());
    assert.equal((await pump.run(waiting)).time.length, 20);
    await pump.run(drive.scope.arm(["Duty"]));
    const ended = assert.rejects(drive.scope.wait(1), { name: "RefusedError", message: "the scope's record was ended by another command" });
    await assert.rejects(pump.run(drive.scope.wait(0.2)), { name: "NoAnswerError", message: "the scope is armed after 0.2 s: the trigger has not occurred" });
    await ended;
});

test("the scope's record of inputs replays to the bits of the drive", async () => {
    const pump = await running();
    const { recording, agrees } = await pump.run(pump.drive.scope.record({ samples: 600 }));
    assert.equal(agrees, true);
    const { ticks, digest, recordedDigest } = replay(recording);
    assert.ok(ticks > 300, `${ticks} ticks`);
    assert.equal(digest, recordedDigest);
});

test("services and lines", async () => {
    const pump = booted();
    const { drive, bench } = pump;
    await pump.run(drive.setOutputs({ dsio1: true }));
    await pump.run(drive.setOutputs({}));
    await pump.run(drive.setPosition());
    await pump.run(drive.autoCalibrate());
    await pump.run(drive.setHallSupply(false));
    pump.pass(0.1);
    assert.equal(bench.observe().hall, 7, "lines without a supply are pulled up");
    await pump.run(drive.setHallSupply(true));
    drive.shutDown();
    pump.pass(0.2);
    assert.ok(drive.faults.includes("external_shutdown"));
    await assert.rejects(pump.run(drive.setOutputs({ dsio3: true })), { name: "TypeError", message: /no option dsio3/ });
});

test("a master without a drive, and a silent one", async () => {
    const master = new Master({ silent: true });
    assert.deepEqual(master.poll(0), []);
    assert.equal(master.nextPoll(0), Infinity);
    assert.throws(() => master.read(1), { name: "RefusedError", message: "the master is silent" });
    const cases = [
        [() => new Master({ slave: 256 }), "RangeError", "Master: slave 256: must be a whole number from 0 to 255"],
        [() => new Master({ timeout: 0 }), "RangeError", "Master: timeout 0 s: must be 0.001 to 10 s"],
        [() => new Master({ silent: 1 }), "TypeError", "Master: silent 1: must be true or false"],
        [() => new Drive({ master: 85 }), "TypeError", /^Master: no option master; one of slave, monitor/],
        [() => new Master().start(0.5), "RangeError", "start 0.5: must be a whole number from -65535 to 65535"],
        [() => new Master().request("dance"), "TypeError", /^request "dance": must be one of build info, device info, description info, reboot/],
        [() => new Master().handleFrame({ id: 2 ** 29, data: new Uint8Array() }, 0), "RangeError", /^frame: id 536870912: must be/],
        [() => new Master().handleFrame({ id: 1, data: [1] }, 0), "TypeError", "frame: data must be a Uint8Array"],
        [() => new Master().handleFrame({ id: 1, data: new Uint8Array(9) }, 0), "RangeError", "frame: data of 9 bytes: must be at most 8"],
    ];
    for (const [call, name, message] of cases) {
        assert.throws(call, { name, message });
    }
    const pump = new Pump({}, { slave: 7, timeout: 0.01 });
    await assert.rejects(pump.run(pump.drive.parameters.get(1)), { name: "NoAnswerError", message: "parameter 1: the drive does not answer" });
});

test("the speed in open loop is that of the field, not 0 of a mode that rests", async () => {
    const pump = new Pump({ mode: "open-loop" });
    const { drive, bench } = pump;
    const rpm = await pump.run(drive.parameters.get(88));
    await pump.run(drive.start(rpm));
    assert.equal(drive.stateName, "Open-loop");
    await pump.run(drive.waitFor(() => Math.abs(bench.value("speed") - rpm) < 0.1 * rpm, 5));
    await pump.run(drive.wait(0.2));
    assert.ok(Math.abs(drive.speed - rpm) < 0.1 * rpm, `${drive.speed} rpm of ${rpm}`);
    assert.equal(drive.speedWarning, undefined);
    drive.setSpeed(rpm + 50);
    assert.match(drive.speedWarning, /^speed \d+ rpm is not equal to parameter 88 "[^"]+": must be \d+ rpm$/);
});

test("a start reads what its limits need, and does not wait until the background has come to it", async () => {
    const pump = new Pump({}, { readParameters: false, readDescription: false });
    await assert.rejects(pump.run(pump.drive.start(30_000)), { name: "RangeError", message: /^speed 30000 rpm is above parameter 103 / });
});

test("a set-point beyond the limits is refused with the parameter that says so and the range", async () => {
    const pump = booted();
    const { drive } = pump;
    const [max, min] = await Promise.all([103, 104].map((number) => pump.run(drive.parameters.get(number))));
    const above = { name: "RangeError", message: new RegExp(`^speed ${max + 1} rpm is above parameter 10\\d "Speed setpoint max saturation HES": must be ${min} to ${max} rpm$`) };
    const below = { name: "RangeError", message: new RegExp(`^speed -${min - 1} rpm is below parameter 10\\d "Speed setpoint min saturation HES": must be ${min} to ${max} rpm in either direction$`) };
    await assert.rejects(pump.run(drive.start(max + 1)), above);
    await assert.rejects(pump.run(drive.start(1 - min)), below);
    assert.equal(drive.state, 1, "nothing was commanded");
    await assert.rejects(pump.run(drive.start(NaN)), { name: "RangeError", message: "start NaN: must be a whole number from -65535 to 65535" });
    assert.throws(() => drive.setSpeed(min), { name: "RefusedError", message: `speed ${min} rpm: the drive is in Standby; call start first` });
    await pump.run(drive.start(min));
    assert.throws(() => drive.setSpeed(max + 1), above);
    assert.throws(() => drive.setSpeed(1000.5), { name: "RangeError", message: "setSpeed 1000.5: must be a whole number from 0 to 65535" });
    assert.equal(drive.master.setpoint, min);
    const silent = new Drive({ silent: true });
    await assert.rejects(silent.start(1000), { name: "RefusedError", message: "start: the master is silent" });
    assert.throws(() => silent.setSpeed(1000), { name: "RefusedError", message: "setSpeed: the master is silent" });
});

test("a fraction of a whole parameter, and what is no number, is refused", async () => {
    const pump = booted();
    const { parameters: table } = pump.drive;
    const before = await pump.run(table.get(78));
    const { min, max } = table.row(78);
    const message = `parameter 78 "Motor pair poles": 4.5 is not a whole number from ${min} to ${max}`;
    await assert.rejects(pump.run(table.set(78, 4.5)), { name: "RangeError", message });
    await assert.rejects(pump.run(table.load({ "Motor pair poles": 4.5 })), { name: "RangeError", message });
    await assert.rejects(pump.run(table.set(78, NaN)), { name: "RangeError", message: /NaN is outside/ });
    assert.equal(await pump.run(table.get(78)), before);
    assert.equal(await pump.run(table.set("Over-voltage HV threshold", 55.54321)), 55.543);
});

test("a start that is stopped while it is checked does not turn the motor", async () => {
    const pump = booted();
    const start = pump.drive.start(1500);
    pump.drive.stop();
    await assert.rejects(pump.run(start), { name: "StartError", message: "the start was ended by another command" });
    await pump.run(pump.drive.wait(0.5));
    assert.equal(pump.drive.state, 1);
});

/** One whose drive has done its self-tests. */
function booted() {
    const pump = new Pump();
    pump.pass(0.6);
    return pump;
}

/** One whose motor turns. */
async function running() {
    const pump = new Pump();
    await pump.run(pump.drive.start(1500));
    await pump.run(pump.drive.wait(0.5));
    return pump;
}
