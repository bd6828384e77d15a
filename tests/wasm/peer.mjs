// A drive that is nothing but its protocol, and serves whatever description it is given.

import { crc32 } from "node:zlib";

const [DRIVE, MASTER] = [170, 85];
const [STATUS, FAULTS, REQUEST, MOTOR, PARAMETER, SCOPE, XML, XML_DATA] = [3, 4, 2, 102, 110, 112, 130, 131];
const [SET, ASK] = [1, 2];

export class Peer {
    /** `xml`: its description; `speedMax`: set-points above it are clamped. Parameters have their factory values. */
    constructor(xml, { build = 7, speedMax = 65_535, check = undefined } = {}) {
        const text = new TextEncoder().encode(xml.length % 2 ? `${xml}\n` : xml);
        Object.assign(this, { text, build, speedMax, check: check ?? crc32(text), downloads: 0, mode: 0, out: [], record: [], measured: [] });
        this.rows = new Map();
        this.raw = new Map();
        for (const [, attributes] of xml.matchAll(/<parameter ([^>]*)>/g)) {
            const row = Object.fromEntries([...attributes.matchAll(/(\w+)="([^"]*)"/g)].map(([, name, value]) => [name, value]));
            const number = Number(row.number);
            this.rows.set(number, row);
            this.raw.set(number, Math.round(Number(row.factory) / Number(row.scale)));
        }
        for (const [number, raw] of [[83, 1], [261, 1], [260, 0], [305, 4096]]) {
            this.raw.set(number, raw);
        }
    }

    /** Frames that it has for its master. */
    take() {
        return this.out.splice(0);
    }

    broadcast() {
        this.#say(STATUS, 0, this.mode ? (3 << 8) | this.mode : 0);
        this.#say(FAULTS);
        this.measured.forEach(([opcode, ...words]) => this.#say(opcode, ...words));
    }

    handle({ id, data }) {
        const [kind, opcode] = [(id >> 9) & 3, id & 0x1ff];
        const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
        const words = [0, 2, 4, 6].map((at) => view.getUint16(at));
        switch (`${kind} ${opcode}`) {
            case `${ASK} 0`:
                return this.#say(0, this.build, 0, 20_261_123 >>> 16, 20_261_123);
            case `${SET} ${REQUEST}`:
                this.mode = words[1] & 0xf;
                this.raw.set(261, this.mode ? 5 : 1);
                return this.broadcast();
            case `${SET} ${MOTOR}`:
                this.#say(MOTOR, Math.min(words[0], this.speedMax));
                return this.broadcast();
            case `${ASK} ${PARAMETER}`:
                return this.#answer(words[0], 0);
            case `${SET} ${PARAMETER}`:
                return this.#write(words[0], ((words[1] << 16) | words[2]) >>> 0);
            case `${SET} ${SCOPE}`:
                return this.raw.set(260, this.raw.get(260) === 1 ? 3 : 1);
            case `${ASK} ${SCOPE}`:
                return this.#stream(SCOPE, this.record);
            case `${ASK} ${XML}`:
                if (words[0] === 0) {
                    return this.#say(XML, this.text.length / 2, 0, this.check >>> 16, this.check);
                }
                this.downloads += 1;
                return this.#stream(XML_DATA, Array.from({ length: this.text.length / 2 }, (_, at) => (this.text[2 * at] << 8) | this.text[2 * at + 1]));
        }
    }

    #say(opcode, ...words) {
        const data = new Uint8Array(8);
        words.forEach((word, at) => new DataView(data.buffer).setUint16(2 * at, word & 0xffff));
        this.out.push({ id: ((2 << 27) | (DRIVE << 19) | (MASTER << 11) | opcode) >>> 0, extended: true, remote: false, data });
    }

    #stream(opcode, words) {
        for (let at = 0; at < words.length; at += 3) {
            this.#say(opcode, at, ...words.slice(at, at + 3));
        }
    }

    #answer(number, status) {
        const raw = this.raw.get(number);
        this.#say(PARAMETER, number, (raw ?? 0) >>> 16, raw ?? 0, raw === undefined ? 1 : status);
    }

    #write(number, bits) {
        const row = this.rows.get(number);
        const raw = row?.type === "int32" ? bits | 0 : bits;
        const within = row && raw >= Math.round(row.min / row.scale) && raw <= Math.round(row.max / row.scale);
        if (within) {
            this.raw.set(number, raw);
        }
        this.#answer(number, within ? 0 : 3);
    }
}

/** A master and such a drive on a bus without a bench. */
export class Pair {
    #time = 0;

    constructor(drive, peer) {
        Object.assign(this, { drive, peer });
    }

    /** Lets time pass until a promise settles. */
    async run(promise) {
        let settled = false;
        const end = () => {
            settled = true;
        };
        promise.then(end, end);
        for (let periods = 0; !settled && periods < 60_000; periods++) {
            this.step();
            await new Promise(setImmediate);
        }
        return promise;
    }

    step() {
        this.#time += 0.001;
        if (Math.round(this.#time * 1000) % 50 === 1) {
            this.peer.broadcast();
        }
        this.drive.poll(this.#time).forEach((frame) => this.peer.handle(frame));
        this.peer.take().forEach((frame) => this.drive.handleFrame(frame, this.#time));
    }
}
