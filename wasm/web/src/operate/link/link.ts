// Links between the page's master and a drive. Panels use only the master, whose frames pass through a link.

import type { BusFrame, Frame } from "narx";

/** Receiver of a link's events. */
export interface Listener {
    /** Called with the present time, s, and the frames that have passed since the previous call, in order,
     * sent ones included. */
    handle(time: number, frames: readonly BusFrame[]): void;
    /** Called when time continues from an earlier instant; everything received after it is void. `frames`
     * came just before it. */
    handleReturn(time: number, frames: readonly BusFrame[]): void;
    /** Called when the link is lost, with the reason in words. */
    handleLoss(reason: string): void;
}

export interface Link {
    /** Name in words, such as "Virtual drive, bly172s-24v". */
    readonly name: string;
    /** The link's present time, s, which never decreases. */
    readonly now: number;
    /** True if nothing can be sent. */
    readonly readOnly: boolean;
    send(frame: Frame): void;
    /** Closes the link. The listener is not called after that. */
    close(): void;
}
