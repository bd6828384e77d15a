//! Captured edges of the hall lines: which period they belong to, in what order they came, and what the lines
//! were after each.

use crate::timing::{PERIOD, instant};
use heapless::Vec;
use narx_core::motor::{Edge, EdgeSource, Samples};

/// Hall lines.
pub const LINES: usize = 3;
/// Captures that are known at once: one of each line that waits for its tick, and one new one.
const HELD: usize = 2 * LINES;

/// One line's capture: the count of TIM4 at its last edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Capture {
    /// 0 to 2.
    pub line: u8,
    /// Count of TIM4.
    pub at: u16,
}

/// The captures that lie in the present period wait for the next tick here.
#[derive(Clone, Debug, Default)]
pub struct Edges {
    held: Vec<Capture, HELD>,
}

impl Edges {
    /// Adds a capture. True if there is no room, which more than two edges of a line in a period need.
    #[must_use]
    pub fn push(&mut self, capture: Capture) -> bool {
        self.held.push(capture).is_err()
    }

    /// Puts the edges of the period before the one that began at `start` (count of TIM4) into `samples`,
    /// whose hall level is of now. What is older than that period, as after the processor stood still, is
    /// counted as lost.
    pub fn take(&mut self, start: u16, samples: &mut Samples) {
        let age = |capture: &Capture| start.wrapping_sub(capture.at);
        // After the present level was reached, the lines changed by what has been captured since the
        // boundary.
        let since = self.held.iter().filter(|capture| !has_ended(age(capture)));
        let mut code = since.fold(samples.hall, |code, capture| code ^ 1 << capture.line);
        // Youngest first, each takes back what it did.
        sort_by(&mut self.held, age);
        let mut kept = Vec::new();
        for capture in &self.held {
            match age(capture) {
                age if !has_ended(age) => _ = kept.push(*capture),
                age @ 1..=PERIOD => {
                    let edge = Edge { instant: instant(PERIOD - age), source: EdgeSource::Hall, code };
                    if samples.edges.push(edge).is_err() {
                        samples.edges_lost = samples.edges_lost.saturating_add(1);
                    }
                    code ^= 1 << capture.line;
                }
                _ => samples.edges_lost = samples.edges_lost.saturating_add(1),
            }
        }
        samples.edges.reverse();
        self.held = kept;
    }
}

/// A handful, most often in order already: neighbours are exchanged, without the kilobyte of a sort for any
/// length.
fn sort_by(captures: &mut [Capture], key: impl Fn(&Capture) -> u16) {
    for _ in 0..captures.len() {
        for place in 0..captures.len() {
            if let Some([first, second]) = captures.get_mut(place..place + 2)
                && key(first) > key(second)
            {
                core::mem::swap(first, second);
            }
        }
    }
}

/// Returns whether a capture of this age, counts before the boundary, lies before the boundary; a negative
/// age is that of a capture in the present period.
const fn has_ended(age: u16) -> bool {
    age != 0 && age < 1 << 15
}
