// The chapters of the explainer in Chromium: each lets the reader do the thing, and the physics answers.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { start } from "./browser.mjs";

let browser;
before(async () => {
    browser = await start();
});
after(() => browser?.close());

/** A chapter whose simulation has opened. */
async function open(chapter, options = {}) {
    const { page, complaints } = await browser.open(options, `#/learn/${chapter}`);
    await page.getByRole("group", { name: "Time" }).first().getByRole("button", { name: /Run|Pause/ }).and(page.locator(":enabled")).waitFor();
    return { page, complaints };
}

/** What stands beside a reading's name, as a number where it begins with one. */
function reading(page, name) {
    return page.locator(`[data-reading="${name}"]`).first().textContent().then((text) => (/^-?[\d.]/.test(text) ? Number.parseFloat(text) : text));
}

/** Waits until a reading, as a number, is between two. */
function reaches(page, name, min, max) {
    const within = ([name, min, max]) => {
        const value = Number.parseFloat(document.querySelector(`[data-reading="${name}"]`).textContent);
        return value >= min && value <= max;
    };
    return page.waitForFunction(within, [name, min, max], { timeout: 30_000 });
}

test("six steps: the rotor is turned by keys, swings to the step's place, and runs when the step follows it", async () => {
    const { page, complaints } = await open("six-steps");
    const rotor = page.getByRole("slider", { name: "Rotor" });
    assert.equal(await rotor.getAttribute("aria-valuetext"), "60 degrees, sector 0");
    assert.equal(await reading(page, "torque"), 100);
    await rotor.press("PageUp");
    await rotor.press("PageUp");
    assert.equal(await reading(page, "angle"), 120);
    assert.equal(await reading(page, "torque"), 50, "half way from the flat top to the place of rest");
    for (const [step, rest] of [["AB", 150], ["AC", 210], ["BC", 270], ["BA", 330]]) {
        await page.getByRole("button", { name: step, exact: true }).click();
        await reaches(page, "angle", rest - 1, rest + 1);
        await reaches(page, "torque", -4, 4);
    }
    await page.getByLabel("The step follows the rotor").check();
    await reaches(page, "sector", 0, 0);
    await reaches(page, "sector", 3, 3);
    assert.deepEqual(complaints, []);
});
