//! The scope's memory.

use super::inputs;
use crate::motor::Drive;
use core::borrow::{Borrow, BorrowMut};

/// Words of a scope that holds as much as parameter 23 can ask for of one signal: 8 KiB.
pub const WORDS: usize = 4096;

/// The memory of a scope, of its shell's choice: of signals `W` holds one word a sample, of inputs two halves of about six words a tick.
#[derive(Clone, Debug)]
#[repr(C)]
pub struct Memory<W: ?Sized = [u16]> {
    /// State of the drive before the first inputs of each half.
    pub(super) checkpoints: [Option<Drive>; 2],
    pub(super) record: Record,
    pub(super) words: W,
}

/// What stands in the words.
#[derive(Clone, Copy, Debug, Default)]
pub(super) enum Record {
    #[default]
    Nothing,
    /// A ring of so many words, the oldest one here.
    Signals { oldest: u16, words: u16 },
    /// The halves, the older one first, and how many of them.
    Inputs { rate: u32, halves: [Half; 2], count: u8 },
}

/// Inputs since a checkpoint.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Half {
    /// Which one.
    pub(super) place: u8,
    /// Number of its first tick.
    pub(super) first: u64,
    pub(super) ticks: u16,
    pub(super) words: u16,
}

impl<const N: usize> Memory<[u16; N]> {
    /// An empty one of `N` words, at most 65 535 of which are used.
    pub const fn new() -> Self {
        Self { checkpoints: [const { None }; 2], record: Record::Nothing, words: [0; N] }
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
    /// Words that are used.
    pub(super) fn room(&self) -> usize {
        self.words.len().min(u16::MAX.into())
    }

    /// Words of half a recording; nothing where it has no room for a tick.
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
