// The example for Node, as its user runs it: with the package in `node_modules`, and a virtual drive on a TCP port.

import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { cpSync, mkdtempSync, rmSync, symlinkSync, mkdirSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { promisify } from "node:util";
import { serveDrive } from "./adapter.mjs";

const root = fileURLToPath(new URL("../..", import.meta.url));
const run = promisify(execFile);

test("a drive is commanded over slcan", async () => {
    const user = mkdtempSync(join(tmpdir(), "narx-node-"));
    const drive = await serveDrive("--mode", "hall", "--pwm-rate", "10000");
    try {
        cpSync(join(root, "examples/node"), user, { recursive: true });
        mkdirSync(join(user, "node_modules"));
        symlinkSync(join(root, "wasm/pkg"), join(user, "node_modules/narx"));
        const program = (...words) => run("node", ["--no-turbo-inline-js-wasm-calls", "drive.mjs", `127.0.0.1:${drive.port}`, ...words], { cwd: user });
        const { stdout } = await program("1500", "2");
        assert.match(stdout, /^Closed-loop Hall Effect Sensors: \d+ rpm, 1[78]\.\d V$/m);
        assert.match(stdout, /^8 pole pairs, faults: none$/m);
        await assert.rejects(program("90000"), { code: 1, stderr: /^RangeError: .*90000/ });
    } finally {
        drive.end();
        rmSync(user, { recursive: true });
    }
});
