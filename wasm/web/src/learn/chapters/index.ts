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
    /** The reader's task in the chapter. */
    about: string;
    page: Component;
}

export const CHAPTERS: Chapter[] = [
    {
        path: "six-steps",
        title: "What six steps are",
        about: "Turn a rotor by hand, feel the torque of each step, and let the drive do it.",
        page: SixSteps,
    },
    {
        path: "back-emf",
        title: "Back-EMF and its zero crossings",
        about: "Spin the rotor and see its voltage; find the crossings where the drive finds them.",
        page: BackEmf,
    },
    {
        path: "open-loop",
        title: "Open loop, and why it stalls",
        about: "Drag a ramp until the rotor no longer follows, and see that the drive does not notice.",
        page: OpenLoop,
    },
    {
        path: "sensorless-start",
        title: "A start without sensors, tick by tick",
        about: "Lock, kick, hand-over: stop time wherever you like.",
        page: SensorlessStart,
    },
    {
        path: "demagnetisation",
        title: "What demagnetisation hides",
        about: "Raise current and inductance until the diode covers the crossing.",
        page: Demagnetisation,
    },
    {
        path: "hall-sensors",
        title: "Hall sensors, and one that is misaligned",
        about: "Shift the sensors, watch the current rise, and let the drive calibrate itself.",
        page: Halls,
    },
    {
        path: "speed-loop",
        title: "Speed loop and current limit",
        about: "Drag the gains and see the response to a load at once.",
        page: SpeedLoop,
    },
    {
        path: "faults",
        title: "Faults and the state machine",
        about: "Break things, follow the way through the states, acknowledge.",
        page: Faults,
    },
    {
        path: "frames",
        title: "The frames behind every click",
        about: "Command the drive over CAN and read each frame bit by bit.",
        page: Frames,
    },
];
