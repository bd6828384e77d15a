//! Parameters in their units: 4.5 A rather than 4500 of 10^-3 A.

use crate::shown::Shown;
use core::fmt;
use narx_core::dictionary::{Decimal, Dictionary, Parameter, Parameters};

/// Why a value was not accepted; nothing has changed then.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ValueError {
    /// There is no parameter of that number.
    Unknown {
        /// The number asked for.
        number: u16,
    },
    /// Not a number, or outside the range.
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
    // Dividing by an exact power of ten rounds once: 1/10 is the nearest number to 0.1.
    if row.exponent < 0 { raw as f64 / power(row) } else { raw as f64 * power(row) }
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

/// The raw value of a value in the parameter's unit, to the nearest step of its scale.
///
/// # Errors
/// An unknown number, not a number, or a value outside the parameter's range.
pub fn raw(number: u16, value: f64) -> Result<i64, ValueError> {
    let parameter = Dictionary::row(number).ok_or(ValueError::Unknown { number })?;
    let raw =
        libm::round(if parameter.exponent < 0 { value * power(parameter) } else { value / power(parameter) });
    if !(parameter.min() as f64..=parameter.max() as f64).contains(&raw) {
        return Err(ValueError::OutOfRange { parameter, value });
    }
    Ok(raw as i64)
}

fn power(row: &Parameter) -> f64 {
    (0..row.exponent.unsigned_abs()).fold(1.0, |power, _| power * 10.0)
}

impl fmt::Display for ValueError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown { number } => write!(f, "there is no parameter {number}"),
            Self::OutOfRange { parameter, value } => {
                let limit = |digits| Decimal { digits, exponent: parameter.exponent };
                let unit = parameter.unit_suffix();
                write!(
                    f,
                    "parameter {} \"{}\": {}{unit} is outside {} to {}{unit}",
                    parameter.number,
                    parameter.name(),
                    Shown::Plain(*value),
                    limit(parameter.min()),
                    limit(parameter.max())
                )
            }
        }
    }
}

impl core::error::Error for ValueError {}
