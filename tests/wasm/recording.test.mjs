// Replay in Node.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { replay, replayTrace } from "../../wasm/pkg/node/lab.js";
import { Bench, Motor } from "../../wasm/pkg/node/narx.js";
import { replayTranscript } from "../../wasm/pkg/node/transcript.js";
import { TRANSCRIPTS, VECTORS } from "./vectors.mjs";

const bytes = readFileSync(VECTORS[0]);

test("every vector replays to its digest", () => {
    assert.ok(VECTORS.length > 30);
    for (const file of VECTORS) {
        const { ticks, digest, recordedDigest } = replay(readFileSync(file));
        assert.match(digest, /^[0-9a-f]{16}$/);
        assert.equal(digest, recordedDigest, file);
        assert.ok(ticks > 0);
    }
});

test("every transcript of a node replays to its digest", () => {
    assert.ok(TRANSCRIPTS.length >= 10);
    for (const file of TRANSCRIPTS) {
        const bytes = readFileSync(file);
        const { ticks, digest, recordedDigest } = replayTranscript(bytes);
        assert.equal(digest, recordedDigest, file);
        assert.equal(replayTranscript(bytes, 100).ticks, 100);
        assert.ok(ticks > 1000);
        assert.throws(() => replay(bytes), { message: /^recording of kind [23] \((node|TX-Driver)\), which is not replayed here$/ });
    }
    assert.throws(() => replayTranscript(bytes), { message: "recording of kind 1 (drive), which is not replayed here" });
    assert.throws(() => replayTranscript(bytes, -1), RangeError);
});

test("a prefix tells its last outputs", () => {
    const { ticks, digest, recordedDigest, outputs } = replay(bytes, 17);
    assert.equal(ticks, 17);
    assert.equal(recordedDigest, undefined);
    assert.match(outputs, /^tick \d+: duty \d+, rectification/);
    assert.notEqual(digest, replay(bytes, 16).digest);
    assert.equal(replay(bytes, 0).outputs, undefined);
    const whole = replay(bytes);
    assert.equal(replay(bytes, whole.ticks + 1).digest, whole.digest);
});

test("damage is named, never replayed", () => {
    assert.throws(() => replay(new Uint8Array()), { name: "Error", message: /not a narx recording|truncated/ });
    assert.throws(() => replay(bytes.subarray(0, 1000)), /truncated: the file ends at byte 1000/);
    const changed = Uint8Array.from(bytes);
    changed[changed.length / 2 | 0] ^= 1;
    assert.throws(() => replay(changed), /corrupt: the check value at byte \d+/);
    for (const until of [-1, 0.5, NaN, Infinity]) {
        assert.throws(() => replay(bytes, until), { name: "RangeError", message: `until ${until}: must be a whole number of ticks, 0 or more` });
    }
});

test("a run's own recording replays, with the times of its PWM rate", () => {
    for (const pwmRate of [10_000, 20_000]) {
        const bench = new Bench(Motor.preset("bly172s-24v"), { supplyVoltage: 24, pwmRate });
        bench.run(0.6);
        bench.start(1000);
        bench.run(0.4);
        const recording = bench.recording();
        const { ticks, digest, recordedDigest } = replay(recording);
        assert.equal(ticks, pwmRate);
        assert.equal(digest, recordedDigest);
        assert.ok(Math.abs(replayTrace(recording).time.at(-1) - 1) < 1e-9);
    }
});
