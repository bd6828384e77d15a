//! Rate limit of a set-point.

use super::error::{SettingError, quantity_within, within};
use crate::motor::ramp::Ramp as Station;
use serde::Serialize;

/// Settings of a [`Ramp`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RampSettings {
    /// Steepest change, raw I16F16 a second, more than 0.
    pub rate: i32,
    /// Steps a second, 1 to 1 000 000 Hz.
    pub step_rate: u32,
}

/// Ready-made coefficients of a ramp: those that its settings build.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[repr(C)]
pub struct RampReady {
    /// Largest change of one step, raw I16F16 with 16 extra bits.
    pub rate: i64,
}

/// A value that approaches its target by at most a rate: `y += clamp(target - y, -rate dt, rate dt)`, with 16
/// more fraction bits than it shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ramp {
    ready: RampReady,
    station: Station,
}

impl Ramp {
    /// A ramp at 0.
    ///
    /// # Errors
    /// The setting that is out of range; a rate too small to move anything in a step.
    pub fn build(settings: &RampSettings) -> Result<Self, SettingError> {
        let RampSettings { rate, step_rate } = *settings;
        within("step_rate", step_rate.into(), 1, 1_000_000, "Hz")?;
        let least = step_rate.div_ceil(1 << 16) as i32;
        quantity_within("rate", rate, least, i32::MAX, "")?;
        Ok(Self::new(RampReady { rate: (i64::from(rate) << 16) / i64::from(step_rate) }))
    }

    /// A ramp at 0 with ready-made coefficients, which are not checked.
    pub fn new(ready: RampReady) -> Self {
        Self { ready, station: Station::default() }
    }

    /// Its coefficients, for [`new`](Self::new) elsewhere.
    pub const fn ready(&self) -> &RampReady {
        &self.ready
    }

    /// One step towards `target`, raw I16F16.
    pub fn step(&mut self, target: i32) -> i32 {
        self.station.step(target, self.ready.rate)
    }

    /// Continues from `value`, raw I16F16.
    pub fn set(&mut self, value: i32) {
        self.station.set(value);
    }

    /// Present value, raw I16F16.
    pub const fn value(&self) -> i32 {
        self.station.value()
    }
}
