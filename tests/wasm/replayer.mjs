// The line protocol of all replayers: `[--ticks N] FILE...` in, a line for each file out.

import { readFile } from "node:fs/promises";
import { basename } from "node:path";
import process from "node:process";

/** Whether a recording is of a node or a TX-Driver: the kind, behind magic, version and a chunk's head, is not that of a drive. */
export const isTranscript = (bytes) => bytes[12] > 1;

/** Replays what the command line names with `replay(bytes, ticks)`, and sets the exit code. */
export async function main(replay) {
    const files = process.argv.slice(2);
    const ticks = files[0] === "--ticks" ? Number(files.splice(0, 2)[1]) : undefined;
    for (const file of files) {
        const stem = basename(file, ".narxrec");
        try {
            console.log(`${stem} ${line(await replay(await readFile(file), ticks))}`);
        } catch (error) {
            console.log(`${stem} error ${error.message.split("\n")[0]}`);
            process.exitCode = 1;
        }
    }
}

function line({ ticks, digest, recordedDigest = "-", outputs }) {
    return [ticks, digest, recordedDigest, outputs].filter((word) => word !== undefined).join(" ");
}
