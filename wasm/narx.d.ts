/// <reference lib="esnext.disposable" />
/* tslint:disable */
/* eslint-disable */

/** A classic CAN frame. */
export interface Frame {
    /** Identifier, 29 or 11 bits. */
    readonly id: number;
    /** True for an identifier of 29 bits, as all of the drive's have; default true. */
    readonly extended?: boolean;
    /** True for a remote frame; default false. */
    readonly remote?: boolean;
    /** Up to 8 bytes; of a remote frame as many zeros as it requests bytes. */
    readonly data: Uint8Array;
}



/** A frame that has passed on the bus of a bench. */
export interface BusFrame extends Frame {
    readonly extended: boolean;
    readonly remote: boolean;
    /** Time of its end, s since power-up. */
    readonly time: number;
    /** True if it was sent by `send`, or by the bench's operator. */
    readonly sent: boolean;
}

/** Arguments of a fault; `Bench.injections` says which it takes. */
export interface InjectionOptions {
    value?: number;
    /** Phase, leg or hall line. */
    phase?: "A" | "B" | "C";
    /** Level of a hall line; default false. */
    high?: boolean;
}

/** A fault that can be injected, and the options that it takes. */
export interface InjectionKind {
    readonly name: InjectionName;
    /** Its value; absent if it takes none. The example is one that a drive with factory parameters does not
     * tolerate. */
    readonly value?: { readonly unit: string; readonly min: number; readonly max: number; readonly example: number };
    readonly phase: boolean;
    readonly high: boolean;
}

/** An eddyCAN TX-Driver on the bus and the shaft of a bench. */
export interface TxDriverOptions {
    /** Node-id, 1 to 127. */
    nodeId: number;
    /** Number of sensors; default 1. */
    channels?: 1 | 2;
    /** Counts per revolution of an incremental encoder on the shaft, 1 to 65 535; default none. */
    encoder?: number;
    /** Measuring range, mm; default 2. */
    measuringRange?: number;
}

/** An input of the board that is read slowly. */
export interface Input {
    readonly name: InputName;
    readonly unit: string;
    readonly min: number;
    readonly max: number;
}



/** A load on the shaft. All torques oppose the motion; the constant one also acts at standstill. All default
 * to 0. */
export interface LoadOptions {
    /** Constant torque, N m. */
    constant?: number;
    /** Torque proportional to the speed, N m s/rad. */
    viscous?: number;
    /** Torque proportional to the square of the speed, N m s2/rad2. */
    quadratic?: number;
    /** Inertia, rigidly coupled, kg m2. */
    inertia?: number;
}

/** Set-up of a bench and its drive: a plain object. The same options and calls give the same bits. */
export interface BenchOptions {
    /** Supply voltage, V. */
    supplyVoltage: number;
    load?: LoadOptions;
    /** Control mode; default "hall". */
    mode?: Mode;
    /** Speed of the mode "open-loop", rpm; default the slowest closed-loop speed. */
    openLoopSpeed?: number;
    /** Delay of the hall sensors' edges, electrical degrees, unknown to commissioning. Default 0. */
    hallOffset?: number;
    /** Parameters of the drive by name or number, in their units; they override those of commissioning. */
    parameters?: Record<string | number, number>;
    /** Ambient temperature, degrees Celsius; default 25. */
    ambient?: number;
    /** Seed of all noise, a whole number; default 1. */
    seed?: number;
    /** PWM frequency of the drive's board, Hz, a whole number from 8000 to 50 000; default 10 000. Every
     * period has one control tick. */
    pwmRate?: number;
    /** True if the bench has an operator of its own, which carries out `start`, `setSpeed` and `stop`;
     * default true. Without it, the drive is commanded by the frames of `send`. */
    operator?: boolean;
    /** Keep every frame of the bus for `takeFrames`; default true if there is no operator. */
    frames?: boolean;
    /** Record for `recording` and `digest`; default true. */
    recording?: boolean;
}



/** Cause of the drive's stop. */
export interface Fault {
    /** Extended fault code. */
    readonly code: number;
    readonly meaning: string;
}

/** True values of an instant, which no drive can measure, and the state of the gates, for pictures. Arrays
 * are of phases A, B, C. */
export interface Observation {
    /** Time since power-up, s. */
    readonly time: number;
    /** Mechanical speed, rpm. */
    readonly speed: number;
    /** Mechanical angle of the shaft, rad, unwrapped. */
    readonly position: number;
    /** Electrical angle, degrees, 0 to 360; 0 is the rising zero crossing of phase A's back-EMF. */
    readonly angle: number;
    /** Phase currents into the motor, A. */
    readonly current: Float64Array;
    /** Terminal voltages against ground, V. */
    readonly voltage: Float64Array;
    /** Back-EMF against the star point, V. */
    readonly backEmf: Float64Array;
    /** Star point against ground, V. */
    readonly neutral: number;
    /** Bus voltage, V. */
    readonly busVoltage: number;
    /** Mean bus current of the last period, A. */
    readonly busCurrent: number;
    /** Mean torque of the last period, N m. */
    readonly torque: number;
    /** Conducting switch of each leg: 1 high, -1 low, 0 none. */
    readonly gates: Int8Array;
    /** Hall lines: bit 0 is A. */
    readonly hall: number;
    /** Pattern: 0 coast, 1 AB, 2 AC, 3 BC, 4 BA, 5 CA, 6 CB, more: rotor lock. */
    readonly step: number;
    /** Duty of this period, 0 to 1. */
    readonly duty: number;
}



/** Name and unit of a signal; the unit of a plain number is empty. */
export interface Signal {
    readonly name: SignalName;
    readonly unit: string;
}



/** Shape of the phase back-EMF against the rotor's angle. */
export type BackEmf = "trapezoidal" | "sinusoidal";

/** A star-connected three-phase motor with equal phases; resistance and inductance line to line, as data
 * sheets print them. */
export interface MotorOptions {
    /** Pole pairs, 1 to 255. */
    polePairs: number;
    /** Resistance line to line, ohm. */
    resistance: number;
    /** Inductance line to line, H. */
    inductance: number;
    /** Mean torque per DC ampere in ideal six-step, N m/A: 60 / (2 pi speed constant in rpm/V). */
    torqueConstant: number;
    /** Inertia of the rotor, kg m2. */
    inertia: number;
    /** Coulomb friction, N m; default 0. */
    staticFriction?: number;
    /** Viscous friction, N m s/rad; default 0. */
    viscousFriction?: number;
    /** Shape of the back-EMF; default "trapezoidal", with a flat top of 120 degrees. */
    backEmf?: BackEmf;
    /** Rated DC current, A, from which commissioning takes the current that the motor needs; default what
     * heats the winding by 6 W, at most 6 A. */
    ratedCurrent?: number;
}



/**
 * A drive with its motor on a simulated bench. The same options and calls give the same bits.
 */
export class Bench {
    free(): void;
    [Symbol.dispose](): void;
    /**
     * Powers up an eddyCAN TX-Driver on the drive's bus, in factory state. Its sensors measure the distance
     * of the shaft's surface, a quarter of a revolution apart.
     */
    addTxDriver(options: TxDriverOptions): void;
    /**
     * Removes one fault of `inject`, or all faults.
     */
    clear(fault?: InjectionName, options?: InjectionOptions): void;
    /**
     * Returns an independent copy of the bench in its present state, with motor, drive, bus and recording.
     * Keep copies to return to an instant; the digest then continues as it would have from there.
     */
    copy(): Bench;
    /**
     * Dismisses the operator: from here, the drive is commanded by the frames of `send`. Does nothing if
     * there is none.
     */
    dismiss(): void;
    /**
     * Injects a fault, until `clear`. A fault is a physical cause, not the fault bit that results from it.
     */
    inject(fault: InjectionName, options?: InjectionOptions): void;
    /**
     * Returns the faults that `inject` knows, and the options that each takes.
     */
    static injections(): InjectionKind[];
    /**
     * Returns the inputs of the board and their ranges.
     */
    static inputs(): Input[];
    /**
     * Returns the names of the control modes.
     */
    static modes(): Mode[];
    /**
     * Commissions the drive for the motor and powers it up; it stays in Standby until `start`. Throws for an
     * invalid option.
     */
    constructor(motor: Motor, options: BenchOptions);
    /**
     * Returns the true values of the present instant.
     */
    observe(): Observation;
    /**
     * Returns the recording of the drive since it last booted, for `replay` of `narx/lab` or a `.narxrec`
     * file. It is empty if nothing is recorded.
     */
    recording(): Uint8Array;
    /**
     * Runs the simulation for `seconds`, to the nearest control tick, and returns the rows since the
     * previous ones were taken, one for each tick. With `trace` false it keeps no rows, which is faster.
     */
    run(seconds: number, trace?: boolean | null): Trace;
    /**
     * Queues a frame at the host's place of the bus, with the present time. Throws a `RangeError` if 64
     * frames wait already.
     */
    send(frame: Frame): void;
    /**
     * Sets an input of the board to a value, in the unit of its measured quantity. Throws for a value that
     * the input cannot have.
     */
    setInput(input: InputName, value: number): void;
    /**
     * Replaces the load on the shaft; commissioning is not repeated.
     */
    setLoad(options: LoadOptions): void;
    /**
     * Requests another speed through the operator, rpm, in the direction of `start`.
     */
    setSpeed(rpm: number): void;
    /**
     * Returns the signals of every trace, and of `value`.
     */
    static signals(): Signal[];
    /**
     * Requests a speed through the operator, mechanical rpm, negative in reverse, and repeats it while time
     * runs. The request waits for the drive's self-tests.
     */
    start(rpm: number): void;
    /**
     * Runs this many control ticks, default one. The next `takeTrace` or `run` returns their rows.
     */
    step(ticks?: number | null): void;
    /**
     * Requests Standby through the operator, which also acknowledges a fault.
     */
    stop(): void;
    /**
     * Returns the frames that have passed on the bus since the previous call, including those that were
     * sent: at most the last 65 536. It returns none if frames are not kept.
     */
    takeFrames(): BusFrame[];
    /**
     * Returns the rows since the previous ones were taken.
     */
    takeTrace(): Trace;
    /**
     * Returns the present value of a signal.
     */
    value(name: SignalName): number;
    /**
     * Returns the present value of every signal, in the order of `signals()`.
     */
    values(): Float64Array;
    /**
     * Returns the digest of all outputs of the drive since it last booted, as in its recording: 16
     * lower-case hexadecimal digits.
     */
    readonly digest: string;
    /**
     * Cause of the drive's stop; `undefined` if it has not stopped.
     */
    readonly fault: Fault | undefined;
    /**
     * Names of the bits of the fault word that are set.
     */
    readonly faults: FaultName[];
    /**
     * Limits of the drive that restrict this motor, a sentence each.
     */
    readonly notes: string[];
    /**
     * Largest set-point that commissioning gave the drive, rpm.
     */
    readonly speedMax: number;
    /**
     * Smallest set-point that commissioning gave the drive, rpm.
     */
    readonly speedMin: number;
    /**
     * Name of the state in the specification.
     */
    readonly stateName: string;
    /**
     * State of the drive's state machine, 0 to 7.
     */
    readonly state: number;
    /**
     * Control ticks a second.
     */
    readonly tickRate: number;
    /**
     * Control ticks since power-up.
     */
    readonly ticks: number;
    /**
     * Time since power-up, s.
     */
    readonly time: number;
}

/**
 * A motor, for one or more benches.
 */
export class Motor {
    free(): void;
    [Symbol.dispose](): void;
    /**
     * Makes a motor from its data sheet. Throws for a missing or invalid value.
     */
    constructor(options: MotorOptions);
    /**
     * Returns a real motor by its name; `sim/src/presets/` has the source of every figure.
     */
    static preset(name: MotorName): Motor;
    /**
     * Returns the names of the real motors that `preset` knows.
     */
    static presets(): MotorName[];
    /**
     * Inductance line to line, H.
     */
    readonly inductance: number;
    /**
     * Inertia of the rotor, kg m2.
     */
    readonly inertia: number;
    /**
     * Maker of a preset.
     */
    readonly maker: string | undefined;
    /**
     * Nominal voltage of a preset, V.
     */
    readonly nominalVoltage: number | undefined;
    /**
     * Part or order number of a preset.
     */
    readonly part: string | undefined;
    /**
     * Pole pairs.
     */
    readonly polePairs: number;
    /**
     * Rated DC current, A.
     */
    readonly ratedCurrent: number | undefined;
    /**
     * Resistance line to line, ohm.
     */
    readonly resistance: number;
    /**
     * Coulomb friction, N m.
     */
    readonly staticFriction: number;
    /**
     * Mean torque per DC ampere in ideal six-step, N m/A.
     */
    readonly torqueConstant: number;
    /**
     * Viscous friction, N m s/rad.
     */
    readonly viscousFriction: number;
}

/**
 * Named signals, one row per control tick.
 */
export class Trace {
    private constructor();
    free(): void;
    [Symbol.dispose](): void;
    /**
     * Returns a copy of the values of one signal: 64 bits for time and counts, 32 for measured values.
     */
    column(name: SignalName): Float32Array | Float64Array;
    /**
     * Number of rows.
     */
    readonly length: number;
    /**
     * Returns the signals in the order of the columns of `run.csv`.
     */
    readonly signals: Signal[];
    /**
     * Time of each row since power-up, s.
     */
    readonly time: Float64Array;
}

export type InitInput = RequestInfo | URL | Response | BufferSource | WebAssembly.Module;

export interface InitOutput {
    readonly memory: WebAssembly.Memory;
    readonly __wbg_bench_free: (a: number, b: number) => void;
    readonly __wbg_motor_free: (a: number, b: number) => void;
    readonly __wbg_trace_free: (a: number, b: number) => void;
    readonly bench_addTxDriver: (a: number, b: any) => [number, number];
    readonly bench_clear: (a: number, b: any, c: any) => [number, number];
    readonly bench_copy: (a: number) => number;
    readonly bench_digest: (a: number) => [number, number];
    readonly bench_dismiss: (a: number) => void;
    readonly bench_fault: (a: number) => any;
    readonly bench_faults: (a: number) => [number, number];
    readonly bench_inject: (a: number, b: any, c: any) => [number, number];
    readonly bench_injections: () => any;
    readonly bench_inputs: () => any;
    readonly bench_modes: () => [number, number];
    readonly bench_new: (a: number, b: any) => [number, number, number];
    readonly bench_notes: (a: number) => [number, number];
    readonly bench_observe: (a: number) => any;
    readonly bench_recording: (a: number) => [number, number];
    readonly bench_run: (a: number, b: number, c: number) => [number, number, number];
    readonly bench_send: (a: number, b: any) => [number, number];
    readonly bench_setInput: (a: number, b: any, c: number) => [number, number];
    readonly bench_setLoad: (a: number, b: any) => [number, number];
    readonly bench_setSpeed: (a: number, b: number) => [number, number];
    readonly bench_signals: () => any;
    readonly bench_speedMax: (a: number) => number;
    readonly bench_speedMin: (a: number) => number;
    readonly bench_start: (a: number, b: number) => [number, number];
    readonly bench_state: (a: number) => number;
    readonly bench_stateName: (a: number) => [number, number];
    readonly bench_step: (a: number, b: number) => void;
    readonly bench_stop: (a: number) => [number, number];
    readonly bench_takeFrames: (a: number) => any;
    readonly bench_takeTrace: (a: number) => number;
    readonly bench_tickRate: (a: number) => number;
    readonly bench_ticks: (a: number) => number;
    readonly bench_time: (a: number) => number;
    readonly bench_value: (a: number, b: any) => [number, number, number];
    readonly bench_values: (a: number) => [number, number];
    readonly motor_inductance: (a: number) => number;
    readonly motor_inertia: (a: number) => number;
    readonly motor_maker: (a: number) => [number, number];
    readonly motor_new: (a: any) => [number, number, number];
    readonly motor_nominalVoltage: (a: number) => [number, number];
    readonly motor_part: (a: number) => [number, number];
    readonly motor_polePairs: (a: number) => number;
    readonly motor_preset: (a: any) => [number, number, number];
    readonly motor_presets: () => [number, number];
    readonly motor_ratedCurrent: (a: number) => [number, number];
    readonly motor_resistance: (a: number) => number;
    readonly motor_staticFriction: (a: number) => number;
    readonly motor_torqueConstant: (a: number) => number;
    readonly motor_viscousFriction: (a: number) => number;
    readonly trace_column: (a: number, b: any) => [number, number, number];
    readonly trace_length: (a: number) => number;
    readonly trace_signals: (a: number) => any;
    readonly trace_time: (a: number) => [number, number, number];
    readonly __wbindgen_malloc: (a: number, b: number) => number;
    readonly __wbindgen_realloc: (a: number, b: number, c: number, d: number) => number;
    readonly __wbindgen_free: (a: number, b: number, c: number) => void;
    readonly __wbindgen_exn_store: (a: number) => void;
    readonly __externref_table_alloc: () => number;
    readonly __wbindgen_externrefs: WebAssembly.Table;
    readonly __externref_table_dealloc: (a: number) => void;
    readonly __externref_drop_slice: (a: number, b: number) => void;
    readonly __wbindgen_start: () => void;
}

export type SyncInitInput = BufferSource | WebAssembly.Module;

/**
 * Instantiates the given `module`, which can either be bytes or
 * a precompiled `WebAssembly.Module`.
 *
 * @param {{ module: SyncInitInput }} module - Passing `SyncInitInput` directly is deprecated.
 *
 * @returns {InitOutput}
 */
export function initSync(module: { module: SyncInitInput } | SyncInitInput): InitOutput;

/**
 * If `module_or_path` is {RequestInfo} or {URL}, makes a request and
 * for everything else, calls `WebAssembly.instantiate` directly.
 *
 * @param {{ module_or_path: InitInput | Promise<InitInput> }} module_or_path - Passing `InitInput` directly is deprecated.
 *
 * @returns {Promise<InitOutput>}
 */
export default function __wbg_init (module_or_path?: { module_or_path: InitInput | Promise<InitInput> } | InitInput | Promise<InitInput>): Promise<InitOutput>;

/** Signals of a trace. */
export type SignalName =
    | "time"
    | "setpoint"
    | "speed"
    | "speed_estimated"
    | "state"
    | "sector"
    | "duty"
    | "current_a"
    | "current_b"
    | "current_c"
    | "bus_current"
    | "bus_voltage"
    | "torque"
    | "voltage_a"
    | "voltage_b"
    | "voltage_c"
    | "angle"
    | "hall"
    | "step"
    | "limiter"
    | "faults"
    | "position"
    | "energy_in"
    | "energy_shaft"
    | "winding_temperature"
    | "peak_current"
    | "crossing"
    | "crossing_margin";

/** Real motors. */
export type MotorName =
    | "ec45-flat-50w-18v"
    | "ec45-flat-50w-36v"
    | "ec45-flat-70w-36v"
    | "ec45-flat-70w-60v"
    | "ec90-flat-90w-24v"
    | "ec-max40-120w-48v"
    | "ec4pole30-200w-36v"
    | "ec-i40-100w-48v"
    | "4221g018bxth-18v"
    | "4221g024bxth-24v"
    | "bly172s-24v"
    | "bly171d-24v"
    | "qbl5704-36v"
    | "dma0204024b101-24v"
    | "bldc-1-25-058-201-24v"
    | "db42m03-24v"
    | "bm-180e-24v"
    | "am8112-0f21-48v";

/** Control modes. */
export type Mode =
    | "hall"
    | "sensorless"
    | "open-loop";

/** Bits of the fault word. */
export type FaultName =
    | "temperature_warning"
    | "over_temperature"
    | "over_voltage"
    | "under_voltage"
    | "over_current"
    | "legs_driver"
    | "hall_sensors"
    | "over_pressure"
    | "store_mismatch"
    | "emergency_shutdown"
    | "external_shutdown"
    | "device_timeout"
    | "store_absent"
    | "store_version";

/** Faults that can be injected. */
export type InjectionName =
    | "ambient"
    | "supply"
    | "leak"
    | "driver"
    | "open-phase"
    | "hall-stuck"
    | "hall-swapped"
    | "hall-glitches"
    | "hall-supply-lost"
    | "blocked-rotor"
    | "pressure"
    | "break"
    | "dsi1"
    | "dsi2";

/** Inputs of the board that are read slowly. */
export type InputName =
    | "asi"
    | "asi_source"
    | "accel_x"
    | "accel_y"
    | "accel_z"
    | "pressure"
    | "pressure_common_mode"
    | "rail6_v"
    | "rail14_v"
    | "accel_reference"
    | "reference"
    | "internal_temperature"
    | "external_temperature"
    | "dsio1"
    | "dsio2"
    | "hall_supply";
