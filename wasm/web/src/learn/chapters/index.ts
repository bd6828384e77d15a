// The chapters in the order in which they are read.

import type { Component } from "svelte";

export interface Chapter {
    /** Name of the chapter in the address. */
    path: string;
    title: string;
    /** Task of the reader in the chapter. */
    about: string;
    /** Loads the chapter. */
    load: () => Promise<{ default: Component }>;
}

export const CHAPTERS: Chapter[] = [
    {
        path: "six-steps",
        title: "Six-step commutation",
        about: "Turn a rotor by hand, see the torque of each step, and let the drive commutate.",
        load: () => import("./SixSteps.svelte"),
    },
    {
        path: "back-emf",
        title: "Back-EMF and its zero crossings",
        about: "Spin the rotor, see the voltage that it induces, and find the zero crossings that the drive uses.",
        load: () => import("./BackEmf.svelte"),
    },
    {
        path: "open-loop",
        title: "Open loop, and why it stalls",
        about: "Shorten the ramp until the rotor no longer follows, and see that the drive does not detect it.",
        load: () => import("./OpenLoop.svelte"),
    },
    {
        path: "sensorless-start",
        title: "Sensorless start, tick by tick",
        about: "Rotor lock, kick and hand-over: stop the time at any control tick.",
        load: () => import("./SensorlessStart.svelte"),
    },
    {
        path: "demagnetisation",
        title: "Demagnetisation and hidden crossings",
        about: "Increase current and inductance until the conducting diode hides the zero crossing.",
        load: () => import("./Demagnetisation.svelte"),
    },
    {
        path: "hall-sensors",
        title: "Hall sensors and misalignment",
        about: "Shift the sensors, watch the current rise, and let the drive calibrate itself.",
        load: () => import("./HallSensors.svelte"),
    },
    {
        path: "speed-loop",
        title: "Speed loop and current limit",
        about: "Change the gains and see the response to a load step at once.",
        load: () => import("./SpeedLoop.svelte"),
    },
    {
        path: "identification",
        title: "How a drive measures its motor",
        about: "Hold the rotor, let it go and let it coast: five figures without a data sheet.",
        load: () => import("./Identification.svelte"),
    },
    {
        path: "faults",
        title: "Faults and the state machine",
        about: "Provoke faults, follow the transitions between the states, and acknowledge.",
        load: () => import("./Faults.svelte"),
    },
    {
        path: "frames",
        title: "The CAN frames behind every click",
        about: "Command the drive over CAN and read each frame bit by bit.",
        load: () => import("./Frames.svelte"),
    },
];
