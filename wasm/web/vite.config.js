import { fileURLToPath } from "node:url";
import { svelte } from "@sveltejs/vite-plugin-svelte";
import { defineConfig } from "vite";

const built = fileURLToPath(new URL("../pkg/web", import.meta.url));

export default defineConfig({
    // One static folder that works wherever it is put.
    base: "./",
    plugins: [svelte()],
    resolve: {
        alias: [
            { find: /^narx$/, replacement: `${built}/narx.js` },
            { find: /^narx\/(core|drive|script)$/, replacement: `${built}/$1.js` },
        ],
    },
    worker: { format: "es" },
    // The colours of style.css are light-dark(); these are the first browsers that know it.
    build: { target: "es2023", cssTarget: ["chrome123", "firefox120", "safari17.5"] },
});
