// The page's one master on its link. Panels read `view` and call this; none of them knows what kind of link it is.

import { untrack } from "svelte";
import type { BusFrame } from "narx";
import { Drive, type DriveOptions } from "narx/drive";
import { descriptions } from "./descriptions";
import { chart } from "./heard.svelte";
import type { Link, Listener } from "./link/link";
import { nodes } from "./nodes.svelte";
import { trace } from "./trace.svelte";
import { NOTHING, look, setpointOf, type View } from "./view";

/** Time that a drive has to be heard, s. */
const BOOT = 1.5;
/** Frames that are heard at once after a return to an earlier instant. */
const PIECE = 20;

class Session {
    link = $state.raw<Link>();
    drive = $state.raw<Drive>();
    view = $state.raw<View>(NOTHING);
    options = $state.raw<DriveOptions>({});
    /** Why there is no link, or none any more. */
    problem = $state<string>();
    connecting = $state(false);
    #changed = false;
    /** The link's time when it was opened, s. */
    #opened = 0;
    #wasConnected = false;
    /** Ends what waits for a drive that is gone. */
    #gone: ((reason: Error) => void) | undefined;
    #over: Promise<never> = Promise.reject(new Error("there is no connection"));

    constructor() {
        this.#over.catch(() => undefined);
        // Whoever closes the page leaves no motor turning without a master.
        addEventListener("pagehide", () => this.#halt());
        requestAnimationFrame(() => this.#draw());
    }

    /** Nothing has come from the drive for longer than it takes to boot. */
    get unheard(): boolean {
        return this.link !== undefined && !this.view.connected && this.view.time > this.#opened + BOOT;
    }

    /** Whether this master can command: it is on a link that sends, and the drive is heard. */
    get commands(): boolean {
        return this.link !== undefined && !this.link.readOnly && this.options.silent !== true && this.view.connected;
    }

    /** Nobody has asked for a connection yet. */
    isFresh = true;

    /** Opens a link and puts a master on it; the one before is let go. `problem` tells what went wrong. */
    async connect(open: (listener: Listener) => Promise<Link>, options: DriveOptions): Promise<void> {
        this.isFresh = false;
        this.disconnect();
        this.connecting = true;
        this.problem = undefined;
        try {
            let drive = this.#begin(options);
            this.options = options;
            this.link = await open({
                handle: (time, frames) => this.#hear(drive, time, frames),
                handleReturn: (time, frames) => {
                    if (this.drive === drive) {
                        drive = this.#return(options, time, frames);
                    }
                },
                handleLoss: (reason) => this.#lose(drive, reason),
            });
            this.#opened = this.link.now;
        } catch (error) {
            this.drive = undefined;
            this.problem = words(error);
        } finally {
            this.connecting = false;
        }
    }

    /** Asks for Standby and lets the link go. */
    disconnect(): void {
        this.#halt();
        this.link?.close();
        this.#forget("the connection was closed meanwhile");
        this.link = undefined;
        this.drive = undefined;
        this.view = NOTHING;
    }

    /** Asks for a speed, rpm, negative in reverse; fails with the reason if the motor does not start. */
    start(rpm: number): Promise<void> {
        return this.run((drive) => drive.start(rpm));
    }

    setSpeed(rpm: number): void {
        this.drive?.setSpeed(rpm);
        this.pump();
    }

    /** Asks for Standby, which also acknowledges a fault. */
    stop(): void {
        this.drive?.stop();
        this.pump();
    }

    shutDown(): void {
        this.drive?.shutDown();
        this.pump();
    }

    /** What a task with the drive comes to; it fails when the connection goes. */
    async run<T>(task: (drive: Drive) => Promise<T>): Promise<T> {
        if (!this.drive || !this.link) {
            throw new Error("there is no connection");
        }
        const found = task(this.drive);
        this.pump();
        return Promise.race([found, this.#over]);
    }

    /** Sends what is due. Whoever asks for something in an effect does not depend on the link's time by that. */
    pump(): void {
        untrack(() => this.#send());
    }

    /** A master that has heard of nothing yet. */
    #begin(options: DriveOptions): Drive {
        const drive = new Drive({ ...options, descriptions });
        this.#over = new Promise((_, reject) => (this.#gone = reject));
        this.#over.catch(() => undefined);
        this.drive = drive;
        return drive;
    }

    /** A master at an earlier instant, who has heard what came just before it and goes on asking for the same speed. */
    #return(options: DriveOptions, time: number, frames: readonly BusFrame[]): Drive {
        this.#forget("time has returned to an earlier instant meanwhile");
        const drive = this.#begin(options);
        this.#opened = time;
        // Piece by piece, as it came: plots have a point for each.
        for (let at = 0; at < frames.length; at += PIECE) {
            const piece = frames.slice(at, at + PIECE);
            this.#hear(drive, piece[piece.length - 1].time, piece);
        }
        const rpm = setpointOf(drive.master);
        if (rpm !== 0) {
            drive.master.start(rpm);
        }
        this.pump();
        return drive;
    }

    /** What was heard, and what waits for an answer. */
    #forget(reason: string): void {
        this.#gone?.(new Error(reason));
        this.#wasConnected = false;
        trace.clear();
        chart.clear();
        nodes.clear();
    }

    #send(): void {
        const { link, drive } = this;
        if (!link || !drive) {
            return;
        }
        for (const frame of [...drive.poll(link.now), ...nodes.poll(link.now, !drive.downloads)]) {
            link.send(frame);
        }
        this.#changed = true;
    }

    #hear(drive: Drive, time: number, frames: readonly BusFrame[]): void {
        if (this.drive !== drive) {
            return;
        }
        trace.append(frames);
        for (const frame of frames) {
            if (!frame.sent) {
                drive.handleFrame(frame, frame.time);
                nodes.handleFrame(frame, frame.time);
            }
        }
        const { connected, speed } = drive.master;
        if (frames.length > 0 && connected && speed !== undefined) {
            chart.append({ time: [time], speed: [speed], setpoint: [setpointOf(drive.master)] });
        }
        if (this.#wasConnected && !connected) {
            // A drive that comes back must not begin to turn.
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

    /** The last frames before the link goes: Standby. */
    #halt(): void {
        if (this.link && !this.link.readOnly) {
            this.stop();
        }
    }

    #draw(): void {
        if (this.#changed && this.drive && this.link) {
            this.#changed = false;
            this.view = look(this.drive, this.link.now);
        }
        requestAnimationFrame(() => this.#draw());
    }
}

/** What an error says, as a sentence. */
export function words(error: unknown): string {
    const text = error instanceof Error ? error.message : String(error);
    return `${text.charAt(0).toUpperCase()}${text.slice(1)}${/[.!?]$/.test(text) ? "" : "."}`;
}

export const session = new Session();
