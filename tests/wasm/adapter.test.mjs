// The operating panel on an slcan adapter by Web Serial, with the virtual drive of `cargo xtask drive` on its bus.

import assert from "node:assert/strict";
import { after, afterEach, before, test } from "node:test";
import { plugIn, serveDrive } from "./adapter.mjs";
import { start as launch } from "./browser.mjs";
import { go, inState, logged, reaches, saved, standsBy, start } from "./operating.mjs";
import { image } from "./signing.mjs";

// Made here: whoever signs stops this process, and with it the adapter. The long one is long enough to be in time with its abort.
const [IMAGE, LONG] = [image(), image({ length: 20 << 10 })];

let browser;
let drive;
/** Of the test that runs. A test that fails must not leave its own behind: it would speak to the drive of the next, and keep this process alive. */
let adapters = [];
before(async () => {
    [browser, drive] = await Promise.all([launch(), serveDrive("--motor", "bly172s-24v", "--supply", "24", "--mode", "hall", "--tx-drivers", "2,5:dual")]);
});
after(async () => {
    drive?.end();
    await browser?.close();
});

afterEach(async () => {
    adapters.forEach((adapter) => adapter.end());
    adapters = [];
    await browser?.closePages();
});

/** A port with the drive behind it. */
async function plug(page) {
    const adapter = await plugIn(page, drive.port);
    adapters.push(adapter);
    return adapter;
}

/** A page that commands the drive over an adapter. */
async function connected() {
    const { page, complaints } = await browser.open({ viewport: { width: 1280, height: 900 } }, "#/operate/connection");
    await page.locator("#power-up:enabled").waitFor();
    const adapter = await plug(page);
    await page.locator("#adapter").click();
    await page.locator(".bar .link").getByText("CAN adapter").waitFor();
    await standsBy(page);
    // A serial port would not be told of by the browser.
    const own = () => complaints.filter((text) => !text.includes(adapter.url));
    return { page, own, adapter };
}

/** REQUEST_WORD with this motor mode, as the adapter is told it. */
function request(mode) {
    return `T0AAD520280000000${mode}00000000`;
}

test("a drive behind an adapter starts, turns and stops, and the adapter is opened and closed", async () => {
    const { page, own, adapter } = await connected();
    assert.match(adapter.written, /C\r.*S6\r.*O\r/s);
    await go(page, "main");
    await start(page, 1800, 40);
    await go(page, "connection");
    await page.locator("#disconnect").click();
    await page.locator(".bar").getByText("Not connected").waitFor();
    // The page's last bytes are still on their way to the adapter.
    for (const deadline = Date.now() + 5000; !adapter.written.endsWith("C\r") && Date.now() < deadline; ) {
        await page.waitForTimeout(20);
    }
    const [beforeStop, last] = [adapter.written.lastIndexOf(request(1)), adapter.written.lastIndexOf(request(0))];
    assert.ok(beforeStop > 0 && last > beforeStop, "Standby is the last request");
    assert.ok(adapter.written.endsWith("C\r"));
    assert.deepEqual(own(), []);
});

test("a drive behind an adapter measures its motor", async () => {
    const { page, own } = await connected();
    await go(page, "identify");
    const polePairs = page.locator("#pole-pairs");
    await polePairs.fill("4");
    await polePairs.press("Tab");
    await page.locator("#identify-ready").check();
    await page.locator("#identify:enabled").click();
    const resistance = page.locator("#identified tbody tr", { hasText: "Resistance" }).locator("b");
    await resistance.waitFor({ timeout: 90_000 });
    // On a busy machine the simulated drive falls behind the clock of the page, which costs accuracy.
    const ohm = Number.parseFloat(await resistance.textContent());
    assert.ok(Math.abs(ohm - 0.768) < 0.15 * 0.768, `${ohm} ohm`);
    await inState(page, "Standby");
    assert.deepEqual(own(), []);
});

test("an adapter that is unplugged while the motor turns is told, and connects again", async () => {
    const { page, adapter } = await connected();
    await go(page, "main");
    await start(page, 1500);
    await adapter.unplug();
    await page.getByRole("alert").getByText(/The connection to the adapter was lost: was it unplugged\?/).waitFor();
    await page.locator(".bar").getByText("Not connected").waitFor();
    adapter.end();
    // Nobody commands it any more: it has stopped by itself, and does not turn again before it is asked to.
    const again = await connected();
    await reaches(again.page, 0, 0);
    assert.equal(again.adapter.written.includes(request(1)), false);
});

test("a page that is closed asks for Standby", async () => {
    const { page, adapter } = await connected();
    await go(page, "main");
    await start(page, 1500);
    await page.evaluate(() => dispatchEvent(new PageTransitionEvent("pagehide")));
    await inState(page, "Standby");
    assert.ok(adapter.written.lastIndexOf(request(0)) > adapter.written.lastIndexOf(request(1)));
});

test("nobody is commanded by a silent master", async () => {
    const { page } = await browser.open({}, "#/operate/connection");
    await page.locator("#power-up:enabled").waitFor();
    await page.locator("#silent").check();
    const adapter = await plug(page);
    await page.locator("#adapter").click();
    await page.locator(".bar .link").getByText("CAN adapter").waitFor();
    await page.waitForTimeout(500);
    assert.doesNotMatch(adapter.written, /[Tt][0-9A-F]/);
    assert.ok(await page.locator("#stop").isDisabled());
});

test("no adapter, and a bus on which nobody answers, are told in words", async () => {
    const { page } = await browser.open({}, "#/operate/connection");
    await page.locator("#power-up:enabled").waitFor();
    await page.evaluate(() => Object.defineProperty(navigator, "serial", { configurable: true, value: { requestPort: () => Promise.reject(new DOMException("", "NotFoundError")) } }));
    await page.locator("#adapter").click();
    await page.getByRole("alert").getByText("No adapter was chosen.").waitFor();
    await page.locator("#slave").fill("99");
    const adapter = await plug(page);
    await page.locator("#adapter").click();
    await page.locator(".bar").getByText("No frames from the drive").waitFor();
    await page.getByText(/No frames were received from a drive with address 99/).waitFor();
});

test("the log is set up, filled, downloaded in part and erased", async () => {
    const { page, own } = await connected();
    await go(page, "logging");
    await page.locator("#add-slot").click();
    await page.getByLabel("Value of slot 1").fill("HV Voltage");
    await page.getByLabel("Statistic of slot 1").selectOption("mean");
    await page.locator("#log-period").fill("0.05");
    await page.locator("#configure-log").click();
    await page.locator("#log-told").getByText("The drive now logs these values").waitFor();
    await logged(page, 5);
    assert.equal(await page.getByLabel("Value of slot 1").inputValue(), "HV Voltage");
    await page.getByLabel("First record").fill("2");
    await page.getByLabel("Number of records").fill("4");
    await page.locator("#download-log").click();
    await page.locator("#log-told").getByText("4 records.").waitFor();
    const { bytes } = await saved(page, () => page.locator(".save-csv").click());
    const [header, ...rows] = bytes.toString().trim().split("\n").map((line) => line.split(","));
    assert.equal(header.at(-1), "HV Voltage mean [V]");
    assert.equal(rows.length, 4);
    assert.ok(rows.every((row) => Math.abs(row.at(-1) - 24) < 0.5));

    await page.getByLabel("Number of records").fill("100000");
    await page.locator("#download-log").click();
    await page.locator("#log-told").getByText(/Records 2 to 100002: the log has \d+ records\./).waitFor();

    await page.locator("#log-period").fill("3600");
    await page.locator("#configure-log").click();
    await page.locator("#log-told").getByText("The drive now logs these values").waitFor();
    await page.locator("#erase-log").click();
    await page.getByRole("dialog").getByRole("button", { name: "Erase log" }).click();
    await page.locator("#log-told").getByText("The log is empty.").waitFor();
    assert.deepEqual(own(), []);
});

test("the drive's description of itself is downloaded", async () => {
    const { page } = await connected();
    await go(page, "parameters");
    const { name, bytes } = await saved(page, () => page.locator("#xml").click());
    assert.equal(name, "narx.xml");
    assert.match(bytes.toString(), /^<\?xml[\s\S]*Over-voltage HV threshold[\s\S]*>\s*$/);
});

test("a drive behind the adapter is programmed: progress, abort, the whole of it", async () => {
    const { page, own } = await connected();
    await go(page, "update");
    const choose = (buffer) => page.locator("#image").setInputFiles({ name: "drive.narximg", mimeType: "application/octet-stream", buffer });
    await choose(LONG);
    const program = async () => {
        await page.locator("#program:enabled").click();
        await page.getByRole("dialog").getByRole("button", { name: "Program" }).click();
    };
    await program();
    await page.locator("#update-stage").getByText("Sending the image.").waitFor();
    // It goes on whichever panel is looked at.
    await go(page, "main");
    await go(page, "update");
    const bar = page.getByLabel("Progress of the update");
    await page.waitForFunction(() => document.querySelector("progress")?.value > 1000);
    assert.equal(await bar.getAttribute("max"), String(LONG.length));
    await page.locator("#abort-update").click();
    await page.locator("#update-told").getByText("The update was aborted. The drive runs its previous firmware.").waitFor();

    await choose(IMAGE);
    await page.locator("#image-info").getByText("1536 bytes").waitFor();
    await program();
    await page.locator("#update-told").getByText("The drive now runs version 0.3.1+99, and the update is confirmed.").waitFor({ timeout: 60_000 });
    await go(page, "main");
    await start(page, 1500);
    await page.locator("#stop").click();
    await inState(page, "Standby");
    assert.deepEqual(own(), []);
});

test("TX-Drivers on the bus are found, started and written to", async () => {
    const { page, own } = await connected();
    await go(page, "nodes");
    await page.locator("#scan").click();
    await page.locator("#scan-told").getByText("2 of 127 node-ids have answered.").waitFor({ timeout: 60_000 });
    const node = page.locator('[data-node="2"]');
    await page.locator('[data-node="5"]').waitFor();
    await node.getByText("Object dictionary").click();
    await node.locator(".read-objects").click();
    const update = node.getByLabel("Update Time");
    await page.waitForFunction((input) => input.value !== "", await update.elementHandle());
    await update.fill("20");
    await update.press("Enter");
    await node.locator(".told").getByText(/^Written/).waitFor();
    await update.fill("-1");
    await update.press("Enter");
    await node.getByRole("alert").getByText(/: -1.*: must be a number from 0 to \d+.*\.$/).waitFor();
    await update.press("Escape");
    assert.equal(await update.inputValue(), "20");
    await node.getByRole("button", { name: "Start" }).click();
    await node.getByText(/Channel 1: -?\d+\.\d{5} mm/).waitFor();
    await node.locator(".read-objects").click();
    await node.locator(".told").getByText(/abort|refuse|state/i).waitFor();
    // Its position is plotted beside the drive's signals.
    await go(page, "main");
    await page.locator("#plot .plot-signals summary").click();
    await page.locator('#plot [data-plot="TX-Driver 2, channel 1"]').check();
    await page.locator("#plot .lane > summary").getByText("TX-Driver 2, channel 1, mm").waitFor();
    assert.deepEqual(own(), []);
});
