// The states of the specification (section 7) and their transitions (Table 7, and our own T45 and T54), with
// their places in the picture.

export interface State {
    name: string;
    /** Action of the bridge. */
    does: string;
    x: number;
    y: number;
}

export interface Transition {
    name: string;
    from: number;
    to: number;
    when: string;
    /** Distance by which the line bends to its left. */
    bend: number;
    /** Place of the name along the line, 0 to 1, and its distance above the line. */
    at?: number;
    above?: number;
}

export const STATES: State[] = [
    { name: "Initialization", does: "bridge off", x: 70, y: 36 },
    { name: "Standby", does: "bridge off", x: 70, y: 196 },
    { name: "Rotor lock", does: "holds the rotor", x: 236, y: 36 },
    { name: "Open-loop", does: "rotates the field", x: 402, y: 36 },
    { name: "Sensorless Closed-loop", does: "uses zero crossings", x: 402, y: 196 },
    { name: "Closed-loop Hall Effect Sensors", does: "uses hall sensors", x: 236, y: 196 },
    { name: "Fault", does: "bridge off", x: 236, y: 376 },
    { name: "Sensorless Auto-Restart", does: "listens and retries", x: 402, y: 376 },
];

/** Names that fit into a box. */
export const SHORT = ["Initialization", "Standby", "Rotor lock", "Open-loop", "Sensorless", "Hall sensors", "Fault", "Auto-restart"];

const FAULT = "critical fault, or time-out of a silent master";
const STANDBY = "Standby is requested";

export const TRANSITIONS: Transition[] = [
    { name: "T01", from: 0, to: 1, when: "half a second has passed, and the self-tests have passed", bend: 0 },
    { name: "T06", from: 0, to: 6, when: "a self-test or the parameter store has failed", bend: -150, at: 0.62 },
    { name: "T12", from: 1, to: 2, when: "Drive is requested, sensorless mode is enabled and hall mode is not", bend: 12, at: 0.62 },
    { name: "T13", from: 1, to: 3, when: "Drive is requested, and only open loop is enabled", bend: 0, at: 0.84 },
    { name: "T15", from: 1, to: 5, when: "Drive is requested, and hall mode is enabled", bend: 16, above: 10 },
    { name: "T16", from: 1, to: 6, when: "critical fault", bend: -14, at: 0.6 },
    { name: "T21", from: 2, to: 1, when: STANDBY, bend: 12, at: 0.66 },
    { name: "T23", from: 2, to: 3, when: "the rotor lock time is over", bend: 0, above: 10 },
    { name: "T26", from: 2, to: 6, when: FAULT, bend: -116, at: 0.3 },
    { name: "T31", from: 3, to: 1, when: `${STANDBY}, or the field has stopped`, bend: 22, at: 0.16 },
    { name: "T34", from: 3, to: 4, when: "the open-loop time is over, and sensorless mode is enabled", bend: 0 },
    { name: "T36", from: 3, to: 6, when: FAULT, bend: -14, at: 0.24 },
    { name: "T41", from: 4, to: 1, when: STANDBY, bend: 84, at: 0.24 },
    { name: "T45", from: 4, to: 5, when: "the estimated speed is 0, and the hall sensors show a rotor that turns (parameter 308)", bend: 16, above: -10 },
    { name: "T46", from: 4, to: 6, when: FAULT, bend: -6, at: 0.3 },
    { name: "T47", from: 4, to: 7, when: "the estimated speed is 0", bend: 12 },
    { name: "T51", from: 5, to: 1, when: STANDBY, bend: 16, above: -10 },
    { name: "T54", from: 5, to: 4, when: "the hall sensors fail, and the terminals show a rotor that turns (parameter 308)", bend: 16, above: 10 },
    { name: "T56", from: 5, to: 6, when: FAULT, bend: 0, at: 0.74 },
    { name: "T61", from: 6, to: 1, when: "the cause is gone, and Standby has been requested since", bend: -14, at: 0.4 },
    { name: "T71", from: 7, to: 1, when: `${STANDBY}, or the rotor stands still after 2 s`, bend: 0, at: 0.2 },
    { name: "T74", from: 7, to: 4, when: "the rotor turns after 2 s", bend: 12 },
    { name: "T76", from: 7, to: 6, when: FAULT, bend: 0, above: 10 },
];
