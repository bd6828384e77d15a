// The time of the virtual drive.

import { virtualDrive } from "./link/virtual.svelte";
import type { Timed } from "./timed";

const PACES = [
    [1, "real time"],
    [0.1, "1/10"],
    [0.01, "1/100"],
    [0.001, "1/1000"],
] as const;
const rate = () => virtualDrive.opened?.tickRate ?? 10_000;

export const virtualTime: Timed = {
    begin: 0,
    paces: PACES,
    get end() {
        return virtualDrive.now.end / rate();
    },
    get now() {
        return virtualDrive.now.time;
    },
    get tick() {
        return 1 / rate();
    },
    get playing() {
        return virtualDrive.now.pace > 0;
    },
    get pace() {
        return virtualDrive.pace;
    },
    get steps() {
        return [
            { title: "−1 tick", by: -1 },
            { title: "+1 tick", by: 1 },
            { title: "+10 ms", by: Math.round(rate() / 100) },
        ];
    },
    get note() {
        const { ticks, end } = virtualDrive.now;
        return ticks < end ? "The arrows and steps look at the run as it was. What comes after this instant is discarded as soon as time runs from here." : undefined;
    },
    seek: (time) => virtualDrive.seek(Math.round(time * rate())),
    play: (playing) => (playing ? virtualDrive.resume() : virtualDrive.pause()),
    setPace(pace) {
        virtualDrive.pace = pace;
        if (virtualDrive.now.pace > 0) {
            virtualDrive.resume();
        }
    },
    /** In the past, steps look at the run as it was. */
    step(by) {
        const { ticks, end } = virtualDrive.now;
        const wanted = Math.max(0, ticks + by);
        if (wanted > end) {
            virtualDrive.step(wanted - ticks);
        } else {
            virtualDrive.seek(wanted);
        }
    },
};
