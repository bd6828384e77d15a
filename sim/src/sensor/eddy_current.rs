//! One channel: from a distance to the position that the driver's board samples.

use super::{Shaft, Target};
use core::fmt;
use narx_core::bus::eddycan::Position;
use narx_core::eddycan::MeasuringRange;
use narx_core::shown::Shown;

/// Measuring ranges, mm; a position on the bus ends at 16 mm.
const RANGES: core::ops::RangeInclusive<f64> = 0.01..=15.9;
/// The most noise, mm rms.
const NOISE_MAX: f64 = 1.0;
/// 1 mm of a position (section 3.1).
const PER_MILLIMETRE: f64 = 134_217_728.0;

/// A sensor and its target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EddyCurrentConfig {
    /// Measuring range, 0.01 to 15.9 mm; a position counts from its start.
    pub range: f64,
    /// Noise of a sample, 0 to 1 mm rms: Gaussian, white up to half the sample rate.
    pub noise: f64,
    /// Target that it watches.
    pub target: Target,
}

impl EddyCurrentConfig {
    /// With noise of 50 ppm of the range, 0.1 um of 2 mm: our estimate.
    pub const fn new(range: f64, target: Target) -> Self {
        Self { range, noise: range * 50e-6, target }
    }
}

/// A sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EddyCurrent {
    config: EddyCurrentConfig,
    measuring_range: MeasuringRange,
}

/// Reason why a sensor cannot be built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SensorError {
    /// Such a measuring range, mm.
    Range(f64),
    /// Noise, mm rms.
    Noise(f64),
    /// A target whose place is not a number.
    Target,
}

impl EddyCurrent {
    /// A sensor.
    ///
    /// # Errors
    /// A value out of its range.
    pub fn new(config: EddyCurrentConfig) -> Result<Self, SensorError> {
        if !(0.0..=NOISE_MAX).contains(&config.noise) {
            return Err(SensorError::Noise(config.noise));
        }
        // Every part of the distance takes part in it at some speed and angle, and what is not finite stays
        // so.
        let parts = config.target.distance(&Shaft { turns: 0.1, speed: 1.0 });
        if !parts.is_finite() {
            return Err(SensorError::Target);
        }
        let refused = SensorError::Range(config.range);
        if !RANGES.contains(&config.range) {
            return Err(refused);
        }
        let [start, end] = [0.0, config.range].map(quantised);
        let measuring_range = MeasuringRange::new(start, end).ok_or(refused)?;
        Ok(Self { config, measuring_range })
    }

    /// Returns its configuration.
    pub const fn config(&self) -> &EddyCurrentConfig {
        &self.config
    }

    /// Returns the measuring range that its driver is given.
    pub const fn measuring_range(&self) -> MeasuringRange {
        self.measuring_range
    }

    /// True distance from the start of the range, mm, wherever it lies.
    pub fn distance(&self, shaft: &Shaft) -> f64 {
        self.config.target.distance(shaft)
    }

    /// A sample; `noise` has a standard deviation of 1. Outside of its range the sensor shows the end of it.
    pub fn sample(&self, shaft: &Shaft, noise: f64) -> Position {
        let seen = self.distance(shaft) + self.config.noise * noise;
        quantised(seen.max(0.0).min(self.config.range))
    }
}

/// To the nearest step of a position.
fn quantised(millimetres: f64) -> Position {
    Position::from_raw(libm::floor(millimetres * PER_MILLIMETRE + 0.5) as i32)
}

impl fmt::Display for SensorError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range(range) => {
                let [range, min, max] = [*range, *RANGES.start(), *RANGES.end()].map(Shown::Plain);
                write!(f, "measuring range {range} mm: must be from {min} to {max} mm")
            }
            Self::Noise(noise) => {
                let [noise, max] = [*noise, NOISE_MAX].map(Shown::Plain);
                write!(f, "noise {noise} mm rms: must be from 0 to {max} mm rms")
            }
            Self::Target => f.write_str("the target's place is not a number"),
        }
    }
}

impl core::error::Error for SensorError {}
