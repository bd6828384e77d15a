// What the tests of the operating panel have in common.

import { readFile } from "node:fs/promises";

/** Opens a panel, with the virtual drive that everybody finds there. */
export async function operate(browser, panel, options = {}) {
    const opened = await browser.open({ viewport: { width: 1280, height: 900 }, ...options }, `#/operate/${panel}`);
    await opened.page.getByRole("status").getByText("Standby", { exact: true }).waitFor();
    return opened;
}

/** Goes to another panel. */
export async function go(page, panel) {
    await page.locator(`main nav a[href="#/operate/${panel}"]`).click();
}

/** Waits until the drive's state is that. */
export function inState(page, name) {
    return page.locator(".bar .state").getByText(name, { exact: true }).waitFor();
}

/** Waits for Standby. A drive that the last test has left without a master is in its time-out's fault: that is acknowledged as a user does it, by Stop, which the drive takes half a second after the fault. */
export async function standsBy(page) {
    const [standby, fault] = ["Standby", "Fault"].map((name) => page.locator(".bar .state").getByText(name, { exact: true }));
    await standby.or(fault).waitFor();
    while (await fault.isVisible()) {
        await page.locator("#stop").click();
        await page.waitForTimeout(600);
    }
    await standby.waitFor();
}

/** Waits until the speed of the status bar is within `tolerance` of `rpm`. */
export function reaches(page, rpm, tolerance) {
    const near = ([rpm, tolerance]) => Math.abs(Number(document.querySelector(".bar .speed b").textContent) - rpm) <= tolerance;
    return page.waitForFunction(near, [rpm, tolerance]);
}

/**
 * Starts from the main panel, and waits for closed loop with hall sensors and a speed within `tolerance` of `rpm`. A page that a busy machine lets
 * wait for a quarter of a second is a silent master, and the drive's time-out stops the motor: then the start is tried again. Any other fault is one.
 */
export async function start(page, rpm, tolerance = Infinity) {
    const [runs, fault] = ["Closed-loop Hall Effect Sensors", "Fault"].map((name) => page.locator(".bar .state").getByText(name, { exact: true }));
    const refusal = page.getByRole("form", { name: "Command" }).getByRole("alert");
    for (let tries = 0; tries < 5; tries++) {
        await page.locator("#start:enabled").waitFor();
        await page.locator("#setpoint").fill(String(rpm));
        await page.locator("#start").click();
        await runs.or(fault).or(refusal).first().waitFor();
        if (await runs.isVisible()) {
            await Promise.race([reaches(page, rpm, tolerance), runs.waitFor({ state: "hidden" })]);
            if (await runs.isVisible()) {
                return;
            }
        }
        if (await fault.isVisible()) {
            await page.locator(".bar .faults").getByText(/device timeout|time-out \(parameter 114\)/).waitFor();
        } else if (await refusal.first().isVisible()) {
            const reason = await refusal.first().textContent();
            // The page that has waited for half a second takes the drive for lost, and requests Standby.
            if (!/ended by another command/.test(reason)) {
                throw new Error(`the start: ${reason}`);
            }
        }
        await standsBy(page);
    }
    throw new Error("every start ended in the drive's time-out");
}

/** Waits until the log has more than so many records. */
export function logged(page, records) {
    const grown = (records) => {
        document.querySelector("#refresh-log:enabled")?.click();
        return Number(document.querySelector("#log-length").textContent) > records;
    };
    return page.waitForFunction(grown, records, { polling: 100 });
}

/** The content of the file that a click saves. */
export async function saved(page, click) {
    const [download] = await Promise.all([page.waitForEvent("download"), click()]);
    return { name: download.suggestedFilename(), bytes: await readFile(await download.path()) };
}

/** Drops files on the page as a reader does. */
export async function drop(page, ...files) {
    const content = files.map(({ name, buffer }) => [name, buffer.toString("base64")]);
    const transfer = await page.evaluateHandle((files) => {
        const transfer = new DataTransfer();
        for (const [name, base64] of files) {
            transfer.items.add(new File([Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0))], name));
        }
        return transfer;
    }, content);
    await page.locator("main").dispatchEvent("drop", { dataTransfer: transfer });
}

/** Whether a plot has pixels of more than background and axes. */
export function isDrawn(canvas) {
    return canvas.evaluate((canvas) => {
        const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
        return new Set(new Uint32Array(data.buffer)).size > 2;
    });
}

/** Stops the time of the run. */
export async function pause(page) {
    await page.locator("#play").getByText("Pause").click();
    await page.locator("#play").getByText("Run").waitFor();
}
