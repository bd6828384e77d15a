// Snapshot of the master for the panels.

import type { Master, Measurement, MeasurementSignal, Parameter, ParameterName, ScopeSignal, SpeedLimits } from "narx/core";
import { measurementSignals, parameters, scopeSignals } from "narx/core";
import type { DescriptionState, Drive } from "narx/drive";
import { FAULT } from "./states";

export interface View {
    /** The link's time, s. */
    time: number;
    /** True if a frame of the drive was received within the time-out for a lost drive. */
    connected: boolean;
    /** State of the drive, 0 to 7; absent while unknown. */
    state?: number;
    stateName: string;
    /** True while the motor is being identified: the drive takes no other commands. */
    identifies: boolean;
    /** Names of the set bits of the fault word. */
    faults: readonly string[];
    /** Meaning of the extended code of the last critical fault, in Fault. */
    fault?: string;
    /** The fields of STATUS_WORD. */
    status: Readonly<Record<string, string | number | boolean>>;
    measurements: readonly Measurement[];
    /** Mechanical speed from the source that the control mode uses, rpm. */
    speed?: number;
    /** Set-point that was requested and that the drive has accepted, rpm, negative in reverse. */
    setpoint: number;
    /** Reason why the motor runs at another speed than requested. */
    speedWarning?: string;
    /** Set-points that the drive accepts unchanged; absent before they were received. */
    speedLimits?: SpeedLimits;
    /** Parameters of the drive: from its own description, or from this page's tables. */
    parameters: readonly Parameter[];
    scopeSignals: readonly ScopeSignal[];
    measurementSignals: readonly MeasurementSignal[];
    description: DescriptionState;
    /** Reason why the drive's description was refused. */
    descriptionProblem?: string;
    /** Number of parameters that are still to be read in the background. */
    toRead: number;
    /** Returns the value of a parameter as last received, in its unit. */
    parameter: (key: ParameterName | number) => number | undefined;
}

/** View without a connection. */
export const NOTHING: View = {
    time: 0,
    connected: false,
    stateName: "state unknown",
    identifies: false,
    faults: [],
    status: {},
    measurements: [],
    setpoint: 0,
    parameters: parameters(),
    scopeSignals: scopeSignals(),
    measurementSignals: measurementSignals(),
    description: "own",
    toRead: 0,
    parameter: () => undefined,
};

export function look(drive: Drive, time: number): View {
    const { master } = drive;
    const { state, critical } = master;
    const status = master.status ?? {};
    return {
        time,
        connected: master.connected,
        state,
        stateName: master.stateName ?? "state unknown",
        identifies: drive.identifies,
        faults: master.faults ?? [],
        fault: state === FAULT ? (critical?.meaning ?? (critical && `extended fault code ${critical.code.toString(16)}h`)) : undefined,
        status: status as View["status"],
        measurements: master.measurements(),
        speed: master.speed,
        setpoint: setpointOf(master),
        speedWarning: drive.speedWarning,
        speedLimits: master.speedLimits,
        parameters: drive.parameters.rows,
        scopeSignals: drive.scope.signals,
        measurementSignals: drive.measurementSignals,
        description: drive.descriptionState,
        descriptionProblem: drive.descriptionProblem,
        toRead: master.parametersToRead,
        parameter: (key) => {
            try {
                return master.parameter(key);
            } catch {
                // A drive with another description may not have the parameter.
                return undefined;
            }
        },
    };
}

/** Returns the set-point that was requested and that the drive has accepted, rpm, negative in reverse; 0 in
 * Standby. */
export function setpointOf({ acceptedSpeed = 0, status }: Master): number {
    const mode = status?.["Motor mode"];
    return mode === "Drive" ? acceptedSpeed : mode === "Reverse" ? -acceptedSpeed : 0;
}
