// Speed and set-point as they were heard on the bus.

import { Rolling } from "./rolling.svelte";

export const chart = new Rolling();
