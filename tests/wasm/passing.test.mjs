// What is passed on: runs as links, recordings, logs and columns as files.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { basename } from "node:path";
import { after, afterEach, before, test } from "node:test";
import { deflateRawSync, inflateRawSync } from "node:zlib";
import { start as launch } from "./browser.mjs";
import { drop, go, inState, isDrawn, operate, pause, saved, start } from "./operating.mjs";
import { VECTORS } from "./vectors.mjs";

let browser;
before(async () => {
    browser = await launch();
});
after(() => browser?.close());
afterEach(() => browser?.closePages());

/** The text of the last row of opened files. */
function lastFile(page) {
    return page.locator("#replays tbody tr").last().locator(".result");
}

test("a link repeats a faulty run bit for bit in another page", async () => {
    const { page, complaints } = await operate(browser, "main");
    await start(page, 1800);
    await go(page, "virtual");
    await page.locator("#load").fill("0.05");
    await page.locator("#load").press("Enter");
    await page.locator("#fault").selectOption("hall-stuck");
    await page.locator("#inject").click();
    await inState(page, "Fault");
    await pause(page);
    await page.locator("#share").click();
    const link = await page.locator("#permalink").getAttribute("href");
    const digest = (await page.getByText(/digest [0-9a-f]{16}/).textContent()).match(/[0-9a-f]{16}/)[0];
    const ticks = (await page.locator("#ticks").textContent()).match(/tick (\d+)/)[1];

    const other = await browser.open({}, link.slice(link.indexOf("#")));
    const told = other.page.locator("#reproduced");
    await told.waitFor();
    assert.equal(await told.textContent(), `Reproduced bit for bit: digest ${digest}.`);
    assert.match(await other.page.locator("#ticks").textContent(), new RegExp(`tick ${ticks}$`));
    await inState(other.page, "Fault");

    // The recording of the run has the very digest.
    const { bytes } = await saved(other.page, () => other.page.locator("#save-recording").click());
    await drop(other.page, { name: "run.narxrec", buffer: bytes });
    await lastFile(other.page).getByText("identical").waitFor();
    assert.ok((await other.page.locator("#replays tbody tr").last().textContent()).includes(digest));

    // Another seed is another run, and told to be one.
    const changed = await browser.open({}, `#/operate/virtual?run=${edited(link, (packed) => ({ ...packed, setup: { ...packed.setup, options: { ...packed.setup.options, seed: 7 } } }))}`);
    await changed.page.locator("#reproduced").waitFor();
    assert.match(await changed.page.locator("#reproduced").textContent(), new RegExp(`Not reproduced: digest [0-9a-f]{16}, expected ${digest}`));
    assert.deepEqual([...complaints, ...other.complaints, ...changed.complaints], []);
});

test("a link keeps the PWM frequency, and one without it means 10 kHz", async () => {
    const { page, complaints } = await operate(browser, "connection");
    assert.equal(await page.locator("#pwm-rate").inputValue(), "10000");
    await page.locator("#pwm-rate").fill("20000");
    await page.locator("#power-up").click();
    await go(page, "virtual");
    await page.locator("#pwm").getByText("PWM frequency 20 kHz: a control tick every 50 µs").waitFor();
    await go(page, "main");
    await inState(page, "Standby");
    await start(page, 1800, 36);
    await go(page, "virtual");
    await pause(page);
    const time = async (page) => Number(await page.locator("#time").textContent());
    const paused = await time(page);
    await page.locator("[data-step='200']").click();
    await page.waitForFunction((paused) => document.querySelector("#time").textContent !== paused, paused.toFixed(5));
    assert.ok(Math.abs((await time(page)) - paused - 0.01) < 1e-6);
    await page.locator("#share").click();
    const link = await page.locator("#permalink").getAttribute("href");

    const other = await browser.open({}, link.slice(link.indexOf("#")));
    await other.page.locator("#reproduced").getByText(/^Reproduced bit for bit/).waitFor();
    await other.page.locator("#pwm").getByText("20 kHz").waitFor();
    assert.equal(await time(other.page), await time(page));
    await inState(other.page, "Closed-loop Hall Effect Sensors");

    const without = ({ setup: { motor, options: { pwmRate, ...options } }, ...packed }) => {
        assert.equal(pwmRate, 20_000);
        return { ...packed, setup: { motor, options } };
    };
    const old = await browser.open({}, `#/operate/virtual?run=${edited(link, without)}`);
    await old.page.locator("#reproduced").getByText(/^Not reproduced/).waitFor();
    await old.page.locator("#pwm").getByText("PWM frequency 10 kHz: a control tick every 100 µs").waitFor();
    assert.deepEqual([...complaints, ...other.complaints, ...old.complaints], []);
});

/** The run of a link, changed. */
function edited(link, change) {
    const packed = JSON.parse(inflateRawSync(Buffer.from(link.split("run=")[1], "base64url")).toString());
    return deflateRawSync(JSON.stringify(change(packed))).toString("base64url");
}

test("a long link is repeated in few pieces, whatever the number of its inputs", async () => {
    const inputs = 6000;
    const run = { format: 1, setup: { motor: "bly172s-24v", options: { supplyVoltage: 24 } }, frames: ["aad5202xd0000000000000000"], after: Array(inputs).fill(500), what: Array(inputs).fill(0), ticks: 500 * inputs, digest: "0" };
    const { page } = await browser.open({}, "#/learn");
    await page.evaluate(() => {
        globalThis.reports = 0;
        const Plain = Worker;
        globalThis.Worker = class extends Plain {
            constructor(...args) {
                super(...args);
                this.addEventListener("message", ({ data }) => (globalThis.reports += Number(["ran", "repeating"].includes(data.kind))));
            }
        };
    });
    await page.evaluate((run) => location.assign(`#/operate/virtual?run=${run}`), deflateRawSync(JSON.stringify(run)).toString("base64url"));
    await page.locator("#reproduced").getByText(/^Not reproduced: digest [0-9a-f]{16}, expected 0/).waitFor({ timeout: 120_000 });
    await page.getByText(/control tick 3000000$/).waitFor();
    const reports = await page.evaluate(() => globalThis.reports);
    assert.ok(reports > 0 && reports < 100, `${reports} reports`);
});

test("a link that is none is told in words", async () => {
    const whole = { format: 1, setup: { motor: "bly172s-24v", options: { supplyVoltage: 24 } }, frames: [], after: [], what: [], ticks: 100, digest: "0" };
    const cases = [
        ["nonsense", /This link is damaged: a part of it is missing or was changed/],
        [edited(`run=${deflateRawSync("{}").toString("base64url")}`, () => ({ ...whole, format: 9 })), /format 9, but this page supports format 1/],
        [edited(`run=${deflateRawSync("{}").toString("base64url")}`, () => ({ ...whole, ticks: -1 })), /-1 control ticks; 0 to 36000000 are allowed/],
        [edited(`run=${deflateRawSync("{}").toString("base64url")}`, () => ({ ...whole, setup: { ...whole.setup, options: { supplyVoltage: 12 } } })), /Supply voltage 12 V is outside 18 to 60 V/],
        [edited(`run=${deflateRawSync("{}").toString("base64url")}`, () => ({ ...whole, frames: ["zz"], after: [5], what: [0] })), /"zz" is not a frame/],
    ];
    for (const [text, message] of cases) {
        const { page } = await browser.open({}, `#/operate/virtual?run=${text}`);
        const problem = page.locator(".bar .problem");
        await problem.waitFor();
        assert.match(await problem.textContent(), message);
        await page.close();
    }
});

test("all vectors replay in the page, and a damaged file is named", async () => {
    const { page, complaints } = await operate(browser, "recordings");
    await page.locator("#recordings").setInputFiles(VECTORS);
    const rows = page.locator("#replays tbody tr");
    await page.waitForFunction((count) => document.querySelectorAll("#replays .result").length === count && [...document.querySelectorAll("#replays .result")].every(({ textContent }) => textContent !== "reading"), VECTORS.length, { timeout: 60_000 });
    const texts = await rows.evaluateAll((rows) => rows.map((row) => [...row.cells].map((cell) => cell.textContent.trim())));
    assert.deepEqual(texts.map(([name]) => name), VECTORS.map((file) => basename(file)));
    for (const [name, ticks, digest, recorded, result] of texts) {
        assert.ok(Number(ticks) > 0, name);
        assert.match(digest, /^[0-9a-f]{16}$/);
        assert.equal(digest, recorded, name);
        assert.equal(result, "identical");
    }
    const damaged = readFileSync(VECTORS[0]);
    damaged[damaged.length >> 1] ^= 1;
    await drop(page, { name: "damaged.narxrec", buffer: damaged });
    await lastFile(page).getByText(/corrupt: the check value at byte \d+/).waitFor();
    await drop(page, { name: "notes.txt", buffer: Buffer.from("hello") });
    await lastFile(page).getByText(/"notes.txt" is not a file that this page can read/).waitFor();
    assert.deepEqual(complaints, []);
});

test("a recording is stepped tick by tick, and a plot shows where", async () => {
    const file = VECTORS.find((name) => name.includes("hall")) ?? VECTORS[0];
    // From anywhere on the page.
    const { page, complaints } = await browser.open({}, "#/learn");
    await page.locator("main h1").waitFor();
    await drop(page, { name: basename(file), buffer: readFileSync(file) });
    await page.getByRole("heading", { name: /^Tick 0 of \d+$/ }).waitFor();
    await page.locator("section[aria-label='Time of the recording'] [data-step='1']").click();
    await page.locator("section[aria-label='Time of the recording'] [data-step='1']").click();
    await page.getByRole("heading", { name: /^Tick 2 of/ }).waitFor();
    await page.getByText("Every output of this tick").click();
    await page.locator("#outputs").getByText(/^tick \d+: duty \d+/).waitFor();
    const canvas = page.locator("[aria-label='Plots'] canvas").first();
    assert.ok(await isDrawn(canvas));
    // Changes of state are marked.
    await page.locator("[aria-label='Plots'] [role=img][aria-label*='marked: Initialization at 0']").first().waitFor();
    // One time: that of the recording, and not that of the virtual drive.
    assert.equal(await page.locator("#instant").count(), 1);
    await page.locator("[aria-label='Plots'] .u-over").first().click({ position: { x: 200, y: 50 } });
    await page.waitForFunction(() => Number(document.querySelector("#instant").value) > 0.01);
    const fault = VECTORS.find((name) => basename(name) === "driver-fault.narxrec");
    await drop(page, { name: basename(fault), buffer: readFileSync(fault) });
    await page.locator("[aria-label='Plots'] [role=img][aria-label*='legs driver at']").first().waitFor();
    assert.deepEqual(complaints, []);
});

test("a bus log opens as columns, and the panels show it without sending", async () => {
    const { page, complaints } = await operate(browser, "main");
    await start(page, 1500);
    await page.waitForTimeout(500);
    await go(page, "trace");
    const { bytes } = await saved(page, () => page.locator("#save-log").click());
    await drop(page, { name: "bus.log", buffer: Buffer.concat([bytes, Buffer.from("no frame\n")]) });
    await lastFile(page).getByText(/^bus log, \d+ frames$/).waitFor();
    const messages = await page.locator("#log-message option").allTextContents();
    assert.ok(messages.some((text) => /^MEASUREMENT_2, \d+$/.test(text)), messages.join());
    await page.getByText("Lines that are not frames: 1").waitFor();
    await page.locator("#play-log").click();
    await page.getByRole("dialog").getByText(/run is lost/).waitFor();
    await page.getByRole("dialog").getByRole("button", { name: "Play on the panels" }).click();
    await page.locator(".bar .link").getByText("Log bus.log").waitFor();
    // It begins where the log begins, and time passes.
    await page.locator("#play").click();
    const instant = page.locator("#instant");
    const [at, end] = await instant.evaluate(({ valueAsNumber, max }) => [valueAsNumber, Number(max)]);
    assert.ok(at < end / 2, `${at} s of ${end} s`);
    const seek = (seconds) =>
        instant.evaluate((input, seconds) => {
            input.value = String(seconds);
            input.dispatchEvent(new Event("input", { bubbles: true }));
        }, seconds);
    await seek(end);
    await inState(page, "Closed-loop Hall Effect Sensors");
    const times = (frames) => bytes.toString().split("\n").filter((line) => frames.test(line)).map((line) => Number(line.slice(1, 18)));
    // Just before the first set-point.
    await seek(times(/0AAD5266#(?!0000)/)[0] - times(/#/)[0] - 0.01);
    await inState(page, "Standby");
    await page.locator("#play").click();
    await inState(page, "Closed-loop Hall Effect Sensors");
    await page.waitForFunction(() => document.querySelector("#instant").valueAsNumber > 1);
    assert.ok(await page.locator("#start").isDisabled());
    assert.deepEqual(complaints, []);
});

test("a table of numbers opens as plots", async () => {
    const { page } = await operate(browser, "recordings");
    await drop(page, { name: "run.csv", buffer: Buffer.from('time [s],speed [rpm],"a, b"\n0,1,2\n1,,4\n') });
    await lastFile(page).getByText("2 rows").waitFor();
    await page.getByLabel("Plots").getByText("speed", { exact: true }).first().waitFor();
    const { name, bytes } = await saved(page, () => page.locator(".save-csv").click());
    assert.equal(name, "run.csv");
    assert.equal(bytes.toString(), 'time [s],speed [rpm],"a, b"\n0,1,2\n1,,4\n');
});
