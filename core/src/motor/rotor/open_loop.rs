//! Open loop: a field that turns by itself, from standstill up a frequency ramp.

use crate::motor::clock::Instant;
use crate::motor::commutate::commutation::Direction;
use crate::motor::ramp::Ramp;
use serde::{Deserialize, Serialize};

/// Coefficients of the open-loop generator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(C)]
pub struct OpenLoopCoefficients {
    /// Speed at the end of the ramp, electrical rev/s, raw I16F16 (parameter 88).
    pub speed: i32,
    /// Rise a millisecond, raw I16F16 with 16 extra bits (parameters 88 and 109).
    pub rate: i64,
    /// Level while the field stands still (rotor lock level, but no more than the open-loop level). Levels as
    /// `initial_level` of the control's coefficients.
    pub level_start: i32,
    /// Level at the end of the ramp (parameter 87).
    pub level: i32,
    /// `(level - level_start) / speed` as mantissa x 2^-shift.
    pub slope: crate::motor::gain::Gain,
    /// Turns of 2^-32 a tick per raw rev/s.
    pub turns: crate::motor::gain::Gain,
}

/// State of the generator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct OpenLoop {
    /// Angle at the boundary `at`, u32 turn.
    angle: u32,
    at: Instant,
    /// 2^-32 turn a tick, signed.
    speed: i32,
    ramp: Ramp,
    level: i32,
}

impl OpenLoopCoefficients {
    /// The speed that the ramp has reached so many `milliseconds` after standstill, raw I16F16 electrical
    /// rev/s.
    pub fn setpoint(&self, milliseconds: u32) -> i32 {
        let risen = self.rate.saturating_mul(milliseconds.into()) >> 16;
        risen.min(self.speed.into()) as i32
    }

    /// Level at `frequency` (raw I16F16 electrical rev/s).
    fn level_at(&self, frequency: i32) -> i32 {
        self.level_start.saturating_add(self.slope.apply32(frequency)).min(self.level).max(0)
    }
}

impl OpenLoop {
    /// Starts from standstill with the rotor resting at `angle` (u32 turn): a quarter turn behind it, where
    /// the field's pull is 0 and grows as it turns.
    pub fn start(&mut self, c: &OpenLoopCoefficients, now: Instant, angle: u32, direction: Direction) {
        const QUARTER: u32 = 1 << 30;
        let angle = match direction {
            Direction::Forward => angle.wrapping_sub(QUARTER),
            Direction::Reverse => angle.wrapping_add(QUARTER),
        };
        *self = Self { angle, at: now, level: c.level_at(0), ..Self::default() };
    }

    /// Once a millisecond: towards the set speed, or towards standstill. True if the field has changed.
    pub fn advance(
        &mut self,
        c: &OpenLoopCoefficients,
        now: Instant,
        direction: Direction,
        run: bool,
    ) -> bool {
        let target = if run { c.speed } else { 0 };
        if self.ramp.rests_at(target) {
            return false;
        }
        let frequency = self.ramp.step(target, c.rate);
        (self.angle, self.at) = (self.angle(now), now);
        self.speed = c.turns.apply32(frequency) * direction.sign();
        self.level = c.level_at(frequency);
        true
    }

    /// Rotor angle that the field is commutated for, u32 turn.
    pub const fn angle(&self, now: Instant) -> u32 {
        self.angle.wrapping_add((self.speed as u32).wrapping_mul(now.since(self.at)))
    }

    /// 2^-32 turn a tick, signed.
    pub const fn speed(&self) -> i32 {
        self.speed
    }

    /// Level of the field.
    pub const fn level(&self) -> i32 {
        self.level
    }

    /// Magnitude, electrical rev/s, raw I16F16.
    pub const fn frequency(&self) -> i32 {
        self.ramp.value()
    }

    /// The field stands still.
    pub const fn stopped(&self) -> bool {
        self.ramp.value() == 0
    }
}
