// What the page and the worker that reads files say to each other.

import type { BusFrame } from "narx";
import type { Replay } from "narx/lab";
import type { Table } from "narx/drive";

/** A file that was read. */
export type Content =
    /** A recording that has run again. */
    | { kind: "recording"; replay: Replay; table: Table }
    /** A log of a bus. */
    | { kind: "log"; frames: BusFrame[]; tables: { name: string; table: Table }[]; errors: { line: number; text: string; reason: string }[] }
    /** Columns of numbers. */
    | { kind: "columns"; table: Table };

/** From the page. */
export type Request =
    | { kind: "open"; key: number; name: string; bytes: Uint8Array }
    /** What the drive answered in the tick before `until`, every output in raw bits. */
    | { kind: "outputs"; key: number; bytes: Uint8Array; until: number };

/** From the worker. */
export type Answer =
    | { kind: "opened"; key: number; content: Content }
    | { kind: "outputs"; key: number; until: number; outputs: string }
    | { kind: "refused"; key: number; reason: string };
