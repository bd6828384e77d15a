import { fileURLToPath } from "node:url";
import { svelte } from "@sveltejs/vite-plugin-svelte";
import { defineConfig } from "vite";

export default defineConfig({
    // One static folder that works wherever it is put.
    base: "./",
    plugins: [svelte()],
    resolve: { alias: { narx: fileURLToPath(new URL("../pkg/web/narx.js", import.meta.url)) } },
    worker: { format: "es" },
    // The colours of style.css are light-dark(); these are the first browsers that know it.
    build: { target: "es2023", cssTarget: ["chrome123", "firefox120", "safari17.5"] },
});
