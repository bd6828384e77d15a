// A bridge from a WebSocket to the bus of `cargo xtask drive`, which speaks slcan on TCP.

import { createRequire } from "node:module";
import { connect } from "node:net";
import { SlcanLines, encodeSlcan, openSlcan } from "../../wasm/pkg/node/core.js";

const { WebSocketServer } = createRequire(new URL("../../wasm/web/package.json", import.meta.url))("ws");
const [EXTENDED, REMOTE] = [0x8000_0000, 0x4000_0000];

/** A bridge that wants a token: `{ url, token, written, refuse(reason), send(bytes), mute(silent), end() }`; `written` are the messages of the page. */
export async function serveBridge(port, token = "secret") {
    const server = new WebSocketServer({ port: 0, host: "127.0.0.1", verifyClient: ({ req }) => new URL(req.url, "ws://localhost").searchParams.get("token") === token });
    const written = [];
    let muted = false;
    let client;
    const sockets = new Set();
    server.on("connection", (found) => {
        client = found;
        const socket = connect({ port, host: "127.0.0.1", noDelay: true });
        sockets.add(socket);
        const lines = new SlcanLines();
        socket.write(openSlcan());
        socket.on("data", (bytes) => lines.handleBytes(bytes).forEach((frame) => muted || found.send(message(frame))));
        found.on("message", (bytes) => {
            written.push(bytes);
            const word = bytes.readUInt32LE(0);
            const remote = (word & REMOTE) !== 0;
            socket.write(encodeSlcan({ id: word & 0x1fff_ffff, extended: (word & EXTENDED) !== 0, remote, data: remote ? new Uint8Array(bytes[4]) : new Uint8Array(bytes.subarray(5)) }));
        });
        found.on("close", () => socket.end());
    });
    await new Promise((resolve) => server.once("listening", resolve));
    return {
        url: `ws://127.0.0.1:${server.address().port}/`,
        token,
        written,
        refuse: (error) => client.send(JSON.stringify({ error })),
        send: (bytes) => client.send(bytes),
        /** While it is silent the page receives nothing. */
        mute: (silent) => (muted = silent),
        end() {
            sockets.forEach((socket) => socket.destroy());
            server.clients.forEach((found) => found.terminate());
            server.close();
        },
    };
}

function message({ id, extended, remote, data }) {
    const bytes = Buffer.alloc(5 + (remote ? 0 : data.length));
    bytes.writeUInt32LE((id | (extended ? EXTENDED : 0) | (remote ? REMOTE : 0)) >>> 0, 0);
    bytes[4] = data.length;
    bytes.set(remote ? [] : data, 5);
    return bytes;
}

/** Gives a page a gs_usb adapter with a clock of 48 MHz, behind which the bridge's bus is: `{ told() }` are the requests to it. */
export async function plugInUsb(page, { url, token }) {
    await page.evaluate(inPage, `${url}?token=${token}`);
    return { told: () => page.evaluate(() => globalThis.usbTold) };
}

/** Runs in the page. */
function inPage(address) {
    const told = (globalThis.usbTold = []);
    const [received, waiting] = [[], []];
    let socket;
    const give = (bytes) => (waiting.length > 0 ? waiting.shift()(bytes) : received.push(bytes));
    const frame = (echo, word, length, data) => {
        const view = new DataView(new ArrayBuffer(20));
        view.setUint32(0, echo, true);
        view.setUint32(4, word, true);
        view.setUint8(8, length);
        new Uint8Array(view.buffer).set(data, 12);
        return view;
    };
    const endpoints = [
        { direction: "in", endpointNumber: 1, packetSize: 32 },
        { direction: "out", endpointNumber: 2, packetSize: 32 },
    ];
    const device = {
        configuration: { interfaces: [{ alternate: { endpoints } }] },
        open: async () => {
            socket = new WebSocket(address);
            socket.binaryType = "arraybuffer";
            socket.onmessage = ({ data }) => {
                const view = new DataView(data);
                give(frame(0xffff_ffff, view.getUint32(0, true), view.getUint8(4), new Uint8Array(data, 5)));
            };
            await new Promise((resolve) => (socket.onopen = resolve));
        },
        selectConfiguration: async () => {},
        claimInterface: async () => {},
        controlTransferOut: async ({ request, value }, words) => {
            told.push([request, value, ...words]);
            return { status: "ok" };
        },
        // feature, clock, limits of segments, jump width and prescaler: those of an STM32F0.
        controlTransferIn: async () => ({ status: "ok", data: new DataView(Uint32Array.of(0, 48_000_000, 1, 16, 1, 8, 4, 1, 1024, 1).buffer) }),
        transferOut: async (_, bytes) => {
            const view = new DataView(bytes.buffer);
            const length = view.getUint8(8);
            const sent = new DataView(new ArrayBuffer(5 + length));
            sent.setUint32(0, view.getUint32(4, true), true);
            sent.setUint8(4, length);
            new Uint8Array(sent.buffer).set(bytes.subarray(12, 12 + length), 5);
            socket.send(sent.buffer);
            // The adapter echoes what it has sent.
            give(frame(0, view.getUint32(4, true), length, bytes.subarray(12, 12 + length)));
        },
        transferIn: async () => {
            const data = received.shift() ?? (await new Promise((resolve) => waiting.push(resolve)));
            if (data === undefined) {
                throw new DOMException("The device was disconnected.", "NetworkError");
            }
            return { status: "ok", data };
        },
        close: async () => socket.close(),
    };
    globalThis.unplugUsb = () => give(undefined);
    Object.defineProperty(navigator, "usb", { configurable: true, value: { requestDevice: async () => device } });
}
