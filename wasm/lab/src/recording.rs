//! Replay of recordings.

use js_sys::{Object, Uint8Array};
use narx_core::motor::Drive;
use narx_core::recording::{self, Recording, record_scoped};
use narx_sim::recording::RecordingBuffer;
use narx_sim::replayed::replayed;
use narx_wasm_values::error::error;
use narx_wasm_values::options::set;
use narx_wasm_values::replay::{count, part, whole};
use narx_wasm_values::trace::Trace;
use wasm_bindgen::prelude::*;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** Result of a replay. Digests are 16 lower-case hexadecimal digits. */
export interface Replay {
    /** Number of ticks that were run. */
    readonly ticks: number;
    /** Digest of the outputs of this replay. */
    readonly digest: string;
    /** Digest of the outputs when they were recorded; absent for a prefix. */
    readonly recordedDigest?: string;
    /** Behaviour version of the recorder, if it differs from this version's: digests may then rightly
     * differ. */
    readonly otherBehaviour?: number;
    /** For a prefix: every output of its last tick, in one line of raw bits; absent if no tick was run. */
    readonly outputs?: string;
}

/** The scope's record of the inputs of every control tick, as a recording. */
export interface ScopeRecording {
    /** Bytes of the recording, for `replay` or a `.narxrec` file. */
    readonly recording: Uint8Array;
    /** Number of its first tick since the drive's power-up. */
    readonly firstTick: number;
    /** True if the replay's state equals the drive's own at the record's second checkpoint; absent if the
     * record has none. */
    readonly agrees?: boolean;
}
"#;

/// Replays a recording bit for bit: all of it, or its first `until` ticks.
///
/// Throws an `Error` that names the first wrong byte of a damaged recording, and a `RangeError` for an
/// `until` that is not a number of ticks.
#[wasm_bindgen(unchecked_return_type = "Replay")]
pub fn replay(bytes: &[u8], until: Option<f64>) -> Result<JsValue, JsValue> {
    let file = Recording::open(bytes).map_err(|refused| error(&refused))?;
    let found = match until {
        None => {
            let outcome = recording::replay::<Drive>(&file).map_err(|refused| error(&refused))?;
            whole(&outcome)
        }
        Some(until) => {
            let prefix = recording::replay_until::<Drive>(&file, count(until)?);
            let prefix = prefix.map_err(|refused| error(&refused))?;
            let found = part(&prefix);
            if let Some(outputs) = prefix.last {
                set(&found, "outputs", outputs.to_string());
            }
            found
        }
    };
    Ok(found.into())
}

/// Replays a recording, or its first `until` ticks, and returns its trace: inputs, outputs and internal
/// values of the drive. Its speeds are electrical, because a recording does not contain the pole pairs.
/// Throws as `replay` does.
#[wasm_bindgen(js_name = replayTrace)]
pub fn replay_trace(bytes: &[u8], until: Option<f64>) -> Result<Trace, JsValue> {
    let until = until.map(count).transpose()?;
    replayed(bytes, until).map(|found| found.trace.into()).map_err(|refused| error(&refused))
}

/// Converts a scope's record of inputs, the bytes of the download, to a recording. Throws an `Error` for a
/// record of another version, or one that is damaged.
#[wasm_bindgen(js_name = scopeRecording, unchecked_return_type = "ScopeRecording")]
pub fn scope_recording(bytes: &[u8], label: &str) -> Result<Object, JsValue> {
    let words: Vec<u16> = bytes.as_chunks().0.iter().map(|word| u16::from_be_bytes(*word)).collect();
    let scoped =
        record_scoped(&words, label, RecordingBuffer::default()).map_err(|refused| error(&refused))?;
    let found = Object::new();
    set(&found, "recording", Uint8Array::from(scoped.sink.0.as_slice()));
    set(&found, "firstTick", scoped.first as f64);
    if let Some(agrees) = scoped.agrees {
        set(&found, "agrees", agrees);
    }
    Ok(found)
}
