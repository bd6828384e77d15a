//! Conversions between the tick's units and the bus: the only place where revolutions per minute exist.

use crate::units::{ElectricalSpeed, quotient};

/// Electrical speed of a mechanical one in rpm: rpm * pole pairs / 60, saturating.
pub(super) fn electrical_speed(rpm: i32, pole_pairs: i32) -> ElectricalSpeed {
    ElectricalSpeed::from_ratio(i64::from(rpm) * i64::from(pole_pairs), 60)
}

/// Mechanical speed in rpm of an electrical one, rounded, saturating at 16 bits: rev/s * 60 / pole pairs.
pub(super) fn mechanical_rpm(speed: ElectricalSpeed, pole_pairs: i32) -> i16 {
    let divisor = i64::from(pole_pairs.max(1)) << 16;
    let numerator = i64::from(speed.to_bits()) * 60;
    let half = if numerator < 0 { -divisor / 2 } else { divisor / 2 };
    saturate16(quotient(numerator + half, divisor))
}

/// Mechanical position in 0.01 degrees of electrical sectors: sectors * 60 degrees / pole pairs, wrapping at
/// 32 bits.
pub(super) fn mechanical_position(sectors: i64, pole_pairs: i32) -> i32 {
    let (turned, pole_pairs) = (sectors.wrapping_mul(6000), i64::from(pole_pairs.max(1)));
    let position = quotient(turned, pole_pairs);
    // Rounded downwards below 0, too.
    (position - i64::from(turned < position * pole_pairs)) as i32
}

/// Electrical angle, 65 536 a turn, in 0.01 degrees, rounded.
pub(super) fn centidegrees(angle: i16) -> i32 {
    (i32::from(angle) * 36_000 + 32_768) >> 16
}

/// The nearest 16-bit number.
pub(super) fn saturate16(value: i64) -> i16 {
    value.clamp(i16::MIN.into(), i16::MAX.into()) as i16
}
