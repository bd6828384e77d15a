// A drive, seen from its master: on a bench, or on a real bus.

import {
    speedParameters,
    type BuildInfo,
    type Commissioned,
    type DeviceInfo,
    type DriveValues,
    type FaultName,
    type Frame,
    type IdentificationOptions,
    type IdentificationStage,
    type Identified,
    type Master,
    type MasterOptions,
    type Measurement,
    type MeasurementSignal,
    type MeasurementName,
    type Outputs,
    type ParameterName,
    type Progress,
    type RequestName,
    type StateName,
    type UpdateProgress,
} from "./core.js";
import { Describer, type Descriptions, type DescriptionState } from "./description.js";
import { commissionFor, type Operation } from "./identification.js";
import { failure, Link } from "./link.js";
import { Log } from "./log.js";
import { Parameters } from "./parameters.js";
import { Scope } from "./scope.js";

export type { Descriptions, DescriptionState } from "./description.js";
export { motorFile, motorOf, type Operation } from "./identification.js";
export { misfit } from "./parameters.js";
export type { Keep, LogName } from "./log.js";
export type { ParameterKey } from "./parameters.js";
export type { ScopeSetup, ScopeState, Trigger } from "./scope.js";
export type { Table } from "./table.js";
export type { Log, Parameters, Scope };

/** Longest wait for a start, s. */
const START_MAX = 10;
/** Largest set-point of MOTOR_CMD, rpm. */
const SPEED_MAX = 65_535;
const [INITIALIZATION, STANDBY, OPEN_LOOP, SENSORLESS, HALL, FAULT] = [0, 1, 3, 4, 5, 6];
/** Parameters of the scope, by number. */
const [PRESCALER, SAMPLING_TIME] = [24, 25];
const TURNING: ReadonlySet<number> = new Set([OPEN_LOOP, SENSORLESS, HALL]);

/** Configuration of a master, and the use of its drive's description. */
export interface DriveOptions extends MasterOptions {
    /** Reads the drive's description (XML) when the first frame of the drive is received, and takes names, units, scales and
     * ranges from it; default true. */
    readDescription?: boolean;
    /** Storage of descriptions, in addition to this program's memory. */
    descriptions?: Descriptions;
}

/** Identity of a drive. */
export interface Info {
    readonly build: BuildInfo;
    readonly device: DeviceInfo;
}

/** A commissioning that was written. */
export interface Commissioning extends Omit<Commissioned, "parameters"> {
    /** Parameters that have changed. */
    readonly changed: ParameterName[];
}

/** A drive. It has no clock and no bus of its own: pass it every frame that arrives, and send the frames of
 * `poll`, which must be called often (`nextPoll`); promises settle during these calls. Times are seconds from
 * any beginning. Set-points are repeated from the beginning, which keeps measurements coming. */
export class Drive {
    #link: Link;
    readonly parameters: Parameters;
    readonly scope: Scope;
    readonly log: Log;
    #describer: Describer;
    #describes: boolean;
    /** Number of starts and stops so far: a stop ends a start that is still being checked. */
    #commands = 0;
    /** The last set-point, rpm, negative in reverse. */
    #asked: number | undefined;
    /** Time of the last set-point, s. */
    #askedAt = 0;

    /** Throws for an invalid option. */
    constructor({ readDescription = true, descriptions, ...options }: DriveOptions = {}) {
        this.#link = new Link(options);
        this.#describer = new Describer(this.#link, descriptions);
        this.#describes = readDescription;
        this.parameters = new Parameters(this.#link);
        this.scope = new Scope(this.#link);
        this.log = new Log(this.#link);
    }

    /** The underlying state machine. */
    get master(): Master {
        return this.#link.master;
    }

    /** Takes a frame that arrived at `now`, s. Only messages of this drive are used. */
    handleFrame(frame: Frame, now: number): void {
        this.#link.handleFrame(frame, now);
    }

    /** Returns the frames to send at `now`, s. */
    poll(now: number): Frame[] {
        if (this.#describes) {
            this.#describer.poll();
        }
        return this.#link.poll(now);
    }

    /** Returns the latest time of the next poll, s. Calls that wait check their condition at every poll, so
     * poll every 10 ms while one waits. */
    nextPoll(now: number): number {
        return this.master.nextPoll(now);
    }

    /** Requests a start at a speed, mechanical rpm, negative in reverse, and waits until the motor is in open
     * or closed loop, depending on the mode. Rejects with a "RangeError" that names parameter and range for a
     * speed beyond the limits of the enabled mode (101 to 104), because the drive would clamp it. Open loop
     * runs at parameter 88, whatever speed is requested; `speedWarning` then has a text. Rejects with a
     * "StartError" that has the reason if the motor does not start. A drive in Fault does not start: `stop`
     * acknowledges the fault. */
    async start(rpm: number): Promise<void> {
        this.#link.expectVoice("start");
        this.#link.expectIdle("start");
        const mine = ++this.#commands;
        this.master.checkSpeed(whole("start", rpm, -SPEED_MAX));
        if (await this.#link.wait(() => this.state !== undefined, START_MAX)) {
            // Without an answer the known values are used; the wait below has its own time-out.
            await Promise.allSettled([...speedParameters()].map((number) => this.parameters.get(number)));
        }
        this.#expectSpeed(rpm);
        if (mine !== this.#commands) {
            throw failure("StartError", "the start was ended by another command");
        }
        if (this.state === undefined) {
            throw failure("StartError", `no start within ${START_MAX} s: no frames were received from the drive`);
        }
        [this.#asked, this.#askedAt] = [rpm, this.#link.now];
        await this.#link.job("start", rpm);
    }

    /** Requests another speed in the same direction, mechanical rpm. Throws as `start` does for one that the
     * drive would clamp, and a "RefusedError" for a motor that was not started. */
    setSpeed(rpm: number): void {
        this.#link.expectVoice("setSpeed");
        this.#link.expectIdle("setSpeed");
        this.#expectSpeed(whole("setSpeed", rpm, 0));
        const stands = this.state === STANDBY || this.state === INITIALIZATION;
        if (this.state === FAULT || (stands && !this.master.startPending && !this.master.asksToTurn)) {
            throw failure("RefusedError", `speed ${rpm} rpm: the drive is in ${this.stateName}; call start first`);
        }
        [this.#asked, this.#askedAt] = [rpm, this.#link.now];
        this.master.setSpeed(rpm);
    }

    /** Reason why the motor runs at another speed than requested: the drive has clamped it, or open loop has
     * a speed of its own; `undefined` if it runs at the requested speed. */
    get speedWarning(): string | undefined {
        const { acceptedSpeed, asksToTurn, setpoint, setpointPeriod, speedLimits } = this.master;
        if (this.#asked === undefined || !asksToTurn || !TURNING.has(this.state ?? STANDBY)) {
            return undefined;
        }
        if (speedLimits?.fixed) {
            return refusal(() => this.master.checkSpeed(this.#asked!));
        }
        // The drive's answer comes only after the next MOTOR_CMD.
        const answered = this.#link.now > this.#askedAt + 3 * setpointPeriod;
        return answered && acceptedSpeed !== undefined && acceptedSpeed !== setpoint ? `speed ${setpoint} rpm: the drive uses ${acceptedSpeed} rpm` : undefined;
    }

    #expectSpeed(rpm: number): void {
        // Open loop starts at its own speed in any case; `speedWarning` has the difference.
        if (!this.master.speedLimits?.fixed) {
            this.master.checkSpeed(rpm);
        }
    }

    /** Requests Standby, which also acknowledges a fault, and ends an identification. */
    stop(): void {
        this.#commands += 1;
        this.#link.abortIdentification();
        this.master.stop();
    }

    /** Requests a shutdown: the drive goes into Fault with bit 28. */
    shutDown(): void {
        this.#link.expectVoice("shutDown");
        this.#link.expectIdle("shutDown");
        this.#commands += 1;
        this.master.shutDown();
    }

    /** State of the drive, 0 to 7; `undefined` while unknown. */
    get state(): number | undefined {
        return this.master.state;
    }

    /** Name of the state in the specification. */
    get stateName(): StateName | undefined {
        return this.master.stateName;
    }

    /** Names of the set bits of the fault word. */
    get faults(): FaultName[] {
        return this.master.faults ?? [];
    }

    /** Meaning of the extended code of the last critical fault; `undefined` without a fault. */
    get fault(): string | undefined {
        const critical = this.master.critical;
        if (this.faults.length === 0 || critical === undefined) {
            return undefined;
        }
        return critical.meaning ?? `extended fault code 0x${critical.code.toString(16).padStart(4, "0")}`;
    }

    /** The fields of the last STATUS_WORD. */
    get status(): DriveValues["STATUS_WORD"] | undefined {
        return this.master.status;
    }

    /** True if a frame of the drive was received within the last 0.5 s, or within three of its broadcast periods if that is
     * longer. */
    get connected(): boolean {
        return this.master.connected;
    }

    /** Measurements that were received from the drive. */
    get measurements(): Measurement[] {
        return this.master.measurements();
    }

    /** Returns the value of a measurement, in its unit; `undefined` before it was received. */
    measurement(name: MeasurementName): number | undefined {
        const found = this.measurements.find((measurement) => measurement.name === name);
        if (found === undefined && !this.#link.tables.measurements.some((signal) => signal.name === name)) {
            throw new TypeError(`there is no measurement "${name}"`);
        }
        return found?.value;
    }

    /** Signals of the drive's measurements. */
    get measurementSignals(): readonly MeasurementSignal[] {
        return this.#link.tables.measurements;
    }

    /** Source of names, units, scales and ranges: the drive's own description ("read"), or this package's
     * tables. */
    get descriptionState(): DescriptionState {
        return this.#describer.state;
    }

    /** Reason why the drive's description was refused. */
    get descriptionProblem(): string | undefined {
        return this.#describer.problem;
    }

    /** Mechanical speed, rpm, from the source that the control mode uses: the hall sensors, the back-EMF, or
     * in open loop the field. */
    get speed(): number | undefined {
        return this.master.speed;
    }

    /** True while a download is under way or about to begin, and during an identification, which downloads records. It takes
     * the bus: frames of lower priority, such as SDOs of TX-Drivers, pass only after its end. */
    get downloads(): boolean {
        return this.descriptionState === "reading" || this.#link.downloads || this.#link.identifies;
    }

    /** Reads BUILD_INFO and DEVICE_INFO now. */
    async info(): Promise<Info> {
        await Promise.all([this.#request("build info"), this.#request("device info")]);
        const { build, device } = this.master;
        if (build === undefined || device === undefined) {
            throw failure("NoAnswerError", "the drive did not answer with BUILD_INFO and DEVICE_INFO");
        }
        return { build, device };
    }

    /** Downloads the drive's description of itself (XML). */
    async description(progress?: (progress: Progress) => void): Promise<string> {
        const bytes = await this.#link.download(() => this.master.download("description"), progress);
        return new TextDecoder().decode(bytes).replace(/\0+$/, "");
    }

    /** Programs the drive with an image (the bytes of a `.narximg` file), waits for its restart and confirms
     * that it runs. The drive must be in Standby, or in Fault at standstill, and refuses a start until the
     * update ends. After an error, or `master.abortUpdate`, the drive runs its previous image. Rejects with
     * an "ImageError" for an image that is invalid for this drive, a "RefusedError" if drive or bootloader
     * rejects it, and a "NoAnswerError" if the drive has no bootloader, or is lost. */
    update(image: Uint8Array, progress?: (progress: UpdateProgress) => void): Promise<void> {
        this.#describer.forget();
        return this.#link.update(image, progress);
    }

    /** Restarts a stopped drive, and waits until it is in Standby or Fault again. The drive first stores
     * written parameters (parameter 307). */
    async reboot(): Promise<void> {
        await this.#link.job("reboot");
        this.#describer.forget();
    }

    /** Sets the digital lines: one without a level is an input. */
    async setOutputs(outputs: Outputs): Promise<void> {
        await this.#link.ask(() => this.master.setOutputs(outputs));
    }

    /** Switches the supply of the hall sensors off, or leaves it under control of parameter 97. */
    async setHallSupply(on: boolean): Promise<void> {
        await this.#request(on ? "enable hall supply" : "disable hall supply");
    }

    /** Sets the present mechanical position to the value of parameter 16. */
    async setPosition(): Promise<void> {
        await this.#request("set position");
    }

    /** Calibrates current and voltage with the bridge off: the bus current then reads 0 and the bus voltage
     * reads parameter 266. */
    async autoCalibrate(): Promise<void> {
        await this.#request("auto-calibrate");
    }

    /** Prepares a hall calibration: the next start turns the motor one electrical revolution each way to find
     * order, polarity and offset of the hall sensors. With `run` that start is made now, and the promise
     * waits until the motor is at rest again, some 5 s; it rejects with a "StartError" if the calibration failed.
     * `parameters.store` stores the result. */
    async calibrateHall(run = false): Promise<void> {
        await (run ? this.#link.job("calibrate hall") : this.#request("calibrate hall"));
    }

    /** Measures the motor's resistance, inductance, torque constant, inertia and friction: within some 15 s the drive holds the
     * rotor, spins it, lets it coast and accelerates it. The shaft must be free and at rest, and the drive in Standby. `progress`
     * is called with each stage. `stop` ends it; other requests are refused meanwhile. At the end the motor stands and every
     * parameter but the scope's has its former value, also after an error. Before the torque constant is known the rotor turns at
     * 50 electrical revolutions a second, or a little more; from then on at half of its nominal speed at most. Rejects with a
     * `RangeError` for an invalid option, a "StartError" for a motor that is missing, blocked or incomplete, or that the drive
     * cannot turn, a "RefusedError" if it was stopped, and a "NoAnswerError" if the drive is lost. */
    identify(options: IdentificationOptions, progress?: (stage: IdentificationStage) => void): Promise<Identified> {
        return this.#link.identify(options, progress);
    }

    /** A mark on the shaft passes the same place as the last time: three of these tell the pole pairs of an identification without
     * them, in its stage "counting". False, and nothing happens, at any other time. */
    mark(): boolean {
        return this.#link.mark();
    }

    /** True while the motor is being identified. */
    get identifies(): boolean {
        return this.#link.identifies;
    }

    /** Writes the parameters for a motor that was identified, and returns the names of those that have changed. The drive must be
     * in Standby. Rejects with a `RangeError` for a motor or a supply that the drive cannot run, and a "RefusedError" for a motor
     * that was not allowed to turn; nothing is written then. */
    async commission(found: Identified, operation: Omit<Operation, "pwmRate">): Promise<Commissioning> {
        // A sampling time of 1000 ticks tells the PWM frequency to 0.01 %.
        const before = await this.parameters.get(PRESCALER);
        await this.parameters.set(PRESCALER, 1000);
        const pwmRate = Math.round(1000 / (await this.parameters.get(SAMPLING_TIME)));
        await this.parameters.set(PRESCALER, before);
        const { parameters, ...made } = commissionFor(found, { ...operation, pwmRate });
        return { ...made, changed: await this.parameters.load(parameters) };
    }

    /** Waits until this many seconds have passed in the times of `poll`. */
    async wait(seconds: number): Promise<void> {
        await this.#link.wait(() => false, seconds);
    }

    /** Waits until `done`, at most `timeout` s; resolves to whether it was done. */
    waitFor(done: () => boolean, timeout = 10): Promise<boolean> {
        return this.#link.wait(done, timeout);
    }

    async #request(what: RequestName): Promise<void> {
        await this.#link.ask(() => this.master.request(what));
    }
}

/** Checks a speed for MOTOR_CMD. */
function whole(call: string, rpm: number, min: number): number {
    if (!Number.isInteger(rpm) || rpm < min || rpm > SPEED_MAX) {
        throw new RangeError(`${call} ${rpm}: must be a whole number from ${min} to ${SPEED_MAX}`);
    }
    return rpm;
}

/** Returns the message of the error that `check` throws; `undefined` if it throws none. */
function refusal(check: () => void): string | undefined {
    try {
        check();
        return undefined;
    } catch (error) {
        return (error as Error).message;
    }
}
