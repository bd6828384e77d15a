//! Replay of a node's transcript. It is a module of its own, because it contains both nodes completely and is
//! rarely used.
#![forbid(unsafe_code)]

use js_sys::Object;
use narx_core::eddycan::TxDriver;
use narx_core::node::Node;
use narx_core::recording::transcript::{Transcribable, Transcript, replay, replay_until};
use narx_core::recording::{Kind, ReplayError};
use narx_wasm_values::error::error;
use narx_wasm_values::replay::{count, part, whole};
use wasm_bindgen::prelude::*;

/// Replays the transcript of a drive's node or of a TX-Driver bit for bit: all of it, or its first `until`
/// calls. In the result, `ticks` counts calls.
///
/// Throws an `Error` that names the first wrong byte of a damaged transcript, or that it is not a transcript,
/// and a `RangeError` for an `until` that is not a number of calls.
#[wasm_bindgen(
    js_name = replayTranscript,
    unchecked_return_type = "{ ticks: number; digest: string; recordedDigest?: string; otherBehaviour?: number }"
)]
pub fn replay_transcript(bytes: &[u8], until: Option<f64>) -> Result<Object, JsValue> {
    let until = until.map(count).transpose()?;
    let run = || {
        let file = Transcript::open(bytes)?;
        if file.header().kind == Kind::Node {
            run::<Node>(&file, until)
        } else {
            run::<TxDriver>(&file, until)
        }
    };
    run().map_err(|refused| error(&refused))
}

fn run<D: Transcribable>(file: &Transcript<'_>, until: Option<u64>) -> Result<Object, ReplayError> {
    match until {
        None => replay::<D>(file).map(|outcome| whole(&outcome)),
        Some(calls) => replay_until::<D>(file, calls).map(|prefix| part(&prefix)),
    }
}
