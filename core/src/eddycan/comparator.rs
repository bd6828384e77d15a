//! A comparator: is the position above a fraction of the measuring range?

use crate::bus::eddycan::Position;

/// What a sensor measures, from its start to its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeasuringRange {
    start: Position,
    end: Position,
}

impl MeasuringRange {
    /// A range, or `None` unless the end lies beyond the start.
    pub fn new(start: Position, end: Position) -> Option<Self> {
        (start < end).then_some(Self { start, end })
    }

    /// Whether the position is above `fraction` of the range, 2^-30. At it is not above.
    pub fn is_above(&self, position: Position, fraction: u32) -> bool {
        let from_start = |to: Position| i64::from(to.raw()) - i64::from(self.start.raw());
        // position - start > fraction (end - start), without a rounding: both sides stay below 2^63.
        from_start(position) << 30 > from_start(self.end) * i64::from(fraction)
    }
}
