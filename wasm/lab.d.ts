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



/** Addresses and nodes whose messages are decoded. */
export interface LogOptions {
    /** Address of the drive; default 170, `null` for any. */
    slave?: number | null;
    /** Address of its master; default 85, `null` for any. */
    monitor?: number | null;
    /** Node-ids of TX-Drivers whose PDOs of 8 bytes carry the encoder. */
    encoders?: readonly number[];
}

/** Every message of one kind: columns of the same length. */
export interface MessageTable {
    /** Name in the CAN database or in Table 3 of the eddyCAN specification. */
    readonly name: MessageName;
    /** True if a drive or node sends it, false if its master does. */
    readonly fromDevice: boolean;
    /** Time stamps, s. */
    readonly time: Float64Array;
    /** Values by signal, in its unit. Named values are numbers; NaN if a message does not carry the
     * signal. */
    readonly columns: Readonly<Record<string, Float64Array>>;
    /** Units by signal; empty for plain numbers. */
    readonly units: Readonly<Record<string, string>>;
    /** Names of a signal's numbers, by signal, for signals that have names. */
    readonly names: Readonly<Record<string, Readonly<Record<number, string>>>>;
}

/** A log as columns. Every line is a frame, blank, or an error. */
export interface CanLog {
    readonly lines: number;
    /** All frames. */
    readonly frames: {
        /** Time stamps, s. */
        readonly time: Float64Array;
        readonly id: Uint32Array;
        /** Bits: 1 29-bit identifier, 2 remote, 4 error frame, 8 CAN FD, 16 received. */
        readonly flags: Uint8Array;
        readonly dlc: Uint8Array;
        /** First 8 bytes of each frame, zeros behind the last one. */
        readonly data: Uint8Array;
        /** Index of the frame's table in `tables`; 255 unknown, 254 malformed, 253 an error frame. */
        readonly message: Uint8Array;
    };
    /** The tables that have rows. */
    readonly tables: readonly MessageTable[];
    /** Lines that are no frame. */
    readonly errors: readonly { readonly line: number; readonly text: string; readonly reason: string }[];
}



/** Name and unit of a signal; the unit of a plain number is empty. */
export interface Signal {
    readonly name: SignalName;
    readonly unit: string;
}



/** Result of a replay. Digests are 16 lower-case hexadecimal digits. */
export interface Replay {
    /** Number of ticks that were run. */
    readonly ticks: number;
    /** Digest of the outputs of this replay. */
    readonly digest: string;
    /** Digest of the outputs when they were recorded; absent for a prefix. */
    readonly recordedDigest?: string;
    /** Behaviour version of the recorder, if it differs from this version's: digests may then rightly
     * differ. */
    readonly otherBehaviour?: number;
    /** For a prefix: every output of its last tick, in one line of raw bits; absent if no tick was run. */
    readonly outputs?: string;
}

/** The scope's record of the inputs of every control tick, as a recording. */
export interface ScopeRecording {
    /** Bytes of the recording, for `replay` or a `.narxrec` file. */
    readonly recording: Uint8Array;
    /** Number of its first tick since the drive's power-up. */
    readonly firstTick: number;
    /** True if the replay's state equals the drive's own at the record's second checkpoint; absent if the
     * record has none. */
    readonly agrees?: boolean;
}



/** Settings of a `Pi`. Error and output have units of the caller's choice, within +-32 767. */
export interface PiOptions {
    /** Kp: output per error. */
    proportional: number;
    /** Ki: output per error and second. */
    integral: number;
    /** Steps a second; default 10 000. */
    stepRate?: number;
    minimum: number;
    maximum: number;
}

/** Settings of a `Ramp`. */
export interface RampOptions {
    /** Steepest change, a second. */
    rate: number;
    /** Steps a second; default 10 000. */
    stepRate?: number;
}

/** Settings of a `Hall`. */
export interface HallOptions {
    /** Ticks a second; default 10 000. */
    tickRate?: number;
    /** Permutation of the lines, 0 to 5 (parameter 262); default 0. */
    order?: number;
    /** Lines to invert, 0 to 7 (parameter 263); default 0. */
    polarity?: number;
    /** Offset of the edges beyond their place, electrical degrees (parameter 80); default 0. */
    offset?: number;
}

/** Reading of the hall sensors after a tick. */
export interface HallReading {
    /** Sector, 0 to 5: sector s spans 30 + 60 s to 90 + 60 s degrees; absent until the first valid code. */
    readonly sector?: number;
    /** Electrical angle, degrees, 0 to 360. */
    readonly angle: number;
    /** Electrical speed, rev/s, negative in reverse. */
    readonly speed: number;
    readonly invalid: boolean;
    readonly jump: boolean;
    readonly stopped: boolean;
    readonly doubtful: boolean;
}

/** Result of a commutation: the step of a period, and its changes within it. Steps are numbered as
 * `Observation.step`. */
export interface Pattern {
    readonly step: number;
    readonly changes: readonly { /** In periods. */ readonly instant: number; readonly step: number }[];
}



/** Settings of a `ZeroCrossing`. */
export interface ZeroCrossingOptions {
    /** Ticks a second, 1 000 to 100 000; default 10 000. */
    tickRate?: number;
    /** Scale of the converter to which voltages are rounded, V, up to 0.0625; default 0.019 531. */
    voltsPerCode?: number;
    /** Smallest signal, 1 to 255 codes; default 4. */
    noiseCodes?: number;
    /** Least time after a commutation, s (parameter 86); default 200e-6. */
    blanking?: number;
    /** Advance of the next commutation, electrical degrees, 0 to 30; default 0. */
    advance?: number;
    /** Line-to-line back-EMF, V a mechanical rpm (parameter 267); default 0: unknown. */
    backEmf?: number;
    /** Pole pairs, 1 to 100; default 1. */
    polePairs?: number;
    /** No crossing for this long is standstill, s (parameter 85); default 0.05. */
    timeout?: number;
}

/** Inputs of a `ZeroCrossing` for one period. */
export interface Terminals {
    /** Terminal voltages of A, B and C against ground, V. */
    phaseVoltage: readonly [number, number, number];
    /** Bus voltage, V. */
    busVoltage: number;
    /** Pattern that was in force in the period that has ended: the `Pattern` of the previous tick. */
    pattern: Pattern;
    /** True if sampled in the on-time, false in the off-time; default true. */
    onTime?: boolean;
    /** True for torque in reverse; default false. */
    reverse?: boolean;
}

/** Reading of the terminals after a tick. */
export interface ZeroCrossingReading {
    /** Age of a crossing that was seen in this tick: time from it to the present boundary, s; negative is
     * after the boundary. */
    readonly crossing?: number;
    /** Outcome of the last step's crossing. */
    readonly why: "none" | "accepted" | "filtered" | "blind" | "demag-late" | "listened";
    /** Lag of the last accepted crossing behind its prediction, electrical degrees. */
    readonly margin: number;
    /** Number of accepted crossings. */
    readonly accepted: number;
    /** Electrical angle, degrees, 0 to 360. */
    readonly angle: number;
    /** Electrical speed, rev/s, negative in reverse; 0 while unknown. */
    readonly speed: number;
    /** Time until the next commutation, s; absent while unknown. */
    readonly commutation?: number;
    /** Six consistent crossings were seen: the loop may be closed. */
    readonly running: boolean;
    /** Reason why the rotor was lost in this tick. */
    readonly lost?: "stall" | "desynchronised" | "wrong-lock";
}



/**
 * The commutation of the drive: steps of the bridge from a rotor's position.
 */
export class Commutation {
    free(): void;
    [Symbol.dispose](): void;
    /**
     * Makes a commutation that knows no rotor position yet. `advance`: timing advance, electrical degrees, 0
     * to 30; default 0. `tickRate`: default 10 000.
     */
    constructor(advance?: number | null, tickRate?: number | null);
    /**
     * Returns the step at the earliest instant of a period, and up to two changes later in it. `angle`:
     * electrical degrees at the period's boundary. `speed`: electrical rev/s, negative in reverse.
     * `reverse`: torque in reverse.
     */
    step(angle: number, speed: number, reverse?: boolean | null): Pattern;
}

/**
 * The hall sensors of the drive: sector, angle and speed from codes. Only the level is read, once a tick.
 */
export class Hall {
    free(): void;
    [Symbol.dispose](): void;
    /**
     * Makes a station that has not seen the sensors yet. Throws for a setting out of range.
     */
    constructor(options?: HallOptions);
    /**
     * Runs one tick. `code`: the lines now, bit 0 is A.
     */
    step(code: number): HallReading;
}

/**
 * A PI controller of the drive: u = Kp e + integral of Ki e dt, within its limits, bit for bit.
 */
export class Pi {
    free(): void;
    [Symbol.dispose](): void;
    /**
     * Sets the integrator so that it alone gives `output`.
     */
    hold(output: number): void;
    /**
     * Makes a controller at rest. Throws for a setting out of range.
     */
    constructor(options: PiOptions);
    /**
     * Returns the output for `error`.
     */
    step(error: number): number;
}

/**
 * A ramp of the drive: a value that approaches its target by at most a rate.
 */
export class Ramp {
    free(): void;
    [Symbol.dispose](): void;
    /**
     * Makes a ramp at 0. Throws for a setting out of range.
     */
    constructor(options: RampOptions);
    /**
     * Continues from `value`.
     */
    set(value: number): void;
    /**
     * Moves one step towards `target`; returns the new value.
     */
    step(target: number): number;
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

/**
 * The zero crossings of the drive: crossing, angle, speed and next commutation from the terminal voltages of
 * a driven or coasting motor. Align the rotor, call `start`, and commutate at the instants of the readings.
 */
export class ZeroCrossing {
    free(): void;
    [Symbol.dispose](): void;
    /**
     * Goes on by a step without any evidence: the rotor that is being brought up has not moved.
     */
    forceStep(): void;
    /**
     * Makes a station that has not seen the motor yet. Throws for a setting out of range.
     */
    constructor(options?: ZeroCrossingOptions);
    /**
     * Begins to bring up a rotor that rests at `angle`, electrical degrees.
     */
    start(angle: number, reverse?: boolean | null): void;
    /**
     * Runs one tick.
     */
    step(terminals: Terminals): ZeroCrossingReading;
}

/**
 * Decodes a log of can-utils (`candump -L`), given as text or bytes.
 */
export function readLog(text: string | Uint8Array, options?: LogOptions): CanLog;

/**
 * Replays a recording bit for bit: all of it, or its first `until` ticks.
 *
 * Throws an `Error` that names the first wrong byte of a damaged recording, and a `RangeError` for an
 * `until` that is not a number of ticks.
 */
export function replay(bytes: Uint8Array | number[], until?: number | null): Replay;

/**
 * Replays a recording, or its first `until` ticks, and returns its trace: inputs, outputs and internal
 * values of the drive. Its speeds are electrical, because a recording does not contain the pole pairs.
 * Throws as `replay` does.
 */
export function replayTrace(bytes: Uint8Array | number[], until?: number | null): Trace;

/**
 * Converts a scope's record of inputs, the bytes of the download, to a recording. Throws an `Error` for a
 * record of another version, or one that is damaged.
 */
export function scopeRecording(bytes: Uint8Array | number[], label: string): ScopeRecording;

export type InitInput = RequestInfo | URL | Response | BufferSource | WebAssembly.Module;

export interface InitOutput {
    readonly memory: WebAssembly.Memory;
    readonly __wbg_commutation_free: (a: number, b: number) => void;
    readonly __wbg_hall_free: (a: number, b: number) => void;
    readonly __wbg_pi_free: (a: number, b: number) => void;
    readonly __wbg_ramp_free: (a: number, b: number) => void;
    readonly __wbg_trace_free: (a: number, b: number) => void;
    readonly __wbg_zerocrossing_free: (a: number, b: number) => void;
    readonly commutation_new: (a: number, b: number, c: number, d: number) => [number, number, number];
    readonly commutation_step: (a: number, b: number, c: number, d: number) => [number, number, number];
    readonly hall_new: (a: any) => [number, number, number];
    readonly hall_step: (a: number, b: number) => [number, number, number];
    readonly pi_hold: (a: number, b: number) => [number, number];
    readonly pi_new: (a: any) => [number, number, number];
    readonly pi_step: (a: number, b: number) => [number, number, number];
    readonly ramp_new: (a: any) => [number, number, number];
    readonly ramp_set: (a: number, b: number) => [number, number];
    readonly ramp_step: (a: number, b: number) => [number, number, number];
    readonly readLog: (a: any, b: any) => [number, number, number];
    readonly replay: (a: number, b: number, c: number, d: number) => [number, number, number];
    readonly replayTrace: (a: number, b: number, c: number, d: number) => [number, number, number];
    readonly scopeRecording: (a: number, b: number, c: number, d: number) => [number, number, number];
    readonly trace_column: (a: number, b: any) => [number, number, number];
    readonly trace_length: (a: number) => number;
    readonly trace_signals: (a: number) => any;
    readonly trace_time: (a: number) => [number, number, number];
    readonly zerocrossing_forceStep: (a: number) => void;
    readonly zerocrossing_new: (a: any) => [number, number, number];
    readonly zerocrossing_start: (a: number, b: number, c: number) => [number, number];
    readonly zerocrossing_step: (a: number, b: any) => [number, number, number];
    readonly __wbindgen_malloc: (a: number, b: number) => number;
    readonly __wbindgen_realloc: (a: number, b: number, c: number, d: number) => number;
    readonly __wbindgen_free: (a: number, b: number, c: number) => void;
    readonly __wbindgen_exn_store: (a: number) => void;
    readonly __externref_table_alloc: () => number;
    readonly __wbindgen_externrefs: WebAssembly.Table;
    readonly __externref_table_dealloc: (a: number) => void;
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

/** Signals of the trace of a replay. */
export type SignalName =
    | "time"
    | "state"
    | "duty"
    | "hall"
    | "step"
    | "limiter"
    | "crossing"
    | "crossing_margin"
    | "bus_voltage_measured"
    | "bus_current_measured"
    | "voltage_a_measured"
    | "voltage_b_measured"
    | "voltage_c_measured"
    | "electrical_setpoint"
    | "electrical_speed_hall"
    | "electrical_speed_sensorless"
    | "faults";

/** Messages of the drive and of TX-Drivers. */
export type MessageName =
    | "BUILD_INFO_REQUEST"
    | "BUILD_INFO"
    | "DEVICE_INFO_REQUEST"
    | "DEVICE_INFO"
    | "REQUEST_WORD"
    | "STATUS_WORD"
    | "FAULT_WORD"
    | "CRITICAL_FAULT"
    | "REBOOT_SET"
    | "REBOOT"
    | "MOTOR_CMD_SET"
    | "MOTOR_CMD"
    | "DSIO_DATA_CMD"
    | "Disable_Hall_PS"
    | "PARAMETER_SET"
    | "PARAMETER_REQUEST"
    | "PARAMETER"
    | "LOG_VIRTUAL_SCOPE_SET"
    | "LOG_VIRTUAL_SCOPE_REQUEST"
    | "LOG_VIRTUAL_SCOPE"
    | "RESTORE_FACTORY_SETTING"
    | "XML_DOWNLOAD_REQUEST"
    | "XML_DOWNLOAD_ANSWER"
    | "XML_DOWNLOAD_DATA"
    | "EXT_MEM_LOG_READ_DATA"
    | "UPDATE_DEVICE_REQUEST"
    | "UPDATE_DEVICE"
    | "UPDATE_VERSION_REQUEST"
    | "UPDATE_VERSION"
    | "UPDATE_BEGIN"
    | "UPDATE_DATA"
    | "UPDATE_STATUS_REQUEST"
    | "UPDATE_STATUS"
    | "UPDATE_END"
    | "UPDATE_ABORT"
    | "UPDATE_CONFIRM"
    | "MEASUREMENT_0"
    | "MEASUREMENT_1"
    | "MEASUREMENT_2"
    | "MEASUREMENT_3"
    | "MEASUREMENT_4"
    | "MEASUREMENT_5"
    | "MEASUREMENT_7"
    | "MEASUREMENT_8"
    | "NMT"
    | "SYNC"
    | "Error"
    | "PDO1"
    | "PDO2"
    | "PDO3"
    | "PDO3 request"
    | "SDO answer"
    | "SDO request"
    | "Heartbeat";
