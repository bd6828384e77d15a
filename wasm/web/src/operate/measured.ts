// Plain names and groups of the broadcast measurements. The types check the names against the core's table.

import type { MeasurementName } from "narx/core";

export const GROUPS = ["Motion", "Supply", "Phases", "Board", "Lines and inputs", "Acceleration", "Other"] as const;

export interface Plain {
    group: (typeof GROUPS)[number];
    name: string;
}

const PLAIN: Readonly<Record<MeasurementName, Plain>> = {
    "Mechanical estimated speed HES": { group: "Motion", name: "Speed, hall sensors" },
    "Mechanical estimated speed SL": { group: "Motion", name: "Speed, sensorless" },
    "Mechanical position": { group: "Motion", name: "Shaft position" },
    "HV Voltage": { group: "Supply", name: "Bus voltage" },
    "HV Current": { group: "Supply", name: "Bus current" },
    "Electrical input Power": { group: "Supply", name: "Input power" },
    VoltagePhaseA: { group: "Phases", name: "Phase A voltage" },
    VoltagePhaseB: { group: "Phases", name: "Phase B voltage" },
    VoltagePhaseC: { group: "Phases", name: "Phase C voltage" },
    "Ambient Temperature": { group: "Board", name: "Temperature" },
    "Driver 14V Voltage": { group: "Board", name: "Gate driver supply" },
    "+6V_MEAS": { group: "Board", name: "6 V supply" },
    "Vref Accel (+1.8V)": { group: "Board", name: "Accelerometer reference" },
    "+0.383VREF": { group: "Board", name: "0.383 of the reference" },
    DSI1_DSP: { group: "Lines and inputs", name: "Digital line 1" },
    DSI2_DSP: { group: "Lines and inputs", name: "Digital line 2" },
    ASI_DSP: { group: "Lines and inputs", name: "Analog input" },
    PIN_MEAS: { group: "Lines and inputs", name: "Pressure input" },
    "Accel X": { group: "Acceleration", name: "Acceleration X" },
    "Accel Y": { group: "Acceleration", name: "Acceleration Y" },
    "Accel Z": { group: "Acceleration", name: "Acceleration Z" },
};

/** Returns the plain name of a signal, which may be a measurement. */
export function title(name: string): string {
    return name in PLAIN ? PLAIN[name as MeasurementName].name : name;
}

/** Manual's names in the order of their groups. */
export const ORDER = Object.keys(PLAIN) as readonly MeasurementName[];

/** Returns plain name and group of a measurement; one that only the drive's description has keeps its name. */
export function plain(name: MeasurementName): Plain {
    return PLAIN[name] ?? { group: "Other", name };
}
