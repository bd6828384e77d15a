// Memory of the page while a motor turns: `node tests/wasm/memory.mjs [MINUTES]` prints a line a minute, MB: of the renderer's process, of the page's heap, of the bench's memory.

import { readFileSync, readdirSync } from "node:fs";
import { argv } from "node:process";
import { start as launch } from "./browser.mjs";
import { operate, start } from "./operating.mjs";

const MINUTES = Number(argv[2] ?? 12);
const browser = await launch();
try {
    const { page } = await operate(browser, "main");
    await start(page, 2000);
    const session = await page.context().newCDPSession(page);
    const MB = (bytes) => (bytes / 2 ** 20).toFixed(0);
    for (let minute = 0; minute <= MINUTES; minute += 1) {
        const { usedSize, totalSize } = await session.send("Runtime.getHeapUsage");
        console.log(`${minute} min: renderer ${MB(renderer())} MB, heap ${MB(usedSize)} of ${MB(totalSize)} MB, ${await page.locator("#time").textContent()} s`);
        await page.waitForTimeout(60_000);
    }
} finally {
    await browser.close();
}

/** Resident memory of the largest renderer that this process has started, bytes. */
function renderer() {
    const processes = readdirSync("/proc").filter((name) => /^\d+$/.test(name)).flatMap((id) => {
        try {
            const [command, status] = ["cmdline", "status"].map((file) => readFileSync(`/proc/${id}/${file}`, "utf8"));
            return [{ id: Number(id), command, parent: Number(/^PPid:\s+(\d+)/m.exec(status)[1]), resident: 1024 * Number(/^VmRSS:\s+(\d+)/m.exec(status)?.[1] ?? 0) }];
        } catch {
            return [];
        }
    });
    const ours = (id) => id === process.pid || (id > 1 && ours(processes.find((process) => process.id === id)?.parent ?? 0));
    return Math.max(0, ...processes.filter(({ id, command }) => command.includes("--type=renderer") && ours(id)).map(({ resident }) => resident));
}
