// What the page must load: bytes of the WebAssembly module, plain and compressed. UPDATE=1 writes them anew.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { test } from "node:test";
import { gzipSync } from "node:zlib";

const module = readFileSync(new URL("../../wasm/pkg/web/narx_bg.wasm", import.meta.url));
const golden = new URL("../golden/wasm.toml", import.meta.url);
const sizes = { raw: module.length, gzip: gzipSync(module, { level: 9 }).length };

test("the module has its golden size", () => {
    if (process.env.UPDATE) {
        const lines = Object.entries(sizes).map(([name, bytes]) => `${name} = ${bytes}\n`);
        writeFileSync(golden, `# Bytes of narx_bg.wasm; \`cargo xtask generate\` writes them anew.\n${lines.join("")}`);
    }
    const text = readFileSync(golden, "utf8");
    for (const [name, bytes] of Object.entries(sizes)) {
        const expected = Number(text.match(new RegExp(`^${name} = (\\d+)$`, "m"))[1]);
        // Folder names move a few bytes: they are part of symbol hashes, by which functions are ordered.
        assert.ok(Math.abs(bytes - expected) <= expected * 0.005, `${name} ${bytes}, golden ${expected}`);
    }
    assert.ok(sizes.gzip <= 150 * 1024, `${sizes.gzip} bytes compressed`);
});
