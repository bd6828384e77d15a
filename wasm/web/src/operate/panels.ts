// The panels in the order of the navigation.

import type { Component } from "svelte";
import Main from "./Main.svelte";
import Recordings from "./Recordings.svelte";

export interface PanelEntry {
    /** In the address: `#/operate/PATH`. */
    path: string;
    title: string;
    Panel: Component;
}

export const PANELS: readonly PanelEntry[] = [
    { path: "main", title: "Main panel", Panel: Main },
    { path: "recordings", title: "Recordings", Panel: Recordings },
];
