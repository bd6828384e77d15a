// TX-Drivers on the drive's bus: a master for each.

import type { Frame } from "narx";
import { TxMaster, txObjects, type TxObject } from "narx/core";

/** CAN configuration, basic configuration and encoder resolution. */
const ENCODER = txObjects().filter(({ index }) => [0x2004, 0x2005, 0x2009].includes(index));

/** Longest time until an answer, s: of a node that is known, which browsers may delay as those of a drive, and of one
 * of the 127 that are looked for. */
const [TIMEOUT, SCAN] = [0.25, 0.1];

interface Question {
    begin: () => void;
    resolve: (value: number) => void;
    reject: (error: Error) => void;
}

/** One node and its master. */
export class Node {
    readonly id: number;
    readonly master: TxMaster;
    #waiting: Question[] = [];
    #asked: Question | undefined;

    constructor(id: number, channels: 1 | 2, timeout: number) {
        this.id = id;
        this.master = new TxMaster({ nodeId: id, channels, timeout });
    }

    /** Reads an entry of the object dictionary, in its unit. */
    async read({ index, subindex, scale }: TxObject): Promise<number> {
        return scale * (await this.#ask(() => this.master.request(index, subindex)));
    }

    /** Writes an entry, in its unit. */
    async write({ index, subindex, scale }: TxObject, value: number): Promise<void> {
        await this.#ask(() => this.master.request(index, subindex, Math.round(value / scale)));
    }

    /** Reads the entries that determine the position of its encoder: whether PDOs carry it, whether it is
     * linear, and the length of a count. */
    async learn(): Promise<void> {
        await Promise.all(ENCODER.map((entry) => this.read(entry)));
    }

    handleFrame(frame: Frame, now: number): void {
        this.master.handleFrame(frame, now);
        this.#settle();
    }

    /** Returns the frames to send. `room`: the bus has room for the answer to a new request. */
    poll(now: number, room: boolean): Frame[] {
        if (!this.#asked && room) {
            this.#asked = this.#waiting.shift();
            try {
                this.#asked?.begin();
            } catch (error) {
                this.#asked?.reject(error as Error);
                this.#asked = undefined;
            }
        }
        const due = this.master.poll(now);
        this.#settle();
        return due;
    }

    #ask(begin: () => void): Promise<number> {
        return new Promise((resolve, reject) => this.#waiting.push({ begin, resolve, reject }));
    }

    #settle(): void {
        const answer = this.#asked && this.master.pollAnswer();
        if (!answer) {
            return;
        }
        if (answer.error) {
            this.#asked?.reject(answer.error);
        } else {
            this.#asked?.resolve(answer.value);
        }
        this.#asked = undefined;
    }
}

class Nodes {
    found = $state.raw<readonly Node[]>([]);
    /** Nodes that are asked for an answer. */
    #candidates: readonly Node[] = [];

    handleFrame(frame: Frame, now: number): void {
        if (frame.extended === false) {
            this.#all().forEach((node) => node.handleFrame(frame, now));
        }
    }

    poll(now: number, room: boolean): Frame[] {
        return this.#all().flatMap((node) => node.poll(now, room));
    }

    /** Returns the positions that each node has sent last, mm, by their names. */
    positions(): Record<string, number> {
        const named = this.found.flatMap(({ id, master }) => (master.reading?.positions ?? []).map((position, channel) => [`TX-Driver ${id}, channel ${channel + 1}`, position]));
        return Object.fromEntries(named);
    }

    clear(): void {
        this.found = [];
        this.#candidates = [];
    }

    /** Adds a node, whether it answers or not. */
    add(id: number, channels: 1 | 2): void {
        this.found = [...this.found.filter((node) => node.id !== id), new Node(id, channels, TIMEOUT)].toSorted((one, two) => one.id - two.id);
    }

    /** Asks nodes for an entry, and adds those that answer, even with a refusal. */
    async ask(ids: readonly number[], entry: TxObject): Promise<void> {
        const candidates = ids.map((id) => new Node(id, 1, SCAN));
        this.#candidates = candidates;
        const answers = await Promise.all(candidates.map((node) => node.read(entry).then(() => true, (error: Error) => error.name !== "NoAnswerError")));
        this.#candidates = [];
        candidates.filter((_, index) => answers[index]).forEach(({ id }) => this.add(id, 1));
    }

    #all(): readonly Node[] {
        return [...this.found, ...this.#candidates];
    }
}

export const nodes = new Nodes();
