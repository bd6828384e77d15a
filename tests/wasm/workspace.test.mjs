// The workspace in Chromium: the strip on every panel, plots of any signals, and the time of a run.

import assert from "node:assert/strict";
import { after, afterEach, before, test } from "node:test";
import { start as launch } from "./browser.mjs";
import { go, inState, operate, pause, saved, start } from "./operating.mjs";

let browser;
before(async () => {
    browser = await launch();
});
after(() => browser?.close());
afterEach(() => browser?.closePages());

test("the strip commands the drive from any panel, and names the limiter in force", async () => {
    const { page, complaints } = await operate(browser, "parameters");
    for (const number of [105, 106]) {
        await page.locator("#search").fill(`${number} Max HV current limitation`);
        const limit = page.locator(`[data-parameter="${number}"] input:enabled`);
        await limit.fill("0.3");
        await limit.press("Enter");
        await page.locator(`[data-parameter="${number}"]`).getByText("not stored").waitFor();
    }
    await go(page, "trace");
    await start(page, 2000, 40);
    const limiter = page.locator(".bar .limiter");
    await limiter.getByText("set by speed loop").waitFor();
    assert.equal(await limiter.getAttribute("title"), "Active limiter, parameter 280");
    await go(page, "virtual");
    await page.locator("#load").fill("0.05");
    await page.locator("#load").press("Enter");
    await limiter.getByText("limited by bus current").waitFor();
    // What acts is shown at every visit.
    await page.locator("#injected").getByText("In force: none.").waitFor();
    await go(page, "trace");
    await go(page, "virtual");
    assert.equal(await page.locator("#load").inputValue(), "0.05");
    await page.locator("#setpoint").fill("1500");
    await page.locator("#setpoint").press("Enter");
    await page.locator("#stop").click();
    await inState(page, "Standby");
    await limiter.waitFor({ state: "detached" });
    assert.deepEqual(complaints, []);
});

test("measurements have plain names in groups, and the manual's name beside them", async () => {
    const { page } = await operate(browser, "main");
    const row = page.getByRole("region", { name: "Supply" }).locator('[title="HV Voltage (name in the manual)"]');
    await row.getByText(/^2[34]\.\d\d/).waitFor();
    assert.match(await row.textContent(), /^Bus voltage/);
    const names = await page.locator("[data-measurement]").evaluateAll((cells) => cells.map(({ dataset }) => dataset.measurement));
    assert.equal(names.length, 21);
});

test("any signals are plotted, held, zoomed, measured and saved, and the choice is kept", async () => {
    const { page, complaints } = await operate(browser, "main");
    await page.waitForTimeout(100);
    const standing = await page.locator("#time").textContent();
    await start(page, 1500, 40);
    await page.locator("#stop").click();
    await inState(page, "Standby");
    const plots = page.locator("#plot");
    await plots.locator(".plot-signals summary").click();
    await plots.locator('[data-plot="HV Current"]').check();
    await plots.locator('[data-plot="state"]').check();
    await plots.locator('[data-plot="true speed"]').check();
    assert.deepEqual(await plots.locator(".lane > summary").allTextContents(), ["Speed, Set-point, True speed, rpm", "State", "Bus current, A"]);
    await plots.locator(".plot-span").selectOption("all");

    // Held: the drive runs on, the view does not.
    await plots.locator(".plot-hold").click();
    await plots.getByText("Cursors A and B").click();
    const edges = () => plots.locator("[data-cursor=A]").evaluate(({ min, max }) => [Number(min), Number(max)]);
    const held = await edges();
    await page.waitForTimeout(300);
    assert.deepEqual(await edges(), held);

    // Cursors read every chosen signal: the motor stands at the beginning.
    await plots.locator("[data-cursor=A]").evaluate((input, standing) => {
        input.value = standing;
        input.dispatchEvent(new Event("input", { bubbles: true }));
    }, standing);
    const values = Object.fromEntries(await plots.locator(".at-cursors tbody tr").evaluateAll((rows) => rows.map((row) => [row.cells[0].textContent, Number(row.cells[1].textContent)])));
    assert.deepEqual([values["Speed, rpm"], values["State"], Math.abs(values["True speed, rpm"]) < 1], [0, 1, true]);

    // Zoomed by dragging over the middle third, and out by a double click.
    const over = plots.locator(".u-over").first();
    await over.scrollIntoViewIfNeeded();
    const { x, y, width, height } = await over.boundingBox();
    await page.mouse.move(x + width / 3, y + height / 2);
    await page.mouse.down();
    await page.mouse.move(x + width / 2, y + height / 2);
    await page.mouse.move(x + (2 * width) / 3, y + height / 2);
    await page.mouse.up();
    const [min, max] = await edges();
    const length = held[1] - held[0];
    assert.ok(Math.abs(min - held[0] - length / 3) < 0.02 * length && Math.abs(max - held[0] - (2 * length) / 3) < 0.02 * length, `${min} to ${max} of ${held}`);

    // The file has what is in view, by names and units; the picture is one.
    // The true speed is one of 32 bits, which 9 digits tell.
    const csv = (await saved(page, () => plots.locator(".save-csv").click())).bytes.toString().trim().split("\n");
    assert.equal(csv[0], "time [s],Speed [rpm],Set-point [rpm],State,Bus current [A],True speed [rpm]");
    const times = csv.slice(1).map((line) => Number(line.split(",")[0]));
    assert.ok(times.length > 100 && times[0] >= min && times.at(-1) <= max);
    const digits = csv.slice(1).map((line) => line.split(",").at(-1).replace(/^-|e.*$/g, "").replace(".", "").replace(/^0+/, "").length);
    assert.ok(Math.max(...digits) <= 9, `${Math.max(...digits)} digits`);
    const picture = await saved(page, () => plots.locator(".save-picture").click());
    assert.equal(picture.name, "drive.png");
    assert.equal(picture.bytes.subarray(1, 4).toString(), "PNG");
    assert.ok(picture.bytes.readUInt32BE(20) > 600, "three plots, one below the other");

    await over.dblclick();
    await plots.locator(".plot-hold").getByText("Hold").waitFor();
    await plots.locator(".lane > summary").nth(1).click();
    await page.waitForFunction(() => JSON.stringify(localStorage).includes("open"));
    await page.reload();
    await inState(page, "Standby");
    assert.equal(await plots.locator(".plot-span").inputValue(), "0");
    assert.deepEqual(await plots.locator(".lane").evaluateAll((lanes) => lanes.map(({ open }) => open)), [true, false, true]);
    assert.deepEqual(complaints, []);
});

test("states, faults and set-points are marked in the plots", async () => {
    const { page } = await operate(browser, "main");
    await start(page, 1500);
    await go(page, "virtual");
    await page.locator("#fault").selectOption("supply");
    await page.locator("#fault-value").fill("70");
    await page.locator("#inject").click();
    await inState(page, "Fault");
    await go(page, "main");
    await pause(page);
    const marks = await page.locator("#plot .chart").first().getAttribute("aria-label");
    for (const mark of [/Standby at [\d.]+/, /1500 rpm at [\d.]+/, /Closed-loop Hall Effect Sensors at [\d.]+/, /Fault: bus voltage above its threshold/]) {
        assert.match(marks, mark);
    }
});

test("no button moves under the pointer when a drive is powered up", async () => {
    const { page, complaints } = await operate(browser, "connection");
    await page.evaluate(() => {
        globalThis.places = new Set();
        const look = () => {
            globalThis.places.add(document.querySelector("#power-up").getBoundingClientRect().top);
            requestAnimationFrame(look);
        };
        look();
    });
    await page.waitForFunction(() => Number(document.querySelector("#time").textContent) > 2);
    await page.locator("#power-up").click();
    await page.waitForFunction(() => Number(document.querySelector("#time").textContent) < 1);
    await inState(page, "Standby");
    await page.locator("#events").getByText(/^Events of the run: \d/).waitFor();
    assert.equal(await page.evaluate(() => globalThis.places.size), 1);
    assert.deepEqual(complaints, []);
});

test("a page whose motor turns asks before it is left", async () => {
    const { page } = await operate(browser, "main");
    const asked = [];
    page.on("dialog", async (dialog) => {
        asked.push(dialog.type());
        await dialog.accept();
    });
    await start(page, 1500);
    await page.reload();
    assert.deepEqual(asked, ["beforeunload"]);
    // Of a motor that stands still it does not ask.
    await inState(page, "Standby");
    await page.reload();
    assert.deepEqual(asked, ["beforeunload"]);
});

test("the events of the run are listed, and each leads to its instant", async () => {
    const { page, complaints } = await operate(browser, "virtual");
    await start(page, 1500);
    await page.locator("#fault").selectOption("hall-supply-lost");
    await page.locator("#inject").click();
    await inState(page, "Fault");
    await page.locator("#events summary").click();
    const fault = page.locator("#events li").filter({ hasText: "Fault: " }).first();
    const time = Number.parseFloat(await fault.locator("button").textContent());
    await fault.locator("button").click();
    await page.waitForFunction((time) => Math.abs(Number(document.querySelector("#time").textContent) - time) < 0.002, time);
    assert.equal(Number.parseFloat(await page.locator('[data-truth="state"]').textContent()), 6);
    // A step back looks at the run as it was, and loses nothing of it.
    const end = await page.locator("#instant").getAttribute("max");
    await page.locator("[data-step='-1']").click();
    await page.waitForFunction((time) => Number(document.querySelector("#time").textContent) < time, time);
    assert.equal(await page.locator("#instant").getAttribute("max"), end);
    assert.deepEqual(complaints, []);
});

test("one timeline goes back on every panel, and the plots with it", async () => {
    const { page, complaints } = await operate(browser, "main");
    await start(page, 1500, 40);
    await page.locator("#stop").click();
    await inState(page, "Standby");
    await pause(page);
    const end = Number(await page.locator("#time").textContent());
    await go(page, "parameters");
    const seek = (seconds) =>
        page.locator("#instant").evaluate((input, seconds) => {
            input.value = String(seconds);
            input.dispatchEvent(new Event("input", { bubbles: true }));
        }, seconds);
    await seek(0.8);
    await page.waitForFunction(() => Number(document.querySelector("#time").textContent) === 0.8);
    await go(page, "main");
    const plots = page.locator("#plot");
    await plots.locator(".plot-span").selectOption("all");
    const csv = async () => (await saved(page, () => plots.locator(".save-csv").click())).bytes.toString().trim().split("\n").slice(1);
    assert.ok(Number((await csv()).at(-1).split(",")[0]) <= 0.8);
    // What was recorded later is still there.
    await seek(end);
    await page.waitForFunction((end) => Number(document.querySelector("#time").textContent) === end, end);
    const whole = await csv();
    assert.ok(Number(whole.at(-1).split(",")[0]) > end - 0.1);
    assert.ok(whole.some((line) => Math.abs(Number(line.split(",")[1]) - 1500) < 40));
    // Until time runs from an earlier instant.
    await seek(0.8);
    await page.waitForFunction(() => Number(document.querySelector("#time").textContent) === 0.8);
    await page.locator("#play").click();
    await page.waitForFunction(() => Number(document.querySelector("#time").textContent) > 1);
    assert.ok((await csv()).every((line) => Math.abs(Number(line.split(",")[1])) < 40));
    assert.deepEqual(complaints, []);
});

test("parameters are grouped, compared with factory and commissioning, and put back one by one", async () => {
    const { page, complaints } = await operate(browser, "parameters");
    await page.getByText(/parameters are still to be read/).waitFor({ state: "detached", timeout: 60_000 });
    const groups = await page.locator("tr.group th").evaluateAll((heads) => heads.map((head) => head.title));
    assert.ok(groups.includes("03-Machine characteristics (name in the manual)"), groups.join());
    await page.locator("#only").selectOption("commissioned");
    await page.getByText("No parameter matches the search.").waitFor();
    await page.locator("#only").selectOption("all");
    await page.locator("#search").fill("Pair poles");
    const row = page.locator('[data-parameter="78"]');
    const input = row.locator("input:enabled");
    const commissioned = Number(await input.inputValue());
    await input.fill("7");
    await input.press("Enter");
    await row.getByText("since commissioning").waitFor();
    await page.locator("#search").fill("");
    await page.locator("#only").selectOption("commissioned");
    assert.deepEqual(await page.locator("[data-parameter]").evaluateAll((rows) => rows.map(({ dataset }) => Number(dataset.parameter))), [78]);
    await row.locator("summary").click();
    await row.locator(".revert-commissioned").click();
    await page.getByText("No parameter matches the search.").waitFor();
    await page.locator("#only").selectOption("all");
    await page.locator("#search").fill("Pair poles");
    assert.equal(Number(await row.locator("input").inputValue()), commissioned);
    // A commissioning can be declared anew.
    await input.fill("7");
    await input.press("Enter");
    await row.getByText("since commissioning").waitFor();
    await page.locator("#keep-commissioned").click();
    await row.getByText("since commissioning").waitFor({ state: "detached" });
    await page.locator("#commissioned").getByText(/kept on \d{4}-\d\d-\d\d\.$/).waitFor();
    const factory = Number(/Factory value: ([\d.]+)/.exec(await row.textContent())[1]);
    if (factory !== 7) {
        await row.locator("summary").click();
        await row.locator(".revert-factory").click();
        await page.waitForFunction((factory) => Number(document.querySelector('[data-parameter="78"] input').value) === factory, factory);
    }
    assert.deepEqual(complaints, []);
});

test("a number has its meaning from the description, and a refusal its unit", async () => {
    const { page } = await operate(browser, "parameters");
    await page.locator("#search").fill("Hall calibration state");
    await page.locator('[data-parameter="279"] .meaning').getByText("none", { exact: true }).waitFor();
    await go(page, "connection");
    const supply = page.locator("#load");
    await supply.fill("-1");
    await supply.blur();
    await page.getByRole("alert").getByText("Load torque: -1 N m: must be a number, at least 0 N m.").waitFor();
    await page.locator("#pwm-rate").fill("8000.5");
    await page.locator("#pwm-rate").blur();
    await page.getByRole("alert").getByText("PWM frequency: 8000.5 Hz: must be a whole number from 8000 to 50000 Hz.").waitFor();
});
