//! Numbers of the blocks in engineering units, as floating-point numbers: for programs on a computer, which
//! convert settings, inputs and outputs with these functions.

use super::{Position, SettingError};
use crate::motor::gain::Gain;
use crate::motor::sense::front_end::Channel;
use crate::shown::Shown;
use core::fmt;

/// Raw value of 1: of a quantity, and of a period.
const ONE: f64 = 65_536.0;
/// Raw value of a turn.
const TURN: f64 = 4_294_967_296.0;

/// A number out of its range. Nothing was built or run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NumberError<'a> {
    /// Name of the setting or input.
    pub name: &'a str,
    /// The rejected value.
    pub value: f64,
    /// Smallest valid value, that of `f64` if only a finite number is asked for.
    pub min: f64,
    /// Largest valid value, likewise.
    pub max: f64,
    /// Unit of the three, "" without one.
    pub unit: &'static str,
}

impl fmt::Display for NumberError<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [value, min, max] = [self.value, self.min, self.max].map(Shown::Plain);
        let space = if self.unit.is_empty() { "" } else { " " };
        write!(f, "{} {value}{space}{}: must be ", self.name, self.unit)?;
        if self.max == f64::MAX { f.write_str("a finite number") } else { write!(f, "from {min} to {max}") }
    }
}

impl core::error::Error for NumberError<'_> {}

impl From<SettingError> for NumberError<'static> {
    /// The error in the units of this module: seconds, and quantities as numbers.
    fn from(SettingError { setting, value, min, max, fraction_bits, unit }: SettingError) -> Self {
        let (name, per_unit, unit) = match setting.strip_suffix("_ms") {
            Some(name) => (name, HALL_TIMEOUT.per_unit, HALL_TIMEOUT.unit),
            None if fraction_bits == 16 => (setting, ONE, unit),
            None => (setting, 1.0, unit),
        };
        let [value, min, max] = [value, min, max].map(|raw| raw as f64 / per_unit);
        Self { name, value, min, max, unit }
    }
}

/// A number as a setting takes it: a whole number of small steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    unit: &'static str,
    /// Steps of the setting in the unit.
    per_unit: f64,
    min: f64,
    max: f64,
}

/// [`CommutationSettings::advance_cdeg`](super::CommutationSettings::advance_cdeg).
pub const ADVANCE: Scale = Scale { unit: "degrees", per_unit: 100.0, min: 0.0, max: 30.0 };
/// [`HallSettings::offset_cdeg`](super::HallSettings::offset_cdeg).
pub const HALL_OFFSET: Scale = Scale { unit: "degrees", per_unit: 100.0, min: -180.0, max: 180.0 };
/// [`HallSettings::timeout_ms`](super::HallSettings::timeout_ms); the tick rate may leave less.
pub const HALL_TIMEOUT: Scale = Scale { unit: "s", per_unit: 1e3, min: 1e-3, max: 65.535 };
/// [`ZeroCrossingSettings::blanking_us`](super::ZeroCrossingSettings::blanking_us).
pub const BLANKING: Scale = Scale { unit: "s", per_unit: 1e6, min: 0.0, max: 0.1 };
/// [`ZeroCrossingSettings::back_emf_uv_per_rpm`](super::ZeroCrossingSettings::back_emf_uv_per_rpm).
pub const BACK_EMF: Scale = Scale { unit: "V/rpm", per_unit: 1e6, min: 0.0, max: 1.0 };
/// [`Channel::micro_per_code`] of a voltage.
pub const VOLTS_PER_CODE: Scale =
    Scale { unit: "V", per_unit: 1e6, min: 1e-6, max: Channel::MICRO_PER_CODE_MAX as f64 / 1e6 };

impl Scale {
    /// [`ZeroCrossingSettings::timeout_ticks`](super::ZeroCrossingSettings::timeout_ticks) at a tick rate in
    /// hertz.
    pub fn zero_crossing_timeout(tick_rate: f64) -> Self {
        Self { unit: "s", per_unit: tick_rate, min: 1.0 / tick_rate, max: 32_767.0 / tick_rate }
    }

    /// Returns the setting for a value, rounded to nearest.
    ///
    /// # Errors
    /// Fails if the value is not a finite number within the range.
    pub fn setting<T: TryFrom<i64>>(self, name: &str, value: f64) -> Result<T, NumberError<'_>> {
        let Self { unit, per_unit, min, max } = self;
        let error = NumberError { name, value, min, max, unit };
        if !(min..=max).contains(&value) {
            return Err(error);
        }
        T::try_from(libm::round(value * per_unit) as i64).map_err(|_| error)
    }
}

/// Converts a value to raw I16F16, rounded to nearest.
///
/// # Errors
/// Fails if it is not a finite number within the range of I16F16.
pub fn raw<'a>(name: &'a str, value: f64, unit: &'static str) -> Result<i32, NumberError<'a>> {
    Scale { unit, per_unit: ONE, min: real(i32::MIN), max: real(i32::MAX) }.setting(name, value)
}

/// Converts a raw I16F16.
pub fn real(raw: i32) -> f64 {
    f64::from(raw) / ONE
}

/// Returns the nearest gain of 30 bits.
///
/// # Errors
/// Fails for a negative value, one of 2^30 or more, and one too small to keep 8 significant bits.
pub fn gain(name: &str, value: f64) -> Result<Gain, NumberError<'_>> {
    let max = f64::from(Gain::MANTISSA_MAX);
    let least = libm::ldexp(1.0, -55);
    let error = NumberError { name, value, min: if value > 0.0 { least } else { 0.0 }, max, unit: "" };
    if value == 0.0 {
        return Ok(Gain::ZERO);
    }
    if !(least..=max).contains(&value) {
        return Err(error);
    }
    let scaled = |shift| libm::round(libm::ldexp(value, shift));
    let shift = (0..=62).rev().find(|shift| scaled(*shift) <= max).unwrap_or(0);
    Gain::new(scaled(shift) as i32, shift.unsigned_abs()).ok_or(error)
}

/// Returns the value of a gain.
pub fn value_of(gain: Gain) -> f64 {
    libm::ldexp(gain.mantissa().into(), -(gain.shift() as i32))
}

/// Converts electrical degrees to a u32 turn.
///
/// # Errors
/// Fails if the angle is not a finite number.
pub fn turn(name: &str, angle: f64) -> Result<u32, NumberError<'_>> {
    if !angle.is_finite() {
        return Err(NumberError { name, value: angle, min: f64::MIN, max: f64::MAX, unit: "degrees" });
    }
    let turns = angle / 360.0;
    Ok(((turns - libm::floor(turns)) * TURN) as u64 as u32)
}

/// Converts a u32 turn to electrical degrees, 0 to 360.
pub fn degrees(turn: u32) -> f64 {
    f64::from(turn) * 360.0 / TURN
}

/// Converts an instant in periods, from 0 to below 1, to 1/65 536 of a period.
///
/// # Errors
/// Fails if the instant is not within the period.
pub fn instant(name: &str, periods: f64) -> Result<u16, NumberError<'_>> {
    if !(0.0..1.0).contains(&periods) {
        return Err(NumberError { name, value: periods, min: 0.0, max: 65_535.0 / ONE, unit: "periods" });
    }
    Ok(libm::round(periods * ONE).min(65_535.0) as u16)
}

/// Returns a rotor position from electrical degrees and rev/s.
///
/// # Errors
/// Fails if the angle is not a finite number, or the speed more than a twelfth of the tick rate.
pub fn position(angle: f64, speed: f64, tick_rate: u32) -> Result<Position, NumberError<'static>> {
    let angle = turn("angle", angle)?;
    let max = f64::from(tick_rate) / 12.0;
    if !(-max..=max).contains(&speed) {
        return Err(NumberError { name: "speed", value: speed, min: -max, max, unit: "rev/s" });
    }
    Ok(Position { angle, speed: libm::round(speed / f64::from(tick_rate) * TURN) as i32 })
}
