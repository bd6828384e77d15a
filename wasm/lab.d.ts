/* tslint:disable */
/* eslint-disable */

/** A classic CAN frame. */
export interface Frame {
    /** Identifier, a number of 29 bits, or of 11. */
    readonly id: number;
    /** It has 29 bits, as all of the drive's have; default true. */
    readonly extended?: boolean;
    /** A remote frame; default false. */
    readonly remote?: boolean;
    /** Up to 8 bytes; of a remote frame as many zeros as it asks for. */
    readonly data: Uint8Array;
}



/** Name and unit of a signal; the unit of a plain number is empty. */
export interface Signal {
    readonly name: SignalName;
    readonly unit: string;
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
    /** Which permutation of the lines, 0 to 5 (parameter 262); default 0. */
    order?: number;
    /** Lines to invert, 0 to 7 (parameter 263); default 0. */
    polarity?: number;
    /** How far the edges lie beyond their place, electrical degrees (parameter 80); default 0. */
    offset?: number;
}

/** What hall sensors say after a tick. */
export interface HallReading {
    /** 0 to 5: sector s spans 30 + 60 s to 90 + 60 s degrees; absent until the first valid code. */
    readonly sector?: number;
    /** Electrical degrees, 0 to 360. */
    readonly angle: number;
    /** Electrical rev/s, negative in reverse. */
    readonly speed: number;
    readonly invalid: boolean;
    readonly jump: boolean;
    readonly stopped: boolean;
    readonly doubtful: boolean;
}

/** What a commutation answers: the step of a period, and its changes within it. Steps are numbered as `Observation.step`. */
export interface Pattern {
    readonly step: number;
    readonly changes: readonly { /** In periods. */ readonly instant: number; readonly step: number }[];
}



/** Settings of a `ZeroCrossing`. */
export interface ZeroCrossingOptions {
    /** Ticks a second, 1 000 to 100 000; default 10 000. */
    tickRate?: number;
    /** Of the converter that voltages are rounded to, V, up to 0.0625; default 0.019 531. */
    voltsPerCode?: number;
    /** Smallest signal, 1 to 255 codes; default 4. */
    noiseCodes?: number;
    /** Least time after a commutation, s (parameter 86); default 200e-6. */
    blanking?: number;
    /** Of the next commutation, electrical degrees, 0 to 30; default 0. */
    advance?: number;
    /** Line to line, V a mechanical rpm (parameter 267); default 0: not known. */
    backEmf?: number;
    /** 1 to 100; default 1. */
    polePairs?: number;
    /** No crossing for so long is standstill, s (parameter 85); default 0.05. */
    timeout?: number;
}

/** What a `ZeroCrossing` sees of a period. */
export interface Terminals {
    /** A, B and C against ground, V. */
    phaseVoltage: readonly [number, number, number];
    /** V. */
    busVoltage: number;
    /** The step that was in force in the period that has ended, and its changes: the `Pattern` of the tick before. */
    pattern: Pattern;
    /** Sampled in the on-time, else in the off-time; default true. */
    onTime?: boolean;
    /** Torque in reverse; default false. */
    reverse?: boolean;
}

/** What the terminals say after a tick. */
export interface ZeroCrossingReading {
    /** A crossing was seen: how long before the present boundary, s; negative is after it. */
    readonly crossing?: number;
    /** What became of the last step's crossing. */
    readonly why: "none" | "accepted" | "filtered" | "blind" | "demag-late" | "listened";
    /** How far the last accepted crossing lay behind its prediction, electrical degrees. */
    readonly margin: number;
    /** Crossings accepted. */
    readonly accepted: number;
    /** Electrical degrees, 0 to 360. */
    readonly angle: number;
    /** Electrical rev/s, negative in reverse; 0 while it is not known. */
    readonly speed: number;
    /** How long until the next commutation, s; absent while it is not known. */
    readonly commutation?: number;
    /** Six consistent crossings: the loop may be closed. */
    readonly running: boolean;
    /** The rotor was lost in this tick. */
    readonly lost?: "stall" | "desynchronised" | "wrong-lock";
}



/** What a replay found. Digests are 16 lower-case hexadecimal digits. */
export interface Replay {
    /** Ticks run. */
    readonly ticks: number;
    /** Digest of the outputs now. */
    readonly digest: string;
    /** Digest of the outputs when they were recorded; absent for a prefix. */
    readonly recordedDigest?: string;
    /** The recorder's behaviour version, where it is another one than ours: digests may then rightly differ. */
    readonly otherBehaviour?: number;
    /** For a prefix: every output of its last tick, in one line of raw bits; absent if no tick was run. */
    readonly outputs?: string;
}

/** What a scope has recorded of the inputs of every control tick. */
export interface ScopeRecording {
    /** What `replay` takes, and a `.narxrec` file holds. */
    readonly recording: Uint8Array;
    /** Number of its first tick since the drive's power-up. */
    readonly firstTick: number;
    /** Whether the replay came to what the drive did itself, from its second checkpoint on; absent where the record has none. */
    readonly agrees?: boolean;
}



/** Whose messages count. */
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
    /** As the CAN database or Table 3 of the eddyCAN specification has it. */
    readonly name: MessageName;
    /** A drive or node sends it, else its master. */
    readonly fromDevice: boolean;
    /** As stamped, s. */
    readonly time: Float64Array;
    /** By signal, in its unit; values with names as their numbers, NaN where a message does not carry it. */
    readonly columns: Readonly<Record<string, Float64Array>>;
    /** By signal; empty for plain numbers. */
    readonly units: Readonly<Record<string, string>>;
    /** By signal: the names of its numbers, where they have some. */
    readonly names: Readonly<Record<string, Readonly<Record<number, string>>>>;
}

/** A log as columns. Every line is a frame, blank, or an error. */
export interface CanLog {
    readonly lines: number;
    /** All frames. */
    readonly frames: {
        /** As stamped, s. */
        readonly time: Float64Array;
        readonly id: Uint32Array;
        /** Bits: 1 29-bit identifier, 2 remote, 4 error frame, 8 CAN FD, 16 received. */
        readonly flags: Uint8Array;
        readonly dlc: Uint8Array;
        /** The first 8 bytes of each, zeros behind the last one. */
        readonly data: Uint8Array;
        /** Place of its table in `tables`; 255 unknown, 254 malformed, 253 an error frame. */
        readonly message: Uint8Array;
    };
    /** The tables that have rows. */
    readonly tables: readonly MessageTable[];
    /** Lines that are no frame. */
    readonly errors: readonly { readonly line: number; readonly text: string; readonly reason: string }[];
}



/**
 * The commutation of the drive: a rotor's position to steps of the bridge.
 */
export class Commutation {
    free(): void;
    [Symbol.dispose](): void;
    /**
     * A commutation that has not seen a rotor. `advance`: electrical degrees ahead of its place, 0 to 30; default 0. `tickRate`: default 10 000.
     */
    constructor(advance?: number | null, tickRate?: number | null);
    /**
     * The step at the earliest instant of a period, and up to two changes later in it. `angle`: electrical degrees at the period's boundary. `speed`: electrical
     * rev/s, negative in reverse. `reverse`: torque in reverse.
     */
    step(angle: number, speed: number, reverse?: boolean | null): Pattern;
}

/**
 * The hall sensors of the drive: codes to sector, angle and speed. The level alone is looked at, once a tick.
 */
export class Hall {
    free(): void;
    [Symbol.dispose](): void;
    /**
     * Sensors of which nothing was seen. Throws for a setting out of range.
     */
    constructor(options?: HallOptions);
    /**
     * One tick. `code`: the lines now, bit 0 is A.
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
     * The integrator alone gives `output` from now on.
     */
    hold(output: number): void;
    /**
     * A controller at rest. Throws for a setting out of range.
     */
    constructor(options: PiOptions);
    /**
     * The output for `error`.
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
     * A ramp at 0. Throws for a setting out of range.
     */
    constructor(options: RampOptions);
    /**
     * Continues from `value`.
     */
    set(value: number): void;
    /**
     * One step towards `target`: where it is then.
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
     * The values of one signal: 64 bits for time and counts, 32 for what is measured. A copy.
     */
    column(name: SignalName): Float32Array | Float64Array;
    /**
     * Rows.
     */
    readonly length: number;
    /**
     * The signals in the order of the columns of `run.csv`.
     */
    readonly signals: Signal[];
    /**
     * Time of each row since power-up, s.
     */
    readonly time: Float64Array;
}

/**
 * The zero crossings of the drive: terminal voltages of a driven or coasting motor to crossing, angle, speed and the next commutation. Align the rotor,
 * `start`, and commutate as it says.
 */
export class ZeroCrossing {
    free(): void;
    [Symbol.dispose](): void;
    /**
     * On by a step without any evidence: the rotor that is being brought up has not moved.
     */
    forceStep(): void;
    /**
     * A motor that nothing has been seen of. Throws for a setting out of range.
     */
    constructor(options?: ZeroCrossingOptions);
    /**
     * The bridge is about to bring up a rotor that rests at `angle`, electrical degrees.
     */
    start(angle: number, reverse?: boolean | null): void;
    /**
     * One tick.
     */
    step(terminals: Terminals): ZeroCrossingReading;
}

/**
 * A log of can-utils (`candump -L`), decoded: text or its bytes.
 */
export function readLog(text: string | Uint8Array, options?: LogOptions): CanLog;

/**
 * Runs a recording again, bit for bit: all of it, or its first `until` ticks.
 *
 * Throws an `Error` that names the byte where a damaged recording is wrong, and a `RangeError` for an `until`
 * that is not a count of ticks.
 */
export function replay(bytes: Uint8Array | number[], until?: number | null): Replay;

/**
 * The trace of a recording that runs again, or of its first `until` ticks: what the drive was given, what it answered, and what it thought meanwhile. Its
 * speeds are electrical, because a recording does not tell the pole pairs. Throws as `replay`.
 */
export function replayTrace(bytes: Uint8Array | number[], until?: number | null): Trace;

/**
 * The recording that a scope's record of inputs is: the bytes of the download. Throws an `Error` for one of another version, or one that is damaged.
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
