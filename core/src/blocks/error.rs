//! Settings that no block can be built from.

use core::fmt;
use fixed::types::I48F16;

/// A setting out of its range. Nothing was built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SettingError {
    /// Name of the setting, as its field is called.
    pub setting: &'static str,
    /// The rejected value.
    pub value: i64,
    /// Smallest value that builds, with the other settings as they are.
    pub min: i64,
    /// Largest value that builds.
    pub max: i64,
    /// Fraction bits of the three: 16 for a raw I16F16 quantity, 0 for a count.
    pub fraction_bits: u8,
    /// Unit of the setting, "" without one.
    pub unit: &'static str,
}

impl fmt::Display for SettingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { setting, value, min, max, unit, .. } = self;
        let space = if unit.is_empty() { "" } else { " " };
        if self.fraction_bits == 16 {
            let [value, min, max] = [*value, *min, *max].map(I48F16::from_bits);
            write!(f, "{setting}: {value} is not within {min} to {max}{space}{unit}")
        } else {
            write!(f, "{setting}: {value} is not within {min} to {max}{space}{unit}")
        }
    }
}

impl core::error::Error for SettingError {}

/// `Err` unless a count lies within `min..=max`.
pub(super) fn within(
    setting: &'static str,
    value: i64,
    min: i64,
    max: i64,
    unit: &'static str,
) -> Result<(), SettingError> {
    let error = SettingError { setting, value, min, max, fraction_bits: 0, unit };
    if (min..=max).contains(&value) { Ok(()) } else { Err(error) }
}

/// `Err` unless a raw I16F16 quantity lies within `min..=max`.
pub(super) fn quantity_within(
    setting: &'static str,
    raw: i32,
    min: i32,
    max: i32,
    unit: &'static str,
) -> Result<(), SettingError> {
    within(setting, raw.into(), min.into(), max.into(), unit)
        .map_err(|error| SettingError { fraction_bits: 16, ..error })
}
