// Opened files, dropped anywhere on the page or chosen.

import type { Timed } from "../timed";
import type { Answer, Content, Request } from "./messages";

export interface Entry {
    key: number;
    name: string;
    bytes: Uint8Array;
    content?: Content;
    /** Reason why it could not be read. */
    reason?: string;
}

class Files {
    entries = $state.raw<readonly Entry[]>([]);
    /** Key of the shown file. */
    chosen = $state<number>();
    /** Time of the recording that is shown. */
    timed = $state.raw<Timed>();
    outputs = $state.raw<{ key: number; until: number; outputs: string }>();
    #next = 0;
    #worker: Worker | undefined;

    async open(files: Iterable<File>): Promise<void> {
        for (const file of files) {
            const entry: Entry = { key: this.#next, name: file.name, bytes: new Uint8Array(await file.arrayBuffer()) };
            this.#next += 1;
            this.entries = [...this.entries, entry];
            this.chosen = entry.key;
            this.#ask({ kind: "open", ...entry });
        }
    }

    /** Requests the drive's outputs in the tick before `until`. */
    step({ key, bytes }: Entry, until: number): void {
        this.#ask({ kind: "outputs", key, bytes, until });
    }

    close(key: number): void {
        this.entries = this.entries.filter((entry) => entry.key !== key);
        this.chosen = this.entries.at(-1)?.key;
    }

    #ask(request: Request): void {
        this.#worker ??= this.#start();
        this.#worker.postMessage(request);
    }

    #start(): Worker {
        const worker = new Worker(new URL("./worker.ts", import.meta.url), { type: "module" });
        worker.addEventListener("message", ({ data }: MessageEvent<Answer>) => this.#handle(data));
        return worker;
    }

    #handle(answer: Answer): void {
        if (answer.kind === "outputs") {
            this.outputs = answer;
            return;
        }
        const known = answer.kind === "opened" ? { content: answer.content } : { reason: answer.reason };
        this.entries = this.entries.map((entry) => (entry.key === answer.key ? { ...entry, ...known } : entry));
    }
}

export const files = new Files();
