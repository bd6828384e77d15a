//! Open loop: a field that turns by itself, from standstill up a frequency ramp.

use crate::motor::clock::Instant;
use crate::motor::commutate::commutation::Direction;
use crate::motor::ramp::Ramp;
use serde::{Deserialize, Serialize};

/// Coefficients of the open-loop generator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct OpenLoopCoefficients {
    /// Speed at the end of the ramp, electrical rev/s, raw I16F16 (parameter 88).
    pub speed: i32,
    /// Rise per tick, raw I16F16 with 16 extra bits (parameters 88 and 109).
    pub rate: i64,
    /// Level while the field stands still (rotor lock level, but no more than the open-loop level). Levels as in
    /// [`ControlCoefficients::initial_level`](crate::motor::control::ControlCoefficients::initial_level).
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
}

/// The field in one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Field {
    /// Rotor angle that the field is commutated for, u32 turn.
    pub angle: u32,
    /// 2^-32 turn a tick, signed.
    pub speed: i32,
    /// Electrical rev/s, raw I16F16, signed.
    pub frequency: i32,
    /// Level.
    pub level: i32,
}

impl OpenLoopCoefficients {
    /// The speed that the ramp has reached so many `ticks` after standstill, raw I16F16 electrical rev/s.
    pub fn setpoint(&self, ticks: u32) -> i32 {
        let risen = self.rate.saturating_mul(ticks.into()) >> 16;
        risen.min(self.speed.into()) as i32
    }
}

impl OpenLoop {
    /// Starts from standstill with the rotor resting at `angle` (u32 turn): a quarter turn behind it, where the field's pull is 0 and grows as it turns.
    pub fn start(&mut self, now: Instant, angle: u32, direction: Direction) {
        const QUARTER: u32 = 1 << 30;
        let angle = match direction {
            Direction::Forward => angle.wrapping_sub(QUARTER),
            Direction::Reverse => angle.wrapping_add(QUARTER),
        };
        *self = Self { angle, at: now, ..Self::default() };
    }

    /// One tick towards the set speed, or towards standstill.
    pub fn step(&mut self, c: &OpenLoopCoefficients, now: Instant, direction: Direction, run: bool) -> Field {
        let frequency = self.ramp.step(if run { c.speed } else { 0 }, c.rate);
        let speed = c.turns.apply32(frequency) * direction.sign();
        // Until now it has turned on by its speed of before.
        self.angle = self.angle(now).wrapping_add(speed.wrapping_sub(self.speed) as u32);
        (self.speed, self.at) = (speed, now);
        let level = c.level_start.saturating_add(c.slope.apply32(frequency));
        Field {
            angle: self.angle,
            speed,
            frequency: frequency * direction.sign(),
            level: level.min(c.level).max(0),
        }
    }

    /// It turns on at the speed that it has.
    pub fn is_steady(&self, c: &OpenLoopCoefficients, run: bool) -> bool {
        self.ramp.rests_at(if run { c.speed } else { 0 })
    }

    /// Rotor angle that the field is commutated for, u32 turn.
    pub const fn angle(&self, now: Instant) -> u32 {
        self.angle.wrapping_add((self.speed as u32).wrapping_mul(now.since(self.at)))
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
