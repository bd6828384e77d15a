// The instruments of the operating panel in Chromium: virtual scope, log, services, update.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { start as launch } from "./browser.mjs";
import { drop, go, inState, isDrawn, operate, saved, start } from "./operating.mjs";

let browser;
before(async () => {
    browser = await launch();
});
after(() => browser?.close());

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
    await page.locator("#scope-told").getByText("100 samples.").waitFor();
    assert.ok(await isDrawn(page.locator("[aria-label='Plots'] canvas").first()));

    const csv = await saved(page, () => page.locator(".save-csv").click());
    assert.equal(csv.name, "scope.csv");
    const [header, ...rows] = csv.bytes.toString().trim().split("\n").map((line) => line.split(","));
    assert.deepEqual(header, ["time [s]", "Mechanical estimated speed HES [rpm]", "HV Voltage [V]"]);
    assert.equal(rows.length, 100);
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

test("a drive without a log memory says so", async () => {
    const { page } = await operate(browser, "logging");
    await page.getByText("This drive has no log memory.").waitFor();
    assert.equal(await page.locator("#log-length").textContent(), "0");
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
    await page.getByLabel("Calibration").getByText("The bus current reads 0 A now, and the bus voltage 24 V.").waitFor();
    await page.locator("#calibrate-hall").click();
    await page.getByLabel("Calibration").getByText(/Found: offset -?[\d.]+ degrees, order \d, polarity \d\./).waitFor({ timeout: 60_000 });
    await inState(page, "Standby");
});

test("programming says why it cannot be", async () => {
    const { page } = await operate(browser, "update");
    assert.match(await page.locator("#update-why").textContent(), /cannot be programmed/);
    assert.ok(await page.getByRole("button", { name: "Program" }).isDisabled());
});
