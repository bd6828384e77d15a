import { readdirSync, writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { svelte } from "@sveltejs/vite-plugin-svelte";
import { defineConfig } from "vite";

const built = fileURLToPath(new URL("../pkg/web", import.meta.url));

const output = fileURLToPath(new URL("dist", import.meta.url));

/** Writes the name of every built file to files.json, for the service worker. */
const files = {
    name: "narx-files",
    apply: "build",
    closeBundle() {
        const names = readdirSync(output, { recursive: true, withFileTypes: true }).filter((entry) => entry.isFile());
        const paths = names.map(({ parentPath, name }) => `${parentPath}/${name}`.slice(output.length + 1)).filter((path) => path !== "service-worker.js");
        writeFileSync(`${output}/files.json`, JSON.stringify(paths.sort()));
    },
};

export default defineConfig({
    // Relative addresses, so that the folder works wherever it is put.
    base: "./",
    plugins: [svelte(), files],
    resolve: {
        alias: [
            { find: /^narx$/, replacement: `${built}/narx.js` },
            { find: /^narx\/(core|lab|full|drive|script)$/, replacement: `${built}/$1.js` },
        ],
    },
    worker: { format: "es" },
    // style.css uses light-dark() colours; these are the first browsers that support them.
    build: { target: "es2023", cssTarget: ["chrome123", "firefox120", "safari17.5"] },
});
