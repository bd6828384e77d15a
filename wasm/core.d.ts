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



/** A message of the drive or its master. `name` determines the type of `values`. */
export type DriveMessage = {
    [Name in keyof DriveValues]: {
        readonly protocol: "narmotion";
        /** Name in the CAN database. */
        readonly name: Name;
        readonly opcode: number;
        /** True if a drive sends it, false if its master does. */
        readonly fromDrive: boolean;
        readonly source: number;
        readonly destination: number;
        /** Values by field: numbers in their units, names of named values. */
        readonly values: DriveValues[Name];
        /** Units by field; empty for plain numbers. */
        readonly units: { readonly [Field in keyof DriveValues[Name]]: string };
    };
}[keyof DriveValues];

/** A message of a TX-Driver or its master (eddyCAN). */
export type NodeMessage = {
    [Name in keyof NodeValues]: {
        readonly protocol: "eddycan";
        /** Name in Table 3 of the specification. */
        readonly name: Name;
        /** True if a node sends it, false if its master does. */
        readonly fromNode: boolean;
        /** Values by signal. Signals that a PDO does not carry are absent. */
        readonly values: NodeValues[Name];
        readonly units: { readonly [Signal in keyof NodeValues[Name]]: string };
    };
}[keyof NodeValues];



/** An `Error` of a master. Its `name` tells the kind: no answer, a refusal by the drive or this master in its
 * present state, a parameter value that is not allowed, an image that is invalid for this drive, or a start that failed. */
export interface MasterError extends Error {
    readonly name: "NoAnswerError" | "RefusedError" | "ParameterError" | "ImageError" | "StartError";
}

/** A conversation of several messages: a start, which ends when the motor is in the loop of its mode; a hall
 * calibration, which ends when the motor is at rest again; a reboot, which ends when the drive is ready. */
export type JobName = "start" | "calibrate hall" | "reboot";

/** A conversation about the scope or the log: arm, force, or await the scope; capture a record; erase the log. */
export type RecordJobName = "arm scope" | "force scope" | "await scope" | "capture scope" | "erase log";

/** Settings of a record of the scope: raw values of its parameters. */
export interface RecordSetup {
    /** Recorded signals, a bit each; 0 records the inputs of every control tick instead. */
    channels: number;
    /** Samples of each signal; of a record of inputs, control ticks. */
    samples: number;
    /** Control ticks from one sample to the next. */
    prescaler: number;
    /** Samples from before the trigger, fewer than all. */
    before: number;
    /** Kind of the trigger (parameter 290); default 0 for none. */
    trigger?: number;
    /** Signal of the triggers 1 to 4, and their level in bases of the signal. */
    signal?: number;
    level?: number;
}

/** The answer to a request: the value that a parameter has now, in its unit (0 for other requests), or the
 * error. */
export type Answer = { readonly value: number; readonly error?: undefined } | { readonly error: MasterError };

/** State of the digital lines: each is an input, or an output of a level. */
export interface Outputs {
    /** Level of the output; `undefined`: an input. */
    dsio1?: boolean;
    dsio2?: boolean;
}



/** Configuration of a TX-Driver's master. */
export interface TxMasterOptions {
    /** Node-id, 1 to 127. */
    nodeId: number;
    /** Number of sensors; default 1. */
    channels?: 1 | 2;
    /** Longest time until an answer, 0.003 to 10 s; default 0.1. */
    timeout?: number;
}

/** The last positions of a TX-Driver. */
export interface Reading {
    /** Positions from the start of the measuring range, mm, one for each channel. */
    readonly positions: readonly number[];
    /** Counts; of a linear encoder with their sign once 2005h was read. Absent if PDOs do not carry the
     * encoder. */
    readonly encoder?: number;
    /** Position of a linear encoder, mm: counts times resolution. Absent before 2005h and 2009h were read,
     * and for a rotary one. */
    readonly encoderPosition?: number;
    readonly trigger: "timer" | "sync" | "remote";
    /** Time of reception, s. */
    readonly time: number;
}

/** An entry of the object dictionary (eddyCAN specification, Table 4). Limits and factory value are in its
 * unit. */
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

/** The raw value that was read or written, or the error; `abort` is the code of a node's refusal. */
export type TxAnswer =
| { readonly value: number; readonly error?: undefined }
| { readonly error: MasterError; readonly abort?: number };



/** Configuration of a master. */
export interface MasterOptions {
    /** Address of the drive, 0 to 255; default 170. */
    slave?: number;
    /** Address of the master, 0 to 255; default 85. */
    monitor?: number;
    /** Period of the set-points, 0.001 to 10 s; default 0.05. */
    setpointPeriod?: number;
    /** Listens only and transmits nothing; default false. */
    silent?: boolean;
    /** Reads every parameter in the background when the first frame of the drive is received, and after an action that
     * changes many of them; default true. */
    readParameters?: boolean;
    /** Longest time until an answer, 0.001 to 10 s; default 0.1. */
    timeout?: number;
}

/** A received measurement. */
export interface Measurement {
    readonly name: MeasurementName;
    readonly unit: string;
    readonly value: number;
    /** Time of reception, s. */
    readonly time: number;
}

/** The last CRITICAL_FAULT. */
export interface CriticalFault {
    readonly faults: FaultName[];
    /** Extended fault code. */
    readonly code: number;
    /** Meaning of the code; absent for a code that this version does not know. */
    readonly meaning?: string;
}

/** BUILD_INFO. */
export interface BuildInfo {
    readonly number: number;
    /** True if built from sources that were not committed. */
    readonly modified: boolean;
    /** Date of the build, YYYYMMDD. */
    readonly date: number;
}

/** Length and check value of a drive's description. */
export interface DescriptionInfo {
    readonly words: number;
    /** CRC-32 of the words; 0 if the drive does not report it. */
    readonly check: number;
}

/** Set-points that the drive accepts unchanged, in the control mode that its enables select: magnitudes, rpm.
 * It clamps all others. */
export interface SpeedLimits {
    readonly min: number;
    readonly max: number;
    /** True if the drive runs at one speed, whatever is requested: open loop at parameter 88. */
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
    /** Place of the first word in the download, words. */
    readonly offset: number;
    /** Bytes of the words, high byte first. */
    readonly bytes: Uint8Array;
}

/** Progress of a download, words. */
export interface Progress {
    readonly received: number;
    readonly total: number;
}



/** Facts that the user knows of the motor, and limits of its identification. */
export interface IdentificationOptions {
    /** Pole pairs, 1 to 50. They cannot be seen in volts and amperes: without them the rotor turns slowly, and `mark` counts. */
    polePairs?: number;
    /** Largest phase current, above 0 and at most 6 A; default the one whose heat in the winding is 6 W, 6 A at most. */
    current?: number;
    /** Resistance of two switches of the drive, 0 or more and below 1 ohm; default that of narx's own board, 0.04. It is taken off
     * what is measured. */
    bridge?: number;
    /** False holds the rotor and measures resistance and inductance alone; default true. */
    turn?: boolean;
    /** True calibrates the hall sensors, too; the drive keeps what it finds. Not with `turn: false`. Default false. */
    halls?: boolean;
}

/** Part of an identification: reads what the drive is; holds the rotor for resistance and inductance; turns it slowly
 * until its turns are marked, for the pole pairs; spins it and lets it coast
 * for the torque constant; accelerates it for inertia and friction; calibrates the hall sensors; stops it and restores the
 * parameters. */
export type IdentificationStage = "asking" | "holding" | "counting" | "spinning" | "accelerating" | "calibrating" | "restoring";

/** A measured figure. The truth is within `uncertainty` of `value` for about 95 of 100 motors. */
export interface Figure {
    readonly value: number;
    readonly uncertainty: number;
}

/** The figures of a motor as its drive has measured them, at the temperature that the motor had. */
export interface Identified {
    /** As given, or as counted. */
    readonly polePairs: number;
    /** Bus voltage without load, V. */
    readonly supplyVoltage: number;
    /** Largest phase current of the identification: the given one, or what the heat allows, A. */
    readonly current: number;
    /** Line to line, ohm. */
    readonly resistance: Figure;
    /** Line to line, H. */
    readonly inductance: Figure;
    /** Ambient temperature at the drive when the measurement began, degrees Celsius: that of a motor that has rested in the same
     * room. Absent if the drive does not broadcast it. */
    readonly temperature?: number;
    /** Figures of a rotor that has turned; absent if it was held. */
    readonly turned?: IdentifiedTurning;
    /** How the hall sensors are wired; absent if they were not asked for. */
    readonly halls?: IdentifiedHalls;
}

/** Wiring of hall sensors, as the drive's parameters have it from then on. */
export interface IdentifiedHalls {
    /** Permutation of the lines, 0 to 5 (parameter 262). */
    readonly order: number;
    /** Lines that are inverted, a bit each (parameter 263). */
    readonly polarity: number;
    /** Offset of the edges, electrical degrees (parameter 80). */
    readonly offset: number;
}

/** Figures that a rotor shows when it turns. */
export interface IdentifiedTurning {
    /** N m/A, which is the back-EMF constant, V s/rad. */
    readonly torqueConstant: Figure;
    /** Of the rotor and what is coupled to it, kg m2. */
    readonly inertia: Figure;
    /** Friction at `speed`, N m. */
    readonly friction: Figure;
    /** Its constant part, N m. */
    readonly staticFriction: number;
    /** Its part that grows with the speed, N m s/rad. */
    readonly viscousFriction: number;
    /** Speed to which `friction` belongs, rad/s. */
    readonly speed: number;
}

/** A motor, its supply and the control mode, for which a drive is commissioned. */
export interface CommissionOptions {
    /** Pole pairs, 1 to 255. */
    polePairs: number;
    /** Line to line, ohm. */
    resistance: number;
    /** Line to line, H. */
    inductance: number;
    /** N m/A. */
    torqueConstant: number;
    /** Of the rotor and what is coupled to it, kg m2. */
    inertia: number;
    /** Coulomb friction, N m; default 0. */
    staticFriction?: number;
    /** Viscous friction, N m s/rad; default 0. */
    viscousFriction?: number;
    /** Rated DC current, A; default what heats the winding by 6 W, at most 6 A. */
    ratedCurrent?: number;
    /** V. */
    supplyVoltage: number;
    mode: "hall" | "sensorless" | "open-loop";
    /** PWM frequency of the drive's board, 8000 to 50 000 Hz, a whole number; default 10 000. */
    pwmRate?: number;
}

/** Parameters for a motor, and what the drive's limits made of it. */
export interface Commissioned {
    /** Values by name, in their units: every parameter that a commissioning writes. */
    readonly parameters: Partial<Record<ParameterName, number>>;
    /** Limits of the drive that hold the motor back. */
    readonly notes: string[];
    /** Smallest and largest set-point, rpm. */
    readonly speedMin: number;
    readonly speedMax: number;
}



/** Header of an image. */
export interface ImageInfo {
    /** Hardware id. */
    readonly hardware: number;
    /** Name of the board with this id; absent for one that this version does not know. */
    readonly board?: string;
    /** Version, MAJOR.MINOR.PATCH+BUILD. */
    readonly version: string;
    /** Length, bytes. */
    readonly length: number;
}

/** Progress of an update. */
export interface UpdateProgress {
    readonly stage: UpdateStage;
    /** Number of bytes that are done in this stage: erased, received or verified. */
    readonly done: number;
    /** Length of the image, bytes. */
    readonly total: number;
}



/** Properties of one parameter, without its value. Limits and factory value are in its unit. */
export interface Parameter {
    readonly number: number;
    readonly name: ParameterName;
    readonly category: string;
    /** Unit; empty for plain numbers. */
    readonly unit: string;
    readonly type: "uint16" | "int32" | "uint32";
    /** Value of a raw 1. */
    readonly scale: number;
    readonly min: number;
    readonly max: number;
    readonly factory: number;
    /** Write access of masters: never, while the drive is stopped, or at any time. */
    readonly access: "read-only" | "stopped" | "live";
    /** True for a command: writing 0, then 1 executes it. */
    readonly command: boolean;
    /** Time at which a written value takes effect. */
    readonly acts: "at once" | "next start" | "reboot";
    readonly description: string;
}

/** A signal of the virtual scope. */
export interface ScopeSignal {
    /** Bit of the signal in parameter 22. */
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
    /** Index of its word in the frame, 0 to 3. */
    readonly word: number;
    /** Value of a raw 1. */
    readonly scale: number;
}

/** A record of a log download. */
export interface LogRecord {
    readonly index: number;
    /** Time since power-up, s. */
    readonly time: number;
    /** Each value's source (the number in its slot, with the kind of kept value in bits 15 and 14), and its
     * raw number. */
    readonly values: readonly (readonly [what: number, raw: number])[];
}



/**
 * The identification of a motor, step by step. It owns the requests, jobs and downloads of the master until
 * it ends. `drive.identify` of `narx/drive` waits for it.
 */
export class Identification {
    free(): void;
    [Symbol.dispose](): void;
    /**
     * Stops the motor; in the steps that follow the parameters get their former values, and the end is a
     * "RefusedError".
     */
    abort(master: Master): void;
    /**
     * A mark on the shaft passes the same place as the last time: in the stage "counting" three of these
     * tell the pole pairs. False, and nothing happens, at any other time.
     */
    mark(master: Master): boolean;
    /**
     * Makes an identification that begins with the first step. The drive must be in Standby, with the shaft
     * at rest. Throws for an invalid option.
     */
    constructor(options: IdentificationOptions);
    /**
     * Goes on, after every poll of the master; returns the figures once. Throws a `MasterError` with which
     * the identification has ended.
     */
    step(master: Master): Identified | undefined;
    /**
     * Part that is under way.
     */
    readonly stage: IdentificationStage;
}

/**
 * The master of a drive, at the other end of its bus. It has no clock and no bus of its own. Times are
 * seconds from any beginning and never decrease. Pass it every frame that arrives, and send the frames of
 * `poll`, at the latest at `nextPoll`. Calls that wait for answers are in `narx/drive`.
 */
export class Master {
    free(): void;
    [Symbol.dispose](): void;
    /**
     * Aborts the download.
     */
    abortDownload(): void;
    /**
     * Aborts the update. An image that is swapped in already is not confirmed, so the drive goes back to the
     * previous one.
     */
    abortUpdate(): void;
    /**
     * Begins a job of the scope or the log; one that is under way ends without a result, jobs of the motor
     * go on. `within`: longest wait for a record, s. Throws a `MasterError` for a silent master, a
     * `RangeError` for a setting that is no whole number of 16 bits.
     */
    beginRecord(job: RecordJobName, setup: RecordSetup | undefined, within?: number | null): void;
    /**
     * Begins a job; one that is under way ends without a result. `rpm`: speed of a start, negative in
     * reverse. Throws a `MasterError` for a silent master.
     */
    begin(job: JobName, rpm?: number | null): void;
    /**
     * Throws a `RangeError` for a set-point, rpm, negative in reverse, that the drive would clamp. The error
     * names the limit's parameter and the range. Before the drive's limits were received, only the range of
     * MOTOR_CMD is checked.
     */
    checkSpeed(rpm: number): void;
    /**
     * Replaces the tables of the drive by those of its description, the bytes of a download; without `text`
     * by those of this package. `check` is the CRC-32 that the drive reports for it. Throws for a text that
     * cannot be read, and then keeps the previous tables.
     */
    describe(text?: Uint8Array | number[] | null, check?: number | null): void;
    /**
     * Begins a download: "description", "scope" with `count` words, "log" with `count` records from `first`
     * on. Throws for a silent master, and during another download.
     */
    download(what: "description" | "scope" | "log", count?: number | null, first?: number | null): void;
    /**
     * Takes a frame that arrived at `now`, s. Only messages of its drive to this master are used.
     */
    handleFrame(frame: Frame, now: number): void;
    /**
     * Returns the signals of the drive's measurements in the order of its description.
     */
    measurementSignals(): MeasurementSignal[];
    /**
     * Returns the measurements that were received, in the order of Figure 14.
     */
    measurements(): Measurement[];
    /**
     * Makes a master that has received nothing yet. Throws for an invalid option.
     */
    constructor(options?: MasterOptions);
    /**
     * Returns the latest time of the next poll, s, if no frame arrives and nothing is requested until then;
     * infinity if there is none.
     */
    nextPoll(now: number): number;
    /**
     * Returns the value of a parameter as last received, in its unit; `undefined` before.
     */
    parameter(key: ParameterName | number): number | undefined;
    /**
     * Returns every parameter of the drive in the order of its description.
     */
    parameters(): Parameter[];
    /**
     * Returns the next answer; `undefined` before it has come.
     */
    pollAnswer(): Answer | undefined;
    /**
     * Returns the words that have come since the previous call. Words may come more than once, each time the
     * same.
     */
    pollChunks(): Chunk[];
    /**
     * Returns the length of the download in words, once all its chunks were taken. Throws a `MasterError`
     * for one that failed.
     */
    pollDownload(): number | undefined;
    /**
     * Returns the next frame that is due at `now`, s.
     */
    pollFrame(now: number): Frame | undefined;
    /**
     * Returns whether the job has ended in success. Throws a `MasterError` for one that has failed.
     */
    pollJob(): boolean;
    /**
     * Returns whether the job of the scope or the log has ended in success. Throws a `MasterError` for one
     * that has failed, a `RangeError` for a setting that does not fit.
     */
    pollRecord(): boolean;
    /**
     * Returns whether the update has succeeded: the drive runs the image now and keeps it. Throws a
     * `MasterError` for one that failed; the previous image then still runs.
     */
    pollUpdate(): boolean;
    /**
     * Returns every frame that is due at `now`, s.
     */
    poll(now: number): Frame[];
    /**
     * Reads every parameter anew in the background.
     */
    readParameters(): void;
    /**
     * Requests a parameter's value.
     */
    read(key: ParameterName | number): void;
    /**
     * Queues a request to the drive. Answers come in the order of the requests. Throws a `MasterError` for a
     * silent master, and while there are eight answers that were not taken.
     */
    request(what: RequestName): void;
    /**
     * Requests factory values, except for the board's own parameters. `serial`: parameter 1 of the addressed
     * board.
     */
    restoreFactory(serial: number): void;
    /**
     * Returns the signals of the drive's scope in the order of its description.
     */
    scopeSignals(): ScopeSignal[];
    /**
     * Requests the digital lines to be inputs, or outputs of a level.
     */
    setOutputs(outputs: Outputs): void;
    /**
     * Requests another speed in the same direction, rpm.
     */
    setSpeed(rpm: number): void;
    /**
     * Requests a shutdown: fault bit 28.
     */
    shutDown(): void;
    /**
     * Requests a start at a speed, mechanical rpm, negative in reverse. A drive accepts a start only after
     * Standby: call `stop` first.
     */
    start(rpm: number): void;
    /**
     * Requests Standby, which also acknowledges a fault.
     */
    stop(): void;
    /**
     * Begins to program the drive with an image, the bytes of a `.narximg` file. `poll` then also returns
     * blocks of the image. Throws a `MasterError` for an incomplete image, for a silent master, and during
     * another update.
     */
    update(image: Uint8Array | number[]): void;
    /**
     * Requests to write a parameter, in its unit, rounded to the nearest step of its scale. Throws a
     * `RangeError` for a value that is not allowed: outside the range, not a number, a fraction of a whole
     * parameter.
     */
    write(key: ParameterName | number, value: number): void;
    /**
     * Set-point that the drive has accepted, rpm.
     */
    readonly acceptedSpeed: number | undefined;
    /**
     * True if the last request was Drive or Reverse.
     */
    readonly asksToTurn: boolean;
    /**
     * The last BUILD_INFO.
     */
    readonly build: BuildInfo | undefined;
    /**
     * True if a frame of the drive was received within the last 0.5 s, or within three of its broadcast
     * periods if that is longer.
     */
    readonly connected: boolean;
    /**
     * The last CRITICAL_FAULT. `faults` shows whether it still holds.
     */
    readonly critical: CriticalFault | undefined;
    /**
     * Length and check value of the drive's description, as last received.
     */
    readonly descriptionInfo: DescriptionInfo | undefined;
    /**
     * The last DEVICE_INFO.
     */
    readonly device: DeviceInfo | undefined;
    /**
     * Progress of the download; `undefined` before its length is known, and without one.
     */
    readonly downloadProgress: Progress | undefined;
    /**
     * Names of the set bits of FAULT_WORD; `undefined` before the first.
     */
    readonly faults: FaultName[] | undefined;
    /**
     * Time at which any message of the drive was last received, s.
     */
    readonly lastReceived: number | undefined;
    /**
     * Number of parameters that are still to be read in the background.
     */
    readonly parametersToRead: number;
    /**
     * Time between two set-points, s.
     */
    readonly setpointPeriod: number;
    /**
     * Magnitude of the set-point, rpm.
     */
    readonly setpoint: number;
    /**
     * True for a master that transmits nothing.
     */
    readonly silent: boolean;
    /**
     * Set-points that the drive accepts unchanged; `undefined` before the needed ones of `speedParameters`
     * were received.
     */
    readonly speedLimits: SpeedLimits | undefined;
    /**
     * Mechanical speed from the source that the control mode uses, rpm.
     */
    readonly speed: number | undefined;
    /**
     * True while a start waits until the drive accepts it.
     */
    readonly startPending: boolean;
    /**
     * Name of the state in the specification.
     */
    readonly stateName: StateName | undefined;
    /**
     * State of the drive, 0 to 7; `undefined` while unknown.
     */
    readonly state: number | undefined;
    /**
     * The last STATUS_WORD (Table 8).
     */
    readonly status: DriveValues["STATUS_WORD"] | undefined;
    /**
     * Progress of the update; `undefined` without one.
     */
    readonly updateProgress: UpdateProgress | undefined;
}

/**
 * Decoder of the bytes from an slcan adapter. Lines that are no frames are counted or ignored.
 */
export class SlcanLines {
    free(): void;
    [Symbol.dispose](): void;
    /**
     * Takes bytes as they arrived, and returns the frames that they complete.
     */
    handleBytes(bytes: Uint8Array | number[]): Frame[];
    /**
     * Makes a decoder before the first byte.
     */
    constructor();
    /**
     * Number of commands that the adapter has refused.
     */
    readonly refusals: number;
}

/**
 * The master of a TX-Driver, at the other end of its bus. Times are seconds from any beginning and never
 * decrease.
 */
export class TxMaster {
    free(): void;
    [Symbol.dispose](): void;
    /**
     * Requests PDO3.
     */
    askPositions(): void;
    /**
     * Commands the node (NMT).
     */
    command(command: "start" | "stop" | "pre-operational" | "reset"): void;
    /**
     * Takes a frame that arrived at `now`, s. Only messages of its node are used.
     */
    handleFrame(frame: Frame, now: number): void;
    /**
     * Makes a master that sends nothing until it gets a command or a request.
     */
    constructor(options: TxMasterOptions);
    /**
     * Returns the latest time of the next poll, s; infinity if there is none.
     */
    nextPoll(now: number): number;
    /**
     * Returns the next answer; `undefined` before it has come.
     */
    pollAnswer(): TxAnswer | undefined;
    /**
     * Returns every frame that is due at `now`, s.
     */
    poll(now: number): Frame[];
    /**
     * Queues a request that reads an entry, or writes a raw value to it.
     */
    request(index: number, subindex: number, value?: number | null): void;
    /**
     * Sends a SYNC: every node samples and sends PDO2.
     */
    sync(): void;
    /**
     * Number of boot-up messages.
     */
    readonly boots: number;
    /**
     * Number of error messages.
     */
    readonly errors: number;
    /**
     * Meaning of the last error message (Table 13).
     */
    readonly lastError: string | undefined;
    /**
     * Number of the node's frames that cannot be decoded: most likely PDOs of another layout.
     */
    readonly malformed: number;
    /**
     * Returns whether a frame of the node was received within 5 s.
     */
    readonly present: boolean;
    /**
     * The last positions since the node booted, if there are any.
     */
    readonly reading: Reading | undefined;
    /**
     * State in the last heartbeat.
     */
    readonly state: "boot-up" | "stopped" | "operational" | "pre-operational" | undefined;
}

/**
 * Returns the command that closes an adapter.
 */
export function closeSlcan(): Uint8Array;

/**
 * Returns the parameters of a drive for a motor, by the design rules. Throws a `RangeError` for a motor or a
 * supply that the drive cannot run.
 */
export function commission(options: CommissionOptions): Commissioned;

/**
 * Decodes a frame, by the tables of PROTOCOL.md: of the drive with 29 bits, of TX-Drivers with 11;
 * `undefined` if neither protocol has such a frame. `encoder`: PDOs of 8 bytes contain the encoder, which
 * the frame itself does not show.
 */
export function decode(frame: Frame, encoder?: boolean | null): DriveMessage | NodeMessage | undefined;

/**
 * Encodes a frame for an adapter.
 */
export function encodeSlcan(frame: Frame): Uint8Array;

/**
 * Returns the header of an image (the bytes of a `.narximg` file). Throws a `MasterError` for an incomplete
 * image.
 */
export function imageInfo(image: Uint8Array | number[]): ImageInfo;

/**
 * Decodes the records of a log download, each of `size` bytes (parameter 69); those that the drive could not
 * read are left out.
 */
export function logRecords(bytes: Uint8Array | number[], size: number): LogRecord[];

/**
 * Returns the signals of the measurements in the order of Figure 14.
 */
export function measurementSignals(): MeasurementSignal[];

/**
 * Returns the commands that open an adapter at this bit rate, bit/s (default 500 000, that of the drive).
 * The adapter is closed first, whatever its state.
 */
export function openSlcan(bitrate?: number | null, listen?: boolean | null): Uint8Array;

/**
 * Returns every parameter in the order of the numbers.
 */
export function parameters(): Parameter[];

/**
 * Returns the signals of the virtual scope in the order of their bits.
 */
export function scopeSignals(): ScopeSignal[];

/**
 * Returns the numbers of the parameters that determine `speedLimits`.
 */
export function speedParameters(): Uint16Array;

/**
 * Returns the object dictionary in order.
 */
export function txObjects(): TxObject[];

export type InitInput = RequestInfo | URL | Response | BufferSource | WebAssembly.Module;

export interface InitOutput {
    readonly memory: WebAssembly.Memory;
    readonly __wbg_identification_free: (a: number, b: number) => void;
    readonly __wbg_master_free: (a: number, b: number) => void;
    readonly __wbg_slcanlines_free: (a: number, b: number) => void;
    readonly __wbg_txmaster_free: (a: number, b: number) => void;
    readonly closeSlcan: () => [number, number];
    readonly commission: (a: any) => [number, number, number];
    readonly decode: (a: any, b: number) => [number, number, number];
    readonly encodeSlcan: (a: any) => [number, number, number, number];
    readonly identification_abort: (a: number, b: number) => void;
    readonly identification_mark: (a: number, b: number) => number;
    readonly identification_new: (a: any) => [number, number, number];
    readonly identification_stage: (a: number) => [number, number];
    readonly identification_step: (a: number, b: number) => [number, number, number];
    readonly imageInfo: (a: number, b: number) => [number, number, number];
    readonly logRecords: (a: number, b: number, c: number) => any;
    readonly master_abortDownload: (a: number) => void;
    readonly master_abortUpdate: (a: number) => void;
    readonly master_acceptedSpeed: (a: number) => number;
    readonly master_asksToTurn: (a: number) => number;
    readonly master_begin: (a: number, b: any, c: number, d: number) => [number, number];
    readonly master_beginRecord: (a: number, b: any, c: any, d: number, e: number) => [number, number];
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
    readonly master_lastReceived: (a: number) => [number, number];
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
    readonly master_pollJob: (a: number) => [number, number, number];
    readonly master_pollRecord: (a: number) => [number, number, number];
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
    readonly master_startPending: (a: number) => number;
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

/** Stages of an update. */
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
    | "Automatic store"
    | "Other rotor source";

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

/** Fields of the drive's messages, by the names of the CAN database. */
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

/** Fields of the TX-Drivers' messages. */
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
