import { fileURLToPath } from "node:url";
import { defineConfig } from "vite";

/** The package as `cargo xtask web` makes it; the longer names first, because each is a beginning of what is imported. */
const names = [["narx/core", "core"], ["narx/lab", "lab"], ["narx/drive", "drive"], ["narx/script", "script"], ["narx", "narx"]];
const alias = names.map(([find, file]) => ({
    find,
    replacement: fileURLToPath(new URL(`../pkg/web/${file}.js`, import.meta.url)),
}));

export default defineConfig({
    // One static folder that works wherever it is put.
    base: "./",
    resolve: { alias },
    worker: { format: "es" },
    build: { target: "es2023" },
});
