import { fileURLToPath } from "node:url";
import { svelte } from "@sveltejs/vite-plugin-svelte";
import { defineConfig } from "vite";

/** The package as `cargo xtask web` makes it; the longer names first, because each is a beginning of what is imported. */
const names = [["narx/core", "core"], ["narx/drive", "drive"], ["narx/script", "script"], ["narx", "narx"]];
const alias = names.map(([find, file]) => ({
    find,
    replacement: fileURLToPath(new URL(`../pkg/web/${file}.js`, import.meta.url)),
}));

export default defineConfig({
    // One static folder that works wherever it is put.
    base: "./",
    plugins: [svelte()],
    resolve: { alias },
    worker: { format: "es" },
    // The colours of style.css are light-dark(); these are the first browsers that know it.
    build: { target: "es2023", cssTarget: ["chrome123", "firefox120", "safari17.5"] },
});
