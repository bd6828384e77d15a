//! The scope's memory.

use super::RECORDER;
use super::inputs::{self, Before, Note};
use super::plan::Plan;
use super::read::Reader;
use super::setup::Setup;
use crate::motor::{self, Drive};
use core::borrow::{Borrow, BorrowMut};

/// Words of a scope that holds the most samples of one signal that parameter 23 can ask for: 8 KiB.
pub const WORDS: usize = 4096;

/// Checkpoints: one for each half of a recording.
const CHECKPOINTS: usize = if RECORDER { 2 } else { 0 };

/// The memory of a scope, whose size the shell chooses. `W` holds one word a sample of a signal, or two
/// halves of inputs with about six words a tick.
#[derive(Clone, Debug)]
#[repr(C)]
pub struct Memory<W: ?Sized = [u16]> {
    /// State of the drive before the first inputs of each half.
    pub(super) checkpoints: [Option<Drive>; CHECKPOINTS],
    pub(super) record: Record,
    /// Reader of the record, while it is downloaded.
    pub(super) reader: Option<Reader>,
    pub(super) plan: Plan,
    pub(super) progress: Progress,
    pub(super) words: W,
}

/// Content of the words.
#[derive(Clone, Copy, Debug, Default)]
pub(super) enum Record {
    #[default]
    Nothing,
    /// A ring of `words` words, the oldest one at `oldest`.
    Signals { oldest: u16, words: u16 },
    /// The halves, the older one first, and their number.
    Inputs { rate: u32, halves: [Half; 2], count: u8 },
}

/// Progress of the record.
#[derive(Clone, Copy, Debug)]
pub(super) struct Progress {
    pub(super) phase: Phase,
    /// A change of the phase has not been reported yet.
    pub(super) changed: bool,
    /// Samples still to come: before the trigger counts, or until the record is full. For inputs, one counts
    /// before the trigger: the first checkpoint.
    pub(super) left: u16,
    pub(super) before: Quiet,
    pub(super) ring: Ring,
    pub(super) course: Course,
}

/// [`State`](super::State) as the control tick knows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Phase {
    /// Armed.
    Watching,
    /// Armed: the trigger has come, and some samples before it have not.
    Fired,
    Recording,
    Done,
}

/// Values of the last tick, with which a trigger compares.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quiet {
    pub(super) holds: bool,
    pub(super) state: motor::State,
    pub(super) faults: u32,
}

/// Progress of a record of signals.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ring {
    /// Place at which this sample begins.
    pub(super) place: u16,
    /// Signals of this sample that have been read.
    pub(super) read: u8,
    /// Ticks since the sample was complete.
    pub(super) waited: u16,
}

/// Progress of a record of inputs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Course {
    /// The event of this tick.
    pub(super) note: Note,
    /// The half that is being filled, if one is.
    pub(super) now: Option<Half>,
    /// The other half, if it comes before without a gap.
    pub(super) older: Option<Half>,
    pub(super) before: Before,
    /// The trigger lies in the older half, which may not be lost any more.
    pub(super) keeps: bool,
    /// Ticks for which the first checkpoint may still wait for a calm tick.
    pub(super) patience: u8,
}

/// Longest wait of the first checkpoint for a calm tick, ticks. It takes longer than the scope's other work,
/// so it avoids ticks that are long themselves.
pub(super) const PATIENCE: u8 = 16;

impl Progress {
    const fn new(before: u16) -> Self {
        Self {
            phase: Phase::Watching,
            changed: false,
            left: before,
            // A level that holds already is no edge; the drive's present state is no change.
            before: Quiet { holds: true, state: motor::State::Initialization, faults: u32::MAX },
            ring: Ring { place: 0, read: 0, waited: 0 },
            course: Course {
                note: Note::Nothing,
                now: None,
                older: None,
                before: Before::START,
                keeps: false,
                patience: PATIENCE,
            },
        }
    }
}

/// Inputs since a checkpoint.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Half {
    /// Place in the memory, 0 or 1.
    pub(super) place: u8,
    /// Number of its first tick.
    pub(super) first: u64,
    pub(super) ticks: u16,
    pub(super) words: u16,
}

impl<const N: usize> Memory<[u16; N]> {
    /// An empty memory of `N` words, at most 65 535 of which are used.
    pub const fn new() -> Self {
        Self {
            checkpoints: [const { None }; CHECKPOINTS],
            record: Record::Nothing,
            reader: None,
            plan: Plan::new(),
            progress: Progress::new(0),
            words: [0; N],
        }
    }
}

impl<const N: usize> Default for Memory<[u16; N]> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> Borrow<Memory> for Memory<[u16; N]> {
    fn borrow(&self) -> &Memory {
        self
    }
}

impl<const N: usize> BorrowMut<Memory> for Memory<[u16; N]> {
    fn borrow_mut(&mut self) -> &mut Memory {
        self
    }
}

impl Memory {
    /// Forgets its record and begins another, if there is room for it.
    pub(super) fn begin(&mut self, setup: &Setup) -> bool {
        (self.record, self.reader) = (Record::Nothing, None);
        let Some(plan) = Plan::of(setup, self) else { return false };
        self.progress = Progress::new(if plan.keeps_inputs() { 1 } else { plan.before });
        self.plan = plan;
        true
    }

    /// Closes a full record: from now on it can be read.
    pub(super) fn close(&mut self) {
        let Progress { ring, course, .. } = &self.progress;
        self.record = if self.plan.keeps_inputs() {
            let halves = [course.older, course.now];
            let count = halves.iter().flatten().count() as u8;
            let [older, now] = halves.map(Option::unwrap_or_default);
            let halves = if count == 2 { [older, now] } else { [now, older] };
            Record::Inputs { rate: self.plan.tick_rate, halves, count }
        } else {
            // The ring is full, so the oldest sample is where the next one would go.
            Record::Signals { oldest: ring.place, words: self.plan.length as u16 }
        };
    }

    /// Words that are used.
    pub(super) fn room(&self) -> usize {
        self.words.len().min(u16::MAX.into())
    }

    /// Words of half a recording; 0 if that has no room for a tick.
    pub(super) fn half(&self) -> usize {
        let half = self.room() / 2;
        if half < inputs::WORDS_MAX { 0 } else { half }
    }

    /// Inputs in a half.
    pub(super) fn inputs(&self, half: Half) -> &[u16] {
        let begin = usize::from(half.place) * self.half();
        self.words.get(begin..begin + usize::from(half.words)).unwrap_or_default()
    }
}
