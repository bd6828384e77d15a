// Serves folders to this computer only; `node serve.mjs [PORT]` serves the built page.

import { readFile, stat } from "node:fs/promises";
import { createServer } from "node:http";
import { extname, join, normalize, sep } from "node:path";
import { argv } from "node:process";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";

const TYPES = {
    ".css": "text/css; charset=utf-8",
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".json": "application/json",
    ".png": "image/png",
    ".svg": "image/svg+xml",
    ".webmanifest": "application/manifest+json",
    ".wasm": "application/wasm",
};

/** Folder of the built page. */
export const PAGE = fileURLToPath(new URL("dist", import.meta.url));

/** Serves each prefix, "/" among them, from its folder on 127.0.0.1; port 0 is any free one. Resolves to the
 * server once it listens. */
export function serve(folders, port = 0) {
    const server = createServer((request, response) => {
        answer(folders, request, response).catch(() => response.writeHead(500).end());
    });
    return new Promise((resolve, reject) => {
        server.once("error", reject);
        server.listen(port, "127.0.0.1", () => resolve(server));
    });
}

async function answer(folders, request, response) {
    const path = decodeURIComponent(new URL(request.url, "http://localhost").pathname);
    // The longest matching prefix.
    const prefix = Object.keys(folders).filter((name) => path.startsWith(name)).sort((a, b) => b.length - a.length)[0];
    const rest = path.slice(prefix?.length ?? 0);
    const file = join(folders[prefix] ?? "", normalize(`/${rest === "" || rest.endsWith("/") ? `${rest}index.html` : rest}`));
    const found = prefix !== undefined && file.startsWith(normalize(folders[prefix]) + sep) && (await stat(file).catch(() => undefined));
    if (!found || !found.isFile()) {
        return response.writeHead(404).end();
    }
    const type = { "Content-Type": TYPES[extname(file)] ?? "application/octet-stream" };
    if (type["Content-Type"] === "application/octet-stream" || !/\bgzip\b/.test(request.headers["accept-encoding"] ?? "")) {
        return response.writeHead(200, type).end(await readFile(file));
    }
    response.writeHead(200, { ...type, "Content-Encoding": "gzip" }).end(await compressed(file, found.mtimeMs));
}

/** Compressed files, by name, with the time of their change. */
const kept = new Map();

async function compressed(file, changed) {
    if (kept.get(file)?.changed !== changed) {
        kept.set(file, { changed, bytes: gzipSync(await readFile(file), { level: 9 }) });
    }
    return kept.get(file).bytes;
}

if (argv[1] === fileURLToPath(import.meta.url)) {
    const server = await serve({ "/": PAGE }, Number(argv[2] ?? 8080)).catch((error) => {
        console.error(error.message);
        process.exit(1);
    });
    console.log(`http://127.0.0.1:${server.address().port}/ (ends with Ctrl-C)`);
}
