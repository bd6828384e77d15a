// The built page in Chromium.

import assert from "node:assert/strict";
import { basename } from "node:path";
import { after, before, test } from "node:test";
import { routes, start, violations } from "./browser.mjs";
import { VECTORS } from "./vectors.mjs";

let browser;
before(async () => {
    browser = await start();
});
after(() => browser?.close());

/** Waits until the text of `selector` as a number is within `tolerance` of `value`. */
function reaches(page, selector, value, tolerance) {
    const near = ([selector, value, tolerance]) => Math.abs(Number(document.querySelector(selector).textContent) - value) <= tolerance;
    return page.waitForFunction(near, [selector, value, tolerance], { timeout: 60_000 });
}

/** Whether the plot has pixels of more than one colour. */
function isDrawn(page) {
    return page.locator("#plot canvas").evaluate((canvas) => {
        const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
        return new Set(new Uint32Array(data.buffer)).size > 2;
    });
}

test("motors spin up to their set-point and stop", async () => {
    const { page, complaints } = await browser.open({}, "#/operate/main");
    await page.waitForSelector("#motor option", { state: "attached" });
    const names = await page.locator("#motor option").evaluateAll((options) => options.map((option) => option.value));
    assert.ok(names.length >= 4);
    // In real time: some of them. bench.test.mjs turns them all.
    for (const name of [names[0], names[names.length >> 1], names.at(-1)]) {
        await page.locator("#motor").selectOption(name);
        await page.locator("#start:enabled").waitFor();
        const rpm = Number(await page.locator("#setpoint").inputValue());
        await page.locator("#start").click();
        await reaches(page, "#speed", rpm, rpm * 0.02);
        assert.equal(await page.locator("#state").textContent(), "Closed-loop Hall Effect Sensors");
        await page.locator("#stop").click();
        await page.getByText("Standby", { exact: true }).waitFor();
    }
    assert.ok(await isDrawn(page));
    assert.deepEqual(complaints, []);
});

test("the set-point changes while the motor turns, by keyboard", async () => {
    const { page, complaints } = await browser.open({}, "#/operate/main");
    await page.locator("#start:enabled").waitFor();
    await page.locator("#setpoint").fill("2000");
    await page.locator("#setpoint").press("Enter");
    await reaches(page, "#speed", 2000, 40);
    await page.locator("#slider").focus();
    await page.keyboard.press("ArrowRight");
    assert.equal(await page.locator("#setpoint").inputValue(), "2010");
    await page.locator("#setpoint").fill("1500");
    await reaches(page, "#speed", 1500, 30);
    assert.deepEqual(complaints, []);
});

test("all vectors replay in the page, and a damaged file is named", async () => {
    const { page, complaints } = await browser.open({}, "#/operate/recordings");
    await page.locator("#recordings").setInputFiles(VECTORS);
    const rows = page.locator("#replays tbody tr");
    await rows.nth(VECTORS.length - 1).waitFor({ timeout: 60_000 });
    const texts = await rows.evaluateAll((rows) => rows.map((row) => [...row.cells].map((cell) => cell.textContent)));
    assert.deepEqual(texts.map(([name]) => name), VECTORS.map((file) => basename(file)));
    for (const [name, ticks, digest, recorded, result] of texts) {
        assert.ok(Number(ticks) > 0, name);
        assert.match(digest, /^[0-9a-f]{16}$/);
        assert.equal(digest, recorded, name);
        assert.equal(result, "identical");
    }
    await page.locator("#recordings").setInputFiles({ name: "notes.txt", mimeType: "text/plain", buffer: Buffer.from("hello") });
    await rows.nth(VECTORS.length).waitFor();
    assert.match(await rows.last().textContent(), /not a narx recording/);
    assert.deepEqual(complaints, []);
});

test("every route has its heading, fits a narrow screen, and breaks no rule of accessibility in light or dark", async () => {
    for (const colorScheme of ["light", "dark"]) {
        const { page, complaints } = await browser.open({ viewport: { width: 360, height: 740 }, colorScheme }, "#/learn");
        for (const route of await routes(page)) {
            await page.evaluate((route) => location.assign(route), route);
            await page.locator("main h1").waitFor();
            const width = await page.evaluate(() => document.documentElement.scrollWidth);
            assert.ok(width <= 360, `${route} is ${width} px wide`);
            assert.deepEqual(await violations(page), [], `${route}, ${colorScheme}`);
        }
        assert.deepEqual(complaints, []);
    }
});

test("an address that is none is named", async () => {
    const { page } = await browser.open({}, "#/fly");
    await page.getByRole("heading", { name: 'There is no page "fly"' }).waitFor();
    await page.evaluate(() => location.assign("#/operate/fly"));
    await page.getByRole("heading", { name: 'There is no panel "fly"' }).waitFor();
});

test("the reader's choice of colours is kept", async () => {
    const { page } = await browser.open({ colorScheme: "light" }, "#/learn");
    const background = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
    const light = await background();
    await page.getByLabel("Colours").selectOption("dark");
    const dark = await background();
    assert.notEqual(dark, light);
    await page.reload();
    await page.getByLabel("Colours").waitFor();
    assert.equal(await background(), dark);
});
