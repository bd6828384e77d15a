//! Missing words of a download, in bounded memory.

use heapless::Vec;

/// Number of separate gaps that can be stored.
const GAPS: usize = 32;

/// Ranges of missing words, in order: begin and, exclusive, end. If there are more gaps than it can hold,
/// some received words still count as missing and are requested once more.
#[derive(Clone, Debug, Default)]
pub(super) struct Missing(Vec<(u32, u32), GAPS>);

impl Missing {
    /// All of `total` words are missing.
    pub(super) fn all(total: u32) -> Self {
        let mut ranges = Vec::new();
        if total > 0 {
            // There is room: it is the first of 32.
            let _ = ranges.push((0, total));
        }
        Self(ranges)
    }

    /// The first range.
    pub(super) fn first(&self) -> Option<(u32, u32)> {
        self.0.first().copied()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Number of missing words.
    pub(super) fn count(&self) -> u32 {
        self.0.iter().fold(0, |sum: u32, (begin, end)| sum.saturating_add(end - begin))
    }

    /// Returns whether any word from `begin` to `end` is missing.
    pub(super) fn wants(&self, begin: u32, end: u32) -> bool {
        self.0.iter().any(|range| range.0 < end && begin < range.1)
    }

    /// Takes the words from `begin` to `end`; returns whether any of them was missing.
    pub(super) fn take(&mut self, begin: u32, end: u32) -> bool {
        let overlaps = |range: &(u32, u32)| range.0 < end && begin < range.1;
        let mut wanted = false;
        // Each turn cuts one range so that it overlaps no more.
        while let Some(place) = self.0.iter().position(overlaps) {
            wanted = true;
            let Some(range) = self.0.get_mut(place) else { break };
            let (left, right) = ((range.0, begin), (end, range.1));
            match (left.0 < left.1, right.0 < right.1) {
                (false, false) => {
                    self.0.remove(place);
                }
                (true, false) => *range = left,
                (false, true) => *range = right,
                (true, true) => {
                    if !self.0.is_full()
                        && let Some(range) = self.0.get_mut(place)
                    {
                        *range = left;
                        // There is room: it was checked above.
                        let _ = self.0.insert(place + 1, right);
                    }
                    break;
                }
            }
        }
        wanted
    }
}
