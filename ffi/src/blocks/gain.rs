//! Gains.

use narx_core::blocks::SettingError;
use narx_core::motor::gain::Gain;

/// A factor: `mantissa` x 2^-`shift`. A gain in IQ24 is {gain, 24}, one in Q15 {gain, 15}.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_gain_t {
    /// 0 to 2^30 - 1.
    pub mantissa: i32,
    /// Fraction bits, 0 to 62.
    pub shift: u8,
}

/// Converts a gain to that of the core, or returns its part that is out of range.
pub(super) fn gain(setting: &'static str, gain: narx_gain_t) -> Result<Gain, SettingError> {
    Gain::new(gain.mantissa, gain.shift).ok_or_else(|| {
        let (value, max) = match gain.shift {
            0..=62 => (gain.mantissa, Gain::MANTISSA_MAX),
            shift => (shift.into(), 62),
        };
        SettingError { setting, value: value.into(), min: 0, max: max.into(), fraction_bits: 0, unit: "" }
    })
}
