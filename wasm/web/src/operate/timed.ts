// A run in which one can go back.

export interface Timed {
    /** Whose time it is; default that of the run. */
    readonly label?: string;
    /** Times of the first instant and of the last, and the present one, s. */
    readonly begin: number;
    readonly end: number;
    readonly now: number;
    /** Step of the time, s; absent if any instant can be shown. */
    readonly tick?: number;
    readonly playing?: boolean;
    /** Names of the button that stops the time, and of the one that lets it go on; default "Pause" and "Run". */
    readonly names?: readonly [string, string];
    /** Seconds of the run in a second while it plays, and the choice of them with their names. */
    readonly pace?: number;
    readonly paces?: readonly (readonly [number, string])[];
    /** Steps that can be taken, in ticks. */
    readonly steps?: readonly { title: string; by: number }[];
    /** Consequence of running on from the present instant. */
    readonly note?: string;
    /** Goes to an instant, s. */
    seek(time: number): void;
    play?(playing: boolean): void;
    setPace?(pace: number): void;
    /** Goes some ticks on, or back if negative. */
    step?(ticks: number): void;
}
