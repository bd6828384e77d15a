// The page: controls and readings around a bench that runs in a worker.

import "./style.css";
import type { MotorName } from "narx";
import type { Answer, Now, Request } from "./messages";
import { Plot } from "./plot";
import { Replays } from "./replays";

/** The element of that id; the ids stand in index.html. */
function element<T extends HTMLElement>(id: string): T {
    return document.getElementById(id) as T;
}

const motor = element<HTMLSelectElement>("motor");
const setpoint = element<HTMLInputElement>("setpoint");
const slider = element<HTMLInputElement>("slider");
const start = element<HTMLButtonElement>("start");
const stop = element<HTMLButtonElement>("stop");
const plot = new Plot(element("plot"));
const replays = new Replays(element("replays"));
const worker = new Worker(new URL("./worker.ts", import.meta.url), { type: "module" });

let latest: Now | undefined;
let running = false;

function ask(request: Request): void {
    worker.postMessage(request);
}

function write(id: string, text: string): void {
    const place = element(id);
    // An unchanged text is not announced again.
    if (place.textContent !== text) {
        place.textContent = text;
    }
}

function complain(reason: string | undefined): void {
    element("problem").hidden = reason === undefined;
    write("problem", reason ?? "");
}

function open(): void {
    running = false;
    latest = undefined;
    plot.clear();
    complain(undefined);
    ask({ kind: "open", motor: motor.value as MotorName });
}

function opened({ speedMin, speedMax, notes }: Answer & { kind: "opened" }): void {
    const [min, max] = [Math.ceil(speedMin / 10) * 10, Math.floor(speedMax / 10) * 10];
    for (const input of [setpoint, slider]) {
        input.min = String(min);
        input.max = String(max);
        input.value = String(Math.round((min + max) / 20) * 10);
    }
    const list = element("notes");
    list.hidden = notes.length === 0;
    list.replaceChildren(...notes.map((note) => Object.assign(document.createElement("li"), { textContent: note })));
}

function show(): void {
    if (latest) {
        const { time, state, stateName, speed, current, voltage, fault } = latest;
        write("speed", speed.toFixed(0));
        write("current", current.toFixed(2));
        write("voltage", voltage.toFixed(1));
        write("time", time.toFixed(1));
        write("state", stateName);
        // A request that comes during boot starts nothing.
        start.disabled = running || state === 0;
        stop.disabled = !running;
        if (fault !== undefined) {
            complain(`The drive has stopped: ${fault}. Stop acknowledges it.`);
        }
        plot.show();
    }
    requestAnimationFrame(show);
}

function handle(answer: Answer): void {
    switch (answer.kind) {
        case "motors":
            motor.replaceChildren(...answer.motors.map(({ name, title }) => new Option(title, name)));
            return open();
        case "opened":
            return opened(answer);
        case "ran":
            latest = answer.now;
            return plot.append(answer.rows);
        case "replayed":
            return replays.found(answer.name, answer.found);
        case "refused":
            return answer.name === undefined ? complain(answer.reason) : replays.refused(answer.name, answer.reason);
    }
}

worker.addEventListener("message", ({ data }: MessageEvent<Answer>) => handle(data));
worker.addEventListener("error", ({ message }) => complain(`The simulation cannot run here: ${message}`));
motor.addEventListener("change", open);
element<HTMLFormElement>("controls").addEventListener("submit", (event) => {
    event.preventDefault();
    running = true;
    complain(undefined);
    ask({ kind: "start", rpm: setpoint.valueAsNumber });
});
stop.addEventListener("click", () => {
    running = false;
    complain(undefined);
    ask({ kind: "stop" });
});
for (const [changed, other] of [[setpoint, slider], [slider, setpoint]] as const) {
    changed.addEventListener("input", () => {
        if (changed.checkValidity()) {
            other.value = changed.value;
            ask({ kind: "setSpeed", rpm: changed.valueAsNumber });
        }
    });
}
element<HTMLInputElement>("recordings").addEventListener("change", async (event) => {
    for (const file of (event.target as HTMLInputElement).files ?? []) {
        ask({ kind: "replay", name: file.name, bytes: new Uint8Array(await file.arrayBuffer()) });
    }
});
document.addEventListener("visibilitychange", () => ask({ kind: "pause", paused: document.hidden }));
requestAnimationFrame(show);
