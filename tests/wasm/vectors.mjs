// The conformance vectors.

import { readdirSync } from "node:fs";
import { fileURLToPath } from "node:url";

/** Paths of the recordings in a folder beside this one, in order. */
function recordings(name) {
    const folder = fileURLToPath(new URL(`../${name}`, import.meta.url));
    return readdirSync(folder).filter((file) => file.endsWith(".narxrec")).sort().map((file) => `${folder}/${file}`);
}

/** Of drives. */
export const VECTORS = recordings("vectors");
/** Of what stands on the bus. */
export const TRANSCRIPTS = recordings("vectors/transcripts");
