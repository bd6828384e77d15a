// The chapters of the explainer in Chromium: each lets the reader do the thing, and the physics answers.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { after, afterEach, before, test } from "node:test";
import { start } from "./browser.mjs";

let browser;
before(async () => {
    browser = await start();
});
after(() => browser?.close());
afterEach(() => browser?.closePages());

/** Nothing moves before it is asked to, which leaves the computer to the physics. */
const STILL = { reducedMotion: "reduce" };

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
    // By hand: a quarter turn from the right to the top.
    const { x, y, width, height } = await rotor.boundingBox();
    const [middle, centre, radius] = [x + width / 2, y + height / 2, 0.35 * width];
    await page.mouse.move(middle + radius, centre);
    await page.mouse.down();
    await page.mouse.move(middle + 0.7 * radius, centre - 0.7 * radius);
    await page.mouse.move(middle, centre - radius);
    assert.equal(await reading(page, "angle"), 210);
    await page.mouse.up();
    for (const [step, rest] of [["AB", 150], ["AC", 210], ["BC", 270], ["BA", 330]]) {
        await page.getByRole("button", { name: step, exact: true }).click();
        await reaches(page, "angle", rest - 1, rest + 1);
        await reaches(page, "torque", -4, 4);
        // The words of the first figure, which shows the same step.
        await page.getByText(`enters at ${step[0]} and leaves at ${step[1]}`).waitFor();
        await page.getByText(`pulls the north pole N to ${rest}°`).waitFor();
        // The pole's mark points there, counterclockwise from the zero on the left.
        await page.waitForFunction((rest) => {
            const turned = Number(/rotate\((-?[\d.]+)\)/.exec(document.querySelector("path.on-north").parentElement.getAttribute("transform"))[1]);
            return Math.cos(((180 - turned - rest) * Math.PI) / 180) > 0.999;
        }, rest);
        assert.doesNotMatch(await page.locator('[data-reading="torque"]').textContent(), /^-0/);
    }
    await guess(page);
    await page.getByLabel("The step follows the rotor").check();
    await reaches(page, "sector", 0, 0);
    await reaches(page, "sector", 3, 3);
    assert.deepEqual(complaints, []);
});

/** Answers the question of a chapter, which reveals its last scene. */
function guess(page) {
    return page.locator(".guess").first().click();
}

/** Moves a slider to a value, as a hand does. */
function slide(page, name, value) {
    return page.getByRole("slider", { name }).evaluate((input, value) => {
        input.value = String(value);
        input.dispatchEvent(new Event("input", { bubbles: true }));
        input.dispatchEvent(new Event("change", { bubbles: true }));
    }, value);
}

test("back-EMF: it grows with the speed of the hand, and the drive accepts a crossing in every sector", async () => {
    const { page, complaints } = await open("back-emf");
    const largest = () =>
        page.evaluate(() => Math.max(...["A", "B", "C"].map((name) => Math.abs(Number.parseFloat(document.querySelector(`[data-reading="emf-${name}"]`).textContent)))));
    // A dot for each crossing, at the spin that the reader finds: spots of a phase's colour on the line of zero.
    await page.waitForFunction(() => {
        const canvas = document.querySelector(".waveforms canvas");
        const { left, width, top, height } = canvas.parentElement.querySelector(".u-over").getBoundingClientRect();
        const box = canvas.getBoundingClientRect();
        const context = new OffscreenCanvas(width, 1).getContext("2d", { willReadFrequently: true });
        context.drawImage(canvas, left - box.left, Math.round(top - box.top + height / 2), width, 1, 0, 0, width, 1);
        const row = context.getImageData(0, 0, width, 1).data;
        const colours = Array.from({ length: width }, (_, x) => row.slice(4 * x, 4 * x + 3).join());
        const spots = colours.filter((colour, x) => colour !== "255,255,255" && [1, 2, 3, 4].every((on) => colours[x + on] === colour));
        return ["179,38,30", "28,113,65", "57,73,171"].every((phase) => spots.includes(phase));
    });
    await slide(page, /Spin/, 1);
    await page.waitForFunction(() => Number.parseFloat(document.querySelector('[data-reading="emf-A"]').textContent) > 25);
    assert.ok(Math.abs((await largest()) - 28) <= 1, "1/4 turn a second of the shaft at 18 mV s/rad");
    await slide(page, /Spin/, 0);
    await page.waitForFunction(() => ["A", "B", "C"].every((name) => document.querySelector(`[data-reading="emf-${name}"]`).textContent.startsWith("0 ")));
    await page.getByRole("slider", { name: "Rotor" }).press("ArrowLeft");
    await page.waitForFunction(() => ["A", "B", "C"].some((name) => !/^-?0 /.test(document.querySelector(`[data-reading="emf-${name}"]`).textContent)));
    assert.match(await page.locator('[data-reading="state"]').textContent(), /4 Sensorless/);
    await slide(page, /Set-point/, 2000);
    await reaches(page, "speed", 1960, 2040);
    assert.deepEqual(complaints, []);
});

test("open loop: too fast a ramp loses the step without a fault, a slower one or a lighter rotor does not", async () => {
    const { page, complaints } = await open("open-loop", STILL);
    const verdict = (text) => page.locator('[data-reading="verdict"]').getByText(text).waitFor();
    await verdict("follows");
    await reaches(page, "field", 990, 1010);
    await reaches(page, "mean", 980, 1020);
    // What the text says of constant speed: several times the current that the load needs, late by more than the flat top.
    assert.ok((await reading(page, "rms")) > 3 * (await reading(page, "needed")));
    await reaches(page, "lag", 120, 180);
    await page.getByRole("slider", { name: "Look back" }).evaluate((input) => {
        input.value = "-15500";
        input.dispatchEvent(new Event("input", { bubbles: true }));
    });
    await reaches(page, "lag", 0, 60);
    await slide(page, /Ramp/, 0.1);
    await verdict("has lost synchronism");
    await reaches(page, "field", 990, 1010);
    await reaches(page, "mean", -150, 150);
    assert.equal(await reading(page, "lag"), "none: it slips");
    assert.match(await page.locator('[data-reading="state"]').textContent(), /3 Open-loop/);
    await slide(page, /Flywheel/, 0);
    await verdict("follows");
    await reaches(page, "mean", 980, 1020);
    // A little more load stalls it, with much more current than that load needs.
    await slide(page, /Ramp/, 0.4);
    await slide(page, /Flywheel/, 50);
    await slide(page, /Load/, 10);
    await verdict("has lost synchronism");
    assert.ok((await reading(page, "rms")) > 3 * (await reading(page, "needed")));
    await slide(page, /Load/, 5);
    await verdict("follows");
    await reaches(page, "mean", 980, 1020);
    // What the text says: without a load it lags as well.
    await slide(page, /Load/, 0);
    await reaches(page, "rms", 0.5, 0.9);
    await reaches(page, "lag", 100, 180);
    assert.deepEqual(complaints, []);
});

test("sensorless start: from state to state, a tick on, a tick back", async () => {
    const { page, complaints } = await open("sensorless-start", STILL);
    const next = page.getByRole("button", { name: "Run to next state" });
    const state = (text) => page.locator('[data-reading="state"]').getByText(text).waitFor();
    await guess(page);
    // It waits at power-up for the reader, and stops where the current of a state flows.
    for (let round = 0; round < 2; round++) {
        await state("1 Standby");
        for (const [name, step, least] of [["2 Rotor lock", /lock C$/, 3], ["3 Open-loop", /AC$/, 1], ["4 Sensorless", /^\d: [ABC]{2}$/, 1]]) {
            await next.click();
            await state(name);
            assert.match(await page.locator('[data-reading="step"]').textContent(), step);
            const amperes = await page.locator(".ampere").allTextContents();
            assert.ok(amperes.filter((text) => Math.abs(Number.parseFloat(text)) > 0.1).length >= Math.min(3, least + 1), `${name}: ${amperes}`);
        }
        // There is no next one.
        assert.ok(await next.isDisabled());
        if (round === 0) {
            await page.getByRole("button", { name: "Restart" }).click();
        }
    }
    const time = page.locator(".time").first();
    const handedOver = Number.parseFloat(await time.textContent());
    // What a click asks for is drawn with the next picture.
    const shows = (milliseconds) => time.getByText(`${milliseconds.toFixed(1)} ms`, { exact: true }).waitFor();
    await page.getByRole("button", { name: "One tick forward" }).click();
    await shows(handedOver + 0.1);
    for (let tick = 0; tick < 3; tick++) {
        await page.getByRole("button", { name: "One tick back" }).click();
    }
    await shows(handedOver - 0.2);
    // 0.15 s before, in the lock.
    await slide(page, "Look back", -1500);
    await state("2 Rotor lock");
    assert.match(await page.locator('[data-reading="step"]').textContent(), /^12: lock C\+A$/);
    // Any flywheel starts, a heavier one later.
    const closed = [];
    for (const flywheel of [1, 10]) {
        await slide(page, /Flywheel/, flywheel);
        await page.waitForFunction((before) => document.querySelector('[data-reading="closed"]').textContent !== before && /^[0-9]/.test(document.querySelector('[data-reading="closed"]').textContent), closed.at(-1));
        closed.push(await page.locator('[data-reading="closed"]').textContent());
    }
    assert.ok(Number.parseFloat(closed[1]) > Number.parseFloat(closed[0]), closed.join());
    assert.deepEqual(complaints, []);
});

test("a moment of a chapter is the same on the bench, and the page's master takes over from there", async () => {
    const { page, complaints } = await open("sensorless-start", STILL);
    const next = page.getByRole("button", { name: "Run to next state" });
    for (const state of ["2 Rotor lock", "3 Open-loop", "4 Sensorless"]) {
        await next.click();
        await page.locator('[data-reading="state"]').getByText(state).waitFor();
    }
    // An instant before the newest tick.
    const newest = await page.locator(".time").textContent();
    await slide(page, "Look back", -123);
    await page.waitForFunction((newest) => document.querySelector(".time").textContent !== newest, newest);
    const [state, speed, time] = await Promise.all([reading(page, "state"), reading(page, "speed"), page.locator(".time").textContent().then(Number.parseFloat)]);
    const angle = /[\d.]+°/.exec(await page.getByRole("img", { name: /Cross-section/ }).first().getAttribute("aria-label"))[0];
    await page.getByRole("button", { name: "Open this moment on the bench" }).click();
    await page.locator("#reproduced").getByText(/^Reproduced bit for bit/).waitFor();
    const truth = (name) => page.locator(`[data-truth="${name}"]`).textContent();
    assert.deepEqual([Number.parseFloat(await truth("state")), await truth("angle")], [state, angle]);
    assert.ok(Math.abs(Number.parseFloat(await truth("speed")) - speed) <= 0.55, "one of them has a digit more");
    assert.match(await page.locator("#ticks").textContent(), new RegExp(`tick ${Math.round(10 * time)}$`));
    // Time runs on from there, and Stop stops.
    await page.locator("#play").click();
    await page.locator('[data-truth="state"]').getByText("4 Sensorless").waitFor();
    assert.equal(await page.locator("#setpoint").inputValue(), "1500");
    await page.locator("#stop").click();
    await page.locator('[data-truth="state"]').getByText("1 Standby").waitFor();
    assert.deepEqual(complaints, []);
});

test("demagnetisation: current and inductance hold the terminal at the rail until crossings come late", async () => {
    const { page, complaints } = await open("demagnetisation", STILL);
    await reaches(page, "clamped", 0, 2);
    await reaches(page, "late", 0, 0);
    await guess(page);
    await page.getByRole("button", { name: "Hide the crossings" }).click();
    await reaches(page, "clamped", 30, 60);
    await reaches(page, "speed", 1400, 1600);
    // Every other crossing is late, because the spike of every other step is longer than half of it.
    await reaches(page, "late", 48, 54);
    const half = await reading(page, "half");
    assert.ok((await reading(page, "spike")) > half, `${await reading(page, "spike")} us`);
    await slide(page, /Load/, 100);
    await reaches(page, "late", 0, 0);
    assert.ok((await reading(page, "spike")) < half, `${await reading(page, "spike")} us`);
    assert.deepEqual(complaints, []);
});

test("hall sensors: misaligned ones cost current, and the calibration finds by how much", async () => {
    const { page, complaints } = await open("hall-sensors", STILL);
    await guess(page);
    // The peak of the curves, without the ripple within a period.
    await reaches(page, "peak", 1.5, 1.9);
    const aligned = await reading(page, "rms");
    const peaks = { 0: await reading(page, "peak") };
    const rms = {};
    for (const offset of [10, -30, 30]) {
        await slide(page, /Sensors/, offset);
        await page.waitForFunction((before) => Number.parseFloat(document.querySelector('[data-reading="peak"]').textContent) > before + 0.04, Math.max(...Object.values(peaks)));
        peaks[offset] = await reading(page, "peak");
        rms[offset] = await reading(page, "rms");
    }
    assert.ok(peaks[30] > peaks[-30] && peaks[-30] > 1.3 * peaks[0], JSON.stringify(peaks));
    assert.ok(rms[10] < 1.1 * aligned && rms[-30] > 1.2 * aligned, JSON.stringify(rms));
    await page.getByText("Sensors 30° late").waitFor();
    await slide(page, /Sensors/, 40);
    await reaches(page, "peak", 7, 12);
    assert.ok((await reading(page, "rms")) > 2 * aligned);
    assert.ok(Math.abs((await reading(page, "speed")) - 2000) < 40);
    await page.getByRole("button", { name: "Calibrate" }).click();
    // By 60 degrees less, and with the lines renamed by a sector: 41.5 degrees under load.
    await page.locator('[data-reading="found"]').getByText(/^-(1[89]|2[01])\.\d°, lines BCA, inverted$/).waitFor();
    await reaches(page, "peak", 1.5, 2.5);
    assert.deepEqual(complaints, []);
});

test("speed loop: less integral gain is slower, too much swings, and a limit of the current takes over", async () => {
    const { page, complaints } = await open("speed-loop", STILL);
    await reaches(page, "back", 50, 150);
    assert.ok((await reading(page, "overshoot")) < 40);
    assert.equal(await reading(page, "limiter"), "speed loop");
    // The speed loop holds the mean, while the speed of an instant swings by 15 rpm.
    await reaches(page, "held", 1997, 2003);
    // Ten times Kp changes little, a hundred times shakes the motor, and the dip grows with the load.
    const commissioned = await reading(page, "dip");
    await slide(page, /Kp/, 1);
    await page.waitForFunction((dip) => Number.parseFloat(document.querySelector('[data-reading="dip"]').textContent) !== dip, commissioned);
    assert.ok(Math.abs((await reading(page, "dip")) - commissioned) < 0.1 * commissioned);
    await slide(page, /Kp/, 2);
    await reaches(page, "dip", 1000, 2000);
    await slide(page, /Kp/, 0);
    await reaches(page, "dip", commissioned, commissioned);
    await slide(page, /Load/, 120);
    await reaches(page, "dip", 1.3 * commissioned, 2 * commissioned);
    await slide(page, /Load/, 80);
    await reaches(page, "dip", commissioned, commissioned);
    await slide(page, /Ki/, 1);
    await reaches(page, "overshoot", 120, 400);
    const dip = await reading(page, "dip");
    await slide(page, /Ki/, -1);
    await page.locator('[data-reading="back"]').getByText("not within 900 ms").waitFor();
    assert.equal(await reading(page, "overshoot"), 0);
    assert.ok(Math.abs((await reading(page, "dip")) - dip) < 0.25 * dip);
    await slide(page, /Ki/, 0);
    // Time that runs on, until the load's part of the run is no longer kept, changes no figure.
    await reaches(page, "held", 1997, 2003);
    await page.getByLabel("Time scale").selectOption("1");
    await page.getByRole("button", { name: "Run", exact: true }).click();
    await page.waitForFunction(() => Number.parseFloat(document.querySelector(".time").textContent) > 5600);
    assert.ok((await reading(page, "dip")) > 200 && (await reading(page, "mean-current")) > 0.7);
    await slide(page, /limit/, 0.5);
    await page.locator('[data-reading="limiter"]').getByText("bus current").waitFor();
    await reaches(page, "held", 800, 1400);
    await reaches(page, "mean-current", 0.45, 0.5);
    // Only after the prediction the end of the run is drawn.
    const whole = page.getByRole("img", { name: /the whole run$/ });
    assert.equal(await whole.count(), 0);
    await guess(page);
    assert.equal(await whole.count(), 1);
    assert.ok((await reading(page, "after")) < 60, `${await reading(page, "after")} rpm`);
    assert.equal(await reading(page, "back"), "not within 900 ms");
    assert.deepEqual(complaints, []);
});

/** The transitions of Table 7, as tests/coverage.md has them from the code: name and states. */
const TABLE = [...readFileSync(new URL("../coverage.md", import.meta.url), "utf8").matchAll(/^\| (T\d\d) \| (\d) to (\d):/gm)].map(
    ([, name, from, to]) => `${name} ${from} ${to}`,
);

test("identification: what the reader measures is what the motor has, whatever the levels, the speed and the flywheel", async () => {
    const { page, complaints } = await open("identification", STILL);
    // Two switches of 0.04 ohm are on the way.
    await reaches(page, "two", 0.392, 0.404);
    const one = await reading(page, "one");
    assert.ok(one > 0.42, `${one} ohm from one level`);
    await reaches(page, "inductance", 0.19, 0.21);
    await reaches(page, "constant", 35.8, 36.2);
    const areas = async () => [await reading(page, "area-first"), await reading(page, "area-last")];
    const [first, last] = await areas();
    assert.ok(Math.abs(first - last) < 0.02 * first, `${first} and ${last} mV s`);
    await guess(page);
    await reaches(page, "inertia", 47, 49);
    const [friction, deceleration] = [await reading(page, "friction"), await reading(page, "deceleration")];

    await slide(page, /Second level/, 5);
    await page.waitForFunction((one) => Number.parseFloat(document.querySelector('[data-reading="one"]').textContent) > one, one);
    await reaches(page, "two", 0.392, 0.404);
    await slide(page, /Flywheel/, 2);
    await reaches(page, "inertia", 141, 147);
    assert.ok(Math.abs((await reading(page, "deceleration")) - deceleration / 3) < 0.1 * deceleration);
    assert.ok(Math.abs((await reading(page, "friction")) - friction) < 0.1 * friction);
    await slide(page, /Speed before/, 1500);
    await page.getByText(/^First electrical revolution, at 14\d\d rpm$/).waitFor();
    await reaches(page, "constant", 35.8, 36.2);
    assert.deepEqual(complaints, []);
});

test("faults: the diagram is Table 7, lights the way to the fault, and lets nobody out unacknowledged", async () => {
    const { page, complaints } = await open("faults");
    const drawn = await page.locator("path[data-name]").evaluateAll((paths) => paths.map(({ dataset: { name, from, to } }) => `${name} ${from} ${to}`));
    assert.ok(TABLE.length > 20);
    assert.deepEqual(drawn.sort(), TABLE.toSorted());
    const state = (text) => page.locator('[data-reading="state"]').getByText(text).waitFor();
    const button = (name) => page.getByRole("button", { name });
    await state("5 Hall sensors");
    const events = page.getByRole("list", { name: "Event log" }).getByRole("listitem");
        // The times are those of PROTOCOL.md, section 4: 300 us; 100 ms without an edge and 500 ms of torque at speed 0.
    for (const [trouble, words, within] of [
        ["Short across the bus", /DC-link current/, [0.3, 0.5]],
        ["Rotor is blocked", /torque applied at speed 0/, [550, 650]],
    ]) {
        await button(trouble).click();
        await state("6 Fault");
        await page.getByRole("status").getByText(words).waitFor();
        assert.equal(await page.locator("path.last").getAttribute("data-name"), "T56");
        const [deed, consequence] = await events.filter({ hasText: /You: (Short|Rotor)|6 Fault/ }).evaluateAll((items) => items.slice(-2).map(({ textContent }) => textContent));
        assert.ok(deed.includes(`You: ${trouble}`));
        assert.match(consequence, words, "the log names the cause");
        const later = Number.parseFloat(/\+([\d.]+)/.exec(consequence)[1]);
        assert.ok(within[0] <= later && later <= within[1], `${trouble}: ${later} ms`);
        await button("Repair all").click();
        await button("Request Drive").click();
        await state("6 Fault");
        await button("Request Standby").click();
        await state("1 Standby");
        assert.equal(await page.locator("path.last").getAttribute("data-name"), "T61");
        await button("Request Drive").click();
        await state("5 Hall sensors");
    }
    await page.getByLabel("Control mode").selectOption("sensorless");
    await state("4 Sensorless");
    await button("Rotor is blocked").click();
    await state("7 Auto-restart");
    assert.equal(await page.locator("path.last").getAttribute("data-name"), "T47");
    // The way out of Fault is shown after the prediction.
    assert.equal(await button("Request Standby").count(), 1);
    await guess(page);
    assert.equal(await button("Request Standby").count(), 2);
    await button("Emergency stop").click();
    await state("6 Fault");
    await button("Repair all").click();
    await button("Request Standby").last().click();
    await state("1 Standby");
    assert.equal(await page.locator("path.last").last().getAttribute("data-name"), "T61");
    assert.deepEqual(complaints, []);
});

test("frames: a click shows what it sends and what the drive says to it", async () => {
    const { page, complaints } = await open("frames", STILL);
    const row = (name) => page.getByRole("row").filter({ has: page.getByRole("cell", { name, exact: true }) }).first();
    /** Chooses the first frame whose row has these texts. */
    const choose = async (...texts) => {
        const rows = await page.locator("tbody tr").allTextContents();
        await page.getByRole("combobox", { name: "Frame" }).selectOption({ index: rows.findIndex((row) => texts.every((text) => row.includes(text))) });
    };
    const field = (name) => page.locator(`[data-field="${name}"]`).textContent();
    await page.getByRole("button", { name: "Drive, 9000 rpm" }).click();
    await row("MOTOR_CMD_SET").getByText("23 28 00 00 00 00 00 00").waitFor();
    await choose("MOTOR_CMD", "drive");
    const accepted = Number.parseFloat(await field("Speed"));
    assert.ok(accepted > 1000 && accepted < 9000, `${accepted} rpm`);
    assert.match(await page.getByRole("list", { name: "Identifier" }).textContent(), /Priority.*frame of a drive.*170 = AAh.*85 = 55h.*drive to master.*102/);
    await page.getByRole("button", { name: "Write pole pairs = 0" }).click();
    await page.getByRole("row").filter({ hasText: "00 4E 00 00 00 04 00 03" }).waitFor();
    await choose("00 4E 00 00 00 04 00 03");
    assert.deepEqual(await Promise.all(["Number", "Value", "Status"].map(field)), ["78 ", "4 ", "Out of range "]);
    assert.match(await page.getByRole("list", { name: "Data" }).textContent(), /004Eh = 78.*0004h = 4.*0003h = 3/);
    await guess(page);
    await page.getByRole("button", { name: "Silence the master" }).click();
    await page.locator('[data-reading="state"]').getByText("6 Fault").waitFor();
    // CAN time-out, parameter 114, from the last command of the master.
    await reaches(page, "silence", 195, 255);
    assert.deepEqual(complaints, []);
});

test("only the chapter that shows decoded messages loads the module that decodes them", async () => {
    for (const [chapter, decodes] of [["speed-loop", false], ["hall-sensors", false], ["frames", true]]) {
        const { page } = await open(chapter, STILL);
        const loaded = await page.evaluate(() => performance.getEntriesByType("resource").map(({ name }) => name));
        assert.ok(loaded.some((name) => name.includes("narx_bg")));
        assert.equal(loaded.some((name) => name.includes("core_bg")), decodes, chapter);
    }
});

test("all chapters say what they are about, lead from one to the next, and end", async () => {
    const { page } = await browser.open(STILL, "#/learn");
    const links = await page.getByRole("navigation", { name: "Chapters" }).getByRole("link").evaluateAll((links) => links.map(({ hash }) => hash));
    await page.getByRole("navigation", { name: "Chapters" }).getByRole("link").first().click();
    const visited = [];
    for (;;) {
        await page.locator(".predict").waitFor();
        visited.push(new URL(page.url()).hash);
        // The answer comes after a prediction.
        const predict = page.locator(".predict");
        assert.equal(await predict.locator("p").count(), 0);
        await predict.locator(".guess").nth(visited.length % 3).click();
        assert.match(await predict.locator(".verdict").textContent(), /^(That is right\.|No\. The right answer: )/);
        assert.ok((await predict.locator("p").last().textContent()).length > 100);
        assert.equal(await predict.locator(".guess.right").count(), 1);
        // Words that name a part of the picture have a colour.
        const plain = await page.locator(".words b").evaluateAll((words) => words.filter((word) => getComputedStyle(word).color === getComputedStyle(word.parentElement).color).map((word) => word.textContent));
        assert.deepEqual(plain, []);
        // Paragraphs with a figure each, and with one control at most; a group is one.
        for (const scene of await page.locator(".scene").all()) {
            const controls = await scene.locator("button, input, select, [role=slider]").evaluateAll((all) => new Set(all.map((control) => control.closest("[role=group]") ?? control)).size);
            assert.equal(await scene.locator("figure").count(), 1);
            assert.ok(controls <= 1, `${controls} controls: ${await scene.innerText()}`);
            assert.ok((await scene.locator(".words").innerText()).length < 620, await scene.locator(".words").innerText());
        }
        const next = page.locator('a[rel="next"]');
        if ((await next.count()) === 0) {
            break;
        }
        const title = (await next.textContent()).replace(" →", "");
        await next.click();
        await page.getByRole("heading", { level: 1, name: title }).waitFor();
    }
    assert.deepEqual(visited, links);
    await page.evaluate(() => location.assign("#/learn/magic"));
    await page.getByRole("heading", { name: 'There is no chapter "magic"' }).waitFor();
});

test("the first place has a motor to grab, and two ways on", async () => {
    const { page, complaints } = await browser.open({}, "");
    const rotor = page.getByRole("slider", { name: "Rotor" });
    await rotor.press("PageUp");
    assert.equal(await rotor.getAttribute("aria-valuenow"), "90");
    await rotor.press("Enter");
    // Step AB pulls it to 150 degrees.
    await page.waitForFunction(() => Math.abs(Number(document.querySelector("[role=slider]").ariaValueNow) - 150) <= 1);
    await page.getByLabel("Let the steps follow the rotor").check();
    await page.getByText("Step BA pulls the north pole, N, to 330°.").waitFor();
    await page.getByRole("link", { name: "Spin a motor" }).click();
    await page.getByRole("heading", { level: 1, name: "Six-step commutation" }).waitFor();
    await page.goBack();
    await page.getByRole("link", { name: "Operate one" }).click();
    await page.locator("#start:enabled").waitFor();
    assert.deepEqual(complaints, []);
});

test("a phone's first screen always has a picture, or something to do", async () => {
    const { page } = await browser.open({ ...STILL, viewport: { width: 360, height: 740 } }, "#/learn");
    const pictures = () => page.evaluate(() => [...document.querySelectorAll("article svg, article canvas, article figure button, article table, article .guess")].filter((picture) => picture.checkVisibility()).map((picture) => picture.getBoundingClientRect()).map(({ top, bottom }) => [top + scrollY, bottom + scrollY]));
    const links = await page.getByRole("navigation", { name: "Chapters" }).getByRole("link").evaluateAll((links) => links.map(({ hash }) => hash));
    for (const route of ["#/learn", ...links]) {
        await page.evaluate((route) => location.assign(route), route);
        await page.locator("main h1").waitFor();
        await page.locator("article svg, article canvas, article table").first().waitFor();
        // Plots are loaded last, into places that have their height.
        const plots = () => page.locator("article .waveforms").evaluateAll((found) => found.map((place) => ({ drawn: place.querySelector("canvas") !== null, height: place.offsetHeight, kept: Number.parseFloat(place.style.minHeight) })));
        while ((await plots()).some(({ drawn }) => !drawn)) {
            await page.waitForTimeout(50);
        }
        // Legends of many words take more lines on a phone.
        assert.deepEqual((await plots()).filter(({ height, kept }) => height < kept || height > kept + 90), [], `${route}: plots as high as the places that were kept for them`);
        const places = (await pictures()).toSorted(([one], [two]) => one - two);
        assert.ok(places[0][0] < 740 / 2 + 80, `${route}: it begins at ${places[0][0]} px`);
        let end = 0;
        for (const [top, bottom] of places) {
            assert.ok(top - end < 740 - 120, `${route}: nothing but text from ${end} to ${top} px`);
            end = Math.max(end, bottom);
        }
    }
});

test("on a phone, the diagram shows the present state", async () => {
    const { page } = await browser.open({ viewport: { width: 360, height: 740 } }, "#/learn/faults");
    const shown = (number) =>
        page.waitForFunction((number) => {
            const [state, view] = [document.querySelector(`[data-state="${number}"]`), document.querySelector(".scroll")].map((element) => element.getBoundingClientRect());
            return document.querySelector(`.here[data-state="${number}"]`) && state.left >= view.left - 1 && state.right <= view.right + 1;
        }, number);
    await shown(5);
    await page.getByRole("button", { name: "Emergency stop" }).click();
    await shown(6);
});

test("only one line of the state diagram crosses others, and no line runs through a box", async () => {
    const { page } = await open("faults", STILL);
    const ways = await page.locator("path.way").evaluateAll((paths) => paths.map((path) => ({ name: path.dataset.name, points: [...path.getAttribute("d").matchAll(/([\d.]+) ([\d.]+)/g)].map(([, x, y]) => [Number(x), Number(y)]) })));
    const boxes = await page.locator("g.state").evaluateAll((groups) =>
        groups.map((group) => {
            const [, x, y] = /translate\(([\d.]+) ([\d.]+)\)/.exec(group.getAttribute("transform")).map(Number);
            const rect = group.querySelector("rect");
            return { x, y, width: rect.width.baseVal.value, height: rect.height.baseVal.value };
        }),
    );
    const segments = ways.flatMap(({ name, points }) => points.slice(1).map((end, at) => ({ name, from: points[at], to: end })));
    assert.ok(ways.length === 23 && segments.every(({ from, to }) => from[0] === to[0] || from[1] === to[1]), "straight");
    const within = (value, one, two) => value > Math.min(one, two) && value < Math.max(one, two);
    const crossed = segments.flatMap((flat) => segments.filter((steep) => flat.from[1] === flat.to[1] && steep.from[0] === steep.to[0] && within(steep.from[0], flat.from[0], flat.to[0]) && within(flat.from[1], steep.from[1], steep.to[1])).map((steep) => `${flat.name} ${steep.name}`));
    assert.deepEqual(crossed.sort(), ["T71 T45", "T71 T54"]);
    for (const { name, from, to } of segments) {
        const [x, y] = [(from[0] + to[0]) / 2, (from[1] + to[1]) / 2];
        assert.ok(boxes.every((box) => Math.abs(x - box.x) >= box.width / 2 || Math.abs(y - box.y) >= box.height / 2), name);
    }
});
