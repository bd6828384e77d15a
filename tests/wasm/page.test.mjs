// The frame of the built page in Chromium: routes, colours, accessibility.

import assert from "node:assert/strict";
import { after, afterEach, before, test } from "node:test";
import { routes, start, unclear, unreadable, violations } from "./browser.mjs";

let browser;
before(async () => {
    browser = await start();
});
after(() => browser?.close());
afterEach(() => browser?.closePages());

test("every route has its heading, fits a narrow screen, and breaks no rule of accessibility in light or dark", async () => {
    for (const colorScheme of ["light", "dark"]) {
        const { page, complaints } = await browser.open({ viewport: { width: 360, height: 740 }, colorScheme }, "#/learn");
        for (const route of await routes(page)) {
            await page.evaluate((route) => location.assign(route), route);
            await page.locator("main h1").waitFor();
            const width = await page.evaluate(() => document.documentElement.scrollWidth);
            assert.ok(width <= 360, `${route} is ${width} px wide`);
            assert.deepEqual(await violations(page), [], `${route}, ${colorScheme}`);
            assert.deepEqual(await unreadable(page), [], route);
            assert.deepEqual(await unclear(page), [], `${route}, ${colorScheme}`);
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

test("once loaded the page works without a network", async () => {
    const { page, complaints } = await browser.open({}, "#/learn");
    await page.evaluate(() => navigator.serviceWorker.register("./service-worker.js").then(() => navigator.serviceWorker.ready).then(({ active }) => active.state));
    await page.context().setOffline(true);
    await page.reload();
    await page.evaluate(() => location.assign("#/operate/main"));
    await page.getByRole("status").getByText("Standby", { exact: true }).waitFor();
    assert.deepEqual(complaints, []);
});
