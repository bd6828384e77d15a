// Link to a run: the address of this page with the run in it.

import { encode, type Run } from "./bench/run";

/** Name of the run in the route's query. */
export const RUN = "run";

/** Returns the whole address. */
export async function address(run: Run): Promise<string> {
    return `${location.href.split("#")[0]}#/operate/virtual?${RUN}=${await encode(run)}`;
}
