// The operating panel in Chromium, on the virtual drive: command, parameters, faults, trace.

import assert from "node:assert/strict";
import { after, afterEach, before, test } from "node:test";
import { start as launch } from "./browser.mjs";
import { go, inState, isDrawn, operate, pause, reaches, saved, start } from "./operating.mjs";

let browser;
before(async () => {
    browser = await launch();
});
after(() => browser?.close());
afterEach(() => browser?.closePages());

test("motors spin up to their set-point and stop", async () => {
    const { page, complaints } = await operate(browser, "connection");
    const names = await page.locator("#motor option").evaluateAll((options) => options.map((option) => option.value));
    assert.ok(names.length >= 4);
    // In real time: some of them. bench.test.mjs turns them all.
    for (const name of [names[0], names.at(-1)]) {
        await go(page, "connection");
        await page.locator("#motor").selectOption(name);
        await page.locator("#power-up").click();
        await page.locator(".bar .link").getByText(`Virtual drive, ${name}`).waitFor();
        await go(page, "main");
        await inState(page, "Standby");
        await page.locator("#control-mode").and(page.locator(":enabled")).waitFor();
        const rpm = Number(await page.locator("#setpoint").inputValue());
        await start(page, rpm, rpm * 0.02);
        assert.equal(await page.locator("li.on").first().textContent().then((text) => text.trim()), "5 Closed-loop Hall Effect Sensors");
        await page.locator("#stop").click();
        await inState(page, "Standby");
    }
    assert.ok(await isDrawn(page.locator("#plot canvas")));
    assert.deepEqual(complaints, []);
});

test("the set-point changes while the motor turns, by keyboard, and the direction is the operator's", async () => {
    const { page, complaints } = await operate(browser, "main");
    await page.locator("#control-mode:enabled").waitFor();
    await page.locator("#direction").selectOption("reverse");
    await page.locator("#setpoint").fill("2000");
    await page.locator("#setpoint").press("Enter");
    // Enter is no Start.
    await page.waitForTimeout(500);
    await inState(page, "Standby");
    await page.locator("#start").focus();
    await page.keyboard.press("Enter");
    await reaches(page, -2000, 40);
    await page.locator("#slider").focus();
    await page.keyboard.press("ArrowRight");
    await page.waitForFunction(() => document.querySelector("#setpoint").value === "2010");
    await page.locator("#setpoint").fill("1500");
    await page.locator("#setpoint").press("Enter");
    await reaches(page, -1500, 30);
    assert.ok(Math.abs(Number((await page.locator('[data-measurement="Mechanical estimated speed HES"]').textContent()).replace("rpm", "")) + 1500) < 40);
    assert.deepEqual(complaints, []);
});

test("a set-point is commanded by Enter, by leaving the field and by the slider's release, not by a keystroke, and Escape restores it", async () => {
    const { page, complaints } = await operate(browser, "main");
    await start(page, 2000);
    const [setpoint, slider] = [page.locator("#setpoint"), page.locator("#slider")];
    const type = async (text) => {
        await setpoint.press("ControlOrMeta+a");
        await setpoint.pressSequentially(text, { delay: 60 });
    };
    await type("3500");
    await setpoint.press("Escape");
    assert.equal(await setpoint.inputValue(), "2000");
    await type("2500");
    await setpoint.press("Enter");
    await reaches(page, 2500, 50);
    await type("2200");
    await setpoint.blur();
    await reaches(page, 2200, 44);
    const slid = await slider.evaluate((slider) => {
        slider.value = "3000";
        slider.dispatchEvent(new Event("input", { bubbles: true }));
        return Number(slider.value);
    });
    assert.equal(await setpoint.inputValue(), String(slid));
    await page.waitForTimeout(200);
    await slider.evaluate((slider) => {
        slider.value = "2800";
        for (const name of ["input", "change"]) {
            slider.dispatchEvent(new Event(name, { bubbles: true }));
        }
    });
    const released = Number(await setpoint.inputValue());
    await reaches(page, released, 56);
    // Nor does the click of Stop, which takes the field's focus, command what was typed.
    await type("1200");
    await page.locator("#stop").click();
    await inState(page, "Standby");
    await go(page, "trace");
    const { bytes } = await saved(page, () => page.locator("#save-log").click());
    const commands = [...bytes.toString().matchAll(/ 0AAD5266#([0-9A-F]{4})/g)].map(([, speed]) => parseInt(speed, 16));
    const changes = commands.filter((speed, at) => speed !== commands[at - 1] && speed !== 0);
    assert.deepEqual(changes, [2000, 2500, 2200, released]);
    assert.notEqual(released, slid);
    assert.deepEqual(complaints, []);
});

test("the control mode is the operator's, and a start without one is refused in words", async () => {
    const { page } = await operate(browser, "main");
    await page.locator("#control-mode").selectOption("none");
    await page.waitForFunction(() => document.querySelector("#control-mode").value === "none");
    await page.locator("#start").click();
    await page.getByRole("alert").getByText("The drive refused the start: no mode is enabled.").waitFor();
    await page.locator("#control-mode").selectOption("sensorless");
    await page.locator("#start").click();
    await inState(page, "Sensorless Closed-loop");
});

test("a set-point is the mode's, until the operator has the field in hand", async () => {
    const { page } = await operate(browser, "main");
    const setpoint = page.locator("#setpoint");
    // No limits are the open loop's, and of whoever has not received of others yet.
    const limited = page.locator('#setpoint:not([data-max="65535"])');
    const unlimited = page.locator('#setpoint[data-max="65535"]');
    await limited.waitFor();
    const hall = await setpoint.inputValue();
    await page.locator("#control-mode").selectOption("none");
    await unlimited.waitFor();
    const none = await setpoint.inputValue();
    assert.notEqual(none, hall);
    await setpoint.focus();
    await page.locator("#control-mode").selectOption("hall");
    await limited.waitFor();
    assert.equal(await setpoint.inputValue(), none);
});

test("a set-point beyond the limits is refused with the limit's parameter and range, and the motor turns on as it did", async () => {
    const { page, complaints } = await operate(browser, "main");
    await start(page, 1500);
    const setpoint = page.locator("#setpoint");
    const misfit = page.getByRole("form", { name: "Command" }).getByRole("alert");
    await setpoint.fill("9000");
    await setpoint.press("Enter");
    assert.match(await misfit.textContent(), /^Speed 9000 rpm is above parameter 10\d "Speed setpoint max saturation HES": must be \d+ to \d+ rpm\.$/);
    await reaches(page, 1500, 40);
    await page.locator("#stop").click();
    await inState(page, "Standby");
    assert.ok(await page.locator("#start").isDisabled());
    assert.equal(await setpoint.inputValue(), "9000");
    await setpoint.press("Escape");
    await misfit.waitFor({ state: "detached" });
    assert.equal(await setpoint.inputValue(), "1500");
    // A decimal comma is no part of a number, and neither is anything else that a field would drop.
    for (const text of ["1,2", "15 00", "1500.5", "99999", "NaN", ""]) {
        await setpoint.fill(text);
        await setpoint.blur();
        assert.match(await misfit.textContent(), /^The set-point must be a whole number from \d+ to \d+ rpm\.$/, text);
    }
    assert.deepEqual(complaints, []);
});

test("open loop shows its speed, in the status bar, too, and turns at that of parameter 88", async () => {
    const { page } = await operate(browser, "main");
    await page.locator("#control-mode:enabled").selectOption("open-loop");
    await page.locator("#setpoint[readonly]").waitFor();
    const rpm = Number(await page.locator("#setpoint").inputValue());
    await page.locator("#start").click();
    await inState(page, "Open-loop");
    await reaches(page, rpm, rpm * 0.1);
});

test("digital lines and the hall supply are commanded, and a refusal is told", async () => {
    const { page, complaints } = await operate(browser, "main");
    const lines = page.getByRole("region", { name: "Digital lines and hall supply" });
    await page.locator("#dsio2:enabled").selectOption("high");
    await page.locator("#set-lines").click();
    await lines.getByText("Set: DSIO1 input; DSIO2 output, high.").waitFor();
    // A visit of another panel does not forget what is driven.
    await go(page, "trace");
    await go(page, "main");
    assert.equal(await page.locator("#dsio2").inputValue(), "high");
    await page.locator("#hall-supply-off:enabled").click();
    await lines.getByText("The hall supply is off.").waitFor();
    await page.locator("#hall-supply-on:enabled").click();
    await lines.getByText("Parameter 97 controls the hall supply.").waitFor();
    await start(page, 1500);
    await page.locator("#hall-supply-off:enabled").click();
    await lines.getByRole("alert").getByText("The drive has refused the request.").waitFor();
    assert.deepEqual(complaints, []);
});

test("factory settings can be restored in every state, and the question says what stays", async () => {
    const { page } = await operate(browser, "main");
    await start(page, 1500);
    await go(page, "parameters");
    await page.locator("#restore:enabled").click();
    await page.getByRole("dialog").getByText(/except the device number and the calibration \(category 02\)/).waitFor();
});

test("what is broken is named, and works again once it is mended and acknowledged", async () => {
    const { page } = await operate(browser, "main");
    await start(page, 1500);
    await go(page, "virtual");
    await page.locator("#fault").selectOption("supply");
    await page.locator("#fault-value").fill("70");
    await page.locator("#inject").click();
    await inState(page, "Fault");
    assert.match(await page.locator(".bar .faults").textContent(), /^Bus voltage above .* Remove the cause, then acknowledge the fault\./s);
    await page.locator("#mend").click();
    await go(page, "main");
    await page.locator("li.alarm.on").getByText(/over voltage/).first().waitFor();
    // The drive takes an acknowledgement half a second after the fault, once the cause is gone.
    await page.waitForTimeout(700);
    await page.locator("#stop").click();
    await inState(page, "Standby");
    await start(page, 1500);
});

test("Stop is at the same place on every panel, scrolled or not, in a fault and beside a question, and F8 is its key", async () => {
    for (const viewport of [{ width: 1280, height: 900 }, { width: 360, height: 740 }]) {
        const { page, complaints } = await operate(browser, "main", { viewport });
        const stop = page.locator("#stop");
        const place = await stop.boundingBox();
        const stays = async (where) => assert.deepEqual(await stop.boundingBox(), place, `${viewport.width} px, ${where}`);
        await start(page, 1500);
        await stays("running");
        for (const panel of await page.locator("main nav a").evaluateAll((links) => links.map(({ hash }) => hash))) {
            await page.evaluate((panel) => location.assign(panel), panel);
            await page.locator("main h1").waitFor();
            await page.evaluate(() => scrollTo(0, document.documentElement.scrollHeight));
            await stays(`${panel}, scrolled`);
            await page.evaluate(() => scrollTo(0, 0));
            await stays(panel);
        }
        await go(page, "parameters");
        await page.locator("#search").fill("speed");
        await page.locator("#restore:enabled").click();
        assert.equal(await page.evaluate(() => document.activeElement.textContent), "Cancel");
        await stays("question");
        // A click reaches what is on top there.
        await stop.click();
        await inState(page, "Standby");
        await page.getByRole("button", { name: "Cancel" }).press("Escape");
        await page.getByRole("dialog").waitFor({ state: "hidden" });
        await go(page, "main");
        await start(page, 1500);
        await page.locator("#setpoint").focus();
        await page.keyboard.press(await stop.getAttribute("aria-keyshortcuts"));
        await inState(page, "Standby");
        await page.locator("#shut-down").click();
        await inState(page, "Fault");
        await page.locator(".bar .faults").waitFor();
        await stays("fault");
        assert.deepEqual(complaints, []);
        await page.close();
    }
});

test("a motor that turns is stopped from every area", async () => {
    const { page, complaints } = await operate(browser, "main");
    for (const stop of [() => page.locator("#stop").click(), () => page.keyboard.press("F8")]) {
        await start(page, 1500);
        await page.evaluate(() => location.assign("#/learn/six-steps"));
        const drive = page.locator("main > section[aria-label='Drive']");
        await drive.getByText(/^The motor of the drive turns: Closed-loop Hall Effect Sensors, \d+ rpm/).waitFor();
        await stop();
        await drive.waitFor({ state: "detached" });
        await page.evaluate(() => location.assign("#/operate/main"));
        await inState(page, "Standby");
    }
    assert.deepEqual(complaints, []);
});

test("a parameter is found, written, marked, refused with its range, saved, compared and loaded", async () => {
    const { page, complaints } = await operate(browser, "parameters");
    await page.locator("#search").fill("over-voltage");
    const row = page.locator('[data-parameter="119"]');
    const input = row.locator("input");
    await input.and(page.locator(":enabled")).waitFor();
    await page.waitForFunction(() => document.querySelector('[data-parameter="119"] input').value !== "");
    assert.match(await row.textContent(), /Over-voltage HV threshold/);
    const factory = await input.inputValue();
    await input.fill("55.5");
    await input.press("Enter");
    // A drive that keeps writes by itself has nothing to mark.
    if (!/automatically/.test(await page.locator("#keeping").textContent())) {
        await row.getByText("not stored").waitFor();
    }
    await row.getByText("changed", { exact: true }).waitFor();
    assert.equal(Number(await input.inputValue()), 55.5);

    await input.fill("1000");
    await input.press("Enter");
    assert.match(await row.getByRole("alert").textContent(), /Parameter 119 "Over-voltage HV threshold": 1000 V is outside .* to .* V/);
    assert.equal(await input.getAttribute("aria-invalid"), "true");
    await input.press("Escape");
    assert.equal(Number(await input.inputValue()), 55.5);

    await page.locator("#search").fill("pair poles");
    const poles = page.locator('[data-parameter="78"]');
    const before = await poles.locator("input").inputValue();
    for (const leave of [(input) => input.press("Enter"), (input) => input.blur()]) {
        await poles.locator("input").fill("4.5");
        await leave(poles.locator("input"));
        assert.match(await poles.getByRole("alert").textContent(), /Parameter 78 "Motor pair poles": 4.5 is not a whole number from 1 to \d+/);
        assert.equal(await poles.locator("input").inputValue(), "4.5");
        await poles.locator("input").press("Escape");
        assert.equal(await poles.locator("input").inputValue(), before);
    }
    // What was typed is not written when the field is left, and the row says so.
    await poles.locator("input").fill("1");
    await poles.locator("input").blur();
    await poles.getByText("Not written: Enter writes, Esc restores.").waitFor();
    await go(page, "main");
    await go(page, "parameters");
    await page.locator("#search").fill("pair poles");
    assert.equal(await poles.locator("input").inputValue(), before);
    await page.locator("#search").fill("over-voltage");

    await page.locator("#store").click();
    await page.locator("#service").getByText("Stored").waitFor();
    assert.equal(await row.getByText("not stored").count(), 0);

    const { name, bytes } = await saved(page, () => page.locator("#save-file").click());
    assert.equal(name, "parameters.json");
    const values = JSON.parse(bytes.toString());
    assert.equal(values["Over-voltage HV threshold"], 55.5);
    values["Over-voltage HV threshold"] = Number(factory);
    await load(page, "mine.json", JSON.stringify(values));
    await page.getByRole("region", { name: "Differences" }).getByText("119 Over-voltage HV threshold").waitFor();
    await page.locator("#write-file").click();
    await page.locator("#told").getByText("Written: Over-voltage HV threshold.").waitFor();

    await load(page, "notes.json", "speed");
    await page.locator("#told").getByText('"notes.json" is not a parameter file: it is not JSON.').waitFor();
    assert.deepEqual(complaints, []);
});

test("parameters and frames are found by their words in any order", async () => {
    const { page } = await operate(browser, "parameters");
    const numbers = () => page.locator("[data-parameter]").evaluateAll((rows) => rows.map(({ dataset }) => Number(dataset.parameter)));
    for (const [search, found] of [
        ["hall offset", [79, 80]],
        ["offset angle HALL", [80]],
        ["Kp speed", [91, 93]],
        ["overcurrent", [116]],
        ["limitation over-current", [116]],
        ["speed zzz", []],
    ]) {
        await page.locator("#search").fill(search);
        assert.deepEqual(await numbers(), found, search);
    }
    await go(page, "trace");
    await page.locator("#trace-filter").fill("received voltage measurement2");
    const texts = () => page.locator("#frames tbody tr").evaluateAll((rows) => rows.map(({ textContent }) => textContent));
    await page.locator("#frames tbody").getByText("MEASUREMENT_2").first().waitFor();
    assert.ok((await texts()).every((text) => text.includes("MEASUREMENT_2")));
});

/** Loads a text as a file of parameters. */
async function load(page, name, text) {
    const [chooser] = await Promise.all([page.waitForEvent("filechooser"), page.locator("#load-file").click()]);
    await chooser.setFiles({ name, mimeType: "application/json", buffer: Buffer.from(text) });
}

test("what the drive refuses while it turns is told", async () => {
    const { page } = await operate(browser, "main");
    await start(page, 1500);
    await go(page, "parameters");
    await page.locator("#search").fill("pair poles");
    const input = page.locator('[data-parameter="78"] input');
    await input.fill("5");
    await input.press("Enter");
    assert.match(await page.locator('[data-parameter="78"]').getByRole("alert").textContent(), /78 .*state/i);
});

test("frames are decoded, filtered, held and saved as a log", async () => {
    const { page, complaints } = await operate(browser, "trace");
    await page.locator("#trace-filter").fill("measurement_2");
    const row = page.locator("#frames tbody tr").first();
    await row.getByText(/HV Voltage 2[34]/).waitFor();
    assert.match(await row.textContent(), /1552A8CA/);
    await page.locator("#trace-pause").click();
    const held = await page.locator("#trace-count").textContent();
    await page.waitForTimeout(400);
    assert.equal(await page.locator("#trace-count").textContent(), held);
    const { name, bytes } = await saved(page, () => page.locator("#save-log").click());
    assert.equal(name, "bus.log");
    const lines = bytes.toString().trim().split("\n");
    assert.ok(lines.length > 100);
    for (const line of lines) {
        assert.match(line, /^\(\d{10}\.\d{6}\) can0 [0-9A-F]{8}#[0-9A-F]{0,16}$/);
    }
    assert.deepEqual(complaints, []);
});

test("a search of many frames goes on in pieces, and a return to an earlier instant keeps the frames until then", async () => {
    const { page, complaints } = await operate(browser, "trace");
    await start(page, 1500);
    await page.waitForFunction(() => Number.parseInt(document.querySelector("#trace-count").textContent) > 3000);
    // A processor on which every look at the clock takes 5 ms: a search ends with the time that it has, and Stop works meanwhile.
    await page.evaluate(() => {
        const now = performance.now.bind(performance);
        let late = 0;
        globalThis.slow = true;
        performance.now = () => now() + (late += globalThis.slow ? 5 : 0);
    });
    await page.locator("#trace-filter").fill("no message has this");
    await page.getByText(/^Searched back to [\d.]+ s\.$/).waitFor();
    await page.keyboard.press("F8");
    await inState(page, "Standby");
    assert.ok(await page.getByText(/^Searched back to/).isVisible());
    await page.evaluate(() => (globalThis.slow = false));
    await page.getByText("No frame matches the filter.").waitFor({ timeout: 60_000 });
    await page.locator("#trace-filter").fill("");
    await pause(page);
    const count = () => page.locator("#trace-count").textContent().then((text) => Number.parseInt(text));
    // The count follows a few times a second.
    await page.waitForTimeout(1000);
    const all = await count();
    const seek = (part) =>
        page.locator("#instant").evaluate((input, part) => {
            input.value = String(part * Number(input.max));
            input.dispatchEvent(new Event("input", { bubbles: true }));
        }, part);
    await seek(0.5);
    await page.waitForFunction((all) => Number.parseInt(document.querySelector("#trace-count").textContent) < all, all);
    // Everything until then, from the first frames on: more than what is sent again at a return.
    assert.ok((await count()) > 0.3 * all, `${await count()} of ${all}`);
    const [newest, instant] = await page.evaluate(() => [document.querySelector("#frames tbody td").textContent, document.querySelector("#time").textContent].map(Number));
    assert.ok(newest <= instant && newest > instant - 0.1, `frame at ${newest} s, shown ${instant} s`);
    await seek(1);
    await page.waitForFunction((all) => Number.parseInt(document.querySelector("#trace-count").textContent) === all, all);
    assert.deepEqual(complaints, []);
});

test("time goes back to an instant of the run, shows it as it was, and goes on from there", async () => {
    const { page, complaints } = await operate(browser, "main");
    await start(page, 1500, 40);
    const bench = page.locator("#time");
    await go(page, "virtual");
    const turning = Number(await bench.textContent());
    await page.locator("#load").fill("0.02");
    await page.locator("#load").press("Enter");
    await page.locator("#stop").click();
    await inState(page, "Standby");
    await pause(page);
    assert.equal(await page.locator("#pace option:checked").textContent(), "real time");
    const digest = await digestOf(page);
    const instant = page.locator("#instant");
    const end = Math.round(Number(await instant.getAttribute("max")) * 10_000);

    const seek = async (tick) => {
        await instant.evaluate((input, tick) => {
            input.value = String(tick / 10_000);
            input.dispatchEvent(new Event("input", { bubbles: true }));
        }, tick);
        await page.getByText(new RegExp(`control tick ${tick}$`)).waitFor();
    };
    await seek(Math.round(turning * 10_000));
    await inState(page, "Closed-loop Hall Effect Sensors");
    await reaches(page, 1500, 60);
    await page.locator("#went-back").waitFor();
    assert.equal(Math.round(Number(await instant.getAttribute("max")) * 10_000), end);
    // The whole run is still there, bit for bit.
    await seek(end);
    await inState(page, "Standby");
    assert.equal(await digestOf(page), digest);
    assert.equal(await page.locator("#went-back").count(), 0);

    // Another way from there: nobody has stopped it, and there is no load.
    await seek(Math.round(turning * 10_000));
    await page.locator("#play").click();
    await page.waitForFunction((end) => Number(document.querySelector("#time").textContent) * 10_000 > end + 5000, end);
    await inState(page, "Closed-loop Hall Effect Sensors");
    await reaches(page, 1500, 60);
    assert.ok(Number(await instant.getAttribute("max")) * 10_000 > end);
    assert.deepEqual(complaints, []);
});

/** The digest of the run so far. */
async function digestOf(page) {
    await page.locator("#share").click();
    const note = await page.getByText(/digest [0-9a-f]{16}\.$/).textContent();
    return note.match(/[0-9a-f]{16}/)[0];
}
