//! Numbers of the blocks in engineering units, as floating-point numbers: for programs on a computer, which
//! convert settings, inputs and outputs with these functions.

use super::{Position, SettingError};
use crate::motor::gain::Gain;
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
    /// The error with the name of the setting less its unit, and in that unit's base unit.
    fn from(SettingError { setting, value, min, max, fraction_bits, unit }: SettingError) -> Self {
        let (per_unit, unit) = match unit {
            "0.01 degree" => (100.0, "degrees"),
            "ms" => (1e3, "s"),
            "us" => (1e6, "s"),
            "uV/rpm" => (1e6, "V/rpm"),
            "uV/code" => (1e6, "V/code"),
            _ if fraction_bits == 16 => (ONE, unit),
            _ => (1.0, unit),
        };
        let endings = ["_cdeg", "_ms", "_us", "_uv_per_rpm", "_ticks"];
        let name = endings.iter().find_map(|ending| setting.strip_suffix(ending)).unwrap_or(setting);
        let [value, min, max] = [value, min, max].map(|raw| raw as f64 / per_unit);
        Self { name, value, min, max, unit }
    }
}

/// A type of whole settings.
pub trait Whole: TryFrom<i64> {
    /// Smallest value.
    const MIN: i64;
    /// Largest value.
    const MAX: i64;
}

macro_rules! whole {
    ($($kind:ty)*) => { $(impl Whole for $kind {
        const MIN: i64 = <$kind>::MIN as i64;
        const MAX: i64 = <$kind>::MAX as i64;
    })* };
}

whole!(u8 u16 u32 i32);

/// Converts a value to the whole setting with `per_unit` of its steps in the unit, rounded to nearest.
///
/// # Errors
/// Fails if the type of the setting cannot represent it; whether a block can be built from it is not checked.
pub fn scaled<'a, T: Whole>(
    name: &'a str,
    value: f64,
    unit: &'static str,
    per_unit: f64,
) -> Result<T, NumberError<'a>> {
    let error =
        NumberError { name, value, min: T::MIN as f64 / per_unit, max: T::MAX as f64 / per_unit, unit };
    let steps = libm::round(value * per_unit);
    let fits = steps >= T::MIN as f64 && steps <= T::MAX as f64;
    T::try_from(if fits { steps as i64 } else { i64::MAX }).map_err(|_| error)
}

/// Converts a value to raw I16F16, rounded to nearest.
///
/// # Errors
/// Fails if it is not a finite number within the range of I16F16.
pub fn raw<'a>(name: &'a str, value: f64, unit: &'static str) -> Result<i32, NumberError<'a>> {
    scaled(name, value, unit, ONE)
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
    let scaled = |shift: u8| libm::round(libm::ldexp(value, shift.into()));
    let shift = (0..=62).rev().find(|shift| scaled(*shift) <= max).unwrap_or(0);
    Gain::new(scaled(shift) as i32, shift).ok_or(error)
}

/// Returns the value of a gain.
pub fn value_of(gain: Gain) -> f64 {
    libm::ldexp(gain.mantissa().into(), -i32::from(gain.shift()))
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
