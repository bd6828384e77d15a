// A drive as its master sees it: on a bench, or on a real bus.

import {
    speedParameters,
    type BuildInfo,
    type DeviceInfo,
    type DriveValues,
    type FaultName,
    type Frame,
    type Master,
    type MasterOptions,
    type Measurement,
    type MeasurementSignal,
    type MeasurementName,
    type Outputs,
    type Progress,
    type RequestName,
    type StateName,
    type UpdateProgress,
} from "./core.js";
import { Describer, type Descriptions, type DescriptionState } from "./description.js";
import { failure, Link } from "./link.js";
import { Log } from "./log.js";
import { Parameters, type ParameterKey } from "./parameters.js";
import { Scope } from "./scope.js";

export type { Descriptions, DescriptionState } from "./description.js";
export { misfit } from "./parameters.js";
export type { Keep, LogName } from "./log.js";
export type { ParameterKey } from "./parameters.js";
export type { ScopeSetup, ScopeState, Trigger } from "./scope.js";
export type { Table } from "./table.js";
export type { Log, Parameters, Scope };

/** Longest wait for a start, s. */
const START_MAX = 10;
/** A command is on the bus and the drive has acted on it within this time, s. */
const ANSWER = 0.05;
/** Longest waits for a hall calibration to begin and to end, s. */
const [CALIBRATION_BEGIN, CALIBRATION_MAX] = [3, 60];
const [CALIBRATION_REQUEST, CALIBRATION_STATE, CALIBRATION_DONE] = ["Hall calibration request", "Hall calibration state", 2] as const;
/** What MOTOR_CMD can carry, rpm. */
const SPEED_MAX = 65_535;
const [INITIALIZATION, STANDBY, ROTOR_LOCK, OPEN_LOOP, SENSORLESS, HALL, FAULT] = [0, 1, 2, 3, 4, 5, 6];
const TURNING: ReadonlySet<number> = new Set([OPEN_LOOP, SENSORLESS, HALL]);
const REFUSALS = new Map([
    [1, "no mode is enabled"],
    [2, "parameters do not fit together"],
    [4, "it was not asked for Standby before"],
]);

/** A master, and how its drive is known. */
export interface DriveOptions extends MasterOptions {
    /** Reads the drive's description (XML) when the drive is first heard, and shows the drive by it; default true. */
    readDescription?: boolean;
    /** Where descriptions are kept beside this program's memory. */
    descriptions?: Descriptions;
}

/** What a drive says of itself. */
export interface Info {
    readonly build: BuildInfo;
    readonly device: DeviceInfo;
}

/** A drive. It has no clock and no bus of its own: give it every frame that arrives and send what `poll` has, often (`nextPoll`); promises settle on the way. Times are
 * seconds from any beginning. Set-points are repeated from the beginning, which keeps measurements coming. */
export class Drive {
    #link: Link;
    readonly parameters: Parameters;
    readonly scope: Scope;
    readonly log: Log;
    #describer: Describer;
    #describes: boolean;
    /** Starts and stops so far: a stop ends a start that is still being checked. */
    #commands = 0;
    /** The last set-point, rpm, negative in reverse. */
    #asked: number | undefined;
    /** When, s. */
    #askedAt = 0;

    /** Throws where an option cannot be. */
    constructor({ readDescription = true, descriptions, ...options }: DriveOptions = {}) {
        this.#link = new Link(options);
        this.#describer = new Describer(this.#link, descriptions);
        this.#describes = readDescription;
        this.parameters = new Parameters(this.#link);
        this.scope = new Scope(this.#link);
        this.log = new Log(this.#link);
    }

    /** The state machine inside. */
    get master(): Master {
        return this.#link.master;
    }

    /** Takes a frame that arrived at `now`, s. Only messages of this drive are heard. */
    handleFrame(frame: Frame, now: number): void {
        this.#link.handleFrame(frame, now);
    }

    /** What is to be sent at `now`, s. */
    poll(now: number): Frame[] {
        if (this.#describes) {
            this.#describer.poll();
        }
        return this.#link.poll(now);
    }

    /** When to poll again at the latest, s. What waits looks at every poll, so 10 ms are good where something is waited for. */
    nextPoll(now: number): number {
        return this.master.nextPoll(now);
    }

    /** Asks for a speed, mechanical rpm, negative in reverse, and waits until the motor is in open or closed loop, as the mode has it. A "RangeError" that names
     * parameter and range refuses a speed beyond the limits of the enabled mode (101 to 104), which the drive would clamp; open loop turns at parameter 88 whatever
     * is asked for, and `speedWarning` says so. A "StartError" says why a motor does not start. A drive in Fault does not start: `stop` acknowledges the fault. */
    async start(rpm: number): Promise<void> {
        const mine = ++this.#commands;
        this.#link.expectVoice("start");
        this.master.checkSpeed(whole("start", rpm, -SPEED_MAX));
        if (await this.#link.wait(() => this.state !== undefined, START_MAX)) {
            // What does not answer leaves what is known; the wait below ends by its time.
            await Promise.allSettled([...speedParameters()].map((number) => this.parameters.get(number)));
        }
        this.#expectSpeed(rpm);
        if (mine !== this.#commands) {
            throw failure("StartError", "the start was ended by another command");
        }
        [this.#asked, this.#askedAt] = [rpm, this.#link.now];
        this.#link.start(rpm);
        const attempt = { asked: undefined as number | undefined, idle: false };
        const ends = this.#endsInClosedLoop();
        if (!(await this.#link.wait(() => this.#started(attempt, rpm < 0, ends), this.state === undefined ? 0 : START_MAX))) {
            const known = this.stateName === undefined ? "nothing was heard of the drive" : `the drive is in ${this.stateName}`;
            throw failure("StartError", `no start within ${START_MAX} s: ${known}`);
        }
        await this.#judge(attempt.idle);
    }

    /** Asks for another speed in the same direction, mechanical rpm. Throws as `start` does for one that the drive would clamp, and a "RefusedError" while nothing
     * was started. */
    setSpeed(rpm: number): void {
        this.#link.expectVoice("setSpeed");
        this.#expectSpeed(whole("setSpeed", rpm, 0));
        const stands = this.state === STANDBY || this.state === INITIALIZATION;
        if (this.state === FAULT || (stands && !this.#link.startPending && !this.master.asksToTurn)) {
            throw failure("RefusedError", `speed ${rpm} rpm: the drive is in ${this.stateName}; start begins with a speed`);
        }
        [this.#asked, this.#askedAt] = [rpm, this.#link.now];
        this.master.setSpeed(rpm);
    }

    /** Why the motor turns at another speed than was asked for: the drive has clamped it, or open loop has its own; `undefined` if it does not. */
    get speedWarning(): string | undefined {
        const { acceptedSpeed, asksToTurn, setpoint, setpointPeriod, speedLimits } = this.master;
        if (this.#asked === undefined || !asksToTurn || !TURNING.has(this.state ?? STANDBY)) {
            return undefined;
        }
        if (speedLimits?.fixed) {
            return refusal(() => this.master.checkSpeed(this.#asked!));
        }
        // The drive answers the next MOTOR_CMD, not this instant.
        const answered = this.#link.now > this.#askedAt + 3 * setpointPeriod;
        return answered && acceptedSpeed !== undefined && acceptedSpeed !== setpoint ? `speed ${setpoint} rpm: the drive uses ${acceptedSpeed} rpm` : undefined;
    }

    #expectSpeed(rpm: number): void {
        // Open loop starts all the same, and its user is told.
        if (!this.master.speedLimits?.fixed) {
            this.master.checkSpeed(rpm);
        }
    }

    /** Asks for Standby, which also acknowledges a fault. */
    stop(): void {
        this.#commands += 1;
        this.#link.stop();
    }

    /** Asks for a shutdown: the drive goes into Fault with bit 28. */
    shutDown(): void {
        this.#commands += 1;
        this.#link.expectVoice("shutDown");
        this.master.shutDown();
    }

    /** State, 0 to 7; `undefined` while it is not known. */
    get state(): number | undefined {
        return this.master.state;
    }

    /** Its name in the specification. */
    get stateName(): StateName | undefined {
        return this.master.stateName;
    }

    /** Names of the bits of the fault word that are set. */
    get faults(): FaultName[] {
        return this.master.faults ?? [];
    }

    /** What the extended code of the last critical fault means; `undefined` without a fault. */
    get fault(): string | undefined {
        const critical = this.master.critical;
        if (this.faults.length === 0 || critical === undefined) {
            return undefined;
        }
        return critical.meaning ?? `extended fault code 0x${critical.code.toString(16).padStart(4, "0")}`;
    }

    /** The fields of STATUS_WORD as they were last heard. */
    get status(): DriveValues["STATUS_WORD"] | undefined {
        return this.master.status;
    }

    /** Whether the drive was heard lately. */
    get connected(): boolean {
        return this.master.connected;
    }

    /** What the drive measures, as far as it was heard. */
    get measurements(): Measurement[] {
        return this.master.measurements();
    }

    /** One of them, in its unit; `undefined` before it was heard. */
    measurement(name: MeasurementName): number | undefined {
        const found = this.measurements.find((measurement) => measurement.name === name);
        if (found === undefined && !this.#link.tables.measurements.some((signal) => signal.name === name)) {
            throw new TypeError(`there is no measurement "${name}"`);
        }
        return found?.value;
    }

    /** What can be measured. */
    get measurementSignals(): readonly MeasurementSignal[] {
        return this.#link.tables.measurements;
    }

    /** Whose names, units, scales and ranges these are: the drive's own ("read"), or this package's. */
    get descriptionState(): DescriptionState {
        return this.#describer.state;
    }

    /** Why the drive's description was refused. */
    get descriptionProblem(): string | undefined {
        return this.#describer.problem;
    }

    /** Mechanical speed by what the control mode uses, rpm: that of the hall sensors, by back-EMF, or in open loop that of the field. */
    get speed(): number | undefined {
        return this.master.speed;
    }

    /** Whether a download has the bus, or is about to: nothing of lower priority comes through before its end, SDOs of TX-Drivers among it. */
    get downloads(): boolean {
        return this.descriptionState === "reading" || this.#link.downloads;
    }

    /** BUILD_INFO and DEVICE_INFO, asked for now. */
    async info(): Promise<Info> {
        await Promise.all([this.#request("build info"), this.#request("device info")]);
        const { build, device } = this.master;
        if (build === undefined || device === undefined) {
            throw failure("NoAnswerError", "the drive does not say what it is");
        }
        return { build, device };
    }

    /** Downloads the drive's description of itself (XML). */
    async description(progress?: (progress: Progress) => void): Promise<string> {
        const bytes = await this.#link.download(() => this.master.download("description"), progress);
        return new TextDecoder().decode(bytes).replace(/\0+$/, "");
    }

    /** Programs the drive with an image (the bytes of a `.narximg` file), waits for its restart and confirms that it runs. The drive must be in Standby, or in Fault at
     * standstill, and takes no start until the end. Whatever goes wrong, `master.abortUpdate` among it, the drive runs what it ran before: an "ImageError" for what is
     * no image for it, a "RefusedError" where drive or bootloader does not want it, a "NoAnswerError" from a drive without a bootloader, and from one that is lost. */
    update(image: Uint8Array, progress?: (progress: UpdateProgress) => void): Promise<void> {
        this.#describer.forget();
        return this.#link.update(image, progress);
    }

    /** Restarts a stopped drive, and waits until it is in Standby or Fault again. It stores first what was written (parameter 307). */
    async reboot(): Promise<void> {
        await this.#request("reboot");
        this.#describer.forget();
        // Its self-tests take half a second.
        await this.#link.wait(() => this.state === INITIALIZATION, 0.2);
        if (!(await this.#link.wait(() => this.state === STANDBY || this.state === FAULT, 5))) {
            throw failure("NoAnswerError", "the drive was not heard within 5 s after its reboot");
        }
    }

    /** Sets the digital lines: without a level one is an input. */
    async setOutputs(outputs: Outputs): Promise<void> {
        await this.#link.ask(() => this.master.setOutputs(outputs));
    }

    /** Switches the supply of the hall sensors off, or leaves it to parameter 97. */
    async setHallSupply(on: boolean): Promise<void> {
        await this.#request(on ? "enable hall supply" : "disable hall supply");
    }

    /** The present mechanical position becomes that of parameter 16. */
    async setPosition(): Promise<void> {
        await this.#request("set position");
    }

    /** With the bridge off: the bus current reads 0 and the bus voltage reads parameter 266. */
    async autoCalibrate(): Promise<void> {
        await this.#request("auto-calibrate");
    }

    /** The next start turns the motor one electrical revolution each way to find order, polarity and offset of the hall sensors. With `run` that start is made now, and the
     * promise waits until the motor stands again, some 5 s; a "StartError" says that nothing was found. `parameters.storeOnce` keeps what was. */
    async calibrateHall(run = false): Promise<void> {
        if (run) {
            await this.#link.wait(() => (this.state ?? INITIALIZATION) !== INITIALIZATION, CALIBRATION_BEGIN);
        }
        await this.#request("calibrate hall");
        if (!run) {
            return;
        }
        // It turns at a speed of its own.
        this.#link.start(1);
        const turns = () => this.state === ROTOR_LOCK || this.state === OPEN_LOOP;
        if (await this.#link.wait(() => turns() || this.state === FAULT, CALIBRATION_BEGIN)) {
            // Between two words of the drive its state may be unknown.
            await this.#link.wait(() => this.state !== undefined && !turns(), CALIBRATION_MAX);
        }
        const [state, name, fault] = [this.state, this.stateName, this.fault];
        const done = (await this.parameters.get(CALIBRATION_STATE as ParameterKey)) === CALIBRATION_DONE;
        this.#link.stop();
        // The next start wants the drive to have heard that.
        await this.wait(2 * this.master.setpointPeriod);
        if (!done || state !== STANDBY) {
            await this.parameters.set(CALIBRATION_REQUEST as ParameterKey, 0);
            const why = fault === undefined ? "" : `: ${fault}`;
            throw failure("StartError", `the hall calibration found nothing: the drive is in ${name}${why}`);
        }
    }

    /** Until so many seconds have passed in the times of `poll`. */
    async wait(seconds: number): Promise<void> {
        await this.#link.wait(() => false, seconds);
    }

    /** Until `done`, at most `timeout` s: whether it was done. */
    waitFor(done: () => boolean, timeout = 10): Promise<boolean> {
        return this.#link.wait(done, timeout);
    }

    async #request(what: RequestName): Promise<void> {
        await this.#link.ask(() => this.master.request(what));
    }

    /** In which state a start ends is the modes' business. */
    #endsInClosedLoop(): () => boolean | undefined {
        let found: boolean | undefined;
        const enabled = ["Closed-loop Hall Effect Sensors enable", "Closed-loop Sensorless enable"] as ParameterKey[];
        const read = async () => {
            const values = await Promise.all(enabled.map((name) => this.parameters.get(name)));
            found = values.some((value) => value !== 0);
        };
        // A drive that does not answer ends the wait by its time.
        read().catch(() => undefined);
        return () => found;
    }

    #started(attempt: { asked: number | undefined; idle: boolean }, reverse: boolean, ends: () => boolean | undefined): boolean {
        const state = this.state;
        if (state === FAULT) {
            return true;
        }
        if (this.#link.startPending || state === undefined) {
            return false;
        }
        const now = this.#link.now;
        attempt.asked ??= now;
        if (now < attempt.asked + ANSWER) {
            return false;
        }
        const turns = this.status?.["Motor mode"] === (reverse ? "Reverse" : "Drive");
        switch (state) {
            case HALL:
            case SENSORLESS:
                return turns;
            case OPEN_LOOP:
                return turns && ends() === false;
            case STANDBY:
                attempt.idle = now >= attempt.asked + 4 * ANSWER;
                return attempt.idle;
            default:
                return false;
        }
    }

    /** Throws for a start that has failed. */
    async #judge(idle: boolean): Promise<void> {
        if (this.state === FAULT) {
            const code = await this.parameters.get("Extended fault code" as ParameterKey);
            // The code may come later than the state.
            await this.#link.wait(() => this.fault !== undefined, ANSWER);
            const why = this.fault ?? `code 0x${code.toString(16).padStart(4, "0")}`;
            throw failure("StartError", `the drive is in Fault: ${why} (${this.faults.toSorted().join(", ")})`);
        }
        if (!idle) {
            return;
        }
        const refusal = await this.parameters.get("Start refusal" as ParameterKey);
        const rejected = await this.parameters.get("Rejected parameter" as ParameterKey);
        const row = refusal === 2 ? this.parameters.row(rejected) : undefined;
        if (row !== undefined) {
            throw failure("StartError", `the drive refused the start: parameter ${row.number} "${row.name}" does not fit the others`);
        }
        const unknown = refusal === 0 ? "it stays in Standby" : `reason ${refusal}`;
        throw failure("StartError", `the drive refused the start: ${REFUSALS.get(refusal) ?? unknown}`);
    }
}

/** A speed that a MOTOR_CMD can carry. */
function whole(call: string, rpm: number, min: number): number {
    if (!Number.isInteger(rpm) || rpm < min || rpm > SPEED_MAX) {
        throw new RangeError(`${call} ${rpm}: must be a whole number from ${min} to ${SPEED_MAX}`);
    }
    return rpm;
}

/** What a check says against; `undefined` if nothing. */
function refusal(check: () => void): string | undefined {
    try {
        check();
        return undefined;
    } catch (error) {
        return (error as Error).message;
    }
}
