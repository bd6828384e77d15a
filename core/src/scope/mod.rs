//! The virtual scope (8.4.4 of the specification) records the drive around a trigger, at the control rate:
//! either signals, or the inputs of every tick with the drive's state before the first, which make a
//! recording that can be replayed bit for bit.
//!
//! ```text
//!              ScopeTask             Order, with the memory
//!   Node ---------------> Keeper ---------------------------> Scope, beside the Drive in the control tick's half
//!        <---------------        <---------------------------
//!             ScopeReply             Answer, with the memory
//! ```
//!
//! The memory has one owner at any time: the scope while armed, the keeper in the background when done. The
//! keeper reads the record to the node at the pace of the bus. A record stays until the scope is armed again.

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

/// True if this build has a scope, and (`RECORDER`) one that records inputs.
pub(crate) const SCOPE: bool = cfg!(feature = "scope");
const RECORDER: bool = cfg!(feature = "recorder");

/// Task of the node for the scope.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ScopeTask {
    /// Wait for a trigger. The last record is lost.
    Arm(Setup),
    /// Do not wait any longer.
    Force,
    /// Read the record from its first word.
    Read,
}

/// Reply to the node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ScopeReply {
    /// Present state, and the number of words of a record that can be read.
    State(State, u16),
    /// Part of the record.
    Block(Block),
    /// Words that the memory holds.
    Room(u16),
}

/// Reason why a request of the master was refused (parameter 306).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum Refusal {
    /// Not refused.
    #[default]
    None = 0,
    /// There is no record to download.
    NoRecord = 1,
    /// The scope is recording, or about to be armed.
    Busy = 2,
    /// Signals times samples exceed the memory.
    TooLong = 3,
    /// Reading the signals takes more ticks than the prescaler leaves.
    TooFast = 4,
    /// No sample is left for the time after the trigger.
    TooEarly = 5,
    /// There is no memory, or none for a recording of inputs.
    NoMemory = 6,
    /// The signal does not exist.
    UnknownSignal = 7,
}

impl Refusal {
    const ALL: [Self; 8] = [
        Self::None,
        Self::NoRecord,
        Self::Busy,
        Self::TooLong,
        Self::TooFast,
        Self::TooEarly,
        Self::NoMemory,
        Self::UnknownSignal,
    ];

    /// Returns the refusal of this number; `None` (0) for a number that this version does not know.
    pub fn of(raw: i32) -> Self {
        Self::ALL.into_iter().find(|refusal| *refusal as i32 == raw).unwrap_or_default()
    }

    /// Meaning in plain words.
    pub const fn meaning(self) -> &'static str {
        match self {
            Self::None => "not refused",
            Self::NoRecord => "no record is stored",
            Self::Busy => "a recording is in progress",
            Self::TooLong => "the samples of all signals exceed the scope memory",
            Self::TooFast => "the prescaler is too small for this number of signals",
            Self::TooEarly => "all samples are before the trigger",
            Self::NoMemory => "the drive has no memory for this record",
            Self::UnknownSignal => "an unknown signal is selected",
        }
    }
}

/// Three words of the record; zeros follow the last one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Block {
    /// Place of the first one.
    pub address: u16,
    /// Samples of the signals in turn, oldest first; or of a recording, [`Inputs`].
    pub words: [u16; 3],
    /// This is the last block.
    pub last: bool,
}

/// State of the scope (parameter 260).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum State {
    /// No activity.
    #[default]
    Idle = 0,
    /// It waits for its trigger, and keeps the samples before it.
    Armed = 1,
    /// It was triggered, and fills its memory.
    Recording = 2,
    /// The record can be read.
    Done = 3,
}

impl State {
    const ALL: [Self; 4] = [Self::Idle, Self::Armed, Self::Recording, Self::Done];

    /// Returns the state of this number; idle for a number that this version does not know.
    pub fn of(raw: i32) -> Self {
        Self::ALL.into_iter().find(|state| *state as i32 == raw).unwrap_or_default()
    }

    /// Name in plain words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Idle => "idle",
            Self::Armed => "armed",
            Self::Recording => "recording",
            Self::Done => "done",
        }
    }
}

/// Order to the control tick's half. `H` holds the [`Memory`].
#[derive(Clone, Debug)]
pub enum Order<H> {
    /// Wait for a trigger, with this memory, which knows what to record.
    Arm(H),
    /// Do not wait any longer.
    Force,
}

/// Answer of the control tick's half.
#[derive(Clone, Debug)]
pub enum Answer<H> {
    /// The trigger has come.
    Triggered,
    /// The record is complete, and stands in this memory.
    Done(H),
}
