//! The values of all parameters.

use super::parameter::Parameter;
use super::{Dictionary, PARAMETER_COUNT};
use crate::blind;
use core::fmt;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// A value for every row of the dictionary, each within its range. Serialises as the raw values in the order
/// of the rows.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "Raw", into = "Raw")]
pub struct Parameters([i32; PARAMETER_COUNT]);

type Raw = Vec<i32, PARAMETER_COUNT>;

/// Reason why a value was not accepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterError {
    /// There is no such parameter.
    Unknown {
        /// The number asked for.
        number: u16,
    },
    /// The value lies outside the allowed range.
    OutOfRange {
        /// The row that states the range.
        parameter: &'static Parameter,
        /// The raw value offered.
        raw: i32,
    },
    /// The set belongs to another dictionary.
    Layout,
}

impl Parameters {
    /// Factory values.
    pub fn new() -> Self {
        let mut values = [0; PARAMETER_COUNT];
        for (value, row) in values.iter_mut().zip(Dictionary::rows()) {
            *value = row.factory_raw();
        }
        Self(values)
    }

    /// The raw value of a parameter (unit and scale: its row), or `None` if there is no such number.
    pub fn value(&self, number: u16) -> Option<i32> {
        self.0.get(Dictionary::index(number)?).copied()
    }

    /// The raw value of a parameter that exists, for code that acts on it; `number` is a constant of
    /// [`super::number`]. 0 for any other number.
    pub fn raw(&self, number: u16) -> i32 {
        if blind::to("parameter", number.into()) {
            return Dictionary::row(number).map_or(0, Parameter::factory_raw);
        }
        self.value(number).unwrap_or(0)
    }

    /// The raw value of a parameter of kind U32 that exists.
    pub fn raw_u32(&self, number: u16) -> u32 {
        self.raw(number) as u32
    }

    /// Speed set-point limit (parameters 101 to 104) in force, mechanical rpm; the raw value of any other
    /// parameter.
    pub fn speed_limit(&self, number: u16) -> i32 {
        super::speed_limit(number, self.raw(number), self.raw(super::number::MOTOR_POLE_PAIRS))
    }

    /// Sets a raw value within its range. The node checks write access; whether values fit each other is
    /// checked when coefficients are built from them.
    ///
    /// # Errors
    /// Unknown number, or a value outside the range; nothing has changed then.
    pub fn set(&mut self, number: u16, raw: i32) -> Result<(), ParameterError> {
        let unknown = ParameterError::Unknown { number };
        let index = Dictionary::index(number).ok_or(unknown)?;
        let parameter = Dictionary::row(number).ok_or(unknown)?;
        if !parameter.accepts(raw) {
            return Err(ParameterError::OutOfRange { parameter, raw });
        }
        if let Some(value) = self.0.get_mut(index) {
            *value = raw;
        }
        Ok(())
    }

    /// Every row with its raw value, in the order of the numbers.
    pub fn iter(&self) -> impl Iterator<Item = (&'static Parameter, i32)> + '_ {
        Dictionary::rows().zip(self.0.iter().copied())
    }
}

impl Default for Parameters {
    fn default() -> Self {
        Self::new()
    }
}

impl From<Parameters> for Raw {
    fn from(parameters: Parameters) -> Self {
        Self::from_array(parameters.0)
    }
}

impl TryFrom<Raw> for Parameters {
    type Error = ParameterError;

    /// Checks a set that comes from outside: its size and every range.
    fn try_from(raw: Raw) -> Result<Self, ParameterError> {
        let values = raw.into_array().map_err(|_| ParameterError::Layout)?;
        match Dictionary::rows().zip(values).find(|(row, raw)| !row.accepts(*raw)) {
            Some((parameter, raw)) => Err(ParameterError::OutOfRange { parameter, raw }),
            None => Ok(Self(values)),
        }
    }
}

impl fmt::Display for ParameterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown { number } => write!(f, "there is no parameter {number}"),
            Self::OutOfRange { parameter, raw } => {
                let decimal = |digits| super::Decimal { digits, exponent: parameter.exponent };
                let unit = parameter.unit_suffix();
                let (value, min, max) =
                    (parameter.engineering(*raw), decimal(parameter.min()), decimal(parameter.max()));
                write!(f, "{parameter}: {value}{unit} is outside {min} to {max}{unit}")
            }
            Self::Layout => f.write_str("a parameter set of another dictionary"),
        }
    }
}

impl core::error::Error for ParameterError {}
