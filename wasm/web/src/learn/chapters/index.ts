// The chapters in the order in which they are read.

import type { Component } from "svelte";
import SixSteps from "./SixSteps.svelte";

export interface Chapter {
    /** In the address. */
    path: string;
    title: string;
    /** What the reader does there. */
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
];
