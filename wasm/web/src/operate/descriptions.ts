// Descriptions of drives that this browser has read, by build number and CRC.

import type { Descriptions } from "narx/drive";

const PREFIX = "narx-description-";

/** Descriptions in the browser's storage; if that is full or disabled, only as long as the page is open. */
class Kept implements Descriptions {
    #read = new Map<string, Uint8Array>();

    get(key: string): Uint8Array | undefined {
        const known = this.#read.get(key);
        if (known) {
            return known;
        }
        try {
            const text = localStorage.getItem(PREFIX + key);
            return text === null ? undefined : new TextEncoder().encode(text);
        } catch {
            return undefined;
        }
    }

    set(key: string, text: Uint8Array): void {
        this.#read.set(key, text);
        try {
            localStorage.setItem(PREFIX + key, new TextDecoder().decode(text));
        } catch {
            // It is downloaded again the next time.
        }
    }
}

export const descriptions = new Kept();
