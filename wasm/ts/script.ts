// Script of a bench: its calls with their ticks, as a plain object that gives the same bits again. It can be
// put into a link or a file, or be used to return to an earlier tick.

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
    | { readonly call: "stop" | "dismiss" }
    | { readonly call: "send"; readonly id: number; readonly extended?: boolean; readonly remote?: boolean; readonly data: readonly number[] }
    | { readonly call: "inject"; readonly fault: InjectionName; readonly options?: InjectionOptions }
    | { readonly call: "clear"; readonly fault?: InjectionName; readonly options?: InjectionOptions }
    | { readonly call: "setLoad"; readonly load: LoadOptions }
    | { readonly call: "setInput"; readonly input: InputName; readonly value: number }
    | { readonly call: "addTxDriver"; readonly options: TxDriverOptions }
);

/** A call without its tick. */
export type Call = Untimed<Input>;
/** Each of these inputs without its tick. */
export type Untimed<One> = One extends unknown ? Omit<One, "tick"> : never;

/** Everything that determines the bits of a bench. It can be passed through `JSON.stringify`. */
export interface Script {
    readonly motor: MotorName | MotorOptions;
    readonly options: BenchOptions;
    /** Calls, in the order in which they were made. */
    readonly inputs: readonly Input[];
    /** Number of control ticks that were run. */
    readonly ticks: number;
}

/** Runs a script, or its first `until` control ticks; returns the bench in its state then, without the rows
 * of the run. */
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
        case "dismiss":
            return bench.dismiss();
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

/** A bench whose calls are recorded as a script. */
export class Recorder {
    #bench: Bench;
    #script: { motor: MotorName | MotorOptions; options: BenchOptions; inputs: Input[] };

    /** Throws for invalid options. */
    constructor(motor: MotorName | MotorOptions, options: BenchOptions) {
        this.#script = structuredClone({ motor, options, inputs: [] });
        this.#bench = perform({ ...this.#script, ticks: 0 });
    }

    /** The bench, for runs and observation. */
    get bench(): Bench {
        return this.#bench;
    }

    /** Makes a call now, and records it; one that throws is not recorded. */
    do(call: Call): void {
        const timed = { ...call, tick: this.#bench.ticks } as Input;
        apply(this.#bench, timed);
        this.#script.inputs.push(timed);
    }

    /** Script of all calls so far. */
    get script(): Script {
        return structuredClone({ ...this.#script, ticks: this.#bench.ticks });
    }

    /** Goes back to a control tick, and removes later calls from the script. */
    rewind(tick: number): void {
        const inputs = this.#script.inputs.filter((input) => input.tick <= tick);
        const bench = perform({ ...this.#script, inputs, ticks: tick });
        this.#bench.free();
        [this.#bench, this.#script.inputs] = [bench, inputs];
    }
}
