// Lanes that several chapters draw.

import { floating, trapezoid } from "./model";
import type { Read } from "./history";
import type { Lane } from "./pictures/Waveforms.svelte";

const NAMES = ["a", "b", "c"] as const;

export const CURRENTS: Lane = {
    title: "Phase currents",
    unit: "A",
    series: NAMES.map((name) => ({ label: name.toUpperCase(), value: `current_${name}`, colour: `--phase-${name}` })),
};

/** Terminals against ground in the middle of the on-time, and half of the bus. */
export const TERMINALS: Lane = {
    title: "Terminals",
    unit: "V",
    series: [
        ...NAMES.map((name) => ({ label: name.toUpperCase(), value: `voltage_${name}` as const, colour: `--phase-${name}` })),
        { label: "half of the bus", value: (read: Read) => read("bus_voltage") / 2, colour: "--quiet", dash: [6, 4] },
    ],
};

/** Back-EMF of each phase; `peak` is in V at 1 rpm. */
export function emfs(peak: number): Lane {
    return {
        title: "Back-EMF",
        unit: "V",
        series: NAMES.map((name, phase) => ({
            label: name.toUpperCase(),
            value: (read: Read) => peak * read("speed") * trapezoid(read("angle"))[phase],
            colour: `--phase-${name}`,
        })),
    };
}

export const TORQUE: Lane = {
    title: "Torque",
    unit: "mN m",
    series: [{ label: "torque", value: (read) => 1000 * read("torque"), colour: "--accent" }],
};

export const SPEED: Lane = {
    title: "Speed",
    unit: "rpm",
    series: [
        { label: "shaft", value: "speed", colour: "--speed" },
        { label: "set-point", value: "setpoint", colour: "--setpoint", dash: [6, 4] },
    ],
};

/** The floating phase's terminal alone, against half of the bus. */
export const FLOATING: Lane = {
    title: "Floating terminal",
    unit: "V",
    series: [
        ...NAMES.map((name, phase) => ({
            label: name.toUpperCase(),
            value: (read: Read) => (floating(read("step")) === phase ? read(`voltage_${name}`) : Number.NaN),
            colour: `--phase-${name}`,
        })),
        { label: "half of the bus", value: (read: Read) => read("bus_voltage") / 2, colour: "--quiet", dash: [6, 4] },
    ],
};
