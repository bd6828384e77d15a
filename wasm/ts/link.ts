// A master, and the calls that wait for it. No call blocks, and there is no clock: the owner of a drive
// passes frames and times, and promises settle during those calls.

import { Identification, Master, parameters, type Chunk, type Frame, type IdentificationOptions, type IdentificationStage, type Identified, type JobName, type MasterError, type MasterOptions, type Progress, type RecordJobName, type RecordSetup, type UpdateProgress } from "./core.js";

import { tablesOf, type Tables } from "./description.js";

/** Returns an error with this `name`, as those of a master. */
export function failure(name: MasterError["name"], message: string): Error {
    return Object.assign(new Error(message), { name });
}

interface Question {
    readonly begin: () => void;
    readonly resolve: (value: number) => void;
    readonly reject: (error: unknown) => void;
}

interface Waiter {
    readonly done: () => boolean;
    /** Time at which the wait ends, s. */
    readonly until: number;
    readonly resolve: (done: boolean) => void;
}

interface Download {
    readonly begin: () => void;
    readonly progress: ((progress: Progress) => void) | undefined;
    readonly chunks: Chunk[];
    readonly resolve: (bytes: Uint8Array) => void;
    readonly reject: (error: unknown) => void;
    told: number;
}

interface Job {
    /** Name in an error. */
    readonly name: string;
    /** Returns whether the job has ended; throws its error. */
    readonly poll: () => boolean;
    readonly resolve: () => void;
    readonly reject: (error: unknown) => void;
}

interface Measuring {
    readonly identification: Identification;
    readonly progress: ((stage: IdentificationStage) => void) | undefined;
    readonly resolve: (found: Identified) => void;
    readonly reject: (error: unknown) => void;
    told: IdentificationStage | undefined;
}

interface Update {
    readonly progress: ((progress: UpdateProgress) => void) | undefined;
    readonly resolve: () => void;
    readonly reject: (error: unknown) => void;
    told: UpdateProgress | undefined;
}

/** Largest number of answers that the master keeps. */
const ANSWERS = 8;

/** Link to one drive. */
export class Link {
    readonly master: Master;
    #now = 0;
    #waiting: Question[] = [];
    #asked: Question[] = [];
    #waiters: Waiter[] = [];
    #downloads: Download[] = [];
    #download: Download | undefined;
    #update: Update | undefined;
    /** The identification under way, which owns the master's requests, jobs and downloads. */
    #measuring: Measuring | undefined;
    /** Jobs under way: of the motor, and of the scope or the log. */
    readonly #jobs = new Map<"motor" | "record", Job>();
    #tables: Tables;
    /** Numbers of the parameters in this package's own tables. */
    #own: ReadonlySet<number>;

    constructor(options: MasterOptions) {
        this.master = new Master(options);
        this.#tables = tablesOf(this.master);
        this.#own = new Set(parameters().map(({ number }) => number));
    }

    /** Tables of the drive, as known at present. */
    get tables(): Tables {
        return this.#tables;
    }

    /** Returns whether this package's own tables have a parameter. */
    isOwn(number: number): boolean {
        return this.#own.has(number);
    }

    /** Replaces the tables of the drive by those of its description, or without `text` by those of this
     * package. */
    describe(text: Uint8Array | undefined, check: number): void {
        this.master.describe(text, check);
        this.#tables = tablesOf(this.master);
    }

    /** Latest time that was passed in, s. */
    get now(): number {
        return this.#now;
    }

    /** True while a download is under way or waits for another one. */
    get downloads(): boolean {
        return this.#download !== undefined || this.#downloads.length > 0;
    }

    /** True while the motor is being identified. */
    get identifies(): boolean {
        return this.#measuring !== undefined;
    }

    /** True while a job of the scope or the log is under way. */
    get records(): boolean {
        return this.#jobs.has("record");
    }

    handleFrame(frame: Frame, now: number): void {
        this.#now = Math.max(this.#now, now);
        this.master.handleFrame(frame, this.#now);
        this.#settle();
    }

    poll(now: number): Frame[] {
        this.#now = Math.max(this.#now, now);
        this.#ask();
        const due = this.master.poll(this.#now);
        this.#settle();
        return due;
    }

    /** Throws for a master that transmits nothing: its commands would be lost without notice. */
    expectVoice(command: string): void {
        if (this.master.silent) {
            throw failure("RefusedError", `${command}: the master is silent`);
        }
    }

    /** Throws while the motor is being identified: nothing else may command the drive or ask it. */
    expectIdle(command: string): void {
        if (this.#measuring) {
            throw failure("RefusedError", `${command}: the motor is being identified; stop ends that`);
        }
    }

    /** Identifies the motor; `abortIdentification` ends it. It begins after the answers and the download that are waited for.
     * Rejects with the error that the options give, too, and with a "RefusedError" while a job or an update is under way. */
    identify(options: IdentificationOptions, progress?: (stage: IdentificationStage) => void): Promise<Identified> {
        return new Promise((resolve, reject) => {
            this.expectVoice("identify");
            this.expectIdle("identify");
            const [job] = this.#jobs.values();
            if (job !== undefined || this.#update !== undefined) {
                throw failure("RefusedError", `identify: the ${job?.name ?? "update"} is under way`);
            }
            this.#measuring = { identification: new Identification(options), progress, resolve, reject, told: undefined };
        });
    }

    /** A mark on the shaft passes: false if its turns are not counted now. */
    mark(): boolean {
        return this.#measuring?.identification.mark(this.master) ?? false;
    }

    /** Ends the identification that is under way: the motor stops, and the parameters get their former values. */
    abortIdentification(): void {
        this.#measuring?.identification.abort(this.master);
    }

    /** Begins a job of the motor, and waits for its end. One that is under way is rejected. */
    job(name: JobName, rpm?: number): Promise<void> {
        const { master } = this;
        return this.#carryOut("motor", name, () => master.begin(name, rpm), () => master.pollJob());
    }

    /** Begins a job of the scope or the log, and waits for its end. One that is under way is rejected; jobs of
     * the motor go on. */
    record(name: RecordJobName, setup?: RecordSetup, within = 0): Promise<void> {
        const { master } = this;
        const shown = name === "erase log" ? "erase of the log" : "scope's record";
        return this.#carryOut("record", shown, () => master.beginRecord(name, setup, within), () => master.pollRecord());
    }

    #carryOut(kind: "motor" | "record", name: string, begin: () => void, poll: () => boolean): Promise<void> {
        return new Promise((resolve, reject) => {
            this.expectIdle(name);
            begin();
            const error = kind === "motor" ? "StartError" : "RefusedError";
            const former = this.#jobs.get(kind);
            former?.reject(failure(error, `the ${former.name} was ended by another command`));
            this.#jobs.set(kind, { name, poll, resolve, reject });
        });
    }

    /** Makes a request of the master, and waits for its answer. Rejects with the error that `begin` throws,
     * too. */
    ask(begin: () => void): Promise<number> {
        return new Promise((resolve, reject) => {
            this.expectIdle("request");
            this.#waiting.push({ begin, resolve, reject });
        });
    }

    /** Waits until `done`, at most `seconds`; resolves to whether it was done. */
    wait(done: () => boolean, seconds: number): Promise<boolean> {
        return new Promise((resolve) => this.#waiters.push({ done, until: this.#now + seconds, resolve }));
    }

    /** Returns the bytes of a download; downloads run one after another. */
    download(begin: () => void, progress?: (progress: Progress) => void): Promise<Uint8Array> {
        return new Promise((resolve, reject) => {
            this.expectIdle("download");
            this.#downloads.push({ begin, progress, chunks: [], resolve, reject, told: -1 });
        });
    }

    /** Programs the drive with an image. Rejects with the error that the master throws at the beginning,
     * too. */
    update(image: Uint8Array, progress?: (progress: UpdateProgress) => void): Promise<void> {
        return new Promise((resolve, reject) => {
            this.expectIdle("update");
            this.master.update(image);
            this.#update = { progress, resolve, reject, told: undefined };
        });
    }

    #ask(): void {
        while (this.#asked.length < ANSWERS && this.#waiting.length > 0) {
            const question = this.#waiting.shift()!;
            try {
                question.begin();
                this.#asked.push(question);
            } catch (error) {
                question.reject(error);
            }
        }
        if (this.#download === undefined && this.#downloads.length > 0) {
            const download = this.#downloads.shift()!;
            try {
                download.begin();
                this.#download = download;
            } catch (error) {
                download.reject(error);
            }
        }
    }

    #settle(): void {
        if (this.#measuring && this.#asked.length === 0 && this.#waiting.length === 0 && !this.downloads) {
            this.#measure(this.#measuring);
        } else {
            this.#answer();
            this.#receive();
            this.#program();
            this.#work();
        }
        // A loop, not `filter`: Node 20 fails with "unreachable code" when it inlines functions that call
        // WebAssembly into `filter`.
        const waiting: Waiter[] = [];
        for (const waiter of this.#waiters.splice(0)) {
            const done = waiter.done();
            if (done || this.#now >= waiter.until) {
                waiter.resolve(done);
            } else {
                waiting.push(waiter);
            }
        }
        this.#waiters.unshift(...waiting);
    }

    #measure(measuring: Measuring): void {
        const { identification, progress } = measuring;
        try {
            const found = identification.step(this.master);
            const { stage } = identification;
            if (stage !== measuring.told) {
                measuring.told = stage;
                progress?.(stage);
            }
            if (found === undefined) {
                return;
            }
            measuring.resolve(found);
        } catch (error) {
            measuring.reject(error);
        }
        this.#measuring = undefined;
        identification.free();
    }

    #answer(): void {
        for (let answer = this.master.pollAnswer(); answer !== undefined; answer = this.master.pollAnswer()) {
            const question = this.#asked.shift();
            if (answer.error !== undefined) {
                question?.reject(answer.error);
            } else {
                question?.resolve(answer.value);
            }
        }
    }

    #receive(): void {
        const download = this.#download;
        if (download === undefined) {
            return;
        }
        const progress = this.master.downloadProgress;
        download.chunks.push(...this.master.pollChunks());
        if (progress !== undefined && progress.received !== download.told) {
            download.told = progress.received;
            download.progress?.(progress);
        }
        try {
            const words = this.master.pollDownload();
            if (words !== undefined) {
                this.#download = undefined;
                // The download ends with its last words; the master then reports no more progress.
                if (download.told !== words) {
                    download.progress?.({ received: words, total: words });
                }
                download.resolve(joined(download.chunks, words));
            }
        } catch (error) {
            this.#download = undefined;
            download.reject(error);
        }
    }

    #work(): void {
        for (const [kind, job] of this.#jobs) {
            try {
                if (job.poll()) {
                    this.#jobs.delete(kind);
                    job.resolve();
                }
            } catch (error) {
                this.#jobs.delete(kind);
                job.reject(error);
            }
        }
    }

    #program(): void {
        const update = this.#update;
        if (update === undefined) {
            return;
        }
        const now = this.master.updateProgress;
        if (now !== undefined && (now.stage !== update.told?.stage || now.done !== update.told.done)) {
            update.told = now;
            update.progress?.(now);
        }
        try {
            if (this.master.pollUpdate()) {
                this.#update = undefined;
                update.resolve();
            }
        } catch (error) {
            this.#update = undefined;
            update.reject(error);
        }
    }
}

function joined(chunks: Chunk[], words: number): Uint8Array {
    const bytes = new Uint8Array(2 * words);
    for (const chunk of chunks) {
        bytes.set(chunk.bytes, 2 * chunk.offset);
    }
    return bytes;
}
