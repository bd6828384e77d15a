// Chromium, with the page and the package served from this computer.

import { accessSync } from "node:fs";
import { createRequire } from "node:module";
import { delimiter, join } from "node:path";
import { fileURLToPath } from "node:url";
import { PAGE, serve } from "../../wasm/web/serve.mjs";

const installed = createRequire(new URL("../../wasm/web/package.json", import.meta.url));
const { chromium } = installed("playwright-core");

/** Where the package for the web is served. */
export const PACKAGE = "/package/";

/** The browser of CHROMIUM, or the first on the path. */
function program() {
    const folders = process.env.PATH.split(delimiter);
    const names = ["chromium-headless-shell", "chromium", "chromium-browser", "google-chrome"];
    const places = names.flatMap((name) => folders.map((folder) => join(folder, name)));
    const found = process.env.CHROMIUM ?? places.find(exists);
    if (found === undefined) {
        throw new Error(`no browser on the path: one of ${names.join(", ")}, or CHROMIUM=/path/to/it`);
    }
    return found;
}

function exists(path) {
    try {
        accessSync(path);
        return true;
    } catch {
        return false;
    }
}

/** Server and browser; `open(options, route)` is a page that has loaded at that route, `closePages()` closes all of them, `close()` ends both. */
export async function start() {
    const server = await serve({ "/": PAGE, [PACKAGE]: fileURLToPath(new URL("../../wasm/pkg/web", import.meta.url)) });
    // Containers have neither user namespaces for the sandbox nor a large /dev/shm.
    const args = ["--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu"];
    const browser = await chromium.launch({ executablePath: program(), args }).catch((error) => {
        server.close();
        throw error;
    });
    return {
        async open(options, route = "") {
            const page = await browser.newPage(options);
            const complaints = [];
            page.on("console", (message) => ["error", "warning"].includes(message.type()) && complaints.push(message.text()));
            page.on("pageerror", (error) => complaints.push(error.message));
            page.on("requestfailed", (request) => complaints.push(`not loaded: ${request.url()}`));
            await page.goto(`http://127.0.0.1:${server.address().port}/${route}`);
            return { page, complaints };
        },
        /** A page that is left open goes on simulating, and every later test gets less of the machine. */
        async closePages() {
            await Promise.all(browser.contexts().map((context) => context.close()));
        },
        async close() {
            await browser.close();
            server.close();
        },
    };
}

/** Every route: the areas, and what their navigation names. */
export async function routes(page) {
    const found = new Set();
    for (const area of await page.locator("header nav a").evaluateAll((links) => links.map((link) => link.hash))) {
        found.add(area);
        await page.evaluate((route) => location.assign(route), area);
        await page.locator("main h1").waitFor();
        for (const link of await page.locator("main nav a").evaluateAll((links) => links.map((link) => link.hash))) {
            found.add(link);
        }
    }
    return [...found];
}

/** What the page does wrong by the rules of WCAG 2.2 AA that a program can judge, a line each. */
export async function violations(page) {
    await page.addScriptTag({ path: installed.resolve("axe-core/axe.min.js") });
    const found = await page.evaluate(() => globalThis.axe.run(document, { runOnly: ["wcag2a", "wcag2aa", "wcag21aa", "wcag22aa", "best-practice"] }));
    return found.violations.flatMap(({ id, nodes }) => nodes.map(({ target, failureSummary }) => `${id}: ${target.join(" ")}: ${failureSummary}`));
}
