//! Open loop: a field that turns by itself, from standstill up a frequency ramp.

use super::commutation::Direction;
use super::ramp::Ramp;
use serde::{Deserialize, Serialize};

/// Coefficients of the open-loop generator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct OpenLoopCoefficients {
    /// Speed at the end of the ramp, electrical rev/s, raw I16F16 (parameter 88).
    pub speed: i32,
    /// Rise per tick, raw I16F16 with 16 extra bits (parameters 88 and 109).
    pub rate: i64,
    /// Voltage while the field stands still (rotor lock level, but no more than the open-loop level), raw I16F16.
    pub voltage_start: i32,
    /// Voltage at the end of the ramp (open-loop level), raw I16F16.
    pub voltage: i32,
    /// `(voltage - voltage_start) / speed`, volts per rev/s as mantissa x 2^-shift.
    pub slope: super::gain::Gain,
    /// Turns of 2^-32 a tick per raw rev/s.
    pub turns: super::gain::Gain,
}

/// State of the generator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct OpenLoop {
    angle: u32,
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
    /// Level, raw I16F16 volts.
    pub voltage: i32,
}

impl OpenLoop {
    /// Starts at a rotor angle (u32 turn) from zero frequency.
    pub fn start(&mut self, angle: u32) {
        *self = Self { angle, ramp: Ramp::default() };
    }

    /// One tick towards the set speed, or towards standstill.
    pub fn step(&mut self, c: &OpenLoopCoefficients, direction: Direction, run: bool) -> Field {
        let frequency = self.ramp.step(if run { c.speed } else { 0 }, c.rate);
        let speed = c.turns.apply32(frequency) * direction.sign();
        self.angle = self.angle.wrapping_add(speed as u32);
        let voltage = c.voltage_start.saturating_add(c.slope.apply32(frequency));
        Field {
            angle: self.angle,
            speed,
            frequency: frequency * direction.sign(),
            voltage: voltage.min(c.voltage).max(0),
        }
    }

    /// The field stands still.
    pub const fn stopped(&self) -> bool {
        self.ramp.value() == 0
    }
}
