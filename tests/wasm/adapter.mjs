// A serial port with a CAN adapter on it for the page: `navigator.serial` in the browser, its bytes over TCP to the virtual drive of
// `cargo xtask drive`, which is an slcan adapter and the bus behind it.

import { spawn } from "node:child_process";
import { connect } from "node:net";
import { fileURLToPath } from "node:url";

/** The virtual drive with its bus as slcan on a TCP port: `{ port, end() }`. */
export async function serveDrive(...options) {
    const root = fileURLToPath(new URL("../..", import.meta.url));
    const drive = spawn("cargo", ["xtask", "drive", "--tcp", "127.0.0.1:0", ...options], { cwd: root, stdio: ["ignore", "pipe", "inherit"] });
    let told = "";
    for await (const piece of drive.stdout) {
        told += piece;
        const port = told.match(/127\.0\.0\.1:(\d+)/)?.[1];
        if (port !== undefined) {
            // Nobody reads what it tells from now on.
            drive.stdout.resume();
            return { port: Number(port), end: () => drive.kill() };
        }
    }
    throw new Error(`the virtual drive did not begin: ${told}`);
}

/** Gives a page a serial port behind which the drive is. `unplug()` takes it away, as a hand would; `written` is what the page has sent. */
export async function plugIn(page, port) {
    const socket = connect(port, "127.0.0.1");
    const adapter = { written: "", unplug: () => page.evaluate(() => globalThis.unplugSerial()), end: () => socket.destroy() };
    await page.exposeFunction("serialWrite", (text) => {
        adapter.written += text;
        socket.write(text, "latin1");
    });
    socket.on("data", (bytes) => page.evaluate((text) => globalThis.serialRead?.(text), bytes.toString("latin1")).catch(() => undefined));
    await page.evaluate(inPage);
    return adapter;
}

/** Runs in the page, before it asks for a port. */
function inPage() {
    const bytes = (text) => Uint8Array.from(text, (letter) => letter.charCodeAt(0));
    const text = (bytes) => Array.from(bytes, (byte) => String.fromCharCode(byte)).join("");
    const port = {
        async open() {
            port.readable = new ReadableStream({
                start(controller) {
                    globalThis.serialRead = (piece) => controller.enqueue(bytes(piece));
                    globalThis.unplugSerial = () => {
                        globalThis.serialRead = undefined;
                        controller.error(new DOMException("The device has been lost.", "NetworkError"));
                    };
                },
                cancel: () => void (globalThis.serialRead = undefined),
            });
            port.writable = new WritableStream({ write: (chunk) => globalThis.serialWrite(text(chunk)) });
        },
        async close() {},
    };
    Object.defineProperty(navigator, "serial", { configurable: true, value: { requestPort: async () => port } });
}
