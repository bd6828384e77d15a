// What links to a real bus have in common: the clock, the times of frames, and the end of the connection.

import type { BusFrame, Frame } from "narx";
import type { Link, Listener } from "./link";

/** Time between two ticks without a frame, ms. */
const TICK = 5;

/** A connection that carries frames. */
export interface Wire {
    /** Sends the frames that are due at once. */
    write(frames: readonly Frame[]): void;
    /** Closes the connection after the last frame, which requests Standby. */
    close(): void;
}

/** Events of a wire. */
export interface Ends {
    handleFrames(frames: readonly Frame[]): void;
    /** Called when the connection is lost, with the reason in words. */
    handleLoss(reason: string): void;
}

export class LiveLink implements Link {
    readonly name: string;
    readonly readOnly = false;
    readonly #begin = performance.now();
    readonly #clock = new Worker(new URL("./clock.ts", import.meta.url), { type: "module" });
    readonly #wire: Wire;
    #listener: Listener | undefined;
    #sent: BusFrame[] = [];
    /** Frames that are sent at the end of this turn: one transfer for all that are due at once. */
    #due: Frame[] = [];

    /** `connect` returns the wire, which calls the events that it is given. */
    constructor(name: string, listener: Listener, connect: (ends: Ends) => Wire) {
        this.name = name;
        this.#listener = listener;
        this.#wire = connect({ handleFrames: (frames) => this.#receive(frames), handleLoss: (reason) => this.#lose(reason) });
        this.#clock.addEventListener("message", () => this.#tell([]));
        this.#clock.postMessage(TICK);
    }

    get now(): number {
        return (performance.now() - this.#begin) / 1000;
    }

    send(frame: Frame): void {
        if (this.#due.length === 0) {
            queueMicrotask(() => this.#flush());
        }
        this.#due.push(frame);
        this.#sent.push(bus(frame, this.now, true));
    }

    close(): void {
        this.#listener = undefined;
        this.#clock.terminate();
        this.#flush();
        this.#wire.close();
    }

    #flush(): void {
        if (this.#due.length > 0) {
            this.#wire.write(this.#due.splice(0));
        }
    }

    #receive(frames: readonly Frame[]): void {
        const time = this.now;
        this.#tell(frames.map((frame) => bus(frame, time, false)));
    }

    #tell(received: readonly BusFrame[]): void {
        this.#listener?.handle(this.now, [...this.#sent.splice(0), ...received]);
    }

    #lose(reason: string): void {
        const listener = this.#listener;
        this.#listener = undefined;
        listener?.handleLoss(
            `${reason} A drive that receives no set-points stops its motor within its CAN time-out (parameter 114). Connect again once the cause is removed.`,
        );
    }
}

function bus({ id, extended = true, remote = false, data }: Frame, time: number, sent: boolean): BusFrame {
    return { id, extended, remote, data, time, sent };
}
