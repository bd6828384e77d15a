// A CAN adapter that speaks slcan on a serial port (Web Serial).

import type { Frame } from "narx";
import { SlcanLines, closeSlcan, encodeSlcan, openSlcan } from "narx/core";
import type { Link, Listener } from "./link";
import { LiveLink, type Ends, type Wire } from "./live";

/** Baud rate of the serial line; adapters on USB ignore it. */
const BAUD = 115_200;

/** Asks the user for a port and opens the bus on it, 500 kbit/s. With `listen` the adapter does not
 * acknowledge frames, either. */
export async function openAdapter(listener: Listener, listen: boolean): Promise<Link> {
    const port = await navigator.serial.requestPort().catch(() => {
        throw new Error("No adapter was chosen.");
    });
    await port.open({ baudRate: BAUD }).catch((error: Error) => {
        throw new Error(`The adapter could not be opened: ${error.message} Is another program using it?`);
    });
    const { readable, writable } = port;
    if (!readable || !writable) {
        throw new Error("The adapter cannot be read or written.");
    }
    return new LiveLink("CAN adapter", listener, (ends) => new Serial(port, readable.getReader(), writable.getWriter(), ends, listen));
}

class Serial implements Wire {
    readonly #port: SerialPort;
    readonly #reader: ReadableStreamDefaultReader<Uint8Array>;
    readonly #writer: WritableStreamDefaultWriter<Uint8Array>;
    readonly #ends: Ends;
    readonly #lines = new SlcanLines();

    constructor(
        port: SerialPort,
        reader: ReadableStreamDefaultReader<Uint8Array>,
        writer: WritableStreamDefaultWriter<Uint8Array>,
        ends: Ends,
        listen: boolean,
    ) {
        this.#port = port;
        this.#reader = reader;
        this.#writer = writer;
        this.#ends = ends;
        this.#send(openSlcan(undefined, listen));
        void this.#read();
    }

    write(frames: readonly Frame[]): void {
        this.#send(Uint8Array.from(frames.flatMap((frame) => [...encodeSlcan(frame)])));
    }

    close(): void {
        this.#send(closeSlcan());
        void this.#release();
    }

    async #release(): Promise<void> {
        // Closing waits until all bytes are written; the last ones are Standby.
        await this.#writer.close().catch(() => undefined);
        await this.#reader.cancel().catch(() => undefined);
        await this.#port.close().catch(() => undefined);
    }

    #send(bytes: Uint8Array): void {
        this.#writer.write(bytes).catch(() => this.#lose());
    }

    async #read(): Promise<void> {
        try {
            for (let piece = await this.#reader.read(); !piece.done; piece = await this.#reader.read()) {
                this.#ends.handleFrames(this.#lines.handleBytes(piece.value));
            }
        } catch {
            // The browser's reason does not help the user.
        }
        this.#reader.releaseLock();
        this.#lose();
    }

    #lose(): void {
        this.#ends.handleLoss("The connection to the adapter was lost: was it unplugged?");
    }
}
