// Budgets of the page: compressed bytes of the scripts and styles that each place loads, WebAssembly apart. UPDATE=1 writes them anew.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { test } from "node:test";
import { gzipSync } from "node:zlib";

const { address } = await import("../../wasm/web/vite.config.js");
const dist = new URL("../../wasm/web/dist/", import.meta.url);
const golden = new URL("../golden/page.toml", import.meta.url);
const manifest = JSON.parse(readFileSync(new URL(".vite/manifest.json", dist), "utf8"));
/** Largest allowed, compressed bytes: a learner's first place, a chapter on top of it, its plots, which come after, the main panel. */
const LIMITS = { learn: 32 * 1024, chapter: 22 * 1024, plots: 24 * 1024, operate: 120 * 1024 };

/** Files of an entry and of what it imports, without those of `before`. */
function files(key, before = new Set(), found = new Set()) {
    const { file, css = [], imports = [] } = manifest[key];
    for (const name of [file, ...css]) {
        if (!before.has(name)) {
            found.add(name);
        }
    }
    imports.forEach((other) => files(other, before, found));
    return found;
}

function bytes(names) {
    return [...names].reduce((sum, name) => sum + gzipSync(readFileSync(new URL(name, dist)), { level: 9 }).length, 0);
}

const first = files("index.html");
const chapters = Object.keys(manifest).filter((key) => key.startsWith("src/learn/chapters/") && manifest[key].isDynamicEntry);
const sizes = {
    learn: bytes(first),
    ...Object.fromEntries(chapters.map((key) => [/(\w+)\.svelte$/.exec(key)[1], bytes(files(key, first))])),
    plots: bytes(files(Object.keys(manifest).find((key) => /^_Chart-.*js$/.test(key)), first)),
    operate: bytes(first) + bytes(files("src/operate/Operate.svelte", first)),
};

test("each place of the page loads its golden number of bytes", () => {
    if (process.env.UPDATE) {
        const lines = Object.entries(sizes).map(([name, size]) => `${name} = ${size}\n`);
        writeFileSync(golden, `# Compressed bytes of scripts and styles: the first place, each chapter on top of it, the plots of chapters, which come after, the main panel.\n# \`UPDATE=1 node --test tests/wasm/budget.test.mjs\` writes them anew.\n${lines.join("")}`);
    }
    const text = readFileSync(golden, "utf8");
    assert.equal(chapters.length, 10);
    for (const [name, size] of Object.entries(sizes)) {
        const expected = Number(text.match(new RegExp(`^${name} = (\\d+)$`, "m"))?.[1]);
        assert.ok(Math.abs(size - expected) <= expected * 0.02, `${name}: ${size} bytes, golden ${expected}`);
    }
});

test("each place of the page is within its budget, and a learner loads no plots of the panels", () => {
    for (const [name, size] of Object.entries(sizes)) {
        const limit = LIMITS[name] ?? LIMITS.chapter;
        assert.ok(size <= limit, `${name}: ${size} bytes compressed, ${limit} allowed`);
    }
    assert.ok(![...first].some((name) => /uPlot|Operate|session/.test(name)), [...first].join());
});

test("icon, manifest, preview and a word for browsers without scripts are there", () => {
    const page = readFileSync(new URL("index.html", dist), "utf8");
    for (const name of ["icon.svg", "manifest.webmanifest", "preview.png"]) {
        assert.match(page, new RegExp(`"\\./${name}"`));
        assert.ok(readFileSync(new URL(name, dist)).length > 100);
    }
    assert.match(page, /<noscript>[^]*needs JavaScript and WebAssembly/);
});

test("the preview's whole address follows from the address of the page", () => {
    const source = readFileSync(new URL("../../wasm/web/index.html", import.meta.url), "utf8");
    assert.equal(address(undefined).transformIndexHtml(source), source);
    const page = address("https://example.org/narx/").transformIndexHtml(source);
    assert.match(page, /<meta property="og:image" content="https:\/\/example\.org\/narx\/preview\.png" \/>/);
    assert.match(page, /<meta property="og:url" content="https:\/\/example\.org\/narx\/" \/>/);
    // The published site has the page in a folder of that name.
    for (const [workflow, host] of [[".github/workflows/site.yml", /\$\{\{ steps\.pages\.outputs\.base_url \}\}/], [".gitlab-ci.yml", /\$CI_PAGES_URL/]]) {
        const place = /NARX_PAGE_ADDRESS: (.*)/.exec(readFileSync(new URL(`../../${workflow}`, import.meta.url), "utf8"))[1];
        assert.equal(place.replace(host, "https://example.org/narx"), "https://example.org/narx/page/");
    }
    for (const wrong of ["example.org/", "https://example.org/narx", 'https://example.org/"/']) {
        assert.throws(() => address(wrong).transformIndexHtml(source), { message: /NARX_PAGE_ADDRESS.*must be an address/ });
    }
});
