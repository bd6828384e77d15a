// Settings of the connection panel, and the connections that are made from them.

import type { BusFrame, MotorName, Mode } from "narx";
import type { Action, Setup } from "./bench/messages";
import { PWM_RATE, type Run } from "./bench/run";
import { openAdapter } from "./link/adapter";
import { openBridge } from "./link/bridge";
import { openGsUsb } from "./link/gsUsb";
import { Playback } from "./link/playback.svelte";
import { virtualDrive } from "./link/virtual.svelte";
import { session } from "./session.svelte";

/** Longest time until an answer through an adapter, s; browsers may delay frames. */
const ADAPTER_TIMEOUT = 0.25;

export const settings = $state({
    motor: "bly172s-24v" as MotorName,
    mode: "hall" as Mode,
    /** Supply voltage, V. */
    supplyVoltage: 24,
    /** PWM frequency of the drive's board, Hz. */
    pwmRate: PWM_RATE,
    /** Load torques, N m, N m s/rad, N m s2/rad2, and load inertia, kg m2. */
    loadTorque: 0,
    loadViscous: 0,
    loadQuadratic: 0,
    loadInertia: 0,
    /** Ambient temperature, degrees Celsius. */
    ambient: 25,
    seed: 1,
    /** Number of TX-Drivers on the drive's bus, with node-ids from 2 on. */
    txDrivers: 0,
    /** True if the virtual drive has log memory, description and bootloader. */
    full: false,
    slave: 170,
    monitor: 85,
    /** Period of the set-points, ms. */
    setpointPeriod: 50,
    readParameters: true,
    silent: false,
    /** Address of a WebSocket bridge, and its token. */
    bridge: "ws://127.0.0.1:8765/",
    token: "",
});

export function connectVirtual(setup: Setup, txDrivers = 0): Promise<void> {
    const actions = Array.from({ length: txDrivers }, (_, index): Action => ({ call: "addTxDriver", options: { nodeId: index + 2 } }));
    return session.connect((listener) => virtualDrive.open(setup, actions, listener), master());
}

/** Powers up the present virtual drive again, with all functions of a drive. */
export async function connectFull(): Promise<void> {
    settings.full = true;
    const { motor, options } = virtualDrive.opened!.setup;
    await connectVirtual({ motor, options, full: true }, settings.txDrivers);
}

/** Connects the default virtual drive, for a reader who has not chosen one. */
export function connectFirst(): Promise<void> {
    const { motor, mode, supplyVoltage } = settings;
    return connectVirtual({ motor, options: { mode, supplyVoltage } });
}

/** Connects the run that another user, or a chapter, has passed on. In that of a chapter no master has read the
 * parameters. */
export function connectRun(run: Run): Promise<void> {
    return session.connect((listener) => virtualDrive.reproduce(run, listener), { ...master(), readParameters: run.setup.options.operator === true, readDescription: false });
}

/** Connects a bus log: the master receives the logged frames, and sends nothing. */
export function connectLog(name: string, frames: readonly BusFrame[]): Promise<void> {
    return session.connect(async (listener) => new Playback(name, frames, listener), { ...master(), silent: true });
}

/** Asks the user for a serial port, and connects the adapter. */
export function connectAdapter(): Promise<void> {
    return session.connect((listener) => openAdapter(listener, settings.silent), { ...master(), timeout: ADAPTER_TIMEOUT });
}

/** Asks the user for a gs_usb adapter, and connects it. */
export function connectGsUsb(): Promise<void> {
    return session.connect((listener) => openGsUsb(listener, settings.silent), { ...master(), timeout: ADAPTER_TIMEOUT });
}

/** Connects the bridge of the settings. */
export function connectBridge(): Promise<void> {
    return session.connect((listener) => openBridge(listener, settings.bridge, settings.token), { ...master(), timeout: ADAPTER_TIMEOUT });
}

/** Applies changed addresses and set-point period to the present connection. */
export function applyMaster(): void {
    const { slave, monitor, setpointPeriod } = master();
    session.configure({ slave, monitor, setpointPeriod });
}

export function hasSerial(): boolean {
    return "serial" in navigator;
}

export function hasUsb(): boolean {
    return "usb" in navigator;
}

function master() {
    const { slave, monitor, setpointPeriod, readParameters, silent } = settings;
    return { slave, monitor, setpointPeriod: setpointPeriod / 1000, readParameters, silent };
}
