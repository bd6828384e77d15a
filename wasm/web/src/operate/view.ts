// What the master knows at one instant, as the panels show it.

import type { Master, Measurement, MeasurementSignal, Parameter, ParameterName, ScopeSignal, SpeedLimits } from "narx/core";
import { measurementSignals, parameters, scopeSignals } from "narx/core";
import type { DescriptionState, Drive } from "narx/drive";
import { FAULT } from "./states";

export interface View {
    /** The link's time, s. */
    time: number;
    /** The drive was heard lately. */
    connected: boolean;
    /** 0 to 7; absent while it is not known. */
    state?: number;
    stateName: string;
    /** Names of the set bits of the fault word. */
    faults: readonly string[];
    /** What the extended code of the last critical fault means, in Fault. */
    fault?: string;
    /** The fields of STATUS_WORD. */
    status: Readonly<Record<string, string | number | boolean>>;
    measurements: readonly Measurement[];
    /** By what the control mode uses, rpm. */
    speed?: number;
    /** What the drive is asked for and has accepted, rpm, negative in reverse. */
    setpoint: number;
    /** Why the motor turns at another speed than was asked for. */
    speedWarning?: string;
    /** Set-points that the drive takes as they are, as far as that was heard. */
    speedLimits?: SpeedLimits;
    /** What the drive is made of: by its own description, or by this page's tables. */
    parameters: readonly Parameter[];
    scopeSignals: readonly ScopeSignal[];
    measurementSignals: readonly MeasurementSignal[];
    description: DescriptionState;
    /** Why its description was refused. */
    descriptionProblem?: string;
    /** Parameters that are still to be read of those that are read in the background. */
    toRead: number;
    /** The value of a parameter as it was last heard, in its unit. */
    parameter: (key: ParameterName | number) => number | undefined;
}

/** Before anything is connected. */
export const NOTHING: View = {
    time: 0,
    connected: false,
    stateName: "not heard",
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
        stateName: master.stateName ?? "not heard",
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
                // A drive of another description does not have it.
                return undefined;
            }
        },
    };
}

/** What the drive is asked for and has accepted, rpm, negative in reverse; 0 in Standby. */
export function setpointOf({ acceptedSpeed = 0, status }: Master): number {
    const mode = status?.["Motor mode"];
    return mode === "Drive" ? acceptedSpeed : mode === "Reverse" ? -acceptedSpeed : 0;
}
