// A serial port with a CAN adapter on it for the page: `navigator.serial` in the browser, its bytes over HTTP and TCP to the virtual drive
// of `cargo xtask drive`, which is an slcan adapter and the bus behind it.

import { spawn } from "node:child_process";
import { createServer } from "node:http";
import { connect } from "node:net";
import { fileURLToPath } from "node:url";
import { SlcanLines, encodeSlcan, openSlcan } from "../../wasm/pkg/node/core.js";

/** The virtual drive with its bus as slcan on a TCP port: `{ port, end() }`. */
export async function serveDrive(...options) {
    const root = fileURLToPath(new URL("../..", import.meta.url));
    const drive = spawn("cargo", ["xtask", "drive", "--tcp", "127.0.0.1:0", ...options], { cwd: root, stdio: ["ignore", "pipe", "inherit"] });
    let told = "";
    for await (const piece of drive.stdout) {
        told += piece;
        const port = told.match(/127\.0\.0\.1:(\d+)/)?.[1];
        if (port !== undefined) {
            await allowSilence(Number(port));
            return { port: Number(port), end: () => drive.kill() };
        }
    }
    throw new Error(`the virtual drive did not begin: ${told}`);
}

/** CAN time-out of the drive in these tests, ms. After its 250 ms it stops the motor, and a page on a busy machine falls silent for longer. */
const SILENCE = 5000;

/** Writes parameter 114, the CAN time-out, which the drive takes in Standby: PARAMETER with number, value and status, identifier 0AAD526Eh. */
async function allowSilence(port) {
    const socket = connect({ port, host: "127.0.0.1", noDelay: true });
    const lines = new SlcanLines();
    const data = Uint8Array.of(0, 114, 0, 0, SILENCE >> 8, SILENCE & 0xff, 0, 0);
    const write = encodeSlcan({ id: 0x0aad_526e, extended: true, data });
    socket.write(openSlcan());
    socket.write(write);
    for await (const bytes of socket) {
        const answers = lines.handleBytes(bytes).filter(({ id }) => (id & 0x1ff) === 0x6e);
        if (answers.some((answer) => Buffer.from(data).equals(answer.data))) {
            return;
        }
        answers.forEach(() => socket.write(write));
    }
    throw new Error("the virtual drive has closed the connection");
}

/** Gives a page a serial port behind which the drive is. `unplug()` takes it away, as a hand would; `written` is what the page has sent. */
export async function plugIn(page, port) {
    const socket = connect({ port, host: "127.0.0.1", noDelay: true });
    const adapter = { written: "", unplug: () => page.evaluate(() => globalThis.unplugSerial()) };
    // What a page reads is one response that does not end; what it writes is a request for each piece.
    const bridge = createServer((request, response) => {
        response.setHeader("Access-Control-Allow-Origin", "*");
        if (request.method === "GET") {
            response.flushHeaders();
            socket.on("data", (bytes) => response.write(bytes));
            return;
        }
        const pieces = [];
        request.on("data", (piece) => pieces.push(piece));
        request.on("end", () => {
            const bytes = Buffer.concat(pieces);
            adapter.written += bytes.toString("latin1");
            socket.write(bytes);
            response.writeHead(204).end();
        });
    });
    await new Promise((resolve) => bridge.listen(0, "127.0.0.1", resolve));
    adapter.end = () => {
        socket.destroy();
        bridge.closeAllConnections();
        bridge.close();
    };
    adapter.url = `http://127.0.0.1:${bridge.address().port}/`;
    await page.evaluate(inPage, adapter.url);
    return adapter;
}

/** Runs in the page, before it asks for a port. */
function inPage(bridge) {
    let lost;
    const port = {
        async open() {
            const { body } = await fetch(bridge);
            const gone = new TransformStream();
            body.pipeTo(gone.writable).catch(() => undefined);
            port.readable = gone.readable.pipeThrough(
                new TransformStream({
                    start(controller) {
                        globalThis.unplugSerial = () => {
                            lost = new DOMException("The device has been lost.", "NetworkError");
                            controller.error(lost);
                        };
                    },
                }),
            );
            const write = (chunk) => (lost ? Promise.reject(lost) : fetch(bridge, { method: "POST", body: chunk, keepalive: true }));
            port.writable = new WritableStream({ write });
        },
        async close() {},
    };
    Object.defineProperty(navigator, "serial", { configurable: true, value: { requestPort: async () => port } });
}
