//! Mirror of the drive's parameters as last received, and its reader in the background.

use super::Received;
use crate::dictionary::{Dictionary, PARAMETER_COUNT, Parameter, number};

/// Time stamp of an unknown value: later than any real one.
const NEVER: u64 = u64::MAX;

/// The drive's parameters as last received, from all answers to this master and from nothing else. A value
/// that the drive changes by itself shows only when it is read again.
#[derive(Clone, Debug)]
pub struct ParameterMirror {
    raw: [i32; PARAMETER_COUNT],
    /// Time at which each was last received, microseconds.
    at: [u64; PARAMETER_COUNT],
}

impl Default for ParameterMirror {
    /// Nothing is known.
    fn default() -> Self {
        Self { raw: [0; PARAMETER_COUNT], at: [NEVER; PARAMETER_COUNT] }
    }
}

impl ParameterMirror {
    /// The raw value of a parameter (unit and scale: its row), if it is known.
    pub fn get(&self, number: u16) -> Option<Received<i32>> {
        self.at_index(Dictionary::index(number)?)
    }

    /// The raw value of the parameter of that name, if it is known; case does not matter.
    pub fn find(&self, name: &str) -> Option<Received<i32>> {
        self.get(Dictionary::find(name)?.number)
    }

    /// Every row in the order of the numbers, with its raw value where it is known.
    pub fn iter(&self) -> impl Iterator<Item = (&'static Parameter, Option<Received<i32>>)> + '_ {
        Dictionary::rows().enumerate().map(|(index, row)| (row, self.at_index(index)))
    }

    /// Number of known parameters.
    pub fn known(&self) -> usize {
        self.at.iter().filter(|at| **at != NEVER).count()
    }

    pub(super) fn note(&mut self, number: u16, raw: i32, now: u64) {
        if let Some(index) = Dictionary::index(number)
            && let (Some(value), Some(at)) = (self.raw.get_mut(index), self.at.get_mut(index))
        {
            (*value, *at) = (raw, now.min(NEVER - 1));
        }
    }

    pub(super) const fn forget(&mut self) {
        self.at = [NEVER; PARAMETER_COUNT];
    }

    fn at_index(&self, index: usize) -> Option<Received<i32>> {
        let at = *self.at.get(index)?;
        let value = *self.raw.get(index)?;
        (at != NEVER).then_some(Received { value, at })
    }
}

/// Shortest time from one row to the next, microseconds. A request and its answer take 640 of them
/// (PROTOCOL.md, section 1.4); the rest of the bus is left to other traffic.
const PACE: u64 = 2000;

/// Reader in the background: of the exact state, and of all parameters row by row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reader {
    /// The next row; behind the last one when all are read.
    row: usize,
    state: bool,
    /// The row that was requested.
    asked: Option<usize>,
    /// Earliest time of the next request for a row, microseconds.
    due: u64,
}

impl Default for Reader {
    /// Nothing is to be read.
    fn default() -> Self {
        Self { row: PARAMETER_COUNT, state: false, asked: None, due: 0 }
    }
}

impl Reader {
    pub(super) const fn read_all(&mut self) {
        self.row = 0;
    }

    pub(super) const fn read_state(&mut self) {
        self.state = true;
    }

    /// Rows that are still to be read.
    pub(super) const fn left(&self) -> usize {
        PARAMETER_COUNT.saturating_sub(self.row)
    }

    /// Time of the next request, microseconds; `u64::MAX` if there is none.
    pub(super) const fn due(&self) -> u64 {
        match (self.state, self.left()) {
            (true, _) => 0,
            (false, 0) => u64::MAX,
            (false, _) => self.due,
        }
    }

    /// Number of the next parameter.
    pub(super) fn next(&mut self, now: u64) -> Option<u16> {
        if now < self.due() {
            return None;
        }
        if core::mem::take(&mut self.state) {
            self.asked = None;
            return Some(number::DRIVE_STATE);
        }
        self.asked = Some(self.row);
        self.due = now.saturating_add(PACE);
        Dictionary::rows().nth(self.row).map(|row| row.number)
    }

    /// Ends the request under way; a row without an answer is skipped.
    pub(super) fn finish(&mut self) {
        // Reading may have begun anew meanwhile.
        if self.asked.take() == Some(self.row) {
            self.row += 1;
        }
    }
}
