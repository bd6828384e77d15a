// Replays recordings in Node: `node replay.mjs [--ticks N] FILE...`

import { replay } from "../../wasm/pkg/node/lab.js";
import { replayTranscript } from "../../wasm/pkg/node/transcript.js";
import { isTranscript, main } from "./replayer.mjs";

await main((bytes, ticks) => (isTranscript(bytes) ? replayTranscript : replay)(bytes, ticks));
