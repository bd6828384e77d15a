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

export const BUS_CURRENT: Lane = {
    title: "Bus current",
    unit: "A",
    series: [{ label: "bus current", value: "bus_current", colour: "--accent" }],
};

export const BUS_VOLTAGE: Lane = {
    title: "Bus voltage",
    unit: "V",
    series: [{ label: "bus voltage", value: "bus_voltage", colour: "--accent" }],
};

/** Returns a lane with the back-EMF of each phase; `peak` is in V at 1 rpm. */
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
    least: 100,
    series: [
        { label: "shaft", value: "speed", colour: "--speed" },
        { label: "set-point", value: "setpoint", colour: "--setpoint", dashed: true },
    ],
};

/** Returns whether a zero crossing was accepted in this row. */
const accepted = (read: Read) => read("crossing") === 1 && read("crossing_margin") !== read("crossing_margin", 1);

/** Voltage of the floating phase's terminal, measured from half of the bus voltage, with the crossings that the
 * drive has accepted. */
export const FLOATING: Lane = {
    title: "Floating, from half",
    unit: "V",
    height: 150,
    least: 1,
    series: [
        ...NAMES.map((name, phase) => ({
            label: name.toUpperCase(),
            value: (read: Read) => (floating(read("step")) === phase ? read(`voltage_${name}`) - read("bus_voltage") / 2 : Number.NaN),
            colour: `--phase-${name}`,
        })),
        { label: "half of the bus voltage", value: () => 0, colour: "--quiet", dashed: true },
        { label: "accepted crossing", value: (read: Read) => (accepted(read) ? 0 : Number.NaN), colour: "--field", points: true },
    ],
};

export const STEPS: Lane = {
    title: "Step",
    unit: "",
    height: 90,
    range: [0, 13],
    series: [{ label: "step", value: "step", colour: "--accent", stepped: true }],
};

/** Limiters of the duty, by the number of the signal `limiter` (parameter 280). */
export const LIMITERS = [
    "bridge off", "fixed level", "speed loop", "bus current", "phase current", "power", "temperature", "maximum duty", "slew rate",
    "no regeneration into the bus", "crossings not detected",
];

/** Outcomes of the last step's zero crossing, by the number of the signal `crossing` (parameter 287). */
export const CROSSINGS = ["none yet", "accepted", "filtered: too early", "blind: not seen", "late: already over", "detected while coasting"];
