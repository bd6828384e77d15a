//! Replay of recordings.

use crate::status::narx_status_t;
use crate::{pointer, text};
use core::ffi::c_char;
use narx_core::recording::{Outcome, Prefix, replay_any, replay_any_until};

/// Room for the longest line that narx_replay_until writes, the closing 0 included.
pub const NARX_OUTPUTS_TEXT_SIZE: usize = 1024;

/// What a replay found.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_outcome_t {
    /// Ticks run.
    pub ticks: u64,
    /// Digest of the outputs now.
    pub digest: u64,
    /// Digest of the outputs when they were recorded; equal to `digest` if they were the same, bit for bit.
    pub recorded_digest: u64,
    /// A warning: the behaviour version that recorded, where it is another one than this library's (the digests may
    /// then rightly differ); otherwise 0.
    pub other_behaviour: u16,
}

/// Runs a drive from a recording's initial state through all of its ticks, or a node or TX-Driver through the calls of its transcript: what
/// is said of ticks then holds for calls. `bytes` is the recording, `length` bytes.
///
/// What it runs lives on the stack. Any context.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_replay(
    bytes: *const u8,
    length: usize,
    outcome: *mut narx_outcome_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        pointer::check(outcome)?;
        let recording = pointer::bytes(bytes, length)?;
        pointer::write(outcome, replay_any(recording)?.into())
    };
    pointer::status(run())
}

/// The same for the first `ticks` ticks, or all of a shorter recording; `recorded_digest` is 0 then. Writes what the
/// last one of them answered, all fields in one line, into `text`, which has `text_size` bytes: NARX_OUTPUTS_TEXT_SIZE
/// are enough, a longer text is cut, a 0 closes it. The line is empty if no tick was run. If the recording cannot be
/// replayed, it says why and where.
///
/// `text` may be NULL if `text_size` is 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_replay_until(
    bytes: *const u8,
    length: usize,
    ticks: u64,
    outcome: *mut narx_outcome_t,
    text: *mut c_char,
    text_size: usize,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        pointer::check(outcome)?;
        let recording = pointer::bytes(bytes, length)?;
        match replay_any_until(recording, ticks) {
            Ok(prefix) => {
                match prefix.last {
                    Some(outputs) => text::write(text, text_size, outputs)?,
                    None => text::write(text, text_size, "")?,
                }
                pointer::write(outcome, prefix.into())
            }
            Err(error) => {
                text::write(text, text_size, error)?;
                Err(error.into())
            }
        }
    };
    pointer::status(run())
}

impl From<Outcome> for narx_outcome_t {
    fn from(Outcome { ticks, recorded_digest, digest, other_behaviour }: Outcome) -> Self {
        Self { ticks, digest, recorded_digest, other_behaviour: other_behaviour.unwrap_or(0) }
    }
}

impl From<Prefix> for narx_outcome_t {
    fn from(Prefix { ticks, digest, last: _ }: Prefix) -> Self {
        Self { ticks, digest, recorded_digest: 0, other_behaviour: 0 }
    }
}
