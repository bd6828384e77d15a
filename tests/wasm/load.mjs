// Time until the page can be used on a slow connection and a slow processor: `node tests/wasm/load.mjs`. The connection is Chromium's "Fast 3G" (1.44 Mbit/s, 562 ms until the first byte), for workers, too; the processor of the page is slowed down four times.

import { createServer, request } from "node:http";
import { start } from "./browser.mjs";

const [RATE, LATENCY, SLOWER] = [1.44e6 / 8, 562, 4];
/** Each area, and what its user waits for. */
const AREAS = { learn: "[data-usable=true]", "learn/sensorless-start": ".transport button:enabled", operate: "#start:enabled" };

const browser = await start();
const slow = await listen(browser.port);
try {
    for (const [area, usable] of Object.entries(AREAS)) {
        const times = [];
        for (let run = 0; run < 3; run += 1) {
            const { page } = await browser.open({}, "", "about:blank");
            const session = await page.context().newCDPSession(page);
            await session.send("Emulation.setCPUThrottlingRate", { rate: SLOWER });
            slow.loaded = 0;
            const begin = performance.now();
            await page.goto(`http://127.0.0.1:${slow.port}/#/${area}`, { waitUntil: "commit" });
            await page.locator(usable).first().waitFor();
            times.push({ seconds: (performance.now() - begin) / 1000, kilobytes: slow.loaded / 1000 });
            await page.context().close();
        }
        times.sort((one, two) => one.seconds - two.seconds);
        console.log(`${area}: usable after ${times[1].seconds.toFixed(1)} s (${times.map(({ seconds }) => seconds.toFixed(1)).join(", ")}), ${times[1].kilobytes.toFixed(0)} KB`);
    }
} finally {
    slow.close();
    await browser.close();
}

/** A slow connection to the server: every answer begins late, and all of them share the rate. */
async function listen(port) {
    /** Time at which the line is free again. */
    let free = 0;
    const slow = { loaded: 0 };
    const server = createServer((asked, answer) => {
        request({ port, path: asked.url, headers: asked.headers }, async (found) => {
            answer.writeHead(found.statusCode, found.headers);
            await wait(LATENCY);
            for (const piece of pieces(await whole(found))) {
                free = Math.max(free, performance.now()) + (1000 * piece.length) / RATE;
                slow.loaded += piece.length;
                await wait(free - performance.now());
                answer.write(piece);
            }
            answer.end();
        }).end();
    });
    await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
    return Object.assign(slow, { port: server.address().port, close: () => server.close() });
}

function* pieces(bytes) {
    for (let at = 0; at < bytes.length; at += 4096) {
        yield bytes.subarray(at, at + 4096);
    }
}

async function whole(stream) {
    return Buffer.concat(await stream.toArray());
}

function wait(milliseconds) {
    return new Promise((resolve) => setTimeout(resolve, milliseconds));
}
