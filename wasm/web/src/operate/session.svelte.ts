// The page's one master on its link. Panels read `view` and call this class; they do not depend on the kind
// of link.

import { untrack } from "svelte";
import type { BusFrame } from "narx";
import { Drive, type DriveOptions } from "narx/drive";
import { commissioned } from "./commissioned.svelte";
import { descriptions } from "./descriptions";
import { PERIOD } from "../plot/pulse.svelte";
import { recorder } from "./recorder.svelte";
import type { Link, Listener } from "./link/link";
import { nodes } from "./nodes.svelte";
import { turns } from "./states";
import { trace } from "./trace.svelte";
import { NOTHING, look, setpointOf, type View } from "./view";

/** Time in which a drive must be received, s. */
const BOOT = 1.5;
/** Number of frames that are processed at once after a return to an earlier instant. */
const PIECE = 20;

class Session {
    link = $state.raw<Link>();
    drive = $state.raw<Drive>();
    view = $state.raw<View>(NOTHING);
    options = $state.raw<DriveOptions>({});
    /** Reason why there is no link. */
    problem = $state<string>();
    connecting = $state(false);
    /** True if the drive was lost while its motor turned, until the next start. */
    interrupted = $state(false);
    /** True if another master has commanded this drive. */
    contested = $state(false);
    /** Identifiers of the frames that this master has sent. */
    readonly #sent = new Set<number>();
    #connection: object | undefined;
    #changed = false;
    /** Time of the last view, ms. */
    #drawn = 0;
    /** The link's time when it was opened, s. */
    #opened = 0;
    #wasConnected = false;
    /** Rejects the calls that wait for the present drive. */
    #gone: ((reason: Error) => void) | undefined;
    #over: Promise<never> = Promise.reject(new Error("no drive is connected"));

    constructor() {
        this.#over.catch(() => undefined);
        // Closing the page must not leave a motor running without a master.
        addEventListener("pagehide", () => this.#halt());
        addEventListener("beforeunload", (event) => this.commands && turns(this.view.state) && event.preventDefault());
        requestAnimationFrame(() => this.#draw());
    }

    /** True if no frame of the drive was received for longer than it takes to boot. */
    get silentDrive(): boolean {
        return this.link !== undefined && !this.view.connected && this.view.time > this.#opened + BOOT;
    }

    /** True if this master can command: its link can send, the drive is received, and its motor is not being
     * identified. */
    get commands(): boolean {
        return this.link !== undefined && !this.link.readOnly && this.options.silent !== true && this.view.connected && !this.view.identifies;
    }

    /** True if the drive is a virtual one of this page. */
    get isVirtual(): boolean {
        return this.link?.name.startsWith("Virtual") === true;
    }

    /** True until a connection was requested. */
    isFresh = true;

    /** Opens a link and puts a master on it; the previous link is closed. `problem` has the error. */
    async connect(open: (listener: Listener) => Promise<Link>, options: DriveOptions): Promise<void> {
        this.isFresh = false;
        this.disconnect();
        this.connecting = true;
        this.problem = undefined;
        try {
            this.#begin(options);
            this.options = options;
            const mine = (this.#connection = {});
            const present = (handle: (drive: Drive) => void) => {
                if (this.#connection === mine && this.drive) {
                    handle(this.drive);
                }
            };
            this.link = await open({
                handle: (time, frames) => present((drive) => this.#receive(drive, time, frames)),
                handleReturn: (time, frames) => present(() => this.#return(this.options, time, frames)),
                handleLoss: (reason) => present((drive) => this.#lose(drive, reason)),
            });
            this.#opened = this.link.now;
        } catch (error) {
            this.drive = undefined;
            this.problem = words(error);
        } finally {
            this.connecting = false;
        }
    }

    /** Changes options of the master on the present link. The drive with the old address gets the request for
     * Standby. */
    configure(options: DriveOptions): void {
        if (!this.link || this.link.readOnly) {
            return;
        }
        this.#halt();
        this.#forget("the addresses were changed");
        this.options = { ...this.options, ...options };
        this.#begin(this.options);
        this.#opened = this.link.now;
        trace.clear();
        commissioned.clear();
        this.pump();
    }

    /** Requests Standby and closes the link. */
    disconnect(): void {
        this.#halt();
        this.link?.close();
        this.#forget("the connection was closed");
        recorder.clear();
        trace.clear();
        commissioned.clear();
        this.interrupted = false;
        this.link = undefined;
        this.drive = undefined;
        this.view = NOTHING;
    }

    /** Requests a start at a speed, rpm, negative in reverse; rejects with the reason if the motor does not
     * start. */
    start(rpm: number): Promise<void> {
        this.interrupted = false;
        return this.run((drive) => drive.start(rpm));
    }

    setSpeed(rpm: number): void {
        this.drive?.setSpeed(rpm);
        this.pump();
    }

    /** Requests Standby, which also acknowledges a fault. */
    stop(): void {
        this.drive?.stop();
        this.pump();
    }

    shutDown(): void {
        this.drive?.shutDown();
        this.pump();
    }

    /** Returns the result of a task with the drive; rejects when the connection is closed. */
    async run<T>(task: (drive: Drive) => Promise<T>): Promise<T> {
        if (!this.drive || !this.link) {
            throw new Error("no drive is connected");
        }
        const found = task(this.drive);
        this.pump();
        return Promise.race([found, this.#over]);
    }

    /** Sends the frames that are due. It is untracked, so an effect that calls it does not depend on the
     * link's time. */
    pump(): void {
        untrack(() => this.#send());
    }

    /** Makes a master that has received nothing yet. */
    #begin(options: DriveOptions): Drive {
        const drive = new Drive({ ...options, descriptions });
        this.#over = new Promise((_, reject) => (this.#gone = reject));
        this.#over.catch(() => undefined);
        this.drive = drive;
        return drive;
    }

    /** Makes a master at an earlier instant. It receives the frames just before that, and continues to
     * request their set-point. */
    #return(options: DriveOptions, time: number, frames: readonly BusFrame[]): void {
        this.#forget("the simulated time has returned to an earlier instant");
        const drive = this.#begin(options);
        this.#opened = time;
        // In pieces, as the frames came, because plots get a point for each piece.
        const known = recorder.history.end >= time;
        trace.show(known ? time : (frames[0]?.time ?? time) - 1e-9);
        for (let at = 0; at < frames.length; at += PIECE) {
            const piece = frames.slice(at, at + PIECE);
            this.#receive(drive, piece[piece.length - 1].time, piece, !known);
        }
        recorder.tell(time);
        const rpm = setpointOf(drive.master);
        if (rpm !== 0) {
            drive.master.start(rpm);
        }
        this.pump();
    }

    /** Removes everything that was received, and rejects the calls that wait. */
    #forget(reason: string): void {
        this.#gone?.(new Error(reason));
        this.#wasConnected = this.contested = false;
        this.#sent.clear();
        nodes.clear();
    }

    #send(): void {
        const { link, drive } = this;
        if (!link || !drive) {
            return;
        }
        for (const frame of [...drive.poll(link.now), ...nodes.poll(link.now, !drive.downloads)]) {
            link.send(frame);
            this.#sent.add(frame.id);
        }
        this.#changed = true;
    }

    /** Takes frames; `records` is false for frames of an instant that was recorded before. */
    #receive(drive: Drive, time: number, frames: readonly BusFrame[], records = true): void {
        if (this.drive !== drive) {
            return;
        }
        if (records) {
            trace.append(frames);
        }
        for (const frame of frames) {
            if (!frame.sent) {
                this.contested ||= this.#sent.has(frame.id);
                drive.handleFrame(frame, frame.time);
                nodes.handleFrame(frame, frame.time);
            }
        }
        const { connected } = drive.master;
        recorder.tell(time);
        if (frames.length > 0 && records) {
            recorder.append(time, drive);
        }
        if (this.#wasConnected && !connected) {
            // A drive that comes back must not start to turn.
            this.interrupted ||= turns(this.view.state);
            drive.stop();
        }
        this.#wasConnected = connected;
        this.pump();
    }

    #lose(drive: Drive, reason: string): void {
        if (this.drive === drive) {
            this.disconnect();
            this.problem = reason;
        }
    }

    /** Sends Standby, in the last frames before the link is closed. */
    #halt(): void {
        if (this.link && !this.link.readOnly) {
            this.stop();
        }
    }

    #draw(): void {
        const now = performance.now();
        if (this.#changed && this.drive && this.link && now >= this.#drawn + PERIOD) {
            [this.#changed, this.#drawn] = [false, now];
            this.view = look(this.drive, this.link.now);
            recorder.describe(this.view.measurementSignals, this.view.parameters, this.isVirtual);
            commissioned.look(this.view, !this.isVirtual);
        }
        requestAnimationFrame(() => this.#draw());
    }
}

/** Returns the message of an error, as a sentence. */
export function words(error: unknown): string {
    const text = error instanceof Error ? error.message : String(error);
    return `${text.charAt(0).toUpperCase()}${text.slice(1)}${/[.!?]$/.test(text) ? "" : "."}`;
}

export const session = new Session();
