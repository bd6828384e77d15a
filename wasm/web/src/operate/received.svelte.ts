// Speed and set-point, as received on the bus.

import { Rolling } from "./rolling.svelte";

export const chart = new Rolling();
