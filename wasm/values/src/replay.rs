//! Results of a replay, as objects. Digests are 16 lower-case hexadecimal digits.

use crate::error::{range_error, shown};
use crate::options::set;
use js_sys::{Number, Object};
use narx_core::recording::{Outcome, Prefix};
use wasm_bindgen::JsValue;

/// Converts the result of a whole recording.
pub fn whole(outcome: &Outcome) -> Object {
    let found = Object::new();
    set(&found, "ticks", outcome.ticks as f64);
    set(&found, "digest", hex(outcome.digest));
    set(&found, "recordedDigest", hex(outcome.recorded_digest));
    if let Some(version) = outcome.other_behaviour {
        set(&found, "otherBehaviour", version);
    }
    found
}

/// Converts the result of the first part of a recording.
pub fn part(prefix: &Prefix) -> Object {
    let found = Object::new();
    set(&found, "ticks", prefix.ticks as f64);
    set(&found, "digest", hex(prefix.digest));
    found
}

/// Converts the length of a replay, or returns a `RangeError`.
pub fn count(until: f64) -> Result<u64, JsValue> {
    // Above 2^53 not every whole number is exact.
    if (0.0..=Number::MAX_SAFE_INTEGER).contains(&until) && until.fract() == 0.0 {
        return Ok(until as u64);
    }
    let until = shown(&until.into());
    Err(range_error(&format!("until {until}: must be a whole number of ticks, 0 or more")))
}

fn hex(digest: u64) -> String {
    format!("{digest:016x}")
}
