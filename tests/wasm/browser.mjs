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
        /** Port of the server. */
        port: server.address().port,
        async open(options, route = "", address = `http://127.0.0.1:${server.address().port}/${route}`) {
            const page = await browser.newPage(options);
            const complaints = [];
            page.on("console", (message) => ["error", "warning"].includes(message.type()) && complaints.push(message.text()));
            page.on("pageerror", (error) => complaints.push(error.message));
            page.on("requestfailed", (request) => complaints.push(`not loaded: ${request.url()}`));
            await page.goto(address);
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

/** What does not suit a phone, a line each: text below 12 px, and tables that are wider than their place. */
export function unreadable(page) {
    return page.evaluate(() => {
        const found = new Set();
        const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
        while (texts.nextNode()) {
            const { textContent, parentElement: element } = texts.currentNode;
            if (textContent.trim() === "" || !element.checkVisibility() || element.closest("title, option")) {
                continue;
            }
            // A picture is drawn larger or smaller than its units.
            const pixels = Number.parseFloat(getComputedStyle(element).fontSize) * (element.ownerSVGElement ? element.getScreenCTM().a : 1);
            if (pixels < 11.99) {
                found.add(`${element.localName} ${element.className.baseVal ?? element.className}: ${pixels.toFixed(1)} px`);
            }
        }
        for (const table of document.querySelectorAll("table")) {
            if (table.checkVisibility() && table.scrollWidth > table.parentElement.clientWidth) {
                found.add(`table of "${table.parentElement.ariaLabel}": ${table.scrollWidth} px in ${table.parentElement.clientWidth} px`);
            }
        }
        return [...found];
    });
}

/**
 * What is hard to see on the visible buttons under the pointer and with the keyboard's focus, a line each: a label below 4.5:1, an outline below 3:1, and a
 * button that means something by its colour and loses it. Of buttons that look alike at rest the first is tried.
 */
export async function unclear(page) {
    const buttons = page.locator("button:visible, .button:visible");
    const kinds = await buttons.evaluateAll((buttons) => buttons.map((button) => `${button.className} ${button.disabled} ${button.ariaPressed}`));
    const found = [];
    for (const [index, kind] of kinds.entries()) {
        const button = buttons.nth(index);
        if (kinds.indexOf(kind) < index || kind.startsWith("skip")) {
            continue;
        }
        const rest = await button.evaluate(look);
        await button.hover({ force: true });
        const hovered = await button.evaluate(look);
        await page.mouse.move(0, 0);
        await button.evaluate((button) => button.focus({ focusVisible: true }));
        const focused = await button.evaluate(look);
        const about = (state) => `${kind}, "${rest.text}", ${state}`;
        for (const [state, { label, outline }] of Object.entries({ rest, hovered, focused })) {
            if (label < 4.5) {
                found.push(`${about(state)}: label ${label.toFixed(1)}:1`);
            }
            if (state === "focused" && !rest.disabled && outline < 3) {
                found.push(`${about(state)}: outline ${outline.toFixed(1)}:1`);
            }
        }
        // A button that the drive enables meanwhile is another one.
        if (/primary|danger/.test(kind) && hovered.disabled === rest.disabled && hovered.colours !== rest.colours) {
            found.push(`${about("hovered")}: ${hovered.colours}, at rest ${rest.colours}`);
        }
    }
    await page.evaluate(() => scrollTo(0, 0));
    return found;
}

/** Runs in the page: colours of a button as they are now, and their contrasts. */
function look(button) {
    const context = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });
    const channels = (colour) => {
        context.clearRect(0, 0, 1, 1);
        context.fillStyle = colour;
        context.fillRect(0, 0, 1, 1);
        return [...context.getImageData(0, 0, 1, 1).data];
    };
    const behind = (element) => {
        const colour = channels(getComputedStyle(element).backgroundColor);
        return colour[3] === 255 || element === document.documentElement ? colour : behind(element.parentElement);
    };
    const luminance = (colour) => {
        const [r, g, b] = colour.slice(0, 3).map((channel) => (channel <= 10 ? channel / 3294.6 : ((channel / 255 + 0.055) / 1.055) ** 2.4));
        return 0.2126 * r + 0.7152 * g + 0.0722 * b;
    };
    const contrast = (one, two) => {
        const [dark, light] = [luminance(one), luminance(two)].sort((a, b) => a - b);
        return (light + 0.05) / (dark + 0.05);
    };
    const { color, backgroundColor, outlineColor, outlineStyle } = getComputedStyle(button);
    return {
        text: button.textContent.trim(),
        disabled: button.disabled,
        colours: `${color} on ${backgroundColor}`,
        label: contrast(channels(color), behind(button)),
        outline: outlineStyle === "none" ? 1 : contrast(channels(outlineColor), behind(button.parentElement)),
    };
}
