// What was done to a bench, and when: a plain object that makes the same bits again, for a link, a file, or the way back in time.

import {
    Bench,
    Motor,
    type BenchOptions,
    type Frame,
    type InjectionName,
    type InjectionOptions,
    type InputName,
    type LoadOptions,
    type MotorName,
    type MotorOptions,
    type TxDriverOptions,
} from "./narx.js";

/** A call of a bench at the beginning of a control tick. */
export type Input = { readonly tick: number } & (
    | { readonly call: "start" | "setSpeed"; readonly rpm: number }
    | { readonly call: "stop" }
    | { readonly call: "send"; readonly id: number; readonly extended?: boolean; readonly remote?: boolean; readonly data: readonly number[] }
    | { readonly call: "inject"; readonly fault: InjectionName; readonly options?: InjectionOptions }
    | { readonly call: "clear"; readonly fault?: InjectionName; readonly options?: InjectionOptions }
    | { readonly call: "setLoad"; readonly load: LoadOptions }
    | { readonly call: "setInput"; readonly input: InputName; readonly value: number }
    | { readonly call: "addTxDriver"; readonly options: TxDriverOptions }
);

/** All that a bench's bits depend on. It survives `JSON.stringify`. */
export interface Script {
    readonly motor: MotorName | MotorOptions;
    readonly options: BenchOptions;
    /** In the order in which they were made. */
    readonly inputs: readonly Input[];
    /** Control ticks that were run. */
    readonly ticks: number;
}

/** Runs a script, or its first `until` control ticks: the bench as it was then, without the rows on the way. */
export function perform(script: Script, until = script.ticks): Bench {
    const motor = typeof script.motor === "string" ? Motor.preset(script.motor) : new Motor(script.motor);
    const bench = new Bench(motor, script.options);
    motor.free();
    for (const input of script.inputs) {
        if (input.tick > until) {
            break;
        }
        advance(bench, input.tick);
        apply(bench, input);
    }
    advance(bench, until);
    return bench;
}

/** Makes a call of a script. */
export function apply(bench: Bench, input: Input): void {
    switch (input.call) {
        case "start":
            return bench.start(input.rpm);
        case "setSpeed":
            return bench.setSpeed(input.rpm);
        case "stop":
            return bench.stop();
        case "send":
            return bench.send(frameOf(input));
        case "inject":
            return bench.inject(input.fault, input.options);
        case "clear":
            return bench.clear(input.fault, input.options);
        case "setLoad":
            return bench.setLoad(input.load);
        case "setInput":
            return bench.setInput(input.input, input.value);
        case "addTxDriver":
            return bench.addTxDriver(input.options);
    }
}

function frameOf({ id, extended, remote, data }: Input & { call: "send" }): Frame {
    return { id, extended: extended ?? true, remote: remote ?? false, data: Uint8Array.from(data) };
}

function advance(bench: Bench, tick: number): void {
    const left = tick - bench.ticks;
    if (left > 0) {
        bench.run(left / bench.tickRate, false).free();
    }
}

/** A bench whose calls are written down. */
export class Recorder {
    #bench: Bench;
    #script: { motor: MotorName | MotorOptions; options: BenchOptions; inputs: Input[] };

    /** Throws where the bench cannot be. */
    constructor(motor: MotorName | MotorOptions, options: BenchOptions) {
        this.#script = structuredClone({ motor, options, inputs: [] });
        this.#bench = perform({ ...this.#script, ticks: 0 });
    }

    /** The bench, to run it and to look at it. */
    get bench(): Bench {
        return this.#bench;
    }

    /** Makes a call now, and writes it down; one that throws leaves nothing. */
    do(input: Input extends infer One ? Omit<One, "tick"> : never): void {
        const timed = { ...input, tick: this.#bench.ticks } as Input;
        apply(this.#bench, timed);
        this.#script.inputs.push(timed);
    }

    /** What was done so far. */
    get script(): Script {
        return structuredClone({ ...this.#script, ticks: this.#bench.ticks });
    }

    /** Goes back to a control tick, and forgets what came later. */
    rewind(tick: number): void {
        const inputs = this.#script.inputs.filter((input) => input.tick <= tick);
        const bench = perform({ ...this.#script, inputs, ticks: tick });
        this.#bench.free();
        [this.#bench, this.#script.inputs] = [bench, inputs];
    }
}
