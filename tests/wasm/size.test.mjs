// What a page must load: bytes of each WebAssembly module, plain and compressed. UPDATE=1 writes them anew.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { test } from "node:test";
import { gzipSync } from "node:zlib";

const golden = new URL("../golden/wasm.toml", import.meta.url);
/** Compressed, bytes. What is loaded first must be small; the laboratory is loaded when somebody opens a file, the full bench when somebody wants such a drive, and what replays a node's transcript when there is one. */
const LIMITS = { narx: 152 * 1024, core: 102 * 1024, lab: 152 * 1024, full: 200 * 1024, transcript: 100 * 1024 };

const sizes = Object.fromEntries(
    Object.keys(LIMITS).map((name) => {
        const module = readFileSync(new URL(`../../wasm/pkg/web/${name}_bg.wasm`, import.meta.url));
        return [name, { raw: module.length, gzip: gzipSync(module, { level: 9 }).length }];
    }),
);

test("each module has its golden size", () => {
    if (process.env.UPDATE) {
        const table = ([name, { raw, gzip }]) => `\n[${name}]\nraw = ${raw}\ngzip = ${gzip}\n`;
        const lines = Object.entries(sizes).map(table);
        writeFileSync(golden, `# Bytes of the modules; \`cargo xtask generate\` writes them anew.\n${lines.join("")}`);
    }
    const text = readFileSync(golden, "utf8");
    for (const [name, module] of Object.entries(sizes)) {
        const section = text.split(`[${name}]\n`)[1] ?? "";
        for (const [kind, bytes] of Object.entries(module)) {
            const expected = Number(section.match(new RegExp(`^${kind} = (\\d+)$`, "m"))?.[1]);
            // Folder names move a few bytes: they are part of symbol hashes, by which functions are ordered.
            assert.ok(Math.abs(bytes - expected) <= expected * 0.005, `${name} ${kind} ${bytes}, golden ${expected}`);
        }
    }
});

test("each module is within what may be loaded", () => {
    for (const [name, limit] of Object.entries(LIMITS)) {
        assert.ok(sizes[name].gzip <= limit, `${name}: ${sizes[name].gzip} bytes compressed, ${limit} allowed`);
    }
});
