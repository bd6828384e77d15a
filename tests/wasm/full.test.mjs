// The bench of `narx/full`, whose drive has what the first module leaves out: log memory, description, bootloader.

import assert from "node:assert/strict";
import { test } from "node:test";
import { imageInfo } from "../../wasm/pkg/node/core.js";
import * as full from "../../wasm/pkg/node/full.js";
import { replay } from "../../wasm/pkg/node/lab.js";
import { Pump } from "./pump.mjs";
import { image } from "./signing.mjs";

const IMAGE = image();
const OTHER_KEY = image({ secret: "0".repeat(64) });

/** A full drive in Standby. */
function booted() {
    const pump = new Pump({}, {}, "bly172s-24v", full);
    pump.pass(0.7);
    return pump;
}

test("the log is set up, filled, downloaded in part and erased", async () => {
    const pump = booted();
    const { log } = pump.drive;
    assert.equal(await pump.run(log.length()), 0);
    assert.ok((await pump.run(log.capacity())) > 100_000);
    await pump.run(log.configure({ "HV Voltage": "mean" }, 0.02));
    assert.deepEqual(await pump.run(log.slots()), { "HV Voltage": "mean" });
    pump.pass(0.5);
    await pump.run(log.configure([], 3600));
    const length = await pump.run(log.length());
    assert.ok(length > 20, `${length} records`);
    let told;
    const { time, columns, units } = await pump.run(log.download(2, 4, (progress) => (told = progress)));
    assert.equal(told.received, told.total);
    assert.deepEqual([...columns.index], [2, 3, 4, 5]);
    assert.deepEqual(units, { index: "", "HV Voltage mean": "V" });
    assert.ok(columns["HV Voltage mean"].every((volts) => Math.abs(volts - 24) < 0.5));
    assert.ok(Math.abs(time[1] - time[0] - 0.02) < 1e-9);
    await pump.run(log.erase());
    assert.equal(await pump.run(log.length()), 0);
});

test("the drive describes itself", async () => {
    const pump = booted();
    const xml = await pump.run(pump.drive.description());
    assert.match(xml, /^<\?xml[\s\S]*Over-voltage HV threshold[\s\S]*>\s*$/);
});

test("a drive is programmed, and runs the new version", async () => {
    const pump = booted();
    const { drive } = pump;
    assert.deepEqual(imageInfo(IMAGE), { hardware: 0x4e58_0000, board: "bench", version: "0.3.1+99", length: 1536 });
    assert.equal((await pump.run(drive.info())).device.software, "0.1");
    const stages = [];
    await pump.run(
        drive.update(IMAGE, ({ stage, done, total }) => {
            assert.ok(done >= 0 && done <= total && total === IMAGE.length);
            if (stages.at(-1) !== stage) {
                stages.push(stage);
            }
        }),
    );
    assert.deepEqual(stages, ["asking", "erasing", "sending", "verifying", "restarting"]);
    const { build, device } = await pump.run(drive.info());
    assert.deepEqual([device.software, build.number], ["0.3", 99]);
    await pump.run(drive.start(2000));
    assert.equal(drive.state, 5);
    // A copy has the program, too.
    assert.equal(pump.bench.copy().digest, pump.bench.digest);
    assert.equal(replay(pump.bench.recording()).digest, pump.bench.digest);
});

test("what is no image for this drive is refused before anything is sent, and the rest by whom it concerns", async () => {
    const pump = booted();
    const cases = [
        [new Uint8Array(), "ImageError", "the file has 0 bytes; the image needs 512"],
        [new Uint8Array(2000), "ImageError", "not an image: it does not begin with NARXIMG"],
        [IMAGE.subarray(0, -8), "ImageError", "the file has 1528 bytes; the image needs 1536"],
        [image({ hardware: "b-g431b-esc1" }), "ImageError", "the image is for hardware 4E580002h, the drive is 4E580000h"],
        [image({ version: "0.0.9+9" }), "ImageError", "the image is version 0.0.9+9, older than the running version 0.1.0+1"],
        [image({ length: 50 << 10 }), "ImageError", "the image has 51712 bytes, the drive has room for 51200"],
        [OTHER_KEY, "RefusedError", "the board's bootloader does not accept the signature"],
    ];
    for (const [bytes, name, message] of cases) {
        await assert.rejects(pump.run(pump.drive.update(bytes)), { name, message });
        assert.equal((await pump.run(pump.drive.info())).device.software, "0.1", message);
    }
    assert.throws(() => imageInfo(new Uint8Array(3)), { name: "ImageError", message: "the file has 3 bytes; the image needs 512" });
    await pump.run(pump.drive.start(2000));
    await assert.rejects(pump.run(pump.drive.update(IMAGE)), { name: "RefusedError", message: "the drive is not in Standby, nor in Fault at standstill" });
    assert.equal(pump.drive.state, 5);
});

test("an aborted update leaves the drive as it was, and the next one is taken", async () => {
    const pump = booted();
    const { drive } = pump;
    const stopped = drive.update(IMAGE, ({ stage, done }) => stage === "sending" && done > 500 && drive.master.abortUpdate());
    const second = drive.update(IMAGE);
    await assert.rejects(second, { name: "RefusedError" });
    await assert.rejects(pump.run(stopped), { name: "RefusedError", message: "the update was aborted" });
    assert.equal(drive.master.updateProgress, undefined);
    pump.pass(0.1);
    await pump.run(drive.start(2000));
    drive.stop();
    await pump.run(drive.wait(1));
    await pump.run(drive.update(IMAGE));
    assert.equal((await pump.run(drive.info())).device.software, "0.3");
});

test("a drive without a bootloader says nothing to it", async () => {
    const pump = new Pump();
    pump.pass(0.7);
    await assert.rejects(pump.run(pump.drive.update(IMAGE)), { name: "NoAnswerError", message: "the drive does not answer; it may have no bootloader" });
});
