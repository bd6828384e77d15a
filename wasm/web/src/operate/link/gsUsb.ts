// A CAN adapter with the gs_usb protocol of Linux (candleLight, CANable with its firmware) by WebUSB.

import type { Frame } from "narx";
import type { Link, Listener } from "./link";
import { LiveLink, type Ends, type Wire } from "./live";

/** Adapters by vendor and product: GEHE Innovations, candleLight, CES CANext FD, ABE CANdebugger. */
const ADAPTERS = [
    { vendorId: 0x1d50, productId: 0x606f },
    { vendorId: 0x1209, productId: 0x2323 },
    { vendorId: 0x1cd2, productId: 0x606f },
    { vendorId: 0x16d0, productId: 0x10b8 },
];
const [HOST_FORMAT, BIT_TIMING, MODE, BIT_TIMING_LIMITS] = [0, 1, 2, 4];
const LITTLE_ENDIAN = 0xbeef;
const [STOP, START, LISTEN_ONLY] = [0, 1, 1];
const [EXTENDED, REMOTE] = [0x8000_0000, 0x4000_0000];
/** Bytes of a frame; adapters may append a time. */
const BYTES = 20;
/** Number in a frame's first word of those that come from the bus; others are echoes of sent ones. */
const RECEIVED = 0xffff_ffff;
/** Bit rate of the bus, bit/s, and the part of a bit before its sample. */
const [RATE, SAMPLE] = [500_000, 0.875];

/** Asks the user for an adapter and opens its first channel, 500 kbit/s. With `listen` it does not acknowledge
 * frames, either. */
export async function openGsUsb(listener: Listener, listen: boolean): Promise<Link> {
    const device = await navigator.usb.requestDevice({ filters: ADAPTERS }).catch(() => {
        throw new Error("No adapter was chosen.");
    });
    try {
        await device.open();
        await device.selectConfiguration(1);
        await device.claimInterface(0);
        await command(device, HOST_FORMAT, 1, [LITTLE_ENDIAN]);
        await command(device, MODE, 0, [STOP, 0]);
        await command(device, BIT_TIMING, 0, timing(await limits(device)));
        await command(device, MODE, 0, [START, listen ? LISTEN_ONLY : 0]);
    } catch (error) {
        await device.close().catch(() => undefined);
        throw new Error(`The adapter could not be opened: ${(error as Error).message} Is another program using it?`);
    }
    return new LiveLink("CAN adapter (gs_usb)", listener, (ends) => new GsUsb(device, ends));
}

class GsUsb implements Wire {
    readonly #device: USBDevice;
    readonly #ends: Ends;
    readonly #in: USBEndpoint;
    readonly #out: USBEndpoint;
    #closed = false;
    /** Settles once everything was sent. */
    #sent: Promise<unknown> = Promise.resolve();

    constructor(device: USBDevice, ends: Ends) {
        const { endpoints } = device.configuration!.interfaces[0].alternate;
        this.#device = device;
        this.#ends = ends;
        this.#in = endpoints.find(({ direction }) => direction === "in")!;
        this.#out = endpoints.find(({ direction }) => direction === "out")!;
        void this.#read();
    }

    write(frames: readonly Frame[]): void {
        for (const frame of frames) {
            this.#sent = this.#sent.then(() => this.#device.transferOut(this.#out.endpointNumber, encode(frame))).catch(() => this.#lose());
        }
    }

    close(): void {
        this.#closed = true;
        void this.#sent
            .then(() => command(this.#device, MODE, 0, [STOP, 0]))
            .then(() => this.#device.close())
            .catch(() => undefined);
    }

    async #read(): Promise<void> {
        try {
            while (!this.#closed) {
                const { data } = await this.#device.transferIn(this.#in.endpointNumber, Math.max(this.#in.packetSize, 64));
                if (data && data.byteLength >= BYTES && data.getUint32(0, true) === RECEIVED) {
                    this.#ends.handleFrames([decode(data)]);
                }
            }
        } catch {
            this.#lose();
        }
    }

    #lose(): void {
        if (!this.#closed) {
            this.#closed = true;
            this.#ends.handleLoss("The connection to the adapter was lost: was it unplugged?");
        }
    }
}

async function command(device: USBDevice, request: number, value: number, words: readonly number[]): Promise<void> {
    const { status } = await device.controlTransferOut({ requestType: "vendor", recipient: "interface", request, value, index: 0 }, Uint32Array.from(words));
    if (status !== "ok") {
        throw new Error(`it has refused request ${request}.`);
    }
}

/** Clock of the controller, Hz, and limits of its bit timing. */
interface Limits {
    clock: number;
    segment1: [number, number];
    segment2: [number, number];
    prescaler: [number, number, number];
}

async function limits(device: USBDevice): Promise<Limits> {
    const { data } = await device.controlTransferIn({ requestType: "vendor", recipient: "interface", request: BIT_TIMING_LIMITS, value: 0, index: 0 }, 40);
    if (!data || data.byteLength < 40) {
        throw new Error("it does not tell its bit timing.");
    }
    const word = (index: number) => data.getUint32(4 * index, true);
    return { clock: word(1), segment1: [word(2), word(3)], segment2: [word(4), word(5)], prescaler: [word(7), word(8), word(9)] };
}

/** Returns the words of a bit timing for the bus: propagation, segments 1 and 2, jump width, prescaler. */
function timing({ clock, segment1, segment2, prescaler: [from, to, step] }: Limits): number[] {
    for (let prescaler = from; prescaler <= to; prescaler += Math.max(step, 1)) {
        const quanta = clock / (RATE * prescaler);
        const after = Math.max(Math.round(quanta * (1 - SAMPLE)), segment2[0], 1);
        const before = quanta - 1 - after;
        if (Number.isInteger(quanta) && before >= segment1[0] && before <= segment1[1] && after <= segment2[1]) {
            const propagation = Math.floor(before / 2);
            return [propagation, before - propagation, after, 1, prescaler];
        }
    }
    throw new Error(`its clock of ${clock} Hz has no bit timing for ${RATE} bit/s.`);
}

function encode({ id, extended = true, remote = false, data }: Frame): Uint8Array<ArrayBuffer> {
    const bytes = new Uint8Array(BYTES);
    const view = new DataView(bytes.buffer);
    view.setUint32(4, (id | (extended ? EXTENDED : 0) | (remote ? REMOTE : 0)) >>> 0, true);
    view.setUint8(8, data.length);
    bytes.set(data, 12);
    return bytes;
}

function decode(view: DataView): Frame {
    const [word, length] = [view.getUint32(4, true), Math.min(view.getUint8(8), 8)];
    const data = Uint8Array.from({ length }, (_, at) => view.getUint8(12 + at));
    return { id: word & 0x1fff_ffff, extended: (word & EXTENDED) !== 0, remote: (word & REMOTE) !== 0, data };
}
