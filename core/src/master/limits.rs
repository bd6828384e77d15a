//! Limits of a speed set-point: the one place that knows which parameters bound it.

use crate::dictionary::{Dictionary, number, speed_limit};
use core::fmt;

/// Set-points that a drive accepts unchanged in the control mode that its enables select (Table 6):
/// magnitudes in mechanical rpm. It clamps all others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SpeedLimits {
    /// The smallest one.
    pub min: SpeedLimit,
    /// The largest one.
    pub max: SpeedLimit,
}

/// A limit, and the parameter that states it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SpeedLimit {
    /// Magnitude, rpm.
    pub rpm: u16,
    /// The parameter that states it: 101 to 104, or 88 in open loop. `None` for a limit of MOTOR_CMD itself,
    /// for example while no mode is enabled.
    pub parameter: Option<u16>,
}

/// A set-point that the drive would clamp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SpeedError {
    /// Requested speed, rpm, negative in reverse.
    pub rpm: i32,
    /// Allowed range.
    pub limits: SpeedLimits,
}

impl SpeedLimits {
    /// Parameters that determine the limits: the enables, the speed of open loop, the limits of both closed
    /// loops, and the pole pairs. The closed-loop limits depend on the pole pairs while they have their
    /// factory values.
    pub const PARAMETERS: [u16; 9] = [
        number::MOTOR_POLE_PAIRS,
        number::OPEN_LOOP_ENABLE,
        number::SENSORLESS_ENABLE,
        number::HALL_ENABLE,
        number::OPEN_LOOP_SPEED,
        number::SPEED_MAX_SL,
        number::SPEED_MIN_SL,
        number::SPEED_MAX_HES,
        number::SPEED_MIN_HES,
    ];

    /// Range of MOTOR_CMD.
    pub const WIRE: Self = Self {
        min: SpeedLimit { rpm: 0, parameter: None },
        max: SpeedLimit { rpm: u16::MAX, parameter: None },
    };

    /// Returns the limits of a drive with these raw parameter values; `None` if a needed one is missing.
    pub fn of(value: impl Fn(u16) -> Option<i32>) -> Option<Self> {
        let limit = |number| {
            let rpm = speed_limit(number, value(number)?, value(number::MOTOR_POLE_PAIRS)?);
            let rpm = rpm.clamp(0, u16::MAX.into()) as u16;
            Some(SpeedLimit { rpm, parameter: Some(number) })
        };
        // Limits that cross each other do not build: the drive reports that when it refuses the start.
        let between = |min, max| {
            let limits = Self { min: limit(min)?, max: limit(max)? };
            Some(if limits.min.rpm > limits.max.rpm { Self::WIRE } else { limits })
        };
        // Hall has priority over sensorless, and sensorless over open loop.
        if value(number::HALL_ENABLE)? != 0 {
            between(number::SPEED_MIN_HES, number::SPEED_MAX_HES)
        } else if value(number::SENSORLESS_ENABLE)? != 0 {
            between(number::SPEED_MIN_SL, number::SPEED_MAX_SL)
        } else if value(number::OPEN_LOOP_ENABLE)? != 0 {
            between(number::OPEN_LOOP_SPEED, number::OPEN_LOOP_SPEED)
        } else {
            Some(Self::WIRE)
        }
    }

    /// Checks a set-point, rpm, negative in reverse.
    ///
    /// # Errors
    /// Its magnitude is outside the limits.
    pub const fn check(self, rpm: i32) -> Result<(), SpeedError> {
        let magnitude = rpm.unsigned_abs();
        if magnitude < self.min.rpm as u32 || magnitude > self.max.rpm as u32 {
            return Err(SpeedError { rpm, limits: self });
        }
        Ok(())
    }
}

impl SpeedError {
    /// Returns whether the drive runs at one speed only: open loop at parameter 88. It starts at that speed,
    /// and the user should be told.
    pub fn is_fixed(&self) -> bool {
        self.limits.min == self.limits.max
    }

    /// Returns the limit that the set-point violates.
    pub const fn limit(&self) -> SpeedLimit {
        let SpeedLimits { min, max } = self.limits;
        if self.rpm.unsigned_abs() > max.rpm as u32 { max } else { min }
    }
}

impl fmt::Display for SpeedError {
    /// Value, parameter and range: `speed 3120 rpm is above parameter 101 "Speed setpoint max saturation SL":
    /// must be 500 to 2191 rpm`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { rpm, limits: SpeedLimits { min, max } } = *self;
        write!(f, "speed {rpm} rpm")?;
        if let Some(parameter) = self.limit().parameter.and_then(Dictionary::row) {
            let side = match (self.is_fixed(), self.limit() == max) {
                (true, _) => "not equal to",
                (false, true) => "above",
                (false, false) => "below",
            };
            write!(f, " is {side} {parameter}")?;
        }
        let direction = if rpm < 0 { " in either direction" } else { "" };
        if self.is_fixed() {
            write!(f, ": must be {} rpm{direction}", max.rpm)
        } else {
            write!(f, ": must be {} to {} rpm{direction}", min.rpm, max.rpm)
        }
    }
}

impl core::error::Error for SpeedError {}
