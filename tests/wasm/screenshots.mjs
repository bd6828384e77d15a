// Pictures of every route, to look at: `node tests/wasm/screenshots.mjs FOLDER [ROUTE...]`, wide and narrow, light and dark.

import { mkdirSync } from "node:fs";
import { argv } from "node:process";
import { routes, start } from "./browser.mjs";

const SIZES = { wide: { width: 1280, height: 900 }, phone: { width: 360, height: 740 } };
const [folder, ...wanted] = argv.slice(2);
mkdirSync(folder, { recursive: true });
const browser = await start();
try {
    for (const [size, viewport] of Object.entries(SIZES)) {
        for (const colorScheme of ["light", "dark"]) {
            const { page, complaints } = await browser.open({ viewport, colorScheme }, "#/operate/main");
            await page.locator("#start:enabled").waitFor({ timeout: 30_000 });
            await page.locator("#start").click();
            await page.waitForTimeout(2000);
            for (const route of wanted.length > 0 ? wanted : await routes(page)) {
                await page.evaluate((route) => location.assign(route), route);
                await page.waitForTimeout(700);
                const name = `${route.replace(/^#\//, "").replaceAll("/", "-")}-${size}-${colorScheme}.png`;
                await page.screenshot({ path: `${folder}/${name}`, fullPage: true });
            }
            console.log(size, colorScheme, complaints);
            await page.close();
        }
    }
} finally {
    await browser.close();
}
