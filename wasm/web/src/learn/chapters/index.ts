// The chapters in the order in which they are read.

import type { Component } from "svelte";
import BackEmf from "./BackEmf.svelte";
import Demagnetisation from "./Demagnetisation.svelte";
import Faults from "./Faults.svelte";
import Frames from "./Frames.svelte";
import Halls from "./Halls.svelte";
import OpenLoop from "./OpenLoop.svelte";
import SensorlessStart from "./SensorlessStart.svelte";
import SixSteps from "./SixSteps.svelte";
import SpeedLoop from "./SpeedLoop.svelte";

export interface Chapter {
    /** Name of the chapter in the address. */
    path: string;
    title: string;
    /** Task of the reader in the chapter. */
    about: string;
    page: Component;
}

export const CHAPTERS: Chapter[] = [
    {
        path: "six-steps",
        title: "Six-step commutation",
        about: "Turn a rotor by hand, see the torque of each step, and let the drive commutate.",
        page: SixSteps,
    },
    {
        path: "back-emf",
        title: "Back-EMF and its zero crossings",
        about: "Spin the rotor, see the voltage that it induces, and find the zero crossings that the drive uses.",
        page: BackEmf,
    },
    {
        path: "open-loop",
        title: "Open loop, and why it stalls",
        about: "Shorten the ramp until the rotor no longer follows, and see that the drive does not detect it.",
        page: OpenLoop,
    },
    {
        path: "sensorless-start",
        title: "Sensorless start, tick by tick",
        about: "Rotor lock, kick and hand-over: stop the time at any control tick.",
        page: SensorlessStart,
    },
    {
        path: "demagnetisation",
        title: "Demagnetisation and hidden crossings",
        about: "Increase current and inductance until the conducting diode hides the zero crossing.",
        page: Demagnetisation,
    },
    {
        path: "hall-sensors",
        title: "Hall sensors and misalignment",
        about: "Shift the sensors, watch the current rise, and let the drive calibrate itself.",
        page: Halls,
    },
    {
        path: "speed-loop",
        title: "Speed loop and current limit",
        about: "Change the gains and see the response to a load step at once.",
        page: SpeedLoop,
    },
    {
        path: "faults",
        title: "Faults and the state machine",
        about: "Provoke faults, follow the transitions between the states, and acknowledge.",
        page: Faults,
    },
    {
        path: "frames",
        title: "The CAN frames behind every click",
        about: "Command the drive over CAN and read each frame bit by bit.",
        page: Frames,
    },
];
