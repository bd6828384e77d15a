// A run that can be passed on: the set-up of the bench, and every input with its control tick. It contains
// everything that determines the run, so repeating it gives the same bits.

import type { Call, Input } from "narx/script";
import type { Setup } from "./messages";

/** Version of the format; increased when the meaning of a field changes. */
const FORMAT = 1;
/** Longest run that can be repeated, s. */
const SECONDS_MAX = 3600;
/** PWM rate of a set-up that has none, Hz. */
export const PWM_RATE = 10_000;

export interface Run {
    setup: Setup;
    /** Inputs, in the order in which they came. */
    inputs: Input[];
    /** Length of the run, control ticks. */
    ticks: number;
    /** Digest of the drive's outputs, 16 hexadecimal digits. */
    digest: string;
}

type Sent = Extract<Input, { call: "send" }>;
type Other = Exclude<Call, { call: "send" }>;

/** Form of a run before compression: each frame once, and a row for each input. */
interface Packed {
    format: number;
    setup: Setup;
    frames: string[];
    /** Ticks since the previous input. */
    after: number[];
    /** Index in `frames`, or an action. */
    what: (number | Other)[];
    ticks: number;
    digest: string;
}

/** Encodes a run as text for an address. */
export async function encode({ setup, inputs, ticks, digest }: Run): Promise<string> {
    const places = new Map<string, number>();
    const place = (frame: Sent) => {
        const text = frameText(frame);
        const known = places.get(text) ?? places.size;
        places.set(text, known);
        return known;
    };
    const what = inputs.map((input) => (input.call === "send" ? place(input) : withoutTick(input)));
    const after = inputs.map(({ tick }, index) => tick - (inputs[index - 1]?.tick ?? 0));
    const packed: Packed = { format: FORMAT, setup, frames: [...places.keys()], after, what, ticks, digest };
    const bytes = await through(new TextEncoder().encode(JSON.stringify(packed)), new CompressionStream("deflate-raw"));
    return base64(bytes);
}

/** Decodes the text of `encode`. Throws an Error that describes the first problem of the text. */
export async function decode(text: string): Promise<Run> {
    let packed: Partial<Packed>;
    try {
        const bytes = await through(fromBase64(text), new DecompressionStream("deflate-raw"));
        packed = JSON.parse(new TextDecoder().decode(bytes)) as Partial<Packed>;
    } catch {
        throw new Error("This link is damaged: a part of it is missing or was changed. Copy the whole link.");
    }
    const { format, setup, frames, after, what, ticks, digest } = packed;
    if (format !== FORMAT) {
        throw new Error(`This link has format ${format}, but this page supports format ${FORMAT}: the link or the page is outdated.`);
    }
    if (!setup || !frames || !after || !what || after.length !== what.length || ticks === undefined || digest === undefined) {
        throw new Error("This link is damaged: it does not contain a whole run.");
    }
    const ticksMax = SECONDS_MAX * (setup.options?.pwmRate ?? PWM_RATE);
    if (!Number.isInteger(ticks) || ticks < 0 || ticks > ticksMax || after.some((ticks) => !Number.isInteger(ticks) || ticks < 0)) {
        throw new Error(`This link is damaged: its run has ${ticks} control ticks; 0 to ${ticksMax} are allowed.`);
    }
    let tick = 0;
    const inputs = what.map((entry, index) => {
        tick += after[index];
        return (typeof entry === "number" ? { tick, ...frameOf(frames[entry]) } : { ...entry, tick }) as Input;
    });
    return { setup, inputs, ticks, digest };
}

function withoutTick({ tick: _, ...call }: Input): Other {
    return call as Other;
}

function frameText({ id, extended, remote, data }: Sent): string {
    const hex = [...data].map((byte) => byte.toString(16).padStart(2, "0")).join("");
    return `${id.toString(16)}${extended === false ? "s" : "x"}${remote ? "r" : "d"}${hex}`;
}

function frameOf(text: string | undefined): Omit<Sent, "tick"> {
    const [, id, extended, remote, hex] = text?.match(/^([0-9a-f]+)([xs])([rd])((?:[0-9a-f]{2}){0,8})$/) ?? [];
    if (id === undefined) {
        throw new Error(`This link is damaged: "${text}" is not a frame.`);
    }
    const data = (hex.match(/../g) ?? []).map((byte) => parseInt(byte, 16));
    return { call: "send", id: parseInt(id, 16), extended: extended === "x", remote: remote === "r", data };
}

async function through(bytes: Uint8Array<ArrayBuffer>, stream: CompressionStream | DecompressionStream): Promise<Uint8Array<ArrayBuffer>> {
    return new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());
}

function base64(bytes: Uint8Array): string {
    const letters = Array.from(bytes, (byte) => String.fromCharCode(byte)).join("");
    return btoa(letters).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

function fromBase64(text: string): Uint8Array<ArrayBuffer> {
    const letters = atob(text.replaceAll("-", "+").replaceAll("_", "/"));
    return Uint8Array.from(letters, (letter) => letter.charCodeAt(0));
}
