import { fileURLToPath } from "node:url";
import { svelte } from "@sveltejs/vite-plugin-svelte";
import { defineConfig } from "vite";
import { VitePWA } from "vite-plugin-pwa";

const built = fileURLToPath(new URL("../pkg/web", import.meta.url));

/** Begins to load, from the page itself, what the area in the address needs: without that each file would wait
 * for the script that names it. It stands before the style sheet, for which scripts wait. */
const begin = {
    name: "narx-begin",
    apply: "build",
    transformIndexHtml: {
        order: "post",
        handler(html, { bundle }) {
            const files = Object.values(bundle);
            const wasm = (name) => files.find(({ fileName }) => new RegExp(`/${name}_bg-.*\\.wasm$`).test(fileName)).fileName;
            /** Files that a place needs besides the first script: chunks, which name their imports, and styles. */
            const needs = (name, found = new Set()) => {
                if (!found.has(name) && !bundle[name].isEntry) {
                    found.add(name);
                    bundle[name].imports.forEach((other) => needs(other, found));
                    bundle[name].viteMetadata?.importedCss.forEach((style) => found.add(style));
                }
                return found;
            };
            const places = files.flatMap(({ facadeModuleId = "", fileName }) => {
                const chapter = /\/learn\/chapters\/(\w+)\.svelte$/.exec(facadeModuleId ?? "")?.[1];
                const place = facadeModuleId?.endsWith("/operate/Operate.svelte") ? "operate" : chapter && `learn/${chapter.replaceAll(/\B[A-Z]/g, "-$&").toLowerCase()}`;
                return place ? [[place, [...needs(fileName)]]] : [];
            });
            const names = [...new Set(places.flatMap(([, needed]) => needed))];
            const numbers = Object.fromEntries(places.map(([place, needed]) => [place, needed.map((name) => names.indexOf(name))]));
            const script = `{
                const [area, page] = location.hash.replace(/^#.?/, "").split(/[/?]/);
                const place = area === "learn" ? "learn/" + page : area;
                const names = ${JSON.stringify(names.map((name) => name.replace("assets/", "")))};
                const needed = ${JSON.stringify(numbers)}[place];
                const load = (name) => WebAssembly.compileStreaming(fetch(name));
                globalThis.begun = { ...(area === "operate" && { core: load("./${wasm("core")}") }), ...(needed && { narx: load("./${wasm("narx")}") }) };
                Object.values(begun).forEach((module) => module.catch(() => undefined));
                for (const name of (needed ?? []).map((number) => names[number])) {
                    document.head.append(Object.assign(document.createElement("link"), { rel: name.endsWith("css") ? "stylesheet" : "modulepreload", href: "./assets/" + name }));
                }
            }`;
            return html.replace("</title>", `</title><script>${script.replaceAll(/\s+/g, " ")}</script>`);
        },
    },
};

/** Address at which the page will be served, from the variable `NARX_PAGE_ADDRESS`: social networks show the preview
 * picture only by its whole address, and nothing else of the page depends on the place. */
export const address = (place) => ({
    name: "narx-address",
    transformIndexHtml(html) {
        if (place === undefined) {
            return html;
        }
        if (!/^https?:\/\/[^\s"]+\/$/.test(place)) {
            throw new Error(`NARX_PAGE_ADDRESS "${place}": must be an address such as https://example.org/narx/, with the slash`);
        }
        return html
            .replace('content="./preview.png"', `content="${place}preview.png"`)
            .replace('<meta property="og:type"', `<meta property="og:url" content="${place}" />\n        <meta property="og:type"`);
    },
});

/** The service worker, which keeps every file for use without a network. A newer version takes over when no page
 * of the older one is open: no page that operates a motor is ever loaded anew. */
const offline = VitePWA({
    injectRegister: null,
    registerType: "prompt",
    filename: "service-worker.js",
    manifest: {
        name: "narx: a BLDC drive in the browser",
        short_name: "narx",
        description: "Operate a virtual or a real BLDC drive, and learn how it works.",
        start_url: "./",
        display: "standalone",
        theme_color: "#0f5a9c",
        background_color: "#f5f6f5",
        icons: [{ src: "icon.svg", sizes: "any", type: "image/svg+xml", purpose: "any" }],
    },
    workbox: { globPatterns: ["**/*.{html,js,css,wasm,svg,webmanifest}"], maximumFileSizeToCacheInBytes: 2 ** 20, clientsClaim: true },
});

export default defineConfig({
    // Relative addresses, so that the folder works wherever it is put.
    base: "./",
    plugins: [svelte(), begin, address(process.env.NARX_PAGE_ADDRESS), offline],
    resolve: {
        alias: [
            { find: /^narx$/, replacement: `${built}/narx.js` },
            { find: /^narx\/(core|lab|full|drive|script)$/, replacement: `${built}/$1.js` },
            { find: /^narx\/(\w+_bg\.wasm)/, replacement: `${built}/$1` },
        ],
    },
    worker: { format: "es" },
    // style.css uses light-dark() colours; these are the first browsers that support them.
    build: { target: "es2023", cssTarget: ["chrome123", "firefox120", "safari17.5"], manifest: true },
});
