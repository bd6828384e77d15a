//! Gains.

use narx_core::blocks::SettingError;
use narx_core::motor::gain::Gain;

/// Returns a gain whose fields the caller has written, or its field that is out of range.
pub(super) fn gain(setting: &'static str, gain: Gain) -> Result<Gain, SettingError> {
    Gain::new(gain.mantissa(), gain.shift()).ok_or_else(|| {
        let (value, max) = match gain.shift() {
            0..=62 => (gain.mantissa().into(), Gain::MANTISSA_MAX),
            shift => (shift.into(), 62),
        };
        SettingError { setting, value, min: 0, max: max.into(), fraction_bits: 0, unit: "" }
    })
}
