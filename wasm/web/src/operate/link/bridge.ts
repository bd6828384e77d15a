// A bridge from a WebSocket to a CAN bus, such as `narx serve`. A binary message is a frame: identifier as a
// little-endian word of 32 bits, whose bit 31 tells an extended frame and bit 30 a remote one; number of data
// bytes; data, of which a remote frame has none. A text message is JSON with the reason of a refusal:
// {"error": "..."}.

import type { Frame } from "narx";
import type { Link, Listener } from "./link";
import { LiveLink, type Ends, type Wire } from "./live";

const [EXTENDED, REMOTE] = [0x8000_0000, 0x4000_0000];
/** Bytes before the data. */
const HEAD = 5;

/** Connects a bridge at an address such as "ws://127.0.0.1:8765/"; a token is added to its query. Rejects with
 * an Error that names the address. */
export async function openBridge(listener: Listener, address: string, token: string): Promise<Link> {
    const url = URL.parse(address.trim());
    if (url === null || !/^wss?:$/.test(url.protocol)) {
        throw new Error(`"${address}" is not the address of a bridge: it must begin with ws:// or wss://, such as ws://127.0.0.1:8765/.`);
    }
    if (token.trim() !== "") {
        url.searchParams.set("token", token.trim());
    }
    const socket = new WebSocket(url);
    socket.binaryType = "arraybuffer";
    await opened(socket, `${url.protocol}//${url.host}${url.pathname}`);
    return new LiveLink(`Bridge ${url.host}`, listener, (ends) => new Bridge(socket, ends));
}

function opened(socket: WebSocket, address: string): Promise<void> {
    return new Promise((resolve, reject) => {
        socket.onopen = () => resolve();
        // The browser does not tell a script why.
        socket.onerror = () => reject(new Error(`The bridge at ${address} does not answer, or refuses the token. Is it running?`));
    });
}

class Bridge implements Wire {
    readonly #socket: WebSocket;

    constructor(socket: WebSocket, ends: Ends) {
        this.#socket = socket;
        socket.onerror = null;
        socket.onclose = ({ reason }) => ends.handleLoss(`The connection to the bridge was closed${reason ? `: ${reason}` : ""}.`);
        socket.onmessage = ({ data }: MessageEvent<string | ArrayBuffer>) => {
            try {
                if (typeof data !== "string") {
                    return ends.handleFrames([decode(new DataView(data))]);
                }
                throw new Error((JSON.parse(data) as { error?: string }).error ?? data);
            } catch (error) {
                socket.onclose = null;
                socket.close();
                ends.handleLoss(`The bridge: ${(error as Error).message}.`);
            }
        };
    }

    write(frames: readonly Frame[]): void {
        if (this.#socket.readyState === WebSocket.OPEN) {
            frames.forEach((frame) => this.#socket.send(encode(frame)));
        }
    }

    close(): void {
        this.#socket.onclose = null;
        // The frames that were sent before still leave.
        this.#socket.close();
    }
}

function encode({ id, extended = true, remote = false, data }: Frame): Uint8Array<ArrayBuffer> {
    const bytes = new Uint8Array(HEAD + (remote ? 0 : data.length));
    new DataView(bytes.buffer).setUint32(0, (id | (extended ? EXTENDED : 0) | (remote ? REMOTE : 0)) >>> 0, true);
    bytes[4] = data.length;
    bytes.set(remote ? [] : data, HEAD);
    return bytes;
}

/** Throws an Error for bytes that are no frame. */
function decode(bytes: DataView<ArrayBuffer>): Frame {
    const length = bytes.byteLength >= HEAD ? bytes.getUint8(4) : NaN;
    const word = bytes.byteLength >= HEAD ? bytes.getUint32(0, true) : 0;
    const remote = (word & REMOTE) !== 0;
    if (!(length <= 8) || bytes.byteLength !== HEAD + (remote ? 0 : length)) {
        throw new Error(`a message of ${bytes.byteLength} bytes is no frame: it must have 5 bytes and as many data as its fifth tells, 0 to 8`);
    }
    const data = remote ? new Uint8Array(length) : new Uint8Array(bytes.buffer, HEAD, length);
    return { id: word & 0x1fff_ffff, extended: (word & EXTENDED) !== 0, remote, data };
}
