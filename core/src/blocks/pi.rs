//! Proportional-integral controller with limits and back-calculation.

use super::error::{SettingError, quantity_within, within};
use crate::motor::control::pi::{Pi as Station, PiGains};
use crate::motor::gain::{Gain, SIGNIFICANT_BITS};
use serde::Serialize;

/// Settings of a [`Pi`]. Errors and outputs are raw I16F16 in units of the caller's choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PiSettings {
    /// Kp: output per error.
    pub proportional: Gain,
    /// Ki: output per error and second.
    pub integral: Gain,
    /// Steps a second, 1 to 1 000 000 Hz.
    pub step_rate: u32,
    /// Least output, raw I16F16.
    pub minimum: i32,
    /// Largest output, raw I16F16, not below the least.
    pub maximum: i32,
}

/// Ready-made coefficients of a PI controller: those that its settings build.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[repr(C)]
pub struct PiReady {
    /// Gains of one step: Kp, and Ki x step time.
    pub gains: PiGains,
    /// Least output, raw I16F16.
    pub minimum: i32,
    /// Largest output, raw I16F16, not below the least.
    pub maximum: i32,
}

/// A PI controller: `u = Kp e + integral of Ki e dt`, within its limits. The integrator has 16 fraction bits
/// more than the output, and never holds more than brings the output to a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pi {
    ready: PiReady,
    station: Station,
}

impl Pi {
    /// A controller at rest: its integrator is 0.
    ///
    /// # Errors
    /// The setting that is out of range; an integral gain whose share of one step keeps fewer than
    /// [`SIGNIFICANT_BITS`] bits.
    pub fn build(settings: &PiSettings) -> Result<Self, SettingError> {
        let PiSettings { proportional, integral, step_rate, minimum, maximum } = *settings;
        within("step_rate", step_rate.into(), 1, 1_000_000, "Hz")?;
        quantity_within("minimum", minimum, i32::MIN, maximum, "")?;
        // Ki x step time.
        let denominator = i128::from(step_rate) << integral.shift();
        let integral = Gain::from_ratio(integral.mantissa().into(), denominator).ok_or_else(|| {
            // Gains go down to 2^-62.
            let least = (denominator << (SIGNIFICANT_BITS - 1)) >> 62;
            SettingError {
                setting: "integral (mantissa)",
                value: integral.mantissa().into(),
                min: least as i64 + 1,
                max: Gain::MANTISSA_MAX.into(),
                fraction_bits: 0,
                unit: "",
            }
        })?;
        let gains = PiGains { proportional, integral };
        Ok(Self::new(PiReady { gains, minimum, maximum }))
    }

    /// A controller at rest with ready-made coefficients, which are not checked.
    pub fn new(ready: PiReady) -> Self {
        Self { ready, station: Station::default() }
    }

    /// Its coefficients, for [`new`](Self::new) elsewhere.
    pub const fn ready(&self) -> &PiReady {
        &self.ready
    }

    /// The output for `error`, both raw I16F16.
    pub fn step(&mut self, error: i32) -> i32 {
        self.station.step(&self.ready.gains, error, self.ready.minimum, self.ready.maximum)
    }

    /// Follows the output `applied` (raw I16F16) that something else decided in this step, whose error was
    /// `error`: the integrator goes an eighth of the way to the value that would have given `applied`, so
    /// that the controller takes over again without a bump.
    pub fn track(&mut self, applied: i32, error: i32) {
        self.station.track(&self.ready.gains, applied, error, 1 << 13);
    }

    /// Sets the integrator so that it alone gives `output` (raw I16F16).
    pub fn hold(&mut self, output: i32) {
        self.station.wait(output);
    }
}
