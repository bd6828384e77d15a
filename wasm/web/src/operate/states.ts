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

/** Faults, and their bits in the fault word. */
export const FAULT_BITS: Readonly<Record<FaultName, number>> = {
    temperature_warning: 0,
    over_temperature: 1,
    over_voltage: 2,
    under_voltage: 3,
    over_current: 4,
    legs_driver: 5,
    hall_sensors: 6,
    over_pressure: 7,
    store_mismatch: 26,
    emergency_shutdown: 27,
    external_shutdown: 28,
    device_timeout: 29,
    store_absent: 30,
    store_version: 31,
};
export const FAULTS = Object.keys(FAULT_BITS) as readonly FaultName[];

export const STANDBY = 1;
export const FAULT = 6;

/** Returns whether the bridge is on in a state. */
export function turns(state: number | undefined): boolean {
    return state !== undefined && state >= 2 && state !== FAULT;
}
