// The operating panel over a WebSocket bridge and over a gs_usb adapter by WebUSB, with the virtual drive of `cargo xtask drive` on the bus.

import assert from "node:assert/strict";
import { after, afterEach, before, test } from "node:test";
import { serveDrive } from "./adapter.mjs";
import { plugInUsb, serveBridge } from "./bridge.mjs";
import { start as launch } from "./browser.mjs";
import { go, inState, standsBy, start } from "./operating.mjs";

let browser;
let drive;
let bridge;
before(async () => {
    [browser, drive] = await Promise.all([launch(), serveDrive("--motor", "bly172s-24v", "--supply", "24", "--mode", "hall")]);
    bridge = await serveBridge(drive.port);
});
after(async () => {
    bridge?.end();
    drive?.end();
    await browser?.close();
});
afterEach(() => browser?.closePages());

async function connection() {
    const { page, complaints } = await browser.open({ viewport: { width: 1280, height: 900 } }, "#/operate/connection");
    await page.locator("#power-up:enabled").waitFor();
    return { page, complaints };
}

async function connect(page, url = bridge.url, token = bridge.token) {
    await page.locator("#bridge").fill(url);
    await page.locator("#token").fill(token);
    await page.locator("#connect-bridge").click();
}

/** REQUEST_WORD with this motor mode as a message: identifier 0AAD5202h, extended; 8 data bytes, the mode in the fourth. */
function request(mode) {
    return Buffer.from(`0252ad8a08000000${mode.toString(16).padStart(2, "0")}00000000`, "hex");
}

test("a drive behind a bridge starts, turns and stops, a frame a message", async () => {
    const { page, complaints } = await connection();
    await connect(page);
    await page.locator(".bar .link").getByText(/^Bridge 127\.0\.0\.1:\d+$/).waitFor();
    await standsBy(page);
    await start(page, 1800, 40);
    await go(page, "connection");
    await page.locator("#disconnect").click();
    await page.locator(".bar").getByText("Not connected").waitFor();
    await page.waitForTimeout(300);
    const requests = bridge.written.filter((bytes) => bytes.subarray(0, 4).equals(request(0).subarray(0, 4)));
    assert.ok(requests.some((bytes) => bytes.equals(request(1))));
    assert.ok(requests.at(-1).equals(request(0)), `Standby is the last request: ${requests.at(-1).toString("hex")}`);
    assert.deepEqual(complaints, []);
});

test("a drive that is lost while its motor turns is stopped, and the page says so once it is back", async () => {
    const { page, complaints } = await connection();
    await connect(page);
    await standsBy(page);
    await go(page, "main");
    await start(page, 1800, 40);
    bridge.mute(true);
    await page.getByRole("status").getByText("No frames from the drive").waitFor();
    bridge.mute(false);
    await page.locator(".bar").getByText("The drive was not received while its motor turned. This page has requested Standby").waitFor();
    await standsBy(page);
    assert.deepEqual(complaints, []);
});

test("plots and measurements of a real drive go back in time, while strip and Stop are live", async () => {
    const { page, complaints } = await connection();
    await connect(page);
    await standsBy(page);
    await go(page, "main");
    await start(page, 1800, 40);
    const speed = async () => Number.parseFloat(await page.locator('[data-measurement="Mechanical estimated speed HES"]').textContent());
    const hold = page.getByRole("button", { name: "Hold view" });
    await hold.click();
    await page.getByRole("heading", { name: /^Measurements, [\d.]+ s ago$/ }).waitFor();
    const then = await speed();
    assert.ok(Math.abs(then - 1800) < 100, `${then} rpm`);
    // Before the start.
    await page.locator("#instant").evaluate((input) => {
        input.value = "0.2";
        input.dispatchEvent(new Event("input", { bubbles: true }));
    });
    await page.waitForFunction(() => Math.abs(Number.parseFloat(document.querySelector('[data-measurement="Mechanical estimated speed HES"]').textContent)) < 20);
    assert.ok(Math.abs(Number(await page.locator(".bar .speed b").textContent()) - 1800) < 100, "the strip is live");
    await page.locator("#stop").click();
    await inState(page, "Standby");
    assert.ok(Math.abs(await speed()) < 20);
    await page.getByRole("button", { name: "Back to live" }).click();
    await page.getByRole("heading", { name: "Measurements", exact: true }).waitFor();
    await hold.waitFor();
    assert.deepEqual(complaints, []);
});

test("a bad address, a wrong token, a refusal, a message that is no frame and a lost bridge are told in words", async () => {
    const { page } = await connection();
    const alert = page.getByRole("alert");
    await connect(page, "http://127.0.0.1:8765/");
    await alert.getByText('"http://127.0.0.1:8765/" is not the address of a bridge: it must begin with ws:// or wss://').waitFor();
    await connect(page, bridge.url, "wrong");
    await alert.getByText(/The bridge at ws:\/\/127\.0\.0\.1:\d+\/ does not answer, or refuses the token/).waitFor();
    await connect(page);
    await standsBy(page);
    bridge.refuse("the adapter is in use by another client");
    await alert.getByText(/The bridge: the adapter is in use by another client\./).waitFor();
    await connect(page);
    await standsBy(page);
    // A set-point of this page's address, which this page has not sent.
    bridge.send(Buffer.from("6652ad8a080000000000000000", "hex"));
    await alert.getByText("Another master commands this drive").waitFor();
    bridge.send(Buffer.from("010203", "hex"));
    await alert.getByText(/a message of 3 bytes is no frame/).waitFor();
    await page.locator(".bar").getByText("Not connected").waitFor();
});

test("a drive behind a gs_usb adapter turns, at 500 kbit/s, and an unplugged one is told", async () => {
    const { page, complaints } = await connection();
    const usb = await plugInUsb(page, bridge);
    await page.locator("#gs-usb").click();
    await page.locator(".bar .link").getByText("CAN adapter (gs_usb)").waitFor();
    await standsBy(page);
    const told = await usb.told();
    assert.deepEqual(told[0], [0, 1, 0xbeef]);
    const [, , propagation, segment1, segment2, , prescaler] = told.find(([request]) => request === 1);
    assert.equal(48_000_000 / prescaler / (1 + propagation + segment1 + segment2), 500_000);
    assert.deepEqual(told.at(-1), [2, 0, 1, 0]);
    await start(page, 1500, 40);
    await page.locator("#stop").click();
    await inState(page, "Standby");
    await page.evaluate(() => globalThis.unplugUsb());
    await page.getByRole("alert").getByText(/The connection to the adapter was lost: was it unplugged\?/).waitFor();
    assert.deepEqual(complaints, []);
});

test("addresses take effect without a new connection", async () => {
    const { page } = await connection();
    await connect(page);
    await standsBy(page);
    await page.locator("#slave").fill("99");
    await page.locator("#slave").press("Enter");
    await page.getByText(/No frames were received from a drive with address 99/).waitFor();
    await page.locator("#slave").fill("170");
    await page.locator("#slave").press("Enter");
    await standsBy(page);
    await page.locator(".bar .link").getByText(/^Bridge/).waitFor();
});
