// The states of the specification (section 7) and their transitions (Table 7, and our own T45 and T54), with
// their places in the picture. Standby and Fault, which nearly all states lead to, are tall, so that nearly all lines
// are straight; one of them must cross others.

export interface State {
    name: string;
    /** Action of the bridge. */
    does: string;
    /** Middle of its box, and its size. */
    x: number;
    y: number;
    width: number;
    height: number;
}

export interface Transition {
    name: string;
    from: number;
    to: number;
    when: string;
    /** Corners of its line. */
    line: readonly (readonly [number, number])[];
    /** Place of its name. */
    label: readonly [number, number];
}

export const STATES: State[] = [
    { name: "Initialization", does: "bridge off", x: 183, y: 30, width: 118, height: 44 },
    { name: "Standby", does: "bridge off", x: 42, y: 209, width: 80, height: 402 },
    { name: "Rotor lock", does: "holds the rotor", x: 183, y: 100, width: 118, height: 44 },
    { name: "Open-loop", does: "rotates the field", x: 183, y: 176, width: 118, height: 44 },
    { name: "Sensorless Closed-loop", does: "uses zero crossings", x: 183, y: 262, width: 118, height: 44 },
    { name: "Closed-loop Hall Effect Sensors", does: "uses hall sensors", x: 183, y: 344, width: 118, height: 44 },
    { name: "Fault", does: "bridge off", x: 482, y: 209, width: 80, height: 402 },
    { name: "Sensorless Auto-Restart", does: "listens and retries", x: 348, y: 262, width: 112, height: 44 },
];

/** Names that fit into a box. */
export const SHORT = ["Initialization", "Standby", "Rotor lock", "Open-loop", "Sensorless", "Hall sensors", "Fault", "Auto-restart"];

/** Times of the drive for which it has no parameters, s: of state 0, and of state 7. */
export const [STARTING, LISTENING] = [0.5, 2];

const FAULT = "critical fault, or time-out of a silent master";
const STANDBY = "Standby is requested";

export const TRANSITIONS: Transition[] = [
    { name: "T01", from: 0, to: 1, when: `after ${STARTING} s, if the self-tests have passed`, line: [[124, 30], [82, 30]], label: [102, 21] },
    { name: "T06", from: 0, to: 6, when: "a self-test or the parameter store has failed", line: [[242, 30], [442, 30]], label: [343, 21] },
    { name: "T12", from: 1, to: 2, when: "Drive is requested, sensorless mode is enabled and hall mode is not", line: [[82, 91], [124, 91]], label: [102, 82] },
    { name: "T13", from: 1, to: 3, when: "Drive is requested, and only open loop is enabled", line: [[82, 167], [124, 167]], label: [102, 158] },
    { name: "T15", from: 1, to: 5, when: "Drive is requested, and hall mode is enabled", line: [[82, 335], [124, 335]], label: [102, 326] },
    { name: "T16", from: 1, to: 6, when: "critical fault", line: [[82, 384], [442, 384]], label: [343, 375] },
    { name: "T21", from: 2, to: 1, when: STANDBY, line: [[124, 109], [82, 109]], label: [102, 119] },
    { name: "T23", from: 2, to: 3, when: "the rotor lock time is over", line: [[183, 122], [183, 154]], label: [200, 137] },
    { name: "T26", from: 2, to: 6, when: FAULT, line: [[242, 100], [442, 100]], label: [343, 91] },
    { name: "T31", from: 3, to: 1, when: `${STANDBY}, or the field has stopped`, line: [[124, 185], [82, 185]], label: [102, 195] },
    { name: "T34", from: 3, to: 4, when: "the open-loop time is over, and sensorless mode is enabled", line: [[183, 198], [183, 240]], label: [166, 219] },
    { name: "T36", from: 3, to: 6, when: FAULT, line: [[242, 176], [442, 176]], label: [343, 167] },
    { name: "T41", from: 4, to: 1, when: STANDBY, line: [[124, 262], [82, 262]], label: [102, 253] },
    { name: "T45", from: 4, to: 5, when: "the estimated speed is 0, and the hall sensors show a rotor that turns (parameter 308)", line: [[172, 284], [172, 322]], label: [156, 313] },
    { name: "T46", from: 4, to: 6, when: FAULT, line: [[222, 240], [222, 219], [442, 219]], label: [343, 210] },
    { name: "T47", from: 4, to: 7, when: "the estimated speed is 0", line: [[242, 253], [292, 253]], label: [266, 244] },
    { name: "T51", from: 5, to: 1, when: STANDBY, line: [[124, 353], [82, 353]], label: [102, 363] },
    { name: "T54", from: 5, to: 4, when: "the hall sensors fail, and the terminals show a rotor that turns (parameter 308)", line: [[196, 322], [196, 284]], label: [213, 313] },
    { name: "T56", from: 5, to: 6, when: FAULT, line: [[242, 344], [442, 344]], label: [343, 335] },
    { name: "T61", from: 6, to: 1, when: "the cause is gone, and Standby has been requested since", line: [[442, 400], [82, 400]], label: [183, 391] },
    { name: "T71", from: 7, to: 1, when: `${STANDBY}, or the rotor stands still after ${LISTENING} s`, line: [[348, 284], [348, 303], [82, 303]], label: [290, 294] },
    { name: "T74", from: 7, to: 4, when: `the rotor turns after ${LISTENING} s`, line: [[292, 271], [242, 271]], label: [268, 281] },
    { name: "T76", from: 7, to: 6, when: FAULT, line: [[404, 262], [442, 262]], label: [423, 253] },
];
