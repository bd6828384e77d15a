//! The virtual scope (8.4.4 of the specification): what the drive did around a trigger, at the control rate. Either signals of it, or the
//! inputs of every tick with the drive's state before the first: a recording, which runs again bit for bit.
//!
//! ```text
//!               Request              Order, with the memory
//!   Node ---------------> Keeper ---------------------------> Scope, beside the Drive in the control tick's half
//!        <---------------        <---------------------------
//!          Report, Blocks          Answer, with the memory
//! ```
//!
//! The memory has one owner at any time: armed, the scope; done, the keeper in the background, who reads the record to the node at the
//! bus' pace. Nothing but another arming takes a record away.

mod inputs;
mod keeper;
mod memory;
mod plan;
mod read;
mod setup;
mod tick;

pub use keeper::Keeper;
pub use memory::{Memory, WORDS};
pub use read::{Inputs, MalformedInputs, Segment};
pub use setup::{SIGNALS_A_TICK, Setup, Threshold, Trigger, period};
pub use tick::Scope;

use serde::{Deserialize, Serialize};

/// Whether this build has a scope at all, and one that records inputs.
pub(crate) const SCOPE: bool = cfg!(feature = "scope");
const RECORDER: bool = cfg!(feature = "recorder");

/// What the node asks of the scope.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Request {
    /// Wait for a trigger. What was recorded is lost.
    Arm(Setup),
    /// Do not wait any longer.
    Force,
    /// Read the record from its first word.
    Read,
}

/// What the node is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Report {
    /// It does this now, and a record of so many words can be read.
    State(State, u16),
    /// Part of the record.
    Block(Block),
    /// Words that the memory holds.
    Room(u16),
}

/// Why a request of the master was refused (parameter 306).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum Refusal {
    /// It was not.
    #[default]
    None = 0,
    /// There is no record to download.
    NoRecord = 1,
    /// It records, or is about to be armed.
    Busy = 2,
    /// Signals times samples exceed the memory.
    TooLong = 3,
    /// Reading the signals takes more ticks than the prescaler leaves.
    TooFast = 4,
    /// No sample is left for what comes after the trigger.
    TooEarly = 5,
    /// There is no memory, or none for a recording of inputs.
    NoMemory = 6,
    /// A signal that there is not.
    UnknownSignal = 7,
}

/// Three words of the record; zeros follow the last one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Block {
    /// Place of the first one.
    pub address: u16,
    /// Samples of the signals in turn, oldest first; or of a recording, [`Inputs`].
    pub words: [u16; 3],
    /// None follow.
    pub last: bool,
}

/// What the scope does (parameter 260).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum State {
    /// Nothing.
    #[default]
    Idle = 0,
    /// It waits for its trigger, and keeps what goes before.
    Armed = 1,
    /// It was triggered, and fills its memory.
    Recording = 2,
    /// The record can be read.
    Done = 3,
}

/// To the control tick's half. `H` holds the [`Memory`].
#[derive(Clone, Debug)]
pub enum Order<H> {
    /// Wait for a trigger, with this memory, which knows what to record.
    Arm(H),
    /// Do not wait any longer.
    Force,
}

/// From the control tick's half.
#[derive(Clone, Debug)]
pub enum Answer<H> {
    /// The trigger has come.
    Triggered,
    /// The record is complete, and stands in this memory.
    Done(H),
}
