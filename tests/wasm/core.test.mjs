// What `narx/core` and `narx/lab` do without a drive: messages, logs, slcan.

import assert from "node:assert/strict";
import { test } from "node:test";
import { SlcanLines, TxMaster, closeSlcan, decode, encodeSlcan, openSlcan, txObjects } from "../../wasm/pkg/node/core.js";
import { Commutation, Hall, Pi, Ramp, ZeroCrossing, readLog, replayTrace, scopeRecording } from "../../wasm/pkg/node/lab.js";
import { Pump } from "./pump.mjs";

const text = (bytes) => new TextDecoder().decode(bytes);
const bytes = (text) => new TextEncoder().encode(text);
const data = (text) => Uint8Array.from(text.match(/../g) ?? [], (pair) => parseInt(pair, 16));

/** A bus on which a drive starts: every frame, the master's among them. */
async function frames() {
    const pump = new Pump({}, { readParameters: false });
    const received = [];
    const take = pump.bench.takeFrames.bind(pump.bench);
    pump.bench.takeFrames = () => {
        const taken = take();
        received.push(...taken);
        return taken;
    };
    await pump.run(pump.drive.start(1500));
    pump.pass(1);
    return received;
}
const BUS = await frames();

test("every frame of a bus is a message with units for all its fields", () => {
    const names = new Set();
    for (const frame of BUS) {
        const message = decode(frame);
        assert.equal(message.protocol, "narmotion");
        assert.equal(message.fromDrive, !frame.sent, message.name);
        assert.deepEqual([message.source, message.destination], frame.sent ? [85, 170] : [170, 85]);
        assert.deepEqual(Object.keys(message.units), Object.keys(message.values));
        names.add(message.name);
    }
    for (const name of ["MOTOR_CMD_SET", "MOTOR_CMD", "REQUEST_WORD", "STATUS_WORD", "PARAMETER", "MEASUREMENT_5"]) {
        assert.ok(names.has(name), name);
    }
    const speeds = BUS.map((frame) => decode(frame)).filter(({ name }) => name === "MEASUREMENT_5");
    assert.ok(Math.abs(speeds.at(-1).values["Mechanical estimated speed HES"] - 1500) < 50);
    assert.equal(speeds.at(-1).units["Mechanical estimated speed HES"], "rpm");
});

test("what is no message is none", () => {
    assert.equal(decode({ id: 0x1fffffff, data: new Uint8Array(8) }), undefined);
    assert.equal(decode({ id: BUS[0].id, data: new Uint8Array(7) }), undefined);
    assert.equal(decode({ id: BUS[0].id, remote: true, data: new Uint8Array(8) }), undefined);
    assert.equal(decode({ id: 0x7e0, extended: false, data: new Uint8Array(8) }), undefined);
});

test("messages of TX-Drivers", () => {
    const cases = [
        [{ id: 0, extended: false, data: data("0102") }, "NMT", { Node: 2, Command: "start" }],
        [{ id: 0x80, extended: false, data: data("") }, "SYNC", {}],
        [{ id: 0x702, extended: false, data: data("05") }, "Heartbeat", { Node: 2, State: "operational" }],
    ];
    for (const [frame, name, values] of cases) {
        const message = decode(frame);
        assert.equal(message.name, name);
        assert.deepEqual(message.values, values);
    }
});

test("a log is read back as the tables of the bus", () => {
    const hex = (bytes) => [...bytes].map((byte) => byte.toString(16).padStart(2, "0")).join("").toUpperCase();
    const line = ({ time, id, data }) => `(${time.toFixed(6)}) can0 ${id.toString(16).padStart(8, "0").toUpperCase()}#${hex(data)}\n`;
    const log = readLog(BUS.map(line).join("") + "no frame at all\n\n(1.0) can0 123#00\n");
    assert.equal(log.lines, BUS.length + 3);
    assert.equal(log.frames.time.length, BUS.length + 1);
    assert.deepEqual(log.errors.map(({ line, text }) => [line, text]), [[BUS.length + 1, "no frame at all"]]);
    assert.deepEqual([...log.frames.data.subarray(0, 8)], [...BUS[0].data]);
    assert.equal(log.frames.message.at(-1), 255);
    const rows = log.tables.reduce((sum, { time }) => sum + time.length, 0);
    assert.equal(rows, BUS.length);
    for (const [at, { name, time }] of log.tables.entries()) {
        const mine = BUS.filter((frame) => decode(frame).name === name);
        assert.equal(mine.length, time.length, name);
        assert.equal(log.frames.message.filter((message) => message === at).length, time.length);
    }
    const speed = log.tables.find(({ name }) => name === "MEASUREMENT_5");
    assert.equal(speed.units["Mechanical estimated speed HES"], "rpm");
    assert.equal(speed.columns["Mechanical estimated speed HES"].at(-1), decode(BUS.findLast((frame) => decode(frame).name === "MEASUREMENT_5")).values["Mechanical estimated speed HES"]);
    const status = log.tables.find(({ name }) => name === "STATUS_WORD");
    assert.equal(status.names["Motor mode"][status.columns["Motor mode"].at(-1)], "Drive");
    assert.equal(readLog(BUS.map(line).join(""), { slave: 7 }).tables.length, 0);
    assert.deepEqual(readLog(bytes(line(BUS[0])), { slave: null, monitor: null }).tables.map(({ name }) => name), [decode(BUS[0]).name]);
    assert.throws(() => readLog(5), { name: "TypeError", message: "readLog: the log must be text or a Uint8Array" });
    assert.throws(() => readLog("", { encoders: [128] }), { name: "RangeError", message: "encoders 128: must be a whole number from 1 to 127" });
});

test("slcan both ways, however the bytes are cut", () => {
    assert.equal(text(openSlcan()), "\rC\rS6\rO\r");
    assert.equal(text(openSlcan(125_000, true)), "\rC\rS4\rL\r");
    assert.equal(text(closeSlcan()), "C\r");
    assert.throws(() => openSlcan(1), { name: "RangeError" });
    assert.equal(text(encodeSlcan({ id: 0x123, extended: false, data: data("aabb") })), "t1232AABB\r");
    const stream = BUS.slice(0, 50).flatMap((frame) => [...encodeSlcan(frame)]);
    const whole = [...stream, 7, ...bytes("z\rV1010\r\r")];
    for (const cut of [1, 7, whole.length]) {
        const lines = new SlcanLines();
        const found = [];
        for (let at = 0; at < whole.length; at += cut) {
            found.push(...lines.handleBytes(Uint8Array.from(whole.slice(at, at + cut))));
        }
        assert.deepEqual(found, BUS.slice(0, 50).map(({ id, extended, remote, data }) => ({ id, extended, remote, data })));
        assert.equal(lines.refusals, 1);
    }
});

test("a recording runs again as a trace", () => {
    const { bench } = new Pump();
    bench.run(0.5, false).free();
    const trace = replayTrace(bench.recording());
    assert.equal(trace.length, 5000);
    assert.ok(trace.column("bus_voltage_measured").subarray(100).every((volts) => Math.abs(volts - 24) < 1));
    assert.equal(replayTrace(bench.recording(), 10).length, 10);
    assert.throws(() => scopeRecording(new Uint8Array(20), "none"), { name: "Error" });
});

test("a linear encoder's position has a length by 2009h", () => {
    const pump = new Pump();
    pump.bench.addTxDriver({ nodeId: 2, encoder: 1000 });
    const master = new TxMaster({ nodeId: 2 });
    pump.others.push(master);
    pump.pass(0.5);
    const ask = (...request) => {
        master.request(...request);
        pump.pass(0.05);
        return master.pollAnswer();
    };
    assert.equal(ask(0x2004, 0, ask(0x2004, 0).value | 2).error, undefined);
    assert.equal(ask(0x2005, 0, ask(0x2005, 0).value & ~2).error, undefined);
    assert.equal(ask(0x2009, 0, 250).error, undefined);
    master.command("start");
    pump.pass(0.1);
    master.askPositions();
    pump.pass(0.05);
    const { encoder, encoderPosition } = master.reading;
    assert.equal(encoderPosition, (encoder * 250) / 1e6);
    master.command("pre-operational");
    pump.pass(0.05);
    ask(0x2005, 0, ask(0x2005, 0).value | 2);
    master.command("start");
    pump.pass(0.05);
    master.askPositions();
    pump.pass(0.05);
    assert.equal(master.reading.encoderPosition, undefined, "a rotary encoder has no length");
});

test("a TX-Driver is commanded, read and written", () => {
    const pump = new Pump();
    pump.bench.addTxDriver({ nodeId: 2, channels: 2 });
    const master = new TxMaster({ nodeId: 2, channels: 2 });
    pump.others.push(master);
    pump.pass(0.1);
    assert.equal(master.boots, 1);
    assert.ok(master.present);
    const range = txObjects().find(({ access, name }) => access === "RW" && name !== "Node-ID");
    master.request(range.index, range.subindex);
    pump.pass(0.05);
    assert.equal(master.pollAnswer().value, Math.round(range.factory / range.scale));
    const counts = txObjects().find(({ access }) => access === "R");
    master.request(counts.index, counts.subindex, 1);
    pump.pass(0.05);
    const { error, abort } = master.pollAnswer();
    assert.equal(error.name, "RefusedError");
    assert.match(error.message, /^node 2, [0-9A-F]{4}h "/);
    assert.ok(abort > 0);
    master.command("start");
    pump.pass(0.05);
    master.sync();
    pump.pass(0.05);
    const { positions, trigger } = master.reading;
    assert.equal(trigger, "sync");
    assert.equal(positions.length, 2);
    assert.ok(positions.every((position) => position > 0.5 && position < 1.5), `${positions} mm`);
    assert.throws(() => pump.bench.addTxDriver({ nodeId: 2 }), { name: "RangeError", message: "addTxDriver: nodeId 2 is that of another TX-Driver" });
    assert.throws(() => new TxMaster({ nodeId: 128 }), { name: "RangeError", message: "TxMaster: nodeId 128: must be a whole number from 1 to 127" });
    assert.throws(() => master.request(0x6fff, 0), { name: "RangeError" });
});

test("a PI and a ramp by their equations, within their limits", () => {
    const pi = new Pi({ proportional: 2, integral: 100, stepRate: 1000, minimum: -10, maximum: 10 });
    for (let step = 1; step <= 20; step++) {
        const output = pi.step(1);
        assert.ok(Math.abs(output - (2 + 0.1 * step)) <= 0.11, `${output} in step ${step}`);
    }
    assert.equal(pi.step(1000), 10);
    assert.equal(pi.step(-1000), -10);
    const ramp = new Ramp({ rate: 500, stepRate: 1000 });
    assert.deepEqual([1, 2, 3].map(() => ramp.step(1.2)), [0.5, 1, Math.round(1.2 * 65536) / 65536]);
    const refusals = [
        [() => new Pi({ proportional: 1, integral: 0, minimum: 1, maximum: -1 }), /minimum/],
        [() => new Pi({ proportional: -1, integral: 0, minimum: 0, maximum: 1 }), /^proportional -1: must be from 0 to 1073741823/],
        [() => new Ramp({ rate: 0 }), /rate/],
        [() => ramp.step(40_000), "target 40000: must be from -32768 to 32768"],
    ];
    for (const [call, message] of refusals) {
        assert.throws(call, { name: "RangeError", message });
    }
});

test("hall codes and the steps that give torque, all the way round", () => {
    const hall = new Hall();
    const commutation = new Commutation();
    const steps = new Set();
    const sectors = [];
    // Gray codes of six sectors, 10 ms each.
    for (const code of [1, 3, 2, 6, 4, 5, 1, 3, 2, 6, 4, 5]) {
        for (let tick = 0; tick < 100; tick++) {
            const { sector, angle, speed, invalid } = hall.step(code);
            assert.equal(invalid, false);
            steps.add(commutation.step(angle, speed).step);
            sectors[code] = sector;
        }
    }
    assert.deepEqual([...new Set(sectors.filter((sector) => sector !== undefined))].sort(), [0, 1, 2, 3, 4, 5]);
    assert.deepEqual([...steps].sort(), [1, 2, 3, 4, 5, 6]);
    assert.ok(Math.abs(Math.abs(hall.step(5).speed) - 1000 / 60) < 2);
    assert.throws(() => hall.step(8), { name: "RangeError", message: "code 8: must be a whole number from 0 to 7" });
    assert.throws(() => commutation.step(0, 1e6), { name: "RangeError" });
});

test("a motor without sensors, commutated by its zero crossings", () => {
    const [rate, bus, speed, peak] = [10_000, 24, 100, 8];
    const crossing = new ZeroCrossing({ timeout: 0.03 });
    const commutation = new Commutation();
    // Of steps 1 to 6: the phase that is switched, the one held low.
    const LEGS = [[], [0, 1], [0, 2], [1, 2], [1, 0], [2, 0], [2, 1]];
    crossing.start(120);
    let turns = 1 / 3;
    let pattern = { step: 0, changes: [] };
    for (let tick = 0; tick < 1500; tick++) {
        turns += speed / rate;
        const [switched, low] = LEGS[pattern.changes.at(-1)?.step ?? pattern.step];
        const phaseVoltage = [0, 1, 2].map((phase) => {
            const emf = peak * Math.sin(2 * Math.PI * (turns - phase / 3));
            const floats = Math.min(Math.max(bus / 2 + 1.5 * emf, 0), bus);
            return phase === switched ? bus : phase === low ? 0 : floats;
        });
        const reading = crossing.step({ phaseVoltage, busVoltage: bus, pattern });
        pattern = commutation.step(reading.angle, reading.speed);
        if (tick > 400) {
            assert.ok(reading.running && reading.lost === undefined, `tick ${tick}`);
            assert.equal(reading.why, "accepted");
            assert.ok(Math.abs(reading.speed - speed) < 0.02 * speed, `${reading.speed} rev/s`);
            assert.ok(Math.abs(((reading.angle - turns * 360 + 540) % 360 + 360) % 360 - 180) < 4);
            assert.ok(reading.commutation >= 0 && reading.commutation < 1.2 / (6 * speed));
        }
    }
    const refusals = [
        [() => new ZeroCrossing({ voltsPerCode: 0.1 }), "RangeError", "voltsPerCode 0.1 V: must be from 0.000001 to 0.0625"],
        [() => new ZeroCrossing({ blanking: -1 }), "RangeError", "blanking -1 s: must be from 0 to 0.1"],
        [() => new ZeroCrossing({ advance: 31 }), "RangeError", /^advance 31 degrees: must be from 0 to 30/],
        [() => crossing.start(NaN), "RangeError", "angle NaN degrees: must be a finite number"],
        [() => crossing.step({ phaseVoltage: [0, 0], busVoltage: 1, pattern }), "RangeError", "phaseVoltage: must be finite numbers, V"],
        [() => crossing.step({ phaseVoltage: [0, 0, 0], busVoltage: 1, pattern: { step: 13 } }), "RangeError", "pattern: step 13: must be a whole number from 0 to 12"],
        [() => crossing.step({ phaseVoltage: [0, 0, 0], busVoltage: 1 }), "TypeError", "step: pattern is missing"],
    ];
    for (const [call, name, message] of refusals) {
        assert.throws(call, { name, message });
    }
});
