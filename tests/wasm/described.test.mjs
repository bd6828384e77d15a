// A drive is shown by its own description: other scales, a parameter more, a signal less (decision of section 8.4.4: the data definition file).

import assert from "node:assert/strict";
import { test } from "node:test";
import { Drive } from "../../wasm/pkg/node/drive.js";
import * as full from "../../wasm/pkg/node/full.js";
import { Pair, Peer } from "./peer.mjs";
import { Pump } from "./pump.mjs";

/** The description of the real drive. */
const XML = await real();
const OTHER = changed(XML);

async function real() {
    const pump = new Pump({}, { readDescription: false }, "bly172s-24v", full);
    pump.pass(0.7);
    return pump.run(pump.drive.description());
}

/** Tenths of the over-voltage threshold's step, a parameter more, a scope signal less, and the bus voltage in steps of 1 V. */
function changed(xml) {
    const put = (pattern, by) => {
        const other = xml.replace(pattern, by);
        assert.notEqual(other, xml, String(pattern));
        xml = other;
    };
    const [over] = xml.match(/<parameter number="119"[^>]*>/);
    const step = (tag) => tag.replace(/scale="[^"]*"/, 'scale="1"').replace(/(min|max|factory)="([\d.]+)"/g, (_, name, value) => `${name}="${Math.round(value)}"`);
    put(over, step(over));
    put(/<parameter number="119"/, '<parameter number="999" name="Fan speed" category="04" unit="rpm" type="uint16" scale="10" min="100" max="9000" factory="1200" access="live">Of the fan.</parameter>\n    <parameter number="119"');
    put(/\s*<signal [^>]*name="HV Voltage"[^>]*\/>/, "");
    return xml;
}

async function described(xml, options = {}, peer = {}) {
    const pair = new Pair(new Drive(options), new Peer(xml, peer));
    await pair.run(pair.drive.waitFor(() => ["read", "refused"].includes(pair.drive.descriptionState), 30));
    await pair.run(pair.drive.wait(0.1));
    return pair;
}

test("a drive of other scales, with a parameter more and a signal less, is shown rightly", async () => {
    const { drive, peer, run } = bound(await described(OTHER));
    assert.equal(drive.descriptionState, "read");
    const own = new Drive().parameters;
    const [threshold, fan] = [drive.parameters.row(119), drive.parameters.row("fan speed")];
    assert.equal(threshold.scale, 1);
    assert.ok(own.row(119).scale < 1);
    assert.equal(threshold.description, own.row(119).description);
    assert.equal(threshold.category, own.row(119).category);
    assert.deepEqual(fan, { number: 999, name: "Fan speed", category: own.row(81).category, unit: "rpm", type: "uint16", scale: 10, min: 100, max: 9000, factory: 1200, access: "live", command: false, acts: "at once", description: "Of the fan." });
    assert.equal(drive.parameters.known("Fan speed"), 1200);
    assert.equal(await run(drive.parameters.set("Fan speed", 2000)), 2000);
    assert.equal(peer.raw.get(999), 200);
    assert.equal(drive.parameters.known(999), 2000);
    assert.equal(await run(drive.parameters.set(119, 58)), 58);
    assert.equal(peer.raw.get(119), 58);
    await assert.rejects(run(drive.parameters.set("Fan speed", 20)), { name: "RangeError", message: 'parameter 999 "Fan speed": 20 rpm is outside 100 to 9000 rpm' });
    await assert.rejects(run(drive.parameters.set(119, 57.5)), { name: "RangeError", message: /is not a whole number from/ });

    assert.ok(!drive.scope.signals.some(({ name }) => name === "HV Voltage"));
    const duty = drive.scope.signals.find(({ name }) => name === "Duty");
    await assert.rejects(run(drive.scope.arm(["HV Voltage"])), { name: "TypeError", message: 'there is no scope signal "HV Voltage"' });
    await run(drive.scope.arm(["Duty"]));
    assert.equal(peer.raw.get(22), 2 ** duty.bit, "the bits of the others have not moved");
});

test("a description is read once for each build number and CRC", async () => {
    const kept = new Map();
    const first = await described(OTHER, { descriptions: kept });
    assert.equal(first.peer.downloads, 1);
    assert.deepEqual([...kept.keys()], [`7-${first.peer.check.toString(16)}`]);
    const second = await described(OTHER, { descriptions: kept });
    // The master may have asked for the stream before its length was looked at; it is not read to its end.
    assert.equal(second.drive.descriptionState, "read");
    assert.equal(second.drive.parameters.known(999), 1200);
    assert.equal(kept.size, 1);
    await described(OTHER, { descriptions: kept }, { build: 8 });
    assert.equal(kept.size, 2);
});

test("compiled tables serve a drive whose description is refused", async () => {
    const broken = await described(OTHER.replace("</parameter>", "</parametre>"), { descriptions: new Map() });
    assert.equal(broken.drive.descriptionState, "refused");
    assert.match(broken.drive.descriptionProblem, /^description, line \d+, byte \d+: /);
    assert.equal(broken.drive.parameters.row(999), undefined);
    assert.deepEqual(broken.drive.parameters.rows, new Drive().parameters.rows);
    const other = await described(OTHER, { descriptions: new Map() }, { check: 1 });
    assert.equal(other.drive.descriptionState, "refused");
    assert.match(other.drive.descriptionProblem, /its CRC differs from the one/);
});

test("the real drive's description says what the tables say", async () => {
    const pump = new Pump({}, {}, "bly172s-24v", full);
    await pump.run(pump.drive.waitFor(() => pump.drive.descriptionState === "read", 60));
    assert.equal(pump.drive.descriptionState, "read");
    const own = new Drive();
    assert.deepEqual(pump.drive.parameters.rows, own.parameters.rows);
    assert.deepEqual(pump.drive.scope.signals, own.scope.signals);
    assert.deepEqual(pump.drive.measurementSignals, own.measurementSignals);
});

test("what the drive itself clamps is told", async () => {
    const { drive, run } = bound(await described(XML, {}, { speedMax: 1500 }));
    // Open loop without limits: its speed is what is asked for.
    await run(drive.parameters.set(82, 1));
    await run(drive.start(2000));
    await run(drive.wait(0.3));
    assert.equal(drive.speedWarning, "speed 2000 rpm: the drive uses 1500 rpm");
    drive.setSpeed(1200);
    assert.equal(drive.speedWarning, undefined, "the drive has not answered yet");
    await run(drive.wait(0.3));
    assert.equal(drive.speedWarning, undefined);
});

function bound(pair) {
    return { ...pair, run: (promise) => pair.run(promise) };
}
