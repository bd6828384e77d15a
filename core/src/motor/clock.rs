//! The drive's clock: control ticks as instants, deadlines, and the time between them.

use super::interval::TICK;
use serde::{Deserialize, Serialize};

/// A control tick, counted from power-up. The count wraps, so instants are compared by their distance, which
/// must stay below 2^31 ticks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Instant(u32);

/// The farthest deadline, 2^30 ticks: 29 hours at 10 kHz. A station that has nothing to do until then is
/// asked all the same.
const HORIZON: u32 = 1 << 30;

impl Instant {
    /// The tick after this one.
    #[inline]
    pub const fn next(self) -> Self {
        Self(self.0.wrapping_add(1))
    }

    /// The instant that many ticks later, at most the farthest deadline.
    #[inline]
    pub const fn after(self, ticks: u32) -> Self {
        Self(self.0.wrapping_add(if ticks < HORIZON { ticks } else { HORIZON }))
    }

    /// Ticks since an `earlier` instant.
    #[inline]
    pub const fn since(self, earlier: Self) -> u32 {
        self.0.wrapping_sub(earlier.0)
    }

    /// The time since an `earlier` instant, 1/65 536 tick, saturating.
    #[inline]
    pub const fn time_since(self, earlier: Self) -> u32 {
        let ticks = self.since(earlier);
        if ticks >> 16 == 0 { ticks * TICK } else { u32::MAX }
    }

    /// This deadline has come by `now`.
    #[inline]
    pub const fn is_due(self, now: Self) -> bool {
        now.0.wrapping_sub(self.0) as i32 >= 0
    }

    /// This instant of the past, or the oldest one that `now` can still be compared with.
    pub const fn within_reach(self, now: Self) -> Self {
        if now.since(self) > HORIZON { Self(now.0.wrapping_sub(HORIZON)) } else { self }
    }

    /// The earlier of two deadlines.
    #[inline]
    pub const fn earlier(self, other: Self) -> Self {
        if other.is_due(self) { other } else { self }
    }
}
