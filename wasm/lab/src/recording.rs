//! Running a recording again.

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
/** What a replay found. Digests are 16 lower-case hexadecimal digits. */
export interface Replay {
    /** Ticks run. */
    readonly ticks: number;
    /** Digest of the outputs now. */
    readonly digest: string;
    /** Digest of the outputs when they were recorded; absent for a prefix. */
    readonly recordedDigest?: string;
    /** The recorder's behaviour version, where it is another one than ours: digests may then rightly differ. */
    readonly otherBehaviour?: number;
    /** For a prefix: every output of its last tick, in one line of raw bits; absent if no tick was run. */
    readonly outputs?: string;
}

/** What a scope has recorded of the inputs of every control tick. */
export interface ScopeRecording {
    /** What `replay` takes, and a `.narxrec` file holds. */
    readonly recording: Uint8Array;
    /** Number of its first tick since the drive's power-up. */
    readonly firstTick: number;
    /** Whether the replay came to what the drive did itself, from its second checkpoint on; absent where the record has none. */
    readonly agrees?: boolean;
}
"#;

/// Runs a recording again, bit for bit: all of it, or its first `until` ticks.
///
/// Throws an `Error` that names the byte where a damaged recording is wrong, and a `RangeError` for an `until`
/// that is not a count of ticks.
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

/// The trace of a recording that runs again, or of its first `until` ticks: what the drive was given, what it answered, and what it thought meanwhile. Its
/// speeds are electrical, because a recording does not tell the pole pairs. Throws as `replay`.
#[wasm_bindgen(js_name = replayTrace)]
pub fn replay_trace(bytes: &[u8], until: Option<f64>) -> Result<Trace, JsValue> {
    let until = until.map(count).transpose()?;
    replayed(bytes, until).map(|found| found.trace.into()).map_err(|refused| error(&refused))
}

/// The recording that a scope's record of inputs is: the bytes of the download. Throws an `Error` for one of another version, or one that is damaged.
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
