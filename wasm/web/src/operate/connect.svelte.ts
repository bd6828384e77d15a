// What was chosen on the connection panel, and the connections that come of it.

import type { BusFrame, MotorName, Mode } from "narx";
import type { Action, Setup } from "./bench/messages";
import type { Run } from "./bench/run";
import { openAdapter } from "./link/adapter";
import { play } from "./link/playback";
import { virtualDrive } from "./link/virtual.svelte";
import { session } from "./session.svelte";

/** How long an answer over an adapter may take, s: a browser does other things, too. */
const ADAPTER_TIMEOUT = 0.25;

export const settings = $state({
    motor: "bly172s-24v" as MotorName,
    mode: "hall" as Mode,
    /** V. */
    supplyVoltage: 24,
    /** N m, N m s/rad, N m s2/rad2, kg m2. */
    loadTorque: 0,
    loadViscous: 0,
    loadQuadratic: 0,
    loadInertia: 0,
    /** Degrees Celsius. */
    ambient: 25,
    seed: 1,
    /** On the drive's bus, with node-ids from 2 on. */
    txDrivers: 0,
    /** The virtual drive has log memory, description and bootloader. */
    full: false,
    slave: 170,
    monitor: 85,
    /** ms. */
    setpointPeriod: 50,
    readParameters: true,
    silent: false,
});

export function connectVirtual(setup: Setup, txDrivers = 0): Promise<void> {
    const actions = Array.from({ length: txDrivers }, (_, index): Action => ({ call: "addTxDriver", options: { nodeId: index + 2 } }));
    return session.connect((listener) => virtualDrive.open(setup, actions, listener), master());
}

/** Whether the connection is a virtual drive of this page. */
export function isVirtual(): boolean {
    return session.link?.name.startsWith("Virtual") === true;
}

/** The virtual drive on the bench now, powered up anew with everything that a drive can have. */
export async function connectFull(): Promise<void> {
    settings.full = true;
    const { motor, options } = virtualDrive.opened!.setup;
    await connectVirtual({ motor, options, full: true }, settings.txDrivers);
}

/** The virtual drive that everybody finds who comes without a wish. */
export function connectFirst(): Promise<void> {
    const { motor, mode, supplyVoltage } = settings;
    return connectVirtual({ motor, options: { mode, supplyVoltage } });
}

/** A run that somebody has passed on. */
export function connectRun(run: Run): Promise<void> {
    return session.connect((listener) => virtualDrive.reproduce(run, listener), { ...master(), readParameters: false, readDescription: false });
}

/** A bus log: the master hears what was heard then, and sends nothing. */
export function connectLog(name: string, frames: readonly BusFrame[]): Promise<void> {
    return session.connect(async (listener) => play(name, frames, listener), { ...master(), silent: true });
}

/** Asks the reader for a serial port. */
export function connectAdapter(): Promise<void> {
    return session.connect((listener) => openAdapter(listener, settings.silent), { ...master(), timeout: ADAPTER_TIMEOUT });
}

export function hasSerial(): boolean {
    return "serial" in navigator;
}

function master() {
    const { slave, monitor, setpointPeriod, readParameters, silent } = settings;
    return { slave, monitor, setpointPeriod: setpointPeriod / 1000, readParameters, silent };
}
