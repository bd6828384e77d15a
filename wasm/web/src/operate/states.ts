// The eight states of the drive (specification, section 7), and the bits of its fault word (Table 9). The
// types check both against the core's tables.

import type { FaultName, StateName } from "narx/core";

export const STATES = [
    "Initialization",
    "Standby",
    "Rotor lock",
    "Open-loop",
    "Sensorless Closed-loop",
    "Closed-loop Hall Effect Sensors",
    "Fault",
    "Sensorless Auto-Restart",
] as const satisfies readonly StateName[];

const BITS: Record<FaultName, true> = {
    temperature_warning: true,
    over_temperature: true,
    over_voltage: true,
    under_voltage: true,
    over_current: true,
    legs_driver: true,
    hall_sensors: true,
    over_pressure: true,
    store_mismatch: true,
    emergency_shutdown: true,
    external_shutdown: true,
    device_timeout: true,
    store_absent: true,
    store_version: true,
};
export const FAULTS = Object.keys(BITS) as readonly FaultName[];

export const STANDBY = 1;
export const FAULT = 6;

/** Returns whether the bridge is on in a state. */
export function turns(state: number | undefined): boolean {
    return state !== undefined && state >= 2 && state !== FAULT;
}
