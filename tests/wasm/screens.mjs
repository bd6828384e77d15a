// Pictures of every route, to be looked at: `node screens.mjs FOLDER [PART OF A ROUTE]`, for desk and telephone, light and dark.

import { mkdirSync } from "node:fs";
import { join } from "node:path";
import { argv } from "node:process";
import { routes, start } from "./browser.mjs";

const SCREENS = { desk: { width: 1280, height: 900 }, phone: { width: 360, height: 740 } };
/** Until the motors of a chapter turn, ms. */
const SETTLED = 3000;

const [folder, part = ""] = argv.slice(2);
mkdirSync(folder, { recursive: true });
const browser = await start();
try {
    for (const [screen, viewport] of Object.entries(SCREENS)) {
        for (const colorScheme of ["light", "dark"]) {
            const { page } = await browser.open({ viewport, colorScheme }, "#/learn");
            for (const route of (await routes(page)).filter((route) => route.includes(part))) {
                await page.evaluate((route) => location.assign(route), route);
                await page.waitForTimeout(SETTLED);
                const name = `${route.slice(2).replaceAll("/", "-")}-${screen}-${colorScheme}.png`;
                await page.screenshot({ path: join(folder, name), fullPage: true });
            }
            await page.close();
        }
    }
} finally {
    await browser.close();
}
