// What lies between the page's master and a drive. Panels know only the master; the master's frames go through one of these.

import type { BusFrame, Frame } from "narx";

/** What a link tells whoever has opened it. */
export interface Listener {
    /** Time has come so far, s, and these frames have passed meanwhile, in order: those that were sent among them. */
    handle(time: number, frames: readonly BusFrame[]): void;
    /** Time goes on from an earlier instant: what was heard so far has not happened. These frames came just before it. */
    handleReturn(time: number, frames: readonly BusFrame[]): void;
    /** The link is gone; in words. */
    handleLoss(reason: string): void;
}

export interface Link {
    /** In words: "Virtual drive, bly172s-24v". */
    readonly name: string;
    /** The link's time now, s, which never runs back. */
    readonly now: number;
    /** Nothing can be sent. */
    readonly readOnly: boolean;
    send(frame: Frame): void;
    /** Lets go. Nothing is told after that. */
    close(): void;
}
