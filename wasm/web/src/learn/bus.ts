// Frames of the drive's protocol that the chapters send: PARAMETER and the hall calibration (PROTOCOL.md,
// sections 2 and 5).

import type { Frame } from "narx";
import type { Call } from "narx/script";

const SET = 0x0aad526e;
const REQUEST = 0x0aad546e;
const ANSWER = 0x1552a86e;

/** PARAMETER: word 0 is the number, words 1 and 2 the value, high word first. */
function parameter(id: number, number: number, value = 0): Call {
    const data = new DataView(new ArrayBuffer(8));
    data.setUint16(0, number);
    data.setInt32(2, value);
    return { call: "send", id, data: [...new Uint8Array(data.buffer)] };
}

/** Returns the call that sends a frame which writes a parameter, in its steps. */
export function set(number: number, value: number): Call {
    return parameter(SET, number, value);
}

/** Returns the call that sends a frame which requests a parameter. */
export function request(number: number): Call {
    return parameter(REQUEST, number);
}

/** Returns the value of a parameter, in its steps, if `frame` is the drive's answer about it. */
export function answered(frame: Frame, number: number): number | undefined {
    const data = new DataView(frame.data.buffer, frame.data.byteOffset);
    return frame.id === ANSWER && data.getUint16(0) === number ? data.getInt32(2) : undefined;
}

/** Results of a calibration: hall order, polarity mask and offset. */
const FOUND = [262, 263, 80];
const ORDERS = ["ABC", "ACB", "BAC", "BCA", "CAB", "CBA"];

/** The hall calibration: a rising edge of parameter 264 requests it for the next start. */
export const calibration = {
    ask: () => [set(264, 0), set(264, 1)],
    askFound: () => FOUND.map(request),
    /** Returns the results from the answers of the drive, as a text; undefined if one is missing. */
    found(frames: Frame[]): string | undefined {
        const [order, polarity, offset] = FOUND.map((number) => frames.map((frame) => answered(frame, number)).find((value) => value !== undefined));
        if (order === undefined || polarity === undefined || offset === undefined) {
            return undefined;
        }
        const inverted = polarity === 0 ? "" : polarity === 7 ? ", inverted" : `, inverted by mask ${polarity}`;
        return `${(offset / 100).toFixed(1)}°, lines ${ORDERS[order]}${inverted}`;
    },
};

/** Returns the parts of a 29-bit identifier. */
export function identifier(id: number): { priority: number; source: number; destination: number; type: number; opcode: number } {
    return { priority: (id >>> 27) & 3, source: (id >>> 19) & 0xff, destination: (id >>> 11) & 0xff, type: (id >>> 9) & 3, opcode: id & 0x1ff };
}

/** Returns the four words of a frame. */
export function words({ data }: Frame): number[] {
    const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
    return Array.from({ length: data.byteLength >> 1 }, (_, word) => view.getUint16(2 * word));
}
