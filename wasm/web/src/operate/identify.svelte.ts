// The identification of the motor, and what was found. It continues when another panel is opened.

import type { MotorOptions } from "narx";
import type { IdentificationOptions, IdentificationStage, Identified } from "narx/core";
import { session, words } from "./session.svelte";
import { virtualDrive } from "./link/virtual.svelte";

const RESTORED = "The parameters have their former values.";
/** State of the drive after an end without figures, by the error's name. */
const LEFT: Partial<Record<string, string>> = { StartError: RESTORED, RefusedError: RESTORED, RangeError: RESTORED };
/** That after any other error, such as the loss of the connection. */
const UNKNOWN = "The drive may still have parameters of the identification: the device manager shows them as changed since commissioning.";

/** An identification that has ended with figures. */
export interface Result {
    found: Identified;
    /** Name of the link to its drive. */
    link: string;
    /** Figures of the data sheet, which a virtual motor has. */
    data: MotorOptions | undefined;
    /** True if the virtual motor had a load, which is part of what was measured. */
    loaded: boolean;
}

class Identify {
    busy = $state(false);
    stage = $state<IdentificationStage>();
    /** Marks of the shaft's turns so far. */
    marks = $state(0);
    /** The link's time at the begin, s. */
    begun = $state(0);
    /** Duration of the last one that has ended, s. */
    took = $state(0);
    result = $state.raw<Result>();
    /** Reason of an end without figures. */
    problem = $state<string>();

    constructor() {
        // A drive that is left alone keeps the parameters that the identification has written.
        addEventListener("beforeunload", (event) => this.busy && event.preventDefault());
    }

    /** A mark on the shaft passes. */
    mark(): void {
        this.marks += session.drive?.mark() ? 1 : 0;
    }

    /** Identifies the motor of the present drive; `result` or `problem` is the end. */
    async run(options: IdentificationOptions): Promise<void> {
        [this.busy, this.stage, this.marks, this.result, this.problem] = [true, "asking", 0, undefined, undefined];
        this.begun = session.view.time;
        const motor = session.isVirtual ? virtualDrive.opened?.setup.motor : undefined;
        const link = session.link?.name ?? "";
        const load = virtualDrive.opened?.setup.options.load;
        try {
            const found = await session.run((drive) => drive.identify(options, (stage) => (this.stage = stage)));
            const data = typeof motor === "string" ? virtualDrive.known?.motors.find(({ name }) => name === motor)?.data : motor;
            this.took = session.view.time - this.begun;
            this.result = { found, link, data, loaded: data !== undefined && Object.values(load ?? {}).some((figure) => figure !== 0) };
        } catch (error) {
            const left = error instanceof Error ? LEFT[error.name] : undefined;
            this.problem = `${words(error)} ${left ?? UNKNOWN}`;
        }
        [this.busy, this.stage] = [false, undefined];
    }
}

export const identify = new Identify();
