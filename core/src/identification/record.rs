//! A record of the drive's scope, in units.

use crate::motor::signal::{DRIVE_SIGNALS, Signal};
use heapless::Vec;

/// Longest record, words: the memory of a scope (8 KiB).
pub(super) const WORDS: usize = 4096;

/// Rows of some signals, one after the other.
#[derive(Clone, Debug, Default)]
pub(super) struct Record {
    words: Vec<i16, WORDS>,
    /// Signals in the order of their bits, with what one step of a word is in the signal's unit.
    steps: Vec<f64, 4>,
    /// Time from one row to the next, s.
    pub(super) interval: f64,
}

impl Record {
    /// Begins a record of these signals, in the order of their bits.
    pub(super) fn begin(&mut self, signals: &[Signal], interval: f64) {
        self.words.clear();
        self.steps.clear();
        self.interval = interval;
        for signal in signals {
            let base =
                DRIVE_SIGNALS.iter().find(|row| row.signal == *signal).map_or(0, |row| row.base.digits);
            let _ = self.steps.push(base as f64 / 4096.0);
        }
    }

    /// Puts words to their place.
    pub(super) fn put(&mut self, offset: u32, words: &[u16]) {
        for (at, word) in (offset as usize..).zip(words) {
            if at >= self.words.len() && self.words.resize(at + 1, 0).is_err() {
                return;
            }
            if let Some(place) = self.words.get_mut(at) {
                *place = *word as i16;
            }
        }
    }

    /// Number of rows of `N` signals.
    pub(super) fn len<const N: usize>(&self) -> usize {
        self.words.len() / N
    }

    /// A row of `N` signals, in their units.
    pub(super) fn row<const N: usize>(&self, row: usize) -> Option<[f64; N]> {
        let words = self.words.get(N * row..N * (row + 1))?;
        Some(core::array::from_fn(|at| match (words.get(at), self.steps.get(at)) {
            (Some(word), Some(step)) => f64::from(*word) * step,
            _ => 0.0,
        }))
    }

    /// Every row of `N` signals.
    pub(super) fn rows<const N: usize>(&self) -> impl DoubleEndedIterator<Item = [f64; N]> + Clone + '_ {
        (0..self.len::<N>()).filter_map(|row| self.row(row))
    }
}

/// Bits of signals, as parameter 22 takes them.
pub(super) fn channels(signals: &[Signal]) -> u32 {
    signals.iter().map(|signal| 1 << *signal as u32).sum()
}
