// The identification of a motor by the package: figures against the truth, ends without figures, and the commissioning from them.

import assert from "node:assert/strict";
import { test } from "node:test";
import { commission, Identification } from "../../wasm/pkg/node/core.js";
import { Drive, motorFile, motorOf } from "../../wasm/pkg/node/drive.js";
import { Motor } from "../../wasm/pkg/node/narx.js";
import { Pump } from "./pump.mjs";

const NAME = "bly172s-24v";
const WRITTEN = [77, 78, 79, 83, 88, 101, 103];

/** One whose drive has done its self-tests, with the values of some parameters. */
async function booted(options) {
    const pump = new Pump(options);
    pump.pass(0.6);
    return { ...pump, pump, before: await values(pump) };
}

async function values(pump) {
    const found = [];
    for (const number of WRITTEN) {
        found.push(await pump.run(pump.drive.parameters.get(number)));
    }
    return found;
}

test("a drive measures its motor, puts its parameters back, and is commissioned from what it has measured", async () => {
    const { pump, drive, before } = await booted({ mode: "hall" });
    const truth = Motor.preset(NAME);
    const stages = [];
    const found = await pump.run(drive.identify({ polePairs: truth.polePairs }, (stage) => stages.push(stage)));
    assert.deepEqual(stages, ["asking", "holding", "spinning", "accelerating", "restoring"]);
    assert.ok(Math.abs(found.temperature - 25) < 1 && found.halls === undefined, `${found.temperature}`);
    assert.deepEqual(await values(pump), before);
    assert.equal(drive.stateName, "Standby");
    const { turned } = found;
    const friction = truth.staticFriction + truth.viscousFriction * turned.speed;
    for (const [name, figure, expected, share] of [
        ["resistance", found.resistance, truth.resistance, 0.03],
        ["inductance", found.inductance, truth.inductance, 0.1],
        ["torque constant", turned.torqueConstant, truth.torqueConstant, 0.02],
        ["inertia", turned.inertia, truth.inertia, 0.1],
        ["friction", turned.friction, friction, 0.2],
    ]) {
        assert.ok(Math.abs(figure.value - expected) < share * expected, `${name} ${figure.value}, truth ${expected}`);
        assert.ok(figure.uncertainty > 0 && figure.uncertainty < 0.5 * figure.value, `${name} +- ${figure.uncertainty}`);
    }

    const lines = motorFile(found).trim().split("\n").slice(1).map((line) => line.split(" = "));
    assert.deepEqual(lines.map(([name]) => name), ["pole_pairs", "resistance", "inductance", "torque_constant", "inertia", "static_friction", "viscous_friction", "rated_current"]);
    assert.deepEqual(lines.map(([, value]) => Number(value)), Object.values(motorOf(found)));
    assert.ok(lines.every(([, value]) => /^\d+(\.\d+)?(e-\d+)?$/.test(value)), "numbers of TOML");

    const operation = { supplyVoltage: 24, mode: "sensorless" };
    const made = await pump.run(drive.commission(found, operation));
    assert.ok(made.changed.includes("Closed-loop Sensorless enable") && made.changed.length > 10, made.changed.join());
    const expected = commission({ ...motorOf(found), ...operation }).parameters;
    for (const [name, value] of Object.entries(expected)) {
        assert.equal(await pump.run(drive.parameters.get(name)), value, name);
    }
    assert.deepEqual((await pump.run(drive.commission(found, operation))).changed, []);
    await pump.run(drive.start(2000));
    assert.ok(await pump.run(drive.waitFor(() => Math.abs(drive.speed - 2000) < 20, 3)));
    assert.equal(drive.stateName, "Sensorless Closed-loop");
});

test("pole pairs are counted by a mark on the shaft", async () => {
    const { pump, drive, bench } = await booted();
    assert.equal(drive.mark(), false, "nothing is counted yet");
    const stages = [];
    let turns = 0;
    const look = () => {
        const before = turns;
        // A rotor that swings in its steps passes the mark to and fro.
        turns = Math.max(turns, Math.floor(Math.abs(bench.observe().position) / (2 * Math.PI)));
        if (turns > before && stages.at(-1) === "counting") {
            drive.mark();
        }
    };
    const found = await pump.run(drive.identify({}, (stage) => stages.push(stage)), look);
    assert.equal(found.polePairs, 4);
    assert.deepEqual(stages.slice(0, 4), ["asking", "holding", "counting", "spinning"]);
});

test("hall sensors are calibrated on request, and the drive keeps their wiring", async () => {
    const { pump, drive } = await booted();
    const stages = [];
    const { halls } = await pump.run(drive.identify({ polePairs: 4, halls: true }, (stage) => stages.push(stage)));
    assert.deepEqual(stages.slice(-2), ["calibrating", "restoring"]);
    assert.ok(Math.abs(halls.offset) < 3, `${halls.offset}`);
    const kept = [];
    for (const name of ["Hall order", "Hall polarity mask", "Hall effect offset angle"]) {
        kept.push(await pump.run(drive.parameters.get(name)));
    }
    assert.deepEqual(kept, [halls.order, halls.polarity, halls.offset]);
});

test("a rotor that is held tells resistance and inductance alone, and no motor file", async () => {
    const { pump, drive } = await booted();
    const stages = [];
    const found = await pump.run(drive.identify({ polePairs: 4, current: 2, turn: false }, (stage) => stages.push(stage)));
    assert.deepEqual(stages, ["asking", "holding", "restoring"]);
    assert.equal(found.turned, undefined);
    assert.ok(found.current <= 2, `${found.current} A`);
    assert.throws(() => motorFile(found), { name: "RefusedError", message: /^the rotor was not allowed to turn/ });
    await assert.rejects(pump.run(drive.commission(found, { supplyVoltage: 24, mode: "hall" })), { name: "RefusedError" });
});

test("stop ends an identification in every stage, and the parameters have their former values", async () => {
    for (const wanted of ["holding", "spinning", "accelerating"]) {
        const { pump, drive, bench, before } = await booted();
        let stage;
        const identified = drive.identify({ polePairs: 4 }, (now) => (stage = now));
        await pump.run(drive.waitFor(() => stage === wanted, 30));
        await pump.run(drive.wait(0.7));
        drive.stop();
        assert.ok(drive.identifies);
        await assert.rejects(pump.run(identified), { name: "RefusedError", message: "the identification was aborted" });
        assert.ok(!drive.identifies);
        assert.deepEqual(await values(pump), before, wanted);
        assert.equal(drive.stateName, "Standby");
        pump.pass(1.5);
        assert.ok(Math.abs(bench.value("speed")) < 1, wanted);
    }
});

test("nothing else commands or asks the drive meanwhile", async () => {
    const { pump, drive } = await booted();
    const identified = drive.identify({ polePairs: 4, turn: false });
    pump.pass(0.3);
    const busy = { name: "RefusedError", message: /: the motor is being identified; stop ends that$/ };
    for (const call of [
        () => drive.start(1000),
        () => drive.parameters.set(78, 3),
        () => drive.description(),
        () => drive.scope.arm(["Duty"]),
        () => drive.calibrateHall(true),
        () => drive.reboot(),
        () => drive.identify({ polePairs: 4 }),
    ]) {
        await assert.rejects(pump.run(call()), busy);
    }
    assert.throws(() => drive.setSpeed(1000), busy);
    assert.throws(() => drive.shutDown(), busy);
    assert.ok((await pump.run(identified)).resistance.value > 0);
    await pump.run(drive.parameters.get(78));
});

test("requests that were made before are answered first, and a start under way is not disturbed", async () => {
    const { pump, drive } = await booted();
    const [poles, found] = await pump.run(Promise.all([drive.parameters.get(78), drive.identify({ polePairs: 4, turn: false })]));
    assert.equal(poles, 4);
    assert.ok(found.inductance.value > 0);
    const start = drive.start(1500);
    await pump.run(drive.waitFor(() => drive.state === 5 || drive.master.asksToTurn, 3));
    await assert.rejects(drive.identify({ polePairs: 4 }), { name: "RefusedError", message: "identify: the start is under way" });
    await pump.run(start);
    await assert.rejects(pump.run(drive.identify({ polePairs: 4 })), { name: "StartError", message: /not in Standby$/ });
    assert.ok(drive.master.asksToTurn, "a motor that somebody runs goes on");
});

test("an end without figures has its reason", async () => {
    const { pump, drive, bench } = await booted();
    for (const [options, name, message] of [
        [{ turn: false }, "RangeError", "hall sensors and pole pairs need a rotor that may turn"],
        [{ polePairs: 0 }, "RangeError", "identify: polePairs 0: must be a whole number from 1 to 50"],
        [{ polePairs: 4, current: 7 }, "RangeError", "largest current 7 A must be above 0 and at most 6 A"],
        [{ polePairs: 4, bridge: 1 }, "RangeError", "resistance of the bridge 1 ohm must be 0 or more and below 1 ohm"],
        [{ polePairs: 4, turn: 1 }, "TypeError", "identify: turn 1: must be true or false"],
        [{ polepairs: 4 }, "TypeError", /no option polepairs/],
    ]) {
        await assert.rejects(drive.identify(options), { name, message });
        assert.ok(!drive.identifies);
    }
    assert.throws(() => new Identification({ polePairs: 4.5 }), { name: "RangeError" });
    await assert.rejects(new Drive({ silent: true }).identify({ polePairs: 4 }), { name: "RefusedError", message: "identify: the master is silent" });
    bench.inject("open-phase", { phase: "A" });
    await assert.rejects(pump.run(drive.identify({ polePairs: 4 })), { name: "StartError", message: /^no current is seen at a duty of [\d.]+ %/ });
    assert.equal(drive.stateName, "Standby");

    const alone = await booted();
    const lost = assert.rejects(alone.drive.identify({ polePairs: 4 }), { name: "NoAnswerError", message: "nothing is received from the drive" });
    alone.pump.pass(1);
    for (let time = alone.bench.time; time < alone.bench.time + 20; time += 0.01) {
        alone.drive.poll(time);
    }
    await lost;
});

test("a commissioning that the drive cannot run names what is wrong", () => {
    const motor = { polePairs: 4, resistance: 0.8, inductance: 1.2e-3, torqueConstant: 0.035, inertia: 4.8e-6, supplyVoltage: 24, mode: "hall" };
    assert.ok(commission(motor).speedMax > commission(motor).speedMin);
    for (const [change, name, message] of [
        [{ supplyVoltage: 12 }, "RangeError", "supply voltage 12 V is outside 18 to 60 V"],
        [{ inertia: 0 }, "RangeError", "motor inertia 0 must be greater than 0"],
        [{ pwmRate: 7999 }, "RangeError", "commission: pwmRate 7999: must be a whole number from 8000 to 50000"],
        [{ mode: "fly" }, "TypeError", /^commission: mode "fly": must be one of hall, sensorless, open-loop$/],
        [{ mode: undefined }, "TypeError", "commission: mode is missing"],
        [{ resistance: undefined }, "TypeError", "commission: resistance is missing"],
        [{ ratedCurrent: -1 }, "RangeError", "commission: ratedCurrent -1: must be 0 or more"],
    ]) {
        assert.throws(() => commission({ ...motor, ...change }), { name, message });
    }
});
