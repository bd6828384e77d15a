// Changes that are shown a few times a second, however often they happen.

/** Time between two updates, ms; a reader cannot follow faster ones. */
export const PERIOD = 40;

/** A dependency of effects that changes at most every `PERIOD`. */
export class Pulse {
    #version = $state(0);
    #timer: ReturnType<typeof setTimeout> | undefined;

    /** Makes the calling effect depend on it. */
    read(): void {
        void this.#version;
    }

    /** Runs the effects within `PERIOD`. */
    change(): void {
        this.#timer ??= setTimeout(() => {
            this.#timer = undefined;
            this.#version += 1;
        }, PERIOD);
    }
}
