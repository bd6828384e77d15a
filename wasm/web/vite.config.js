import { fileURLToPath } from "node:url";
import { defineConfig } from "vite";

export default defineConfig({
    // One static folder that works wherever it is put.
    base: "./",
    resolve: { alias: { narx: fileURLToPath(new URL("../pkg/web/narx.js", import.meta.url)) } },
    worker: { format: "es" },
    build: { target: "es2023" },
});
