// The instruments of the operating panel in Chromium: virtual scope, log, services, update.

import assert from "node:assert/strict";
import { after, afterEach, before, test } from "node:test";
import { start as launch } from "./browser.mjs";
import { drop, go, inState, isDrawn, logged, operate, saved, start } from "./operating.mjs";
import { image } from "./signing.mjs";

const IMAGE = image();
const OLD = image({ version: "0.2.0" });
const FOREIGN = image({ version: "0.4.0", secret: "0".repeat(64) });

let browser;
before(async () => {
    browser = await launch();
});
after(() => browser?.close());
afterEach(() => browser?.closePages());

/** The scope's lamp that is on. */
function lamp(page, name) {
    return page.locator(`.lamps .on[data-lamp="${name}"]`).waitFor();
}

test("the scope records what it is forced to, and its columns go into files", async () => {
    const { page, complaints } = await operate(browser, "main");
    await start(page, 1500);
    await go(page, "scope");
    await lamp(page, "idle");
    for (const name of ["Speed set-point", "Mechanical estimated speed SL"]) {
        await page.locator(`[data-signal="${name}"]`).uncheck();
    }
    await page.locator('[data-signal="HV Voltage"]').check();
    await page.locator("#samples").fill("100");
    await page.locator("#scope-run").click();
    await lamp(page, "armed");
    await page.locator("#scope-force").click();
    await lamp(page, "done");
    await page.locator("#scope-download").click();
    await page.locator("#scope-told").getByText("100 samples, 0 of them before the trigger.").waitFor();
    assert.ok(await isDrawn(page.locator("[aria-label='Plots'] canvas").first()));

    const csv = await saved(page, () => page.locator(".save-csv").click());
    assert.equal(csv.name, "scope.csv");
    const [header, ...rows] = csv.bytes.toString().trim().split("\n").map((line) => line.split(","));
    assert.deepEqual(header, ["time [s]", "Mechanical estimated speed HES [rpm]", "HV Voltage [V]"]);
    assert.equal(rows.length, 100);
    // A sample has 12 bits and a sign.
    for (const [, ...cells] of rows) {
        assert.match(cells.join(), /^-?\d+,\d+(\.\d{1,3})?$/);
    }
    for (const [, speed, voltage] of rows) {
        assert.ok(Math.abs(speed - 1500) < 50 && Math.abs(voltage - 24) < 1, `${speed} rpm, ${voltage} V`);
    }
    const xlsx = await saved(page, () => page.locator(".save-xlsx").click());
    assert.equal(xlsx.name, "scope.xlsx");
    // A workbook is a ZIP archive.
    assert.equal(xlsx.bytes.subarray(0, 2).toString(), "PK");
    assert.ok(xlsx.bytes.includes("xl/worksheets/sheet1.xml"));

    await drop(page, { name: "scope.csv", buffer: csv.bytes });
    await page.locator("#replays .result").getByText("100 rows").waitFor();
    assert.deepEqual(complaints, []);
});

test("the scope says what fits and what is recorded, draws the trigger, measures between cursors, and keeps all of it", async () => {
    const { page, complaints } = await operate(browser, "scope");
    await lamp(page, "idle");
    const type = async (field, text) => {
        await page.locator(field).fill(text);
        await page.locator(field).press("Enter");
    };
    const boxes = page.locator("[data-signal]");
    for (let index = 0; index < 9; index += 1) {
        await boxes.nth(index).check();
    }
    await type("#samples", "2000");
    await type("#before", "500");
    await page.locator("#unkept").getByText("The scope memory cannot hold 2000 samples of 9 signals: at most 455 samples per signal.").waitFor();
    assert.ok(await page.locator("#scope-run").isDisabled());
    await type("#samples", "455");
    await page.locator("#unkept").getByText("The drive cannot record 9 signals every tick: the prescaler must be at least 3.").waitFor();
    await type("#prescaler", "3");
    await page.locator("#unkept").getByText("The samples before the trigger, 500, must be fewer than the 455 samples of the record.").waitFor();
    await type("#before", "100");
    await page.locator("#kept").getByText(/^4095 of the 4096 samples .* at most 455 per signal. One every 300 µs: 30.0 ms before the trigger, 106.5 ms after it.$/).waitFor();
    for (let index = 2; index < 9; index += 1) {
        await boxes.nth(index).uncheck();
    }
    await type("#prescaler", "1");
    await page.locator("#trigger").selectOption("above");
    await type("#level", "-100");
    await page.locator("#scope-run").click();
    await lamp(page, "done");
    await page.locator("#scope-download").click();
    await page.locator("#scope-told").getByText("455 samples, 100 of them before the trigger.").waitFor();
    const red = () =>
        page.locator("[aria-label='Plots'] canvas").first().evaluate((canvas) => {
            const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
            const found = new Set();
            for (let at = 0; at < data.length; at += 4) {
                if (data[at] === 0xb3 && data[at + 1] === 0x26 && data[at + 2] === 0x1e) {
                    found.add((at / 4) % canvas.width);
                }
            }
            return found.size;
        });
    assert.ok((await red()) > 0);
    await page.locator("[data-cursor=A]").fill("0");
    await page.locator("[data-cursor=B]").fill("0.01");
    assert.match(await page.locator(".apart").textContent(), /^B is 0.01 s from A: 100 Hz\./);
    const [, , b] = (await page.locator(".at-cursors tbody tr").first().locator("th, td").allTextContents()).map(Number);
    assert.ok(Math.abs(b) < 5);

    await go(page, "main");
    await go(page, "scope");
    // The area before it has cursors, too, for as long as it is shown.
    await page.locator(".apart", { hasText: /^B is 0.01 s from A/ }).waitFor();
    await page.locator("#scope-told").getByText("455 samples, 100 of them before the trigger.").waitFor();
    assert.ok((await red()) > 0);
    assert.deepEqual(await Promise.all(["#samples", "#before", "#level"].map((field) => page.locator(field).inputValue())), ["455", "100", "-100"]);
    assert.equal(await boxes.evaluateAll((boxes) => boxes.filter(({ checked }) => checked).length), 2);
    assert.deepEqual(complaints, []);
});

test("the scope waits for its trigger", async () => {
    const { page } = await operate(browser, "scope");
    await lamp(page, "idle");
    await page.locator("#trigger").selectOption("state change");
    await page.locator("#scope-run").click();
    await lamp(page, "armed");
    await go(page, "main");
    await start(page, 1500);
    await go(page, "scope");
    await lamp(page, "done");
});

test("the scope's record of inputs is a recording that replays", async () => {
    const { page } = await operate(browser, "main");
    await start(page, 1500);
    await go(page, "scope");
    await lamp(page, "idle");
    await page.locator("#scope-inputs").check();
    await page.locator("#samples").fill("200");
    await page.locator("#scope-run").click();
    await lamp(page, "armed");
    await page.locator("#scope-force").click();
    await lamp(page, "done");
    const { name, bytes } = await saved(page, () => page.locator("#scope-download").click());
    assert.equal(name, "scope.narxrec");
    await drop(page, { name, buffer: bytes });
    await page.locator("#replays .result").getByText("identical").waitFor();
});

test("a virtual drive without a log memory says so, and one with everything is a click away", async () => {
    const { page, complaints } = await operate(browser, "logging");
    await page.getByText("This drive has no log memory.").waitFor();
    assert.equal(await page.locator("#log-length").textContent(), "0");
    await page.locator(".full-drive").click();
    await page.waitForFunction(() => Number(document.querySelector("#log-capacity").textContent) > 100_000);
    assert.equal(await page.locator(".full-drive").count(), 0);
    await page.locator("#add-slot").click();
    await page.getByLabel("Value of slot 1").fill("HV Voltage");
    await page.locator("#log-period").fill("0.02");
    await page.locator("#configure-log").click();
    await page.locator("#log-told").getByText("The drive now logs these values").waitFor();
    await logged(page, 5);
    await page.getByLabel("Number of records").fill("3");
    await page.locator("#download-log:enabled").click();
    await page.locator("#log-told").getByText("3 records.").waitFor();
    await page.locator("#log-period").fill("3600");
    await page.locator("#configure-log:enabled").click();
    await page.locator("#log-told").getByText("The drive now logs these values").waitFor();
    await page.locator("#erase-log").click();
    await page.getByRole("dialog").getByRole("button", { name: "Erase log" }).click();
    await page.locator("#log-told").getByText("The log is empty.").waitFor();

    await go(page, "parameters");
    const { name, bytes } = await saved(page, () => page.locator("#xml").click());
    assert.equal(name, "narx.xml");
    assert.match(bytes.toString(), /^<\?xml[\s\S]*Over-voltage HV threshold/);
    assert.deepEqual(complaints, []);
});

test("services ask before what cannot be undone", async () => {
    const { page } = await operate(browser, "parameters");
    await page.locator("#reboot").click();
    await page.getByRole("dialog").getByRole("button", { name: "Cancel" }).click();
    await page.waitForTimeout(300);
    await inState(page, "Standby");
    await page.locator("#reboot").click();
    await page.getByRole("dialog").getByRole("button", { name: "Reboot" }).click();
    await page.locator("#service").getByText("The drive has restarted.").waitFor();
    await inState(page, "Standby");
});

test("calibration finds misplaced zeros and the hall sensors", async () => {
    const { page } = await operate(browser, "main");
    await page.locator("#meter").fill("24");
    await page.locator("#auto-calibrate").click();
    await page.getByLabel("Calibration").getByText("The bus current now reads 0 A and the bus voltage 24 V.").waitFor();
    await page.locator("#calibrate-hall").click();
    await page.getByLabel("Calibration").getByText(/Found: offset -?[\d.]+ degrees, order \d, polarity \d\./).waitFor({ timeout: 60_000 });
    await inState(page, "Standby");
});

/** Chooses a file as an image. */
function choose(page, name, buffer) {
    return page.locator("#image").setInputFiles({ name, mimeType: "application/octet-stream", buffer });
}

/** Programs the drive with what was chosen: what was told at the end. */
async function program(page) {
    await page.locator("#program:enabled").click();
    await page.getByRole("dialog").getByRole("button", { name: "Program" }).click();
    await page.locator("#update-told").waitFor({ timeout: 60_000 });
    return page.locator("#update-told").textContent();
}

test("a virtual drive with a bootloader is programmed, and what goes wrong is told in words", async () => {
    const { page, complaints } = await operate(browser, "update");
    await choose(page, "notes.narximg", Buffer.from("hello"));
    await page.getByRole("alert").getByText('"notes.narximg": The file has 5 bytes; the image needs 512.').waitFor();
    assert.equal(await page.locator("#program").count(), 0);

    await choose(page, "drive.narximg", IMAGE);
    assert.match(await page.locator("#image-info").textContent(), /drive\.narximg.*0\.3\.1\+99.*bench, 4E580000h.*1536 bytes/);
    assert.match(await program(page), /^The drive does not answer; it may have no bootloader\. /);

    await page.locator(".full-drive").click();
    await inState(page, "Standby");
    assert.equal(await program(page), "The drive now runs version 0.3.1+99, and the update is confirmed.");

    // Dropped anywhere on the page; the result of before is gone with the next try.
    await go(page, "main");
    await drop(page, { name: "old.narximg", buffer: OLD });
    await page.locator("#image-info").getByText("0.2.0+0").waitFor();
    assert.equal(await program(page), "The image is version 0.2.0+0, older than the running version 0.3.1+99. The drive was not changed.");

    await choose(page, "foreign.narximg", FOREIGN);
    assert.equal(await program(page), "The board's bootloader does not accept the signature. The drive runs its previous firmware.");

    await go(page, "main");
    // It has restarted: a start that it receives while it boots is spent.
    await inState(page, "Standby");
    await start(page, 1500);
    await go(page, "update");
    await page.locator("#update-why").getByText("A drive can be programmed only in Standby, or in Fault at standstill.").waitFor();
    assert.ok(await page.locator("#program").isDisabled());
    assert.deepEqual(complaints, []);
});
