// The panels in the order of the navigation.

import type { Component } from "svelte";
import Main from "./Main.svelte";

export interface PanelEntry {
    /** Name of the panel in the address: `#/operate/PATH`. */
    path: string;
    title: string;
    /** Returns the panel, which is loaded when it is opened. */
    load: () => { default: Component } | Promise<{ default: Component }>;
}

export const PANELS: readonly PanelEntry[] = [
    { path: "main", title: "Main panel", load: () => ({ default: Main }) },
    { path: "connection", title: "Connection", load: () => import("./Connection.svelte") },
    { path: "virtual", title: "Virtual drive", load: () => import("./VirtualDrive.svelte") },
    { path: "identify", title: "Identify", load: () => import("./Identify.svelte") },
    { path: "parameters", title: "Device manager", load: () => import("./DeviceManager.svelte") },
    { path: "scope", title: "Virtual scope", load: () => import("./Scope.svelte") },
    { path: "logging", title: "Logging", load: () => import("./Logging.svelte") },
    { path: "trace", title: "CAN trace", load: () => import("./CanTrace.svelte") },
    { path: "nodes", title: "eddyCAN nodes", load: () => import("./Nodes.svelte") },
    { path: "update", title: "Firmware update", load: () => import("./Update.svelte") },
    { path: "recordings", title: "Recordings and logs", load: () => import("./Files.svelte") },
];
