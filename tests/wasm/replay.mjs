// Replays recordings in Node: `node replay.mjs [--ticks N] FILE...`

import { replay } from "../../wasm/pkg/node/lab.js";
import { main } from "./replayer.mjs";

await main((bytes, ticks) => replay(bytes, ticks));
