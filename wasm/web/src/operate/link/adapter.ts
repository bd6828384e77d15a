// A CAN adapter that speaks slcan on a serial port (Web Serial).

import type { BusFrame, Frame } from "narx";
import { SlcanLines, closeSlcan, encodeSlcan, openSlcan } from "narx/core";
import type { Link, Listener } from "./link";

/** Baud rate of the serial line; adapters on USB ignore it. */
const BAUD = 115_200;
/** Time between two ticks without a frame, ms. */
const TICK = 5;

/** Asks the user for a port and opens the bus on it, 500 kbit/s. With `listen` the adapter does not
 * acknowledge frames, either. */
export async function openAdapter(listener: Listener, listen: boolean): Promise<Link> {
    const port = await navigator.serial.requestPort().catch(() => {
        throw new Error("No adapter was chosen.");
    });
    await port.open({ baudRate: BAUD }).catch((error: Error) => {
        throw new Error(`The adapter could not be opened: ${error.message} Is another program using it?`);
    });
    if (!port.readable || !port.writable) {
        throw new Error("The adapter cannot be read or written.");
    }
    return new Adapter(port, port.readable.getReader(), port.writable.getWriter(), listener, listen);
}

class Adapter implements Link {
    readonly name = "CAN adapter";
    readonly readOnly = false;
    readonly #port: SerialPort;
    readonly #reader: ReadableStreamDefaultReader<Uint8Array>;
    readonly #writer: WritableStreamDefaultWriter<Uint8Array>;
    readonly #begin = performance.now();
    readonly #lines = new SlcanLines();
    readonly #clock = new Worker(new URL("./clock.ts", import.meta.url), { type: "module" });
    #listener: Listener | undefined;
    #sent: BusFrame[] = [];
    /** Bytes that are sent at the end of this turn: one transfer for all frames that are due at once. */
    #due: number[] = [];

    constructor(
        port: SerialPort,
        reader: ReadableStreamDefaultReader<Uint8Array>,
        writer: WritableStreamDefaultWriter<Uint8Array>,
        listener: Listener,
        listen: boolean,
    ) {
        this.#port = port;
        this.#reader = reader;
        this.#writer = writer;
        this.#listener = listener;
        this.#write(openSlcan(undefined, listen));
        this.#clock.addEventListener("message", () => this.#tell([]));
        this.#clock.postMessage(TICK);
        void this.#read();
    }

    get now(): number {
        return (performance.now() - this.#begin) / 1000;
    }

    send(frame: Frame): void {
        if (this.#due.length === 0) {
            queueMicrotask(() => this.#flush());
        }
        this.#due.push(...encodeSlcan(frame));
        this.#sent.push(bus(frame, this.now, true));
    }

    close(): void {
        this.#listener = undefined;
        this.#clock.terminate();
        this.#flush();
        this.#write(closeSlcan());
        void this.#release();
    }

    async #release(): Promise<void> {
        // Closing waits until all bytes are written; the last ones are Standby.
        await this.#writer.close().catch(() => undefined);
        await this.#reader.cancel().catch(() => undefined);
        await this.#port.close().catch(() => undefined);
    }

    #flush(): void {
        if (this.#due.length > 0) {
            this.#write(Uint8Array.from(this.#due.splice(0)));
        }
    }

    #write(bytes: Uint8Array): void {
        this.#writer.write(bytes).catch(() => this.#lose());
    }

    async #read(): Promise<void> {
        try {
            for (let piece = await this.#reader.read(); !piece.done; piece = await this.#reader.read()) {
                const time = this.now;
                this.#tell(this.#lines.handleBytes(piece.value).map((frame) => bus(frame, time, false)));
            }
        } catch {
            // The browser's reason does not help the user.
        }
        this.#reader.releaseLock();
        this.#lose();
    }

    #tell(received: readonly BusFrame[]): void {
        this.#listener?.handle(this.now, [...this.#sent.splice(0), ...received]);
    }

    #lose(): void {
        const listener = this.#listener;
        this.#listener = undefined;
        listener?.handleLoss(
            "The connection to the adapter was lost: was it unplugged? A drive that receives no set-points stops its motor within its CAN time-out (parameter 114). Plug in the adapter and connect again.",
        );
    }
}

function bus({ id, extended = true, remote = false, data }: Frame, time: number, sent: boolean): BusFrame {
    return { id, extended, remote, data, time, sent };
}
