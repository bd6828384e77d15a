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



/** A message of the drive or its master. Its name tells what is in it. */
export type DriveMessage = {
    [Name in keyof DriveValues]: {
        readonly protocol: "narmotion";
        /** As in the CAN database. */
        readonly name: Name;
        readonly opcode: number;
        /** Sent by a drive, else by its master. */
        readonly fromDrive: boolean;
        readonly source: number;
        readonly destination: number;
        /** By field: numbers in their units, names of what has names. */
        readonly values: DriveValues[Name];
        /** By field; empty for plain numbers. */
        readonly units: { readonly [Field in keyof DriveValues[Name]]: string };
    };
}[keyof DriveValues];

/** A message of a TX-Driver or its master (eddyCAN). */
export type NodeMessage = {
    [Name in keyof NodeValues]: {
        readonly protocol: "eddycan";
        /** As Table 3 of the specification prints it. */
        readonly name: Name;
        /** Sent by a node, else by its master. */
        readonly fromNode: boolean;
        /** By signal; what a PDO does not carry is not there. */
        readonly values: NodeValues[Name];
        readonly units: { readonly [Signal in keyof NodeValues[Name]]: string };
    };
}[keyof NodeValues];



/** An `Error` of a master by its `name`: nothing answers, the drive (or this master) does not do it now, a parameter cannot have the value, or an image is none for
 * this drive. */
export interface MasterError extends Error {
    readonly name: "NoAnswerError" | "RefusedError" | "ParameterError" | "ImageError";
}

/** The answer to a request: the value that a parameter has now, in its unit (0 for other requests), or why it was not done. */
export type Answer = { readonly value: number; readonly error?: undefined } | { readonly error: MasterError };

/** What a digital line is: an input, or an output of this level. */
export interface Outputs {
    /** `undefined`: an input. */
    dsio1?: boolean;
    dsio2?: boolean;
}



/** What a master must know of its TX-Driver. */
export interface TxMasterOptions {
    /** 1 to 127. */
    nodeId: number;
    /** Sensors of it; default 1. */
    channels?: 1 | 2;
    /** How long an answer may take, 0.003 to 10 s; default 0.1. */
    timeout?: number;
}

/** The last positions of a TX-Driver. */
export interface Reading {
    /** From the start of the measuring range, mm; of as many channels as it has. */
    readonly positions: readonly number[];
    /** Counts, of a linear encoder with their sign once 2005h was read; absent where PDOs do not carry the encoder. */
    readonly encoder?: number;
    /** Position of a linear encoder, mm: counts times resolution; absent before 2005h and 2009h were read, and of a rotary one. */
    readonly encoderPosition?: number;
    readonly trigger: "timer" | "sync" | "remote";
    /** When they came, s. */
    readonly time: number;
}

/** An entry of the object dictionary (eddyCAN specification, Table 4). Limits and factory value are in its unit. */
export interface TxObject {
    readonly index: number;
    readonly subindex: number;
    readonly name: string;
    readonly unit: string;
    /** Value of a raw 1. */
    readonly scale: number;
    readonly min: number;
    readonly max: number;
    readonly factory: number;
    readonly access: string;
    readonly acts: "at once" | "after a restart";
    readonly description: string;
}

/** The raw value that was read or written, or why not; `abort` is the code of a node that refuses. */
export type TxAnswer =
| { readonly value: number; readonly error?: undefined }
| { readonly error: MasterError; readonly abort?: number };



/** What an image says of itself. */
export interface ImageInfo {
    /** Hardware id. */
    readonly hardware: number;
    /** Name of the board that has it; absent for one that this version does not know. */
    readonly board?: string;
    /** MAJOR.MINOR.PATCH+BUILD. */
    readonly version: string;
    /** Bytes. */
    readonly length: number;
}

/** How far an update is. */
export interface UpdateProgress {
    readonly stage: UpdateStage;
    /** Bytes of the stage that are done: erased, received or verified. */
    readonly done: number;
    /** Length of the image, bytes. */
    readonly total: number;
}



/** What there is to know of one parameter but its value. Limits and factory value are in its unit. */
export interface Parameter {
    readonly number: number;
    readonly name: ParameterName;
    readonly category: string;
    /** Empty for plain numbers. */
    readonly unit: string;
    readonly type: "uint16" | "int32" | "uint32";
    /** Value of a raw 1. */
    readonly scale: number;
    readonly min: number;
    readonly max: number;
    readonly factory: number;
    /** Who may write it: nobody, a master while the drive is stopped, or at any time. */
    readonly access: "read-only" | "stopped" | "live";
    /** Writing 0, then 1 is a command. */
    readonly command: boolean;
    /** When a written value acts. */
    readonly acts: "at once" | "next start" | "reboot";
    readonly description: string;
}

/** A signal of the virtual scope. */
export interface ScopeSignal {
    /** Its bit in parameter 22. */
    readonly bit: number;
    readonly name: ScopeSignalName;
    readonly unit: string;
    /** Value of a sample of 4096. */
    readonly base: number;
}

/** A signal of the broadcast measurements. */
export interface MeasurementSignal {
    readonly name: MeasurementName;
    readonly unit: string;
    readonly opcode: number;
    /** Place in its frame, 0 to 3. */
    readonly word: number;
    /** Value of a raw 1. */
    readonly scale: number;
}

/** A record of the log as it was downloaded. */
export interface LogRecord {
    readonly index: number;
    /** Since power-up, s. */
    readonly time: number;
    /** What each value is (the slot's number, and what is kept of it in bits 15 and 14), and its raw number. */
    readonly values: readonly (readonly [what: number, raw: number])[];
}



/** Whom a master talks to, and how. */
export interface MasterOptions {
    /** Address of the drive, 0 to 255; default 170. */
    slave?: number;
    /** Address of the master, 0 to 255; default 85. */
    monitor?: number;
    /** Between two set-points, 0.001 to 10 s; default 0.05. */
    setpointPeriod?: number;
    /** Transmits nothing and hears everything; default false. */
    silent?: boolean;
    /** Reads every parameter in the background when the drive is first heard, and after what changes many of them; default true. */
    readParameters?: boolean;
    /** How long an answer may take, 0.001 to 10 s; default 0.1. */
    timeout?: number;
}

/** A measurement that was heard. */
export interface Measurement {
    readonly name: MeasurementName;
    readonly unit: string;
    readonly value: number;
    /** When, s. */
    readonly time: number;
}

/** CRITICAL_FAULT as it was last heard. */
export interface CriticalFault {
    readonly faults: FaultName[];
    /** Extended fault code. */
    readonly code: number;
    /** What that means; absent for a code of another firmware. */
    readonly meaning?: string;
}

/** BUILD_INFO. */
export interface BuildInfo {
    readonly number: number;
    /** Built from sources that were not committed. */
    readonly modified: boolean;
    /** YYYYMMDD. */
    readonly date: number;
}

/** What the drive tells of its description before that is downloaded. */
export interface DescriptionInfo {
    readonly words: number;
    /** CRC-32 of the words; 0 from a drive that does not tell it. */
    readonly check: number;
}

/** Set-points that the drive takes as they are, in the control mode that its enables select: magnitudes, rpm. It clamps every other one. */
export interface SpeedLimits {
    readonly min: number;
    readonly max: number;
    /** The drive turns at one speed whatever is asked for: open loop at parameter 88. */
    readonly fixed: boolean;
}

/** DEVICE_INFO. */
export interface DeviceInfo {
    /** Release of the board. */
    readonly hardware: number;
    /** Release of the firmware, major.minor. */
    readonly software: string;
    /** Serial number. */
    readonly deviceNumber: number;
    readonly address: number;
}

/** Words of a download. */
export interface Chunk {
    /** Place of the first one in the download, words. */
    readonly offset: number;
    /** High byte first. */
    readonly bytes: Uint8Array;
}

/** How far a download is, words. */
export interface Progress {
    readonly received: number;
    readonly total: number;
}



/**
 * The other end of a drive's bus: it has no clock and no bus of its own. Times are seconds from any beginning and never run back. Give it every frame that
 * arrives, and send what `poll` has, at `nextPoll` at the latest. `narx/drive` waits for its answers.
 */
export class Master {
    free(): void;
    [Symbol.dispose](): void;
    /**
     * Ends the download.
     */
    abortDownload(): void;
    /**
     * Ends the update. An image that is swapped in already is not confirmed then, and its drive goes back.
     */
    abortUpdate(): void;
    /**
     * Throws a `RangeError` for a set-point, rpm, negative in reverse, that the drive would clamp, as far as its limits were heard. It names the limit's parameter and the range.
     */
    checkSpeed(rpm: number): void;
    /**
     * From now on the drive is what its description says, the bytes of its download; without one it is this package's own. `check`: the CRC-32 that the drive tells
     * of it. Throws for a text that cannot be read, and has the tables of before then.
     */
    describe(text?: Uint8Array | number[] | null, check?: number | null): void;
    /**
     * Begins a download: "description", "scope" with `count` words, "log" with `count` records from `first` on. Throws for a silent master, and while
     * another one goes on.
     */
    download(what: "description" | "scope" | "log", count?: number | null, first?: number | null): void;
    /**
     * Takes a frame that arrived at `now`, s. Only messages of its drive to this master are heard.
     */
    handleFrame(frame: Frame, now: number): void;
    /**
     * Signals of the drive's measurements in the order of its description.
     */
    measurementSignals(): MeasurementSignal[];
    /**
     * What the drive measures, as far as it was heard, in the order of Figure 14.
     */
    measurements(): Measurement[];
    /**
     * A master that has heard of nothing yet. Throws where an option cannot be.
     */
    constructor(options?: MasterOptions);
    /**
     * When to poll again at the latest if nothing arrives and nothing is asked for until then, s; infinity without a reason.
     */
    nextPoll(now: number): number;
    /**
     * Value of a parameter as it was last heard, in its unit; `undefined` before.
     */
    parameter(key: ParameterName | number): number | undefined;
    /**
     * Every parameter of the drive in the order of its description.
     */
    parameters(): Parameter[];
    /**
     * The next answer; `undefined` before it is there.
     */
    pollAnswer(): Answer | undefined;
    /**
     * Words that have come since the last call. Words may come more than once, each time the same.
     */
    pollChunks(): Chunk[];
    /**
     * The end of the download, once all its chunks were taken: its length in words. Throws a `MasterError` for one that came to nothing.
     */
    pollDownload(): number | undefined;
    /**
     * The next frame that is due at `now`, s.
     */
    pollFrame(now: number): Frame | undefined;
    /**
     * Whether the update has come to its end: the drive runs the image now and keeps it. Throws a `MasterError` for one that came to nothing; what ran before then
     * still runs.
     */
    pollUpdate(): boolean;
    /**
     * Every frame that is due at `now`, s.
     */
    poll(now: number): Frame[];
    /**
     * Reads every parameter anew in the background.
     */
    readParameters(): void;
    /**
     * Asks for a parameter's value.
     */
    read(key: ParameterName | number): void;
    /**
     * Asks the drive for something. Answers come in the order of the requests. Throws a `MasterError` for a silent master, and while eight answers were not
     * taken.
     */
    request(what: RequestName): void;
    /**
     * Asks for factory values of everything but what is the board's own. `serial`: parameter 1 of the board that is meant.
     */
    restoreFactory(serial: number): void;
    /**
     * Signals of the drive's scope in the order of its description.
     */
    scopeSignals(): ScopeSignal[];
    /**
     * Asks for the digital lines to be inputs, or outputs of a level.
     */
    setOutputs(outputs: Outputs): void;
    /**
     * Asks for another speed in the same direction, rpm.
     */
    setSpeed(rpm: number): void;
    /**
     * Asks for a shutdown: fault bit 28.
     */
    shutDown(): void;
    /**
     * Asks for a speed, mechanical rpm, negative in reverse. A drive takes a start once it has seen Standby: `stop` first.
     */
    start(rpm: number): void;
    /**
     * Asks for Standby, which also acknowledges a fault.
     */
    stop(): void;
    /**
     * Begins to program the drive with an image, the bytes of a `.narximg` file. Blocks are then among what `poll` has. Throws a `MasterError` for what is no
     * whole image, for a silent master, and while another update goes on.
     */
    update(image: Uint8Array | number[]): void;
    /**
     * Asks the drive to give a parameter a value, in its unit, to the nearest step of its scale. Throws a `RangeError` for one that it cannot have: outside the range,
     * not a number, a fraction of a whole parameter.
     */
    write(key: ParameterName | number, value: number): void;
    /**
     * The set-point that the drive has accepted, rpm.
     */
    readonly acceptedSpeed: number | undefined;
    /**
     * Whether the last request was for a turning motor.
     */
    readonly asksToTurn: boolean;
    /**
     * BUILD_INFO as it was last heard.
     */
    readonly build: BuildInfo | undefined;
    /**
     * Whether the drive was heard lately.
     */
    readonly connected: boolean;
    /**
     * CRITICAL_FAULT as it was last heard. Whether it still holds, `faults` says.
     */
    readonly critical: CriticalFault | undefined;
    /**
     * What the drive tells of its description, as it was last heard.
     */
    readonly descriptionInfo: DescriptionInfo | undefined;
    /**
     * DEVICE_INFO as it was last heard.
     */
    readonly device: DeviceInfo | undefined;
    /**
     * How far the download is; `undefined` before its length is known, and without one.
     */
    readonly downloadProgress: Progress | undefined;
    /**
     * Names of the set bits of FAULT_WORD; `undefined` before it was heard.
     */
    readonly faults: FaultName[] | undefined;
    /**
     * When anything was last heard of the drive, s.
     */
    readonly lastHeard: number | undefined;
    /**
     * Parameters that are still to be read in the background.
     */
    readonly parametersToRead: number;
    /**
     * From one set-point to the next, s.
     */
    readonly setpointPeriod: number;
    /**
     * Magnitude of the set-point, rpm.
     */
    readonly setpoint: number;
    /**
     * Transmits nothing.
     */
    readonly silent: boolean;
    /**
     * Set-points that the drive takes as they are; `undefined` before those of `speedParameters` that say so were heard.
     */
    readonly speedLimits: SpeedLimits | undefined;
    /**
     * Mechanical speed by what the control mode uses, rpm.
     */
    readonly speed: number | undefined;
    /**
     * Name of the state in the specification.
     */
    readonly stateName: StateName | undefined;
    /**
     * State of the drive, 0 to 7; `undefined` while it is not known.
     */
    readonly state: number | undefined;
    /**
     * STATUS_WORD as it was last heard (Table 8).
     */
    readonly status: DriveValues["STATUS_WORD"] | undefined;
    /**
     * How far the update is; `undefined` without one.
     */
    readonly updateProgress: UpdateProgress | undefined;
}

/**
 * Frames out of the bytes that come from an slcan adapter. Everything else that it says is counted or left.
 */
export class SlcanLines {
    free(): void;
    [Symbol.dispose](): void;
    /**
     * Takes bytes as they arrived, and returns the frames that are complete with them.
     */
    handleBytes(bytes: Uint8Array | number[]): Frame[];
    /**
     * Before the first byte.
     */
    constructor();
    /**
     * How often the adapter has said no.
     */
    readonly refusals: number;
}

/**
 * The other end of a TX-Driver's bus. Times are seconds from any beginning and never run back.
 */
export class TxMaster {
    free(): void;
    [Symbol.dispose](): void;
    /**
     * Asks for PDO3.
     */
    askPositions(): void;
    /**
     * Commands the node (NMT).
     */
    command(command: "start" | "stop" | "pre-operational" | "reset"): void;
    /**
     * Takes a frame that arrived at `now`, s. Only messages of its node are heard.
     */
    handleFrame(frame: Frame, now: number): void;
    /**
     * A master that sends nothing until it is asked for something.
     */
    constructor(options: TxMasterOptions);
    /**
     * When to poll again at the latest, s; infinity without a reason.
     */
    nextPoll(now: number): number;
    /**
     * The next answer; `undefined` before it is there.
     */
    pollAnswer(): TxAnswer | undefined;
    /**
     * Every frame that is due at `now`, s.
     */
    poll(now: number): Frame[];
    /**
     * Reads an entry, or writes a raw value to it.
     */
    request(index: number, subindex: number, value?: number | null): void;
    /**
     * Sends a SYNC: every node samples and sends PDO2.
     */
    sync(): void;
    /**
     * Boot-up messages.
     */
    readonly boots: number;
    /**
     * Error messages.
     */
    readonly errors: number;
    /**
     * What the last error message meant (Table 13).
     */
    readonly lastError: string | undefined;
    /**
     * Frames of the node that mean nothing: most likely PDOs of another layout.
     */
    readonly malformed: number;
    /**
     * Whether the node was heard lately.
     */
    readonly present: boolean;
    /**
     * The last positions, if some have come since the node booted.
     */
    readonly reading: Reading | undefined;
    /**
     * The state of the last heartbeat.
     */
    readonly state: "boot-up" | "stopped" | "operational" | "pre-operational" | undefined;
}

/**
 * What closes an adapter.
 */
export function closeSlcan(): Uint8Array;

/**
 * The message in a frame, by the tables of PROTOCOL.md: of the drive with 29 bits, of TX-Drivers with 11; `undefined` if neither protocol has such a
 * frame. `encoder`: PDOs of 8 bytes have the encoder in them, which they do not tell themselves.
 */
export function decode(frame: Frame, encoder?: boolean | null): DriveMessage | NodeMessage | undefined;

/**
 * A frame as an adapter takes it.
 */
export function encodeSlcan(frame: Frame): Uint8Array;

/**
 * What an image (the bytes of a `.narximg` file) says of itself. Throws a `MasterError` for what is no whole image.
 */
export function imageInfo(image: Uint8Array | number[]): ImageInfo;

/**
 * The records of a log download, each of `size` bytes (parameter 69); those that the drive could not read are left out.
 */
export function logRecords(bytes: Uint8Array | number[], size: number): LogRecord[];

/**
 * Signals of the measurements in the order of Figure 14.
 */
export function measurementSignals(): MeasurementSignal[];

/**
 * What opens an adapter at so many bit/s (default 500 000, those of the drive): it is closed before, whatever it was told.
 */
export function openSlcan(bitrate?: number | null, listen?: boolean | null): Uint8Array;

/**
 * Every parameter in the order of the numbers.
 */
export function parameters(): Parameter[];

/**
 * Signals of the virtual scope in the order of their bits.
 */
export function scopeSignals(): ScopeSignal[];

/**
 * Numbers of the parameters that decide about `speedLimits`.
 */
export function speedParameters(): Uint16Array;

/**
 * The object dictionary in order.
 */
export function txObjects(): TxObject[];

export type InitInput = RequestInfo | URL | Response | BufferSource | WebAssembly.Module;

export interface InitOutput {
    readonly memory: WebAssembly.Memory;
    readonly __wbg_master_free: (a: number, b: number) => void;
    readonly __wbg_slcanlines_free: (a: number, b: number) => void;
    readonly __wbg_txmaster_free: (a: number, b: number) => void;
    readonly closeSlcan: () => [number, number];
    readonly decode: (a: any, b: number) => [number, number, number];
    readonly encodeSlcan: (a: any) => [number, number, number, number];
    readonly imageInfo: (a: number, b: number) => [number, number, number];
    readonly logRecords: (a: number, b: number, c: number) => any;
    readonly master_abortDownload: (a: number) => void;
    readonly master_abortUpdate: (a: number) => void;
    readonly master_acceptedSpeed: (a: number) => number;
    readonly master_asksToTurn: (a: number) => number;
    readonly master_build: (a: number) => any;
    readonly master_checkSpeed: (a: number, b: number) => [number, number];
    readonly master_connected: (a: number) => number;
    readonly master_critical: (a: number) => any;
    readonly master_describe: (a: number, b: number, c: number, d: number) => [number, number];
    readonly master_descriptionInfo: (a: number) => any;
    readonly master_device: (a: number) => any;
    readonly master_download: (a: number, b: any, c: number, d: number) => [number, number];
    readonly master_downloadProgress: (a: number) => any;
    readonly master_faults: (a: number) => any;
    readonly master_handleFrame: (a: number, b: any, c: number) => [number, number];
    readonly master_lastHeard: (a: number) => [number, number];
    readonly master_measurementSignals: (a: number) => any;
    readonly master_measurements: (a: number) => any;
    readonly master_new: (a: any) => [number, number, number];
    readonly master_nextPoll: (a: number, b: number) => number;
    readonly master_parameter: (a: number, b: any) => [number, number, number, number];
    readonly master_parameters: (a: number) => any;
    readonly master_parametersToRead: (a: number) => number;
    readonly master_poll: (a: number, b: number) => any;
    readonly master_pollAnswer: (a: number) => any;
    readonly master_pollChunks: (a: number) => any;
    readonly master_pollDownload: (a: number) => [number, number, number];
    readonly master_pollFrame: (a: number, b: number) => any;
    readonly master_pollUpdate: (a: number) => [number, number, number];
    readonly master_read: (a: number, b: any) => [number, number];
    readonly master_readParameters: (a: number) => void;
    readonly master_request: (a: number, b: any) => [number, number];
    readonly master_restoreFactory: (a: number, b: number) => [number, number];
    readonly master_scopeSignals: (a: number) => any;
    readonly master_setOutputs: (a: number, b: any) => [number, number];
    readonly master_setSpeed: (a: number, b: number) => [number, number];
    readonly master_setpoint: (a: number) => number;
    readonly master_setpointPeriod: (a: number) => number;
    readonly master_shutDown: (a: number) => void;
    readonly master_silent: (a: number) => number;
    readonly master_speed: (a: number) => number;
    readonly master_speedLimits: (a: number) => any;
    readonly master_start: (a: number, b: number) => [number, number];
    readonly master_state: (a: number) => number;
    readonly master_stateName: (a: number) => [number, number];
    readonly master_status: (a: number) => any;
    readonly master_stop: (a: number) => void;
    readonly master_update: (a: number, b: number, c: number) => [number, number];
    readonly master_updateProgress: (a: number) => any;
    readonly master_write: (a: number, b: any, c: number) => [number, number];
    readonly measurementSignals: () => any;
    readonly openSlcan: (a: number, b: number, c: number) => [number, number, number, number];
    readonly parameters: () => any;
    readonly scopeSignals: () => any;
    readonly slcanlines_handleBytes: (a: number, b: number, c: number) => any;
    readonly slcanlines_new: () => number;
    readonly slcanlines_refusals: (a: number) => number;
    readonly speedParameters: () => [number, number];
    readonly txObjects: () => any;
    readonly txmaster_askPositions: (a: number) => [number, number];
    readonly txmaster_boots: (a: number) => number;
    readonly txmaster_command: (a: number, b: any) => [number, number];
    readonly txmaster_errors: (a: number) => number;
    readonly txmaster_handleFrame: (a: number, b: any, c: number) => [number, number];
    readonly txmaster_lastError: (a: number) => [number, number];
    readonly txmaster_malformed: (a: number) => number;
    readonly txmaster_new: (a: any) => [number, number, number];
    readonly txmaster_nextPoll: (a: number, b: number) => number;
    readonly txmaster_poll: (a: number, b: number) => any;
    readonly txmaster_pollAnswer: (a: number) => any;
    readonly txmaster_present: (a: number) => number;
    readonly txmaster_reading: (a: number) => any;
    readonly txmaster_request: (a: number, b: number, c: number, d: number) => [number, number];
    readonly txmaster_state: (a: number) => [number, number];
    readonly txmaster_sync: (a: number) => [number, number];
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

/** States of the drive, 0 to 7. */
export type StateName =
    | "Initialization"
    | "Standby"
    | "Rotor lock"
    | "Open-loop"
    | "Sensorless Closed-loop"
    | "Closed-loop Hall Effect Sensors"
    | "Fault"
    | "Sensorless Auto-Restart";

/** Requests without a value. */
export type RequestName =
    | "build info"
    | "device info"
    | "description info"
    | "reboot"
    | "trigger scope"
    | "disable hall supply"
    | "enable hall supply"
    | "set position"
    | "erase log"
    | "store"
    | "store once"
    | "reset calibration"
    | "auto-calibrate"
    | "calibrate hall";

/** What an update is about. */
export type UpdateStage =
    | "asking"
    | "erasing"
    | "sending"
    | "verifying"
    | "restarting";

/** Parameters of the drive. */
export type ParameterName =
    | "Memory Mapping Flag"
    | "Device Number"
    | "Slave CAN address"
    | "Master CAN address"
    | "Hardware Release"
    | "Build number"
    | "Software Release"
    | "Source modified"
    | "Temperature measurement source selection"
    | "Accel use ref for scaling selection"
    | "Accel X calib offset"
    | "Accel Y calib offset"
    | "Accel Z calib offset"
    | "HV current calib offset"
    | "HV voltage calib offset"
    | "Temperature calib offset"
    | "Mechanical position calibration value"
    | "Set position calibration value (rising edge)"
    | "Pressure calib offset"
    | "Pressure calib gain"
    | "Pressure meas offset"
    | "Pressure meas gain"
    | "Virtual Scop Channels Selection"
    | "Virtual Scop Samples Number"
    | "Virtual Scop Sampling Prescaler"
    | "Virtual Scop Sampling Time"
    | "Virtual Scop Trig phase"
    | "01 - Logging start index"
    | "02 - Logging package index"
    | "03 - Logging slot"
    | "04 - Logging slot"
    | "05 - Logging slot"
    | "06 - Logging slot"
    | "07 - Logging slot"
    | "08 - Logging slot"
    | "09 - Logging slot"
    | "10 - Logging slot"
    | "11 - Logging slot"
    | "12 - Logging slot"
    | "13 - Logging slot"
    | "14 - Logging slot"
    | "15 - Logging slot"
    | "16 - Logging slot"
    | "17 - Logging slot"
    | "18 - Logging slot"
    | "19 - Logging slot"
    | "20 - Logging slot"
    | "21 - Logging slot"
    | "22 - Logging slot"
    | "23 - Logging slot"
    | "24 - Logging slot"
    | "25 - Logging slot"
    | "26 - Logging slot"
    | "27 - Logging slot"
    | "28 - Logging slot"
    | "29 - Logging slot"
    | "30 - Logging slot"
    | "31 - Logging slot"
    | "32 - Logging slot"
    | "33 - Logging slot"
    | "34 - Logging slot"
    | "35 - Logging slot"
    | "36 - Logging slot"
    | "37 - Logging slot"
    | "38 - Logging slot"
    | "39 - Logging slot"
    | "40 - Logging end index"
    | "Logging read start index"
    | "Logging read number of indexes"
    | "Logging data size bytes"
    | "Logging data max index"
    | "Logging data write index"
    | "Logging period"
    | "Logging data subsectors number"
    | "Logging data ongoing subsector erase index"
    | "Logging read request"
    | "Logging erase request"
    | "Logging memory full flag"
    | "Motor pair poles"
    | "Select control sequence for standard motor"
    | "Hall effect offset angle"
    | "Open-loop enable"
    | "Closed-loop Sensorless enable"
    | "Closed-loop Hall Effect Sensors enable"
    | "Closed-Loop initial duty cycle"
    | "Max period between two ZC events"
    | "N periods to discard after a sector change"
    | "Open-Loop duty cycle"
    | "Open-loop speed setpoint"
    | "Rotor lock duty cycle"
    | "Speed Ki coefficient SL"
    | "Speed Kp coefficient SL"
    | "Speed Ki coefficient HES"
    | "Speed Kp coefficient HES"
    | "HV current Kp coefficient"
    | "HV current Ki coefficient"
    | "Max HV current setpoint rate"
    | "Hall Effect Sensors PS enable"
    | "Max duty cycle SL"
    | "Speed setpoint rate"
    | "ZC delay compensation"
    | "Speed setpoint max saturation SL"
    | "Speed setpoint min saturation SL"
    | "Speed setpoint max saturation HES"
    | "Speed setpoint min saturation HES"
    | "Max HV current limitation soft start"
    | "Max HV current limitation"
    | "Max duty cycle"
    | "Open-Loop phase duration"
    | "Open-Loop ramp rising time"
    | "Rotor lock phase duration"
    | "can_autosend_period"
    | "Fault state wait time before acknowledgement"
    | "Electrical period measurement time-out"
    | "Can TimeOut period"
    | "Critical fault mask"
    | "Over-current HV threshold"
    | "Over-pressure threshold"
    | "Over-temperature shutdown threshold"
    | "Over-voltage HV threshold"
    | "Under-voltage HV threshold"
    | "Over-temperature warning threshold"
    | "Store parameters"
    | "Store once parameters"
    | "Reset calibration parameters"
    | "Auto-calibrate"
    | "Scope state"
    | "Drive state"
    | "Hall order"
    | "Hall polarity mask"
    | "Hall calibration request"
    | "Hall stall time"
    | "Nominal supply voltage"
    | "Back-EMF constant"
    | "Winding resistance"
    | "Phase current limit"
    | "Digital shutdown input"
    | "Duty slew limit"
    | "Minimum on-time"
    | "Timing advance"
    | "Refused frames"
    | "Malformed frames"
    | "Start refusal"
    | "Hall invalid codes"
    | "Hall jumps"
    | "Hall calibration state"
    | "Active limiter"
    | "Hall interpolation speed"
    | "Extended fault code"
    | "Winding inductance"
    | "Frames lost"
    | "Rejected parameter"
    | "ZC falling delay difference"
    | "Last zero crossing"
    | "Zero crossing margin"
    | "Zero crossings"
    | "Scope trigger"
    | "Scope trigger signal"
    | "Scope trigger level"
    | "Bus error state"
    | "Transmit error counter"
    | "Receive error counter"
    | "Bus-offs"
    | "Accel meas offset"
    | "Tilt"
    | "Vibration"
    | "Scope inputs"
    | "Scope words"
    | "Reset cause"
    | "Failed self-tests"
    | "Diagnostics"
    | "Scope room"
    | "Scope refusal"
    | "Automatic store";

/** Signals of the measurements. */
export type MeasurementName =
    | "Accel X"
    | "Accel Y"
    | "Accel Z"
    | "DSI1_DSP"
    | "Mechanical estimated speed SL"
    | "Mechanical position"
    | "Electrical input Power"
    | "HV Voltage"
    | "HV Current"
    | "+6V_MEAS"
    | "Driver 14V Voltage"
    | "Ambient Temperature"
    | "Vref Accel (+1.8V)"
    | "+0.383VREF"
    | "ASI_DSP"
    | "VoltagePhaseA"
    | "VoltagePhaseB"
    | "VoltagePhaseC"
    | "PIN_MEAS"
    | "Mechanical estimated speed HES"
    | "DSI2_DSP";

/** Signals of the virtual scope. */
export type ScopeSignalName =
    | "Speed set-point"
    | "Mechanical estimated speed SL"
    | "Mechanical estimated speed HES"
    | "HV Voltage"
    | "HV Current"
    | "Electrical input Power"
    | "VoltagePhaseA"
    | "VoltagePhaseB"
    | "VoltagePhaseC"
    | "Duty"
    | "Electrical angle"
    | "Drive state"
    | "Active limiter"
    | "Step"
    | "Hall code"
    | "Last zero crossing"
    | "Zero crossing margin"
    | "Speed loop voltage"
    | "Phase current"
    | "HV Current of one period"
    | "Fault bit"
    | "Digital inputs"
    | "Mechanical position";

/** What is in the drive's messages, by their names in the CAN database. */
export interface DriveValues {
    readonly BUILD_INFO_REQUEST: {};
    readonly BUILD_INFO: {
        readonly "Build number": number;
        readonly "Source modified": "no" | "yes" | number;
        readonly "Build date": number;
    };
    readonly DEVICE_INFO_REQUEST: {};
    readonly DEVICE_INFO: {
        readonly "Hardware release": number;
        readonly "Software release": number;
        readonly "Device number": number;
        readonly "CAN address": number;
    };
    readonly REQUEST_WORD: {
        readonly "Motor mode": "Standby" | "Drive" | "Reverse" | "Fault" | number;
    };
    readonly STATUS_WORD: {
        readonly "Log erase possible": "no" | "yes";
        readonly "Log download possible": "no" | "yes";
        readonly "Log memory erased": "no" | "yes";
        readonly "Log memory full": "no" | "yes";
        readonly "Logging state": "LOG_BOOT_UP" | "LOG_INIT" | "LOG_WRITE_WAIT_PER" | "LOG_WRITE" | "LOG_READ_REQ_INIT" | "LOG_SEND_READ_REQ" | "LOG_WAIT_READ_RESULT" | "LOG_READ_SEND_CAN_FRAMES" | "LOG_ERASE_ONGOING" | "LOG_ERASE_END" | "LOG_READ_END" | number;
        readonly "Control mode": "Off" | "Open loop" | "Sensorless closed loop" | "Hall closed loop" | number;
        readonly "Motor mode": "Standby" | "Drive" | "Reverse" | "Fault" | number;
    };
    readonly FAULT_WORD: {
        readonly "Faults": FaultName[];
    };
    readonly CRITICAL_FAULT: {
        readonly "Faults": FaultName[];
        readonly "Extended fault code": number;
    };
    readonly REBOOT_SET: {};
    readonly REBOOT: {
        readonly "Acknowledged": "no" | "yes" | number;
    };
    readonly MOTOR_CMD_SET: {
        readonly "Speed": number;
    };
    readonly MOTOR_CMD: {
        readonly "Speed": number;
    };
    readonly DSIO_DATA_CMD: {
        readonly "DSIO1 output enable": "no" | "yes" | number;
        readonly "DSIO1 level": "low" | "high" | number;
        readonly "DSIO2 output enable": "no" | "yes" | number;
        readonly "DSIO2 level": "low" | "high" | number;
    };
    readonly Disable_Hall_PS: {
        readonly "Disable": "no" | "yes" | number;
    };
    readonly PARAMETER_SET: {
        readonly "Number": number;
        readonly "Value": number;
    };
    readonly PARAMETER_REQUEST: {
        readonly "Number": number;
    };
    readonly PARAMETER: {
        readonly "Number": number;
        readonly "Value": number;
        readonly "Status": "Done" | "Unknown number" | "Read-only" | "Out of range" | "Wrong state" | "Storage" | "Not equipped" | number;
    };
    readonly LOG_VIRTUAL_SCOPE_SET: {};
    readonly LOG_VIRTUAL_SCOPE_REQUEST: {};
    readonly LOG_VIRTUAL_SCOPE: {
        readonly "Address": number;
        readonly "Sample 1": number;
        readonly "Sample 2": number;
        readonly "Sample 3": number;
    };
    readonly RESTORE_FACTORY_SETTING: {
        readonly "Serial number": number;
    };
    readonly XML_DOWNLOAD_REQUEST: {
        readonly "Command": "Length" | "Start" | number;
    };
    readonly XML_DOWNLOAD_ANSWER: {
        readonly "Length": number;
        readonly "CRC-32": number;
    };
    readonly XML_DOWNLOAD_DATA: {
        readonly "Address": number;
        readonly "Text 1": number;
        readonly "Text 2": number;
        readonly "Text 3": number;
    };
    readonly EXT_MEM_LOG_READ_DATA: {
        readonly "Word counter": number;
        readonly "Data 1": number;
        readonly "Data 2": number;
        readonly "Data 3": number;
    };
    readonly UPDATE_DEVICE_REQUEST: {};
    readonly UPDATE_DEVICE: {
        readonly "Hardware id": number;
        readonly "Room": number;
    };
    readonly UPDATE_VERSION_REQUEST: {};
    readonly UPDATE_VERSION: {
        readonly "Major version": number;
        readonly "Minor version": number;
        readonly "Patch level": number;
        readonly "Build number": number;
    };
    readonly UPDATE_BEGIN: {
        readonly "Length": number;
        readonly "Hardware id": number;
    };
    readonly UPDATE_DATA: {
        readonly "Block": number;
        readonly "Image 1": number;
        readonly "Image 2": number;
        readonly "Image 3": number;
    };
    readonly UPDATE_STATUS_REQUEST: {};
    readonly UPDATE_STATUS: {
        readonly "State": "Idle" | "Erasing" | "Receiving" | "Verifying" | "Marked" | "Trial" | number;
        readonly "Code": "Done" | "Wrong state" | "Not now" | "On trial" | "Hardware" | "Length" | "Sequence" | "Flash" | "Checksum" | "No image" | "Older" | "Timed out" | "Aborted" | "Signature" | "Reverted" | number;
        readonly "Window": number;
        readonly "Offset": number;
    };
    readonly UPDATE_END: {
        readonly "Checksum": number;
    };
    readonly UPDATE_ABORT: {};
    readonly UPDATE_CONFIRM: {};
    readonly MEASUREMENT_0: {
        readonly "Accel X": number;
        readonly "Accel Y": number;
        readonly "Accel Z": number;
        readonly "DSI1_DSP": "low" | "high" | number;
    };
    readonly MEASUREMENT_1: {
        readonly "Mechanical estimated speed SL": number;
        readonly "Mechanical position": number;
        readonly "Electrical input Power": number;
    };
    readonly MEASUREMENT_2: {
        readonly "HV Voltage": number;
        readonly "HV Current": number;
        readonly "+6V_MEAS": number;
        readonly "Driver 14V Voltage": number;
    };
    readonly MEASUREMENT_3: {
        readonly "Ambient Temperature": number;
        readonly "Vref Accel (+1.8V)": number;
        readonly "+0.383VREF": number;
        readonly "ASI_DSP": number;
    };
    readonly MEASUREMENT_4: {
        readonly "VoltagePhaseA": number;
        readonly "VoltagePhaseB": number;
        readonly "VoltagePhaseC": number;
        readonly "PIN_MEAS": number;
    };
    readonly MEASUREMENT_5: {
        readonly "Mechanical estimated speed HES": number;
        readonly "DSI2_DSP": "low" | "high" | number;
    };
    readonly MEASUREMENT_7: {};
    readonly MEASUREMENT_8: {};
}

/** What is in the messages of TX-Drivers. */
export interface NodeValues {
    readonly "NMT": {
        readonly "Node": number;
        readonly "Command": "start" | "stop" | "pre-operational" | "reset" | number;
    };
    readonly "SYNC": {};
    readonly "Error": {
        readonly "Node": number;
        readonly "Code": "generic error" | "CAN controller error passive" | "protocol error" | number;
    };
    readonly "PDO1": {
        readonly "Node": number;
        readonly "Position 1": number;
        readonly "Position 2"?: number;
        readonly "Encoder"?: number;
    };
    readonly "PDO2": {
        readonly "Node": number;
        readonly "Position 1": number;
        readonly "Position 2"?: number;
        readonly "Encoder"?: number;
    };
    readonly "PDO3": {
        readonly "Node": number;
        readonly "Position 1": number;
        readonly "Position 2"?: number;
        readonly "Encoder"?: number;
    };
    readonly "PDO3 request": {
        readonly "Node": number;
        readonly "Bytes": number;
    };
    readonly "SDO answer": {
        readonly "Node": number;
        readonly "Index": number;
        readonly "Subindex": number;
        readonly "Entry": "Node-ID" | "Bitrate Index" | "Nr Of Nodes" | "Update Time" | "Can Config Register" | "Basic Config Register" | "Filter" | "Filter" | "Comparator" | "Comparator" | "Counts Per Revolution" | "Encoder Resolution" | "Reset Encoder" | "Firmware Version" | "unknown" | number;
        readonly "Outcome": "written" | "value" | "abort" | number;
        readonly "Value": number;
    };
    readonly "SDO request": {
        readonly "Node": number;
        readonly "Index": number;
        readonly "Subindex": number;
        readonly "Entry": "Node-ID" | "Bitrate Index" | "Nr Of Nodes" | "Update Time" | "Can Config Register" | "Basic Config Register" | "Filter" | "Filter" | "Comparator" | "Comparator" | "Counts Per Revolution" | "Encoder Resolution" | "Reset Encoder" | "Firmware Version" | "unknown" | number;
        readonly "Action": "read" | "write" | "abort" | "unknown" | number;
        readonly "Value": number;
    };
    readonly "Heartbeat": {
        readonly "Node": number;
        readonly "State": "boot-up" | "stopped" | "operational" | "pre-operational" | number;
    };
}
