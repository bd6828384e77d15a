// Description of a drive, from the XML text that the drive itself serves. The tables of this package are used
// before it was read, and for a drive that serves none.

import type { Master, MeasurementSignal, Parameter, ScopeSignal } from "./core.js";
import type { Link } from "./link.js";

/** The tables of a drive. */
export interface Tables {
    readonly parameters: readonly Parameter[];
    readonly signals: readonly ScopeSignal[];
    readonly measurements: readonly MeasurementSignal[];
}

/** Storage of descriptions, by build number and CRC. */
export interface Descriptions {
    get(key: string): Uint8Array | undefined;
    set(key: string, text: Uint8Array): void;
}

/** Source of the tables: "own" are those of this package, before the drive's description was requested, and
 * for a drive without one. */
export type DescriptionState = "own" | "reading" | "read" | "refused";

/** Descriptions that were read since this program began. */
const KEPT: Descriptions = new Map<string, Uint8Array>();

export function tablesOf(master: Master): Tables {
    return { parameters: master.parameters(), signals: master.scopeSignals(), measurements: master.measurementSignals() };
}

/** Reads the description when the first frame of a drive is received, and again when it comes back, because it may then be
 * another drive. */
export class Describer {
    #link: Link;
    #kept: Descriptions;
    #asked = false;
    state: DescriptionState = "own";
    /** Reason why the description was refused. */
    problem: string | undefined;

    constructor(link: Link, kept: Descriptions = KEPT) {
        this.#link = link;
        this.#kept = kept;
    }

    /** Reads the description again at the next poll; a new image may have other tables. */
    forget(): void {
        this.#asked = false;
    }

    poll(): void {
        const { connected, silent } = this.#link.master;
        if (!connected) {
            this.#asked = false;
        } else if (!this.#asked && !silent) {
            this.#asked = true;
            void this.#read();
        }
    }

    async #read(): Promise<void> {
        this.#enter("reading");
        let tells = false;
        try {
            await this.#link.ask(() => this.#link.master.request("build info"));
            const text = await this.#text(() => (tells = true));
            this.#link.describe(text, this.#link.master.descriptionInfo?.check ?? 0);
            this.#enter("read");
        } catch (error) {
            this.#link.describe(undefined, 0);
            // A drive that does not even report a length has no description.
            this.#enter(tells ? "refused" : "own", error instanceof Error ? error.message : String(error));
        }
        // The master's reading in the background does not include parameters that only this drive has.
        const { master, tables } = this.#link;
        for (const { number } of tables.parameters) {
            if (master.parameter(number) === undefined && !this.#link.isOwn(number)) {
                await this.#link.ask(() => master.read(number)).catch(() => undefined);
            }
        }
    }

    /** Returns the stored description, or else downloads it. */
    async #text(tells: () => void): Promise<Uint8Array> {
        const { master } = this.#link;
        let found: Uint8Array | undefined;
        const key = () => `${master.build?.number ?? 0}-${(master.descriptionInfo?.check ?? 0).toString(16)}`;
        const known = () => (master.descriptionInfo?.check ? this.#kept.get(key()) : undefined);
        try {
            const text = await this.#link.download(
                () => master.download("description"),
                () => {
                    tells();
                    found = known();
                    if (found !== undefined) {
                        master.abortDownload();
                    }
                },
            );
            if (master.descriptionInfo?.check) {
                this.#kept.set(key(), text);
            }
            return text;
        } catch (error) {
            if (found !== undefined) {
                return found;
            }
            throw error;
        }
    }

    #enter(state: DescriptionState, problem?: string): void {
        [this.state, this.problem] = [state, state === "refused" ? problem : undefined];
    }
}
