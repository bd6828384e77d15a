// Replays recordings in Chromium, in the page's context: `node chromium.mjs [--ticks N] FILE...`

import { PACKAGE, start } from "./browser.mjs";
import { isTranscript, main } from "./replayer.mjs";

const browser = await start();
try {
    const { page } = await browser.open();
    await main(async (bytes, ticks) => {
        const { found, reason } = await page.evaluate(inPage, [PACKAGE, bytes.toString("base64"), ticks, isTranscript(bytes)]);
        if (reason !== undefined) {
            throw new Error(reason);
        }
        return found;
    });
} finally {
    await browser.close();
}

/** Runs in the page. An exception would come back with the browser's words around it. */
async function inPage([folder, base64, ticks, transcript]) {
    const module = await import(`${folder}${transcript ? "transcript" : "lab"}.js`);
    await module.default();
    const replay = transcript ? module.replayTranscript : module.replay;
    const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
    try {
        return { found: replay(bytes, ticks ?? undefined) };
    } catch (error) {
        return { reason: error.message };
    }
}
