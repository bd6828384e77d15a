// Pictures of every route, to look at: `node tests/wasm/screenshots.mjs FOLDER [ROUTE...]`, wide and narrow, light and dark; of "Identify" also the progress and the figures.

import { mkdirSync } from "node:fs";
import { argv } from "node:process";
import { routes, start } from "./browser.mjs";

const SIZES = { wide: { width: 1280, height: 900 }, phone: { width: 360, height: 740 } };
const [folder, ...wanted] = argv.slice(2);
mkdirSync(folder, { recursive: true });
const browser = await start();

async function shoot(page, route, size, colorScheme) {
    const name = `${route.replace(/^#\//, "").replaceAll("/", "-")}-${size}-${colorScheme}.png`;
    await page.screenshot({ path: `${folder}/${name}`, fullPage: true });
}

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
                await shoot(page, route, size, colorScheme);
                if (route === "#/operate/identify") {
                    await page.locator("#stop").click();
                    await page.locator(".bar .state").getByText("Standby", { exact: true }).waitFor();
                    await page.locator("#pole-pairs").fill("4");
                    await page.locator("#pole-pairs").press("Tab");
                    await page.locator("#identify-ready").check();
                    await page.locator("#identify:enabled").click();
                    await page.locator("#identify-stage").getByText(/^Spinning/).waitFor({ timeout: 60_000 });
                    await shoot(page, `${route}-progress`, size, colorScheme);
                    await page.locator("#identified").waitFor({ timeout: 60_000 });
                    await page.locator("#commission:enabled").click();
                    await page.locator("#commissioned-told").waitFor({ timeout: 60_000 });
                    await shoot(page, `${route}-figures`, size, colorScheme);
                }
            }
            console.log(size, colorScheme, complaints);
            await page.close();
        }
    }
} finally {
    await browser.close();
}
