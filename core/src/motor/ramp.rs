//! Rate limit of a set-point.

use serde::{Deserialize, Serialize};

/// A value that approaches its target by at most a rate per step; 16 extra fraction bits keep slow ramps
/// moving.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Ramp {
    value: i64,
}

impl Ramp {
    /// One step towards `target` (raw I16F16) by at most `rate` (raw I16F16 with 16 extra bits, per step, >=
    /// 0).
    #[inline]
    pub fn step(&mut self, target: i32, rate: i64) -> i32 {
        let target = (target as i64) << 16;
        if self.value == target {
            return self.value();
        }
        let rate = rate.max(0);
        let distance = (target - self.value).clamp(rate.saturating_neg(), rate);
        self.value += distance;
        self.value()
    }

    /// [`step`](Self::step); true if the value has changed.
    #[inline]
    pub fn advance(&mut self, target: i32, rate: i64) -> bool {
        let moves = !self.rests_at(target);
        self.step(target, rate);
        moves
    }

    /// Continues from `value` (raw I16F16).
    #[inline]
    pub fn set(&mut self, value: i32) {
        self.value = (value as i64) << 16;
    }

    /// It has reached `target` (raw I16F16).
    #[inline]
    pub const fn rests_at(&self, target: i32) -> bool {
        self.value == (target as i64) << 16
    }

    /// Present value (raw I16F16). It never leaves the range of the value that was set and of the targets.
    #[inline]
    pub const fn value(&self) -> i32 {
        (self.value >> 16) as i32
    }
}
