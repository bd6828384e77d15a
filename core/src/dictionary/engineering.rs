//! Parameters in their units: 4.5 A rather than 4500 of 10^-3 A.

use super::{Decimal, Dictionary, Parameter, Parameters};
use crate::shown::Shown;
use core::fmt;

/// Scale of a parameter, between its value in its unit and its raw value: of a row of the dictionary, or as a
/// drive describes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scale<'a> {
    /// Number on the wire.
    pub number: u16,
    /// Its name.
    pub name: &'a str,
    /// Unit of the value; empty without one.
    pub unit: &'a str,
    /// Value = raw value * 10^exponent.
    pub exponent: i8,
    /// Smallest raw value.
    pub min: i64,
    /// Largest raw value.
    pub max: i64,
}

/// A value that a parameter cannot have, and why.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Misfit<'a> {
    /// The parameter.
    pub scale: Scale<'a>,
    /// The value offered, in its unit.
    pub value: f64,
}

/// Reason why a value was not accepted; nothing has changed then.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ValueError {
    /// There is no parameter of that number.
    Unknown {
        /// The number asked for.
        number: u16,
    },
    /// Not a number, outside the range, or a fraction of a parameter that is whole.
    OutOfRange {
        /// The row that states the range.
        parameter: &'static Parameter,
        /// The value offered, in the parameter's unit.
        value: f64,
    },
}

/// The value of a parameter in its unit, or `None` if there is no such number.
pub fn value(parameters: &Parameters, number: u16) -> Option<f64> {
    let row = Dictionary::row(number)?;
    Some(to_unit(row, row.kind.widen(parameters.value(number)?)))
}

/// A raw value in the parameter's unit.
pub fn to_unit(row: &Parameter, raw: i64) -> f64 {
    Scale::from(row).to_unit(raw)
}

/// Sets a parameter to a value in its unit, to the nearest step of its scale.
///
/// # Errors
/// An unknown number, not a number, or a value outside the parameter's range.
pub fn set(parameters: &mut Parameters, number: u16, value: f64) -> Result<(), ValueError> {
    let raw = raw(number, value)?;
    // No kind has more than 32 bits, and the range was just looked at.
    parameters.set(number, raw as i32).map_err(|_| ValueError::Unknown { number })
}

/// As [`set`], for a value that somebody has entered: a fraction of a whole parameter is refused.
///
/// # Errors
/// An unknown number, not a number, a fraction of a whole parameter, or a value outside the parameter's
/// range.
pub fn enter(parameters: &mut Parameters, number: u16, value: f64) -> Result<(), ValueError> {
    let raw = entered(number, value)?;
    parameters.set(number, raw as i32).map_err(|_| ValueError::Unknown { number })
}

/// The raw value of a value in the parameter's unit, to the nearest step of its scale.
///
/// # Errors
/// An unknown number, not a number, or a value outside the parameter's range.
pub fn raw(number: u16, value: f64) -> Result<i64, ValueError> {
    let parameter = Dictionary::row(number).ok_or(ValueError::Unknown { number })?;
    Scale::from(parameter).raw(value).map_err(|_| ValueError::OutOfRange { parameter, value })
}

/// As [`raw`], for a value that somebody has entered: 2.5 of a parameter without decimals is refused, not
/// rounded.
///
/// # Errors
/// An unknown number, not a number, a fraction of a whole parameter, or a value outside the parameter's
/// range.
pub fn entered(number: u16, value: f64) -> Result<i64, ValueError> {
    let parameter = Dictionary::row(number).ok_or(ValueError::Unknown { number })?;
    Scale::from(parameter).entered(value).map_err(|_| ValueError::OutOfRange { parameter, value })
}

impl<'a> From<&'a Parameter> for Scale<'a> {
    fn from(row: &'a Parameter) -> Self {
        let unit = if row.unit() == "-" { "" } else { row.unit() };
        let (min, max) = (row.min(), row.max());
        Self { number: row.number, name: row.name(), unit, exponent: row.exponent, min, max }
    }
}

impl<'a> Scale<'a> {
    /// A raw value in the unit.
    pub fn to_unit(&self, raw: i64) -> f64 {
        // Dividing by an exact power of ten rounds once: 1/10 is the nearest number to 0.1.
        if self.exponent < 0 { raw as f64 / self.power() } else { raw as f64 * self.power() }
    }

    /// The raw value of a value in the unit, to the nearest step.
    ///
    /// # Errors
    /// Not a number, or a value outside the range.
    pub fn raw(self, value: f64) -> Result<i64, Misfit<'a>> {
        let raw = libm::round(self.steps(value));
        if (self.min as f64..=self.max as f64).contains(&raw) {
            Ok(raw as i64)
        } else {
            Err(Misfit { scale: self, value })
        }
    }

    /// As [`Scale::raw`], for a value that somebody has entered: a fraction of a whole parameter is refused.
    ///
    /// # Errors
    /// Not a number, a fraction of a whole parameter, or a value outside the range.
    pub fn entered(self, value: f64) -> Result<i64, Misfit<'a>> {
        let raw = self.raw(value)?;
        // 0.07 * 1000 is whole, whatever its last bit says.
        if self.is_whole() && (raw as f64 - self.steps(value)).abs() > 1e-6 {
            return Err(Misfit { scale: self, value });
        }
        Ok(raw)
    }

    /// Returns whether the values have no decimals.
    pub const fn is_whole(&self) -> bool {
        self.exponent >= 0
    }

    fn steps(&self, value: f64) -> f64 {
        if self.exponent < 0 { value * self.power() } else { value / self.power() }
    }

    fn power(&self) -> f64 {
        (0..self.exponent.unsigned_abs()).fold(1.0, |power, _| power * 10.0)
    }
}

impl fmt::Display for Scale<'_> {
    /// Number and name, as errors tell them.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "parameter {} \"{}\"", self.number, self.name)
    }
}

impl fmt::Display for Misfit<'_> {
    /// Number, name, value and range.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { scale, value } = self;
        let Scale { unit, exponent, min, max, .. } = *scale;
        let limit = |digits| Decimal { digits, exponent };
        let space = if unit.is_empty() { "" } else { " " };
        let problem = if scale.raw(*value).is_ok() { "not a whole number from" } else { "outside" };
        write!(
            f,
            "{scale}: {}{space}{unit} is {problem} {} to {}{space}{unit}",
            Shown::Plain(*value),
            limit(min),
            limit(max)
        )
    }
}

impl fmt::Display for ValueError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Unknown { number } => write!(f, "there is no parameter {number}"),
            Self::OutOfRange { parameter, value } => Misfit { scale: parameter.into(), value }.fmt(f),
        }
    }
}

impl core::error::Error for ValueError {}
