//! Replay of recordings.

use crate::status::narx_status_t;
use crate::{pointer, text};
use core::ffi::c_char;
use narx_core::eddycan::TxDriver;
use narx_core::motor::Drive;
use narx_core::node::Node;
use narx_core::recording::transcript::{self, Transcribable, Transcript};
use narx_core::recording::{Kind, Outcome, Prefix, Recording, ReplayError, replay, replay_until};

/// Size of the longest line that narx_replay_until writes, the closing 0 included.
pub const NARX_OUTPUTS_TEXT_SIZE: usize = 1024;

/// Result of a replay.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_outcome_t {
    /// Number of ticks that were run.
    pub ticks: u64,
    /// Digest of the outputs of this replay.
    pub digest: u64,
    /// Digest of the outputs when they were recorded; equal to `digest` if they were the same, bit for bit.
    pub recorded_digest: u64,
    /// A warning: the behaviour version of the recorder if it differs from this library's (the digests may
    /// then rightly differ); otherwise 0.
    pub other_behaviour: u16,
}

/// Runs a drive from a recording's initial state through all of its ticks. `bytes` is the recording, `length`
/// bytes.
///
/// The drive is on the stack. Any context.
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
        pointer::write(outcome, whole(recording)?.into())
    };
    pointer::status(run())
}

/// Runs the first `ticks` ticks of a recording, or all of a shorter one, as narx_replay does;
/// `recorded_digest` is then 0. Writes all outputs of the last tick in one line into `text`, which has
/// `text_size` bytes: NARX_OUTPUTS_TEXT_SIZE are enough. A longer text is cut; a closing 0 ends it. The line
/// is empty if no tick was run. If the recording cannot be replayed, the line holds the reason and the place.
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
        match prefix(recording, ticks) {
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

/// Powers up a drive's node, or a TX-Driver, as described in a transcript, and makes the first `calls` calls
/// of the transcript, or all of a shorter one (UINT64_MAX: all). `bytes` is the transcript, `length` bytes.
/// In the outcome `ticks` counts calls, and `recorded_digest` is 0 unless all calls were requested.
///
/// The device is on the stack. Any context.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_replay_transcript(
    bytes: *const u8,
    length: usize,
    calls: u64,
    outcome: *mut narx_outcome_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        pointer::check(outcome)?;
        let recording = pointer::bytes(bytes, length)?;
        pointer::write(outcome, of_transcript(recording, calls)?)
    };
    pointer::status(run())
}

fn whole(bytes: &[u8]) -> Result<Outcome, ReplayError> {
    replay::<Drive>(&Recording::open(bytes)?)
}

fn prefix(bytes: &[u8], ticks: u64) -> Result<Prefix, ReplayError> {
    replay_until::<Drive>(&Recording::open(bytes)?, ticks)
}

fn of_transcript(bytes: &[u8], calls: u64) -> Result<narx_outcome_t, ReplayError> {
    let file = Transcript::open(bytes)?;
    match file.header().kind {
        Kind::TxDriver => told::<TxDriver>(&file, calls),
        Kind::Node | Kind::Drive => told::<Node>(&file, calls),
    }
}

fn told<D: Transcribable>(file: &Transcript<'_>, calls: u64) -> Result<narx_outcome_t, ReplayError> {
    if calls == u64::MAX {
        return transcript::replay::<D>(file).map(Into::into);
    }
    transcript::replay_until::<D>(file, calls).map(Into::into)
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
