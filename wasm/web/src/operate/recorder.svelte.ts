// Everything that was received of the drive, and its events, as a source of plots.

import type { Drive } from "narx/drive";
import type { Table } from "narx/drive";
import type { MeasurementSignal, Parameter } from "narx/core";
import uPlot from "uplot";
import { History } from "../plot/history";
import { Pulse } from "../plot/pulse.svelte";
import type { Event, Signal, Source } from "../plot/source";
import { ROW } from "./bench/messages";
import { virtualDrive } from "./link/virtual.svelte";
import { plain } from "./measured";
import { valueNames } from "./meaning";
import { nodes } from "./nodes.svelte";
import { FAULT, STATES } from "./states";
import { setpointOf } from "./view";

/** Largest number of events; the oldest are removed. */
const EVENTS = 500;
/** Shortest time between two rows, s. */
const APART = 0.02;
/** Prefix of the columns of the virtual drive's true values. */
const TRUE = "true ";
const LIMITER = "Active limiter";

const OWN: readonly Signal[] = [
    { key: "speed", name: "Speed", unit: "rpm", group: "Drive", manual: "speed of the sensors that the control mode uses", atLeast: 100 },
    { key: "setpoint", name: "Set-point", unit: "rpm", group: "Drive", dashed: true, atLeast: 100 },
    { key: "state", name: "State", unit: "", group: "Drive", stepped: true, names: new Map(STATES.entries()), atLeast: 7 },
    {
        key: "limiter",
        name: "Limiter",
        unit: "",
        group: "Drive",
        manual: LIMITER,
        stepped: true,
        atLeast: 10,
    },
];

const PLANT: readonly Signal[] = [
    { key: "speed", name: "True speed", unit: "rpm", atLeast: 100 },
    { key: "setpoint", name: "Ramped set-point", unit: "rpm", dashed: true, atLeast: 100 },
    { key: "bus_current", name: "True bus current", unit: "A", atLeast: 0.1 },
    { key: "bus_voltage", name: "True bus voltage", unit: "V", atLeast: 1 },
    { key: "torque", name: "True torque", unit: "N m", atLeast: 0.01 },
    { key: "duty", name: "Duty", unit: "", atLeast: 0.1 },
] satisfies { key: (typeof ROW)[number]; name: string; unit: string; dashed?: boolean; atLeast: number }[];
const TRUTH: readonly Signal[] = PLANT.map((signal) => ({ ...signal, key: TRUE + signal.key, group: "Virtual drive, true values" }));

class Recorder implements Source {
    readonly live = true;
    readonly history = new History();
    events = $state.raw<readonly Event[]>([]);
    /** Earlier instant that plots and measurements show while a real drive runs on, s. */
    past = $state<number>();
    #now = 0;
    readonly #pulse = new Pulse();
    #signals = $state.raw<readonly MeasurementSignal[]>([]);
    #limiter = $state.raw<Parameter>();
    #virtual = $state(false);
    /** Names of the positions that TX-Drivers have sent. */
    #positions = $state.raw<readonly string[]>([]);
    #state: number | undefined;
    #faults = "";
    #setpoint = 0;
    #last = -Infinity;
    readonly signals = $derived<readonly Signal[]>([
        ...OWN.map((signal) => (signal.manual === LIMITER ? { ...signal, names: valueNames(this.#limiter?.description ?? "") } : signal)),
        ...this.#signals.map(({ name, unit }) => ({ key: name, unit, manual: name, ...plain(name) })),
        ...this.#positions.map((name) => ({ key: name, name, unit: "mm", group: "TX-Drivers" })),
        ...(this.#virtual ? TRUTH : []),
    ]);

    get begin(): number {
        return this.#virtual ? Math.min(this.history.begin, virtualDrive.rows.begin) : this.history.begin;
    }

    get end(): number {
        return this.past ?? this.now;
    }

    /** The link's present time, s. */
    get now(): number {
        this.#pulse.read();
        return this.#now;
    }

    /** Tells the link's present time, s. */
    tell(now: number): void {
        this.#now = now;
        this.#pulse.change();
    }

    /** Records what the master knows of the drive now. A run that has returned to an earlier instant continues
     * here: what was recorded of later instants is removed. */
    append(time: number, { master }: Drive): void {
        const { speed, state, faults, critical, connected } = master;
        if (!connected || speed === undefined || (time >= this.#last && time < this.#last + APART)) {
            return;
        }
        if (time < this.#last) {
            this.events = this.events.filter((event) => event.time < time);
        }
        this.#last = time;
        const setpoint = setpointOf(master);
        const row: Record<string, [number]> = { speed: [speed], setpoint: [setpoint], state: [state ?? NaN], limiter: [limiter(master)] };
        for (const { name, value } of master.measurements()) {
            row[name] = [value];
        }
        for (const [name, position] of Object.entries(nodes.positions())) {
            row[name] = [position];
            if (!this.#positions.includes(name)) {
                this.#positions = [...this.#positions, name];
            }
        }
        this.history.append([time], row);
        const fault = (faults ?? []).join(", ").replaceAll("_", " ");
        if (state !== this.#state && state !== undefined) {
            const reason = state === FAULT && critical?.meaning !== undefined ? `: ${critical.meaning}` : "";
            this.#mark({ time, text: `${STATES[state] ?? state}${reason}`, tone: state === FAULT ? "fault" : "state" });
        } else if (fault !== this.#faults && fault !== "") {
            this.#mark({ time, text: fault, tone: "fault" });
        }
        if (setpoint !== this.#setpoint && setpoint !== 0) {
            this.#mark({ time, text: `${setpoint} rpm`, tone: "command" });
        }
        [this.#state, this.#faults, this.#setpoint] = [state, fault, setpoint];
    }

    /** Tells the recorder which signals and parameters the drive has, and whether it is a virtual one. */
    describe(signals: readonly MeasurementSignal[], parameters: readonly Parameter[], virtual: boolean): void {
        [this.#signals, this.#virtual] = [signals, virtual];
        this.#limiter = parameters.find(({ name }) => name === LIMITER);
    }

    clear(): void {
        this.past = undefined;
        this.history.clear();
        this.#positions = [];
        this.events = [];
        [this.#state, this.#faults, this.#setpoint, this.#last] = [undefined, "", 0, -Infinity];
        this.tell(0);
    }

    window(keys: readonly string[], from: number, to: number, points: number): uPlot.AlignedData {
        const [received, plant] = [keys.filter((key) => !key.startsWith(TRUE)), keys.filter((key) => key.startsWith(TRUE))];
        const end = Math.min(to, this.past ?? this.#now);
        const own = () => this.history.window(received, from, end, points);
        const truth = () => virtualDrive.rows.window(plant.map((key) => key.slice(TRUE.length)), from, end, points);
        if (plant.length === 0) {
            return own();
        }
        if (received.length === 0) {
            return truth();
        }
        const [time, ...columns] = uPlot.join([own(), truth()]);
        // In the order of the keys.
        const order = [...received, ...plant];
        return [time, ...keys.map((key) => columns[order.indexOf(key)])] as uPlot.AlignedData;
    }

    at(key: string, time: number): number {
        return key.startsWith(TRUE) ? virtualDrive.rows.at(key.slice(TRUE.length), time) : this.history.at(key, time);
    }

    /** Returns every row that was kept; with true values, a row for each time of theirs. */
    table(keys: readonly string[], from: number, to: number): Table {
        const end = Math.min(to, this.#now);
        const rows = keys.some((key) => key.startsWith(TRUE)) ? virtualDrive.rows : this.history;
        const { time } = rows.table([], {}, from, end);
        const named = this.signals.filter(({ key }) => keys.includes(key));
        const columns = named.map(({ key, name }) => [name, Float64Array.from(time, (instant) => this.at(key, instant))]);
        return { time, columns: Object.fromEntries(columns), units: Object.fromEntries(named.map(({ name, unit }) => [name, unit])) };
    }

    #mark(event: Event): void {
        this.events = [...this.events.slice(1 - EVENTS), event];
    }
}

/** Returns the limiter as last read; NaN if the drive has none. */
function limiter(master: Drive["master"]): number {
    try {
        return master.parameter(LIMITER) ?? NaN;
    } catch {
        return NaN;
    }
}

export const recorder = new Recorder();
