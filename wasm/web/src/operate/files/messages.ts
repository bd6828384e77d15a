// Messages between the page and the worker that reads files.

import type { BusFrame } from "narx";
import type { Replay } from "narx/lab";
import type { Table } from "narx/drive";

/** Content of a file. */
export type Content =
    /** A recording that was replayed. */
    | { kind: "recording"; replay: Replay; table: Table }
    /** A log of a bus. */
    | { kind: "log"; frames: BusFrame[]; tables: { name: string; table: Table }[]; errors: { line: number; text: string; reason: string }[] }
    /** Columns of numbers. */
    | { kind: "columns"; table: Table };

/** Message from the page. */
export type Request =
    | { kind: "open"; key: number; name: string; bytes: Uint8Array }
    /** Requests the drive's outputs in the tick before `until`, in raw bits. */
    | { kind: "outputs"; key: number; bytes: Uint8Array; until: number };

/** Message from the worker. */
export type Answer =
    | { kind: "opened"; key: number; content: Content }
    | { kind: "outputs"; key: number; until: number; outputs: string }
    | { kind: "refused"; key: number; reason: string };
