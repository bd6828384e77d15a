//! A range of values, told by one subtraction and one comparison.

use serde::{Deserialize, Serialize};

/// A range of values: the lowest one, and their number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Band {
    low: i32,
    count: u32,
}

impl Band {
    /// No value at all.
    pub const EMPTY: Self = Self { low: 0, count: 0 };

    /// `low..=high`, less than 2^32 values; nothing if `high` is below `low`.
    pub const fn new(low: i32, high: i32) -> Self {
        let count = if low <= high { high.wrapping_sub(low) as u32 } else { return Self { low, count: 0 } };
        Self { low, count: count.wrapping_add(1) }
    }

    /// The part of this band within `low..=high`.
    pub fn within(self, low: i32, high: i32) -> Self {
        let last = self.low.wrapping_add(self.count.wrapping_sub(1) as i32);
        if self.is_empty() { self } else { Self::new(self.low.max(low), last.min(high)) }
    }

    /// `value` lies in it.
    #[inline]
    pub const fn contains(self, value: i32) -> bool {
        (value.wrapping_sub(self.low) as u32) < self.count
    }

    /// The lowest value, if there is one.
    pub const fn low(self) -> i32 {
        self.low
    }

    /// It contains no value.
    #[inline]
    pub const fn is_empty(self) -> bool {
        self.count == 0
    }
}
