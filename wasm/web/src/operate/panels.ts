// The panels in the order of the navigation.

import type { Component } from "svelte";
import CanTrace from "./CanTrace.svelte";
import Connection from "./Connection.svelte";
import DeviceManager from "./DeviceManager.svelte";
import Files from "./Files.svelte";
import Logging from "./Logging.svelte";
import Main from "./Main.svelte";
import Nodes from "./Nodes.svelte";
import Scope from "./Scope.svelte";
import Update from "./Update.svelte";
import VirtualDrive from "./VirtualDrive.svelte";

export interface PanelEntry {
    /** Name of the panel in the address: `#/operate/PATH`. */
    path: string;
    title: string;
    Panel: Component;
}

export const PANELS: readonly PanelEntry[] = [
    { path: "main", title: "Main panel", Panel: Main },
    { path: "connection", title: "Connection", Panel: Connection },
    { path: "virtual", title: "Virtual drive", Panel: VirtualDrive },
    { path: "parameters", title: "Device manager", Panel: DeviceManager },
    { path: "scope", title: "Virtual scope", Panel: Scope },
    { path: "logging", title: "Logging", Panel: Logging },
    { path: "trace", title: "CAN trace", Panel: CanTrace },
    { path: "nodes", title: "eddyCAN nodes", Panel: Nodes },
    { path: "update", title: "Firmware update", Panel: Update },
    { path: "recordings", title: "Recordings and logs", Panel: Files },
];
