// The time of a real drive, which cannot be stopped: plots and measurements go back, the drive runs on.

import { recorder } from "./recorder.svelte";
import type { Timed } from "./timed";

/** An instant as near to the present as this is the present, s. */
const NEAR = 0.05;

export const liveTime: Timed = {
    names: ["Hold view", "Back to live"],
    get begin() {
        return recorder.history.begin;
    },
    get end() {
        return recorder.now;
    },
    get now() {
        return recorder.end;
    },
    get playing() {
        return recorder.past === undefined;
    },
    get note() {
        return recorder.past === undefined ? undefined : "Plots and measurements show this instant. The drive runs on: strip, lamps and commands are live.";
    },
    seek(time) {
        recorder.past = time < recorder.now - NEAR ? time : undefined;
    },
    play(playing) {
        recorder.past = playing ? undefined : recorder.now;
    },
};
