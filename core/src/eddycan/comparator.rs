//! A comparator: is the position above a fraction of the measuring range?

use crate::bus::eddycan::Position;
use serde::{Deserialize, Serialize};

/// Measuring range of a sensor, from its start to its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "[Position; 2]", into = "[Position; 2]")]
pub struct MeasuringRange {
    start: Position,
    end: Position,
}

impl From<MeasuringRange> for [Position; 2] {
    fn from(range: MeasuringRange) -> Self {
        [range.start, range.end]
    }
}

impl TryFrom<[Position; 2]> for MeasuringRange {
    type Error = &'static str;

    fn try_from([start, end]: [Position; 2]) -> Result<Self, Self::Error> {
        Self::new(start, end).ok_or("a measuring range whose end lies beyond its start")
    }
}

impl MeasuringRange {
    /// A range, or `None` unless the end lies beyond the start.
    pub fn new(start: Position, end: Position) -> Option<Self> {
        (start < end).then_some(Self { start, end })
    }

    /// Returns whether the position is above `fraction` of the range, 2^-30. An equal position is not above.
    pub fn is_above(&self, position: Position, fraction: u32) -> bool {
        let from_start = |to: Position| i64::from(to.raw()) - i64::from(self.start.raw());
        // position - start > fraction (end - start), without a rounding: both sides stay below 2^63.
        from_start(position) << 30 > from_start(self.end) * i64::from(fraction)
    }
}
