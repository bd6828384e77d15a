// Images as their owner makes them: `cargo xtask sign`, with the key that bench and tests believe.

import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

const ROOT = fileURLToPath(new URL("../..", import.meta.url));
const KEY = join(ROOT, "boot/keys/TEST-ONLY.key");

/** The bytes of an image. `secret`: 64 hexadecimal digits of another key. */
export function image({ version = "0.3.1+99", hardware = "bench", length = 1024, secret } = {}) {
    const folder = mkdtempSync(join(tmpdir(), "narx-"));
    try {
        const [program, key, out] = ["program", "own.key", "drive.narximg"].map((name) => join(folder, name));
        writeFileSync(program, Uint8Array.from({ length }, (_, at) => at));
        if (secret !== undefined) {
            writeFileSync(key, secret);
        }
        const options = ["--key", secret === undefined ? KEY : key, "--hardware", hardware, "--version", version, "--out", out];
        execFileSync("cargo", ["xtask", "sign", program, ...options], { cwd: ROOT, stdio: ["ignore", "ignore", "inherit"] });
        return readFileSync(out);
    } finally {
        rmSync(folder, { recursive: true });
    }
}
