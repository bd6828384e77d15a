// The conformance vectors.

import { readdirSync } from "node:fs";
import { fileURLToPath } from "node:url";

const folder = fileURLToPath(new URL("../vectors", import.meta.url));

/** Paths of all recordings, in order. */
export const VECTORS = readdirSync(folder).filter((name) => name.endsWith(".narxrec")).sort().map((name) => `${folder}/${name}`);
