// A table of recordings that were replayed.

import type { Replay } from "narx/lab";

export class Replays {
    #table: HTMLTableElement;

    constructor(table: HTMLTableElement) {
        this.#table = table;
    }

    found(name: string, { ticks, digest, recordedDigest, otherBehaviour }: Replay): void {
        const identical = digest === recordedDigest;
        const version = otherBehaviour === undefined ? "different" : `recorded by behaviour version ${otherBehaviour}`;
        this.#row([name, String(ticks), digest, recordedDigest ?? "", identical ? "identical" : version]);
    }

    refused(name: string, reason: string): void {
        this.#row([name, "", "", "", reason]);
    }

    #row(texts: string[]): void {
        const row = this.#table.tBodies[0].insertRow();
        for (const text of texts) {
            row.insertCell().textContent = text;
        }
        this.#table.hidden = false;
    }
}
