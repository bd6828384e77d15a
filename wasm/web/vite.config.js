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
            const chunks = new Set();
            const add = (name) => {
                if (!chunks.has(name) && !bundle[name].isEntry) {
                    chunks.add(name);
                    bundle[name].imports.forEach(add);
                }
            };
            add(files.find(({ facadeModuleId }) => facadeModuleId?.endsWith("/operate/Operate.svelte")).fileName);
            const styles = [...chunks].flatMap((name) => [...(bundle[name].viteMetadata?.importedCss ?? [])]);
            const links = [...[...chunks].map((href) => ["modulepreload", href]), ...styles.map((href) => ["stylesheet", href])];
            const script = `{
                const operates = location.hash.startsWith("#/operate");
                const simulates = operates || /^#.learn../.test(location.hash);
                const load = (name) => WebAssembly.compileStreaming(fetch(name));
                globalThis.begun = { ...(simulates && { narx: load("./${wasm("narx")}") }), ...(operates && { core: load("./${wasm("core")}") }) };
                Object.values(begun).forEach((module) => module.catch(() => undefined));
                for (const [rel, href] of operates ? ${JSON.stringify(links)} : []) {
                    document.head.append(Object.assign(document.createElement("link"), { rel, href: "./" + href }));
                }
            }`;
            return html.replace("</title>", `</title><script>${script.replaceAll(/\s+/g, " ")}</script>`);
        },
    },
};

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
    plugins: [svelte(), begin, offline],
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
