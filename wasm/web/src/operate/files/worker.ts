// Reads files in a worker, because that takes longer than one picture.

import init, { readLog, replay, replayTrace, type CanLog } from "narx/lab";
import type { BusFrame } from "narx";
import type { Table } from "narx/drive";
import { columns } from "./columns";
import type { Answer, Content, Request } from "./messages";

/** Bits of a frame's flags in a log. */
const [EXTENDED, REMOTE, OTHER] = [1, 2, 4 | 8];
/** A line of `candump -L`. */
const CANDUMP = /^\s*\(\d+\.\d+\)\s+\S+\s+[0-9A-Fa-f]+#/;
/** Factory address of a master: without directions in the log, frames from it count as sent. */
const MONITOR = 85;

function open(name: string, bytes: Uint8Array): Content {
    const text = new TextDecoder().decode(bytes.subarray(0, 4096));
    if (name.endsWith(".narxrec") || text.startsWith("NARX")) {
        return { kind: "recording", replay: replay(bytes), table: traced(bytes) };
    }
    if (CANDUMP.test(text)) {
        return log(bytes);
    }
    const table = columns(new TextDecoder().decode(bytes));
    if (table) {
        return { kind: "columns", table };
    }
    throw new Error(`"${name}" is not a file that this page can read: it is neither a narx recording (.narxrec), nor a candump log, nor a CSV file of numbers with a header.`);
}

function traced(bytes: Uint8Array): Table {
    const trace = replayTrace(bytes);
    const signals = trace.signals.filter(({ name }) => name !== "time");
    const table = {
        time: trace.time,
        columns: Object.fromEntries(signals.map(({ name }) => [name, Float64Array.from(trace.column(name))])),
        units: Object.fromEntries(signals.map(({ name, unit }) => [name, unit])),
    };
    trace.free();
    return table;
}

function log(bytes: Uint8Array): Content {
    const found = readLog(bytes, { slave: null, monitor: null });
    const tables = found.tables.map(({ name, time, columns, units }) => ({ name: String(name), table: { time, columns, units } }));
    return { kind: "log", frames: frames(found), tables, errors: [...found.errors] };
}

function frames({ frames: { time, id, flags, dlc, data } }: CanLog): BusFrame[] {
    return Array.from(id, (id, at): BusFrame => {
        const extended = (flags[at] & EXTENDED) !== 0;
        const sent = extended && ((id >>> 19) & 0xff) === MONITOR;
        return { id, extended, remote: (flags[at] & REMOTE) !== 0, data: data.slice(8 * at, 8 * at + dlc[at]), time: time[at], sent };
    }).filter((_, at) => (flags[at] & OTHER) === 0);
}

function handle(request: Request): Answer {
    const { key } = request;
    if (request.kind === "open") {
        return { kind: "opened", key, content: open(request.name, request.bytes) };
    }
    return { kind: "outputs", key, until: request.until, outputs: replay(request.bytes, request.until).outputs ?? "" };
}

addEventListener("message", async ({ data }: MessageEvent<Request>) => {
    await ready;
    try {
        postMessage(handle(data));
    } catch (error) {
        const reason = error instanceof Error ? error.message : String(error);
        postMessage({ kind: "refused", key: data.key, reason } satisfies Answer);
    }
});

const ready = init();
