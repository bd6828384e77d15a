//! Records the calls to a device on the bus, in order, and replays them to the same answers. The devices are
//! the node of the drive (kind 2) and the TX-Driver (kind 3), which have neither a clock nor a bus of their
//! own.
//!
//! ```text
//!  shell ──calls──> Transcriber ──> bytes ──> Transcript ──> replay ──> the same answers
//!        <─answers─ Digest ───────────────── compared with ────┘
//! ```
//!
//! The container is that of a drive's [recording](super), with the kind in its header, and in the place of
//! the layout version [`CALLS_VERSION`]. What differs:
//!
//! | chunk | payload |
//! |---|---|
//! | `S` | what the device was powered up with, postcard of [`Transcribable::Setup`]: a transcript begins there |
//! | `C` | calls, whole ones, at most [`CHUNK_BYTES`] together: postcard of [`Transcribable::Call`]; or the byte FFh and a varint, the last call so many times more |
//! | `E` | number of calls u64, digest u64 |
//!
//! The digest is CRC-64/XZ over every answer in order: postcard of the call, then of its answer; and in the
//! end over what [`Transcribable::show`] shows of the device. A call that is answered with nothing changes
//! nothing, so a shell leaves it out.

mod drive_node;
mod read;
mod tx_driver;
mod write;

pub use drive_node::{NodeCall, NodeSetup};
pub use read::{Calls, Transcript, replay, replay_until};
pub use tx_driver::{TxDriverCall, TxDriverSetup};
pub use write::Transcriber;

use super::digest::{Check, check};
use super::{Kind, ReplayError};
use postcard::ser_flavors::Flavor;
use serde::Serialize;
use serde::de::DeserializeOwned;

#[allow(unused_imports, reason = "for the documentation")]
use super::CHUNK_BYTES;

/// Version of the calls: rises when the bytes of the chunks `S` and `C` get another meaning, that is, with
/// [`NodeSetup`], [`NodeCall`], [`TxDriverSetup`], [`TxDriverCall`] and every type within them. `NodeSetup`
/// has a value for every parameter, so a new parameter raises it. Answers are in the digest alone: a change
/// of them moves the digest and raises nothing.
pub const CALLS_VERSION: u16 = 2;

/// Stands before the number of repetitions. No call begins with it.
const AGAIN: u8 = 0xff;

/// A device whose only inputs and outputs are the calls of its shell.
pub trait Transcribable: Sized {
    /// Kind of its transcripts.
    const KIND: Kind;
    /// Set-up at power-up.
    type Setup: Serialize + DeserializeOwned;
    /// Call of a shell.
    type Call: Serialize + DeserializeOwned + PartialEq;

    /// Powers up the device.
    ///
    /// # Errors
    /// The device that was recorded has other features than this build.
    fn power_up(setup: Self::Setup) -> Result<Self, ReplayError>;

    /// Repeats a call of the shell and notes the device's answer. `clock` is the last time that the device
    /// was passed.
    fn call(&mut self, call: &Self::Call, clock: &mut u64, answers: &mut Answers);

    /// Notes the visible state of the device.
    fn show(&self, answers: &mut Answers);
}

/// Digest of a device's answers.
#[derive(Clone)]
pub struct Answers(Check);

impl Default for Answers {
    fn default() -> Self {
        Self(check())
    }
}

impl core::fmt::Debug for Answers {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "Answers({:016x})", self.value())
    }
}

impl Answers {
    /// Adds a call or an answer.
    pub fn note(&mut self, said: &impl Serialize) {
        // The digest accepts every byte.
        let _ = postcard::serialize_with_flavor(said, Sum(&mut self.0));
    }

    /// Adds a call and its answer.
    pub(super) fn answer(&mut self, call: &impl Serialize, answer: &impl Serialize) {
        self.note(call);
        self.note(answer);
    }

    /// The digest so far.
    pub fn value(&self) -> u64 {
        self.0.clone().finalize()
    }
}

struct Sum<'a>(&'a mut Check);

impl Flavor for Sum<'_> {
    type Output = ();

    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        self.0.update(&[byte]);
        Ok(())
    }

    fn finalize(self) -> postcard::Result<()> {
        Ok(())
    }
}
