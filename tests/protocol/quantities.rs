//! Tests of physical quantities at the ends of their ranges: conversions saturate, and none wraps.

use narx_core::units::{Duty, Volts};
use proptest::prelude::*;

#[test]
fn a_duty_is_at_most_always_on() {
    for (bits, duty) in
        [(0, 0), (1, 1), (32_767, 32_767), (32_768, 32_768), (32_769, 32_768), (u16::MAX, 32_768)]
    {
        assert_eq!(Duty::from_bits(bits).to_bits(), duty, "{bits}");
    }
    assert_eq!(Duty::from_bits(u16::MAX), Duty::ONE);
}

/// Quotient in units of 2^-16, in arithmetic wide enough for everything.
fn exact(numerator: i64, denominator: i32) -> i32 {
    let denominator = i128::from(if denominator == 0 { 1 } else { denominator });
    let scaled = i128::from(numerator) << 16;
    let half = denominator.abs() / 2 * scaled.signum();
    ((scaled + half) / denominator).clamp(i32::MIN.into(), i32::MAX.into()) as i32
}

#[test]
fn a_quotient_is_rounded_and_saturates() {
    let (max, min) = (i32::MAX, i32::MIN);
    for (numerator, denominator, bits) in [
        (1, 1, 0x1_0000),
        (1, 2, 0x8000),
        (1, 3, 0x5555),
        (2, 3, 0xAAAB),
        (-2, 3, -0xAAAB),
        (2, -3, -0xAAAB),
        // Half of the lowest bit rounds away from zero.
        (1, 1 << 17, 1),
        (-1, 1 << 17, -1),
        (1, (1 << 17) + 1, 0),
        (32_767, 1, 32_767 << 16),
        (32_768, 1, max),
        (-32_768, 1, min),
        (-32_769, 1, min),
        (0, 0, 0),
        (5, 0, 5 << 16),
        (i64::MAX, 1, max),
        (i64::MAX, 0, max),
        (i64::MAX, -1, min),
        (i64::MAX, max, max),
        (i64::MAX, min, min),
        (i64::MIN, 1, min),
        (i64::MIN, -1, max),
        (i64::MIN, max, min),
        (i64::MIN, min, max),
    ] {
        assert_eq!(Volts::from_ratio(numerator, denominator).to_bits(), bits, "{numerator} / {denominator}");
        assert_eq!(exact(numerator, denominator), bits, "{numerator} / {denominator}");
    }
}

proptest! {
    /// The conversion is right for any numbers, whether their quotient fits or not.
    #[test]
    fn any_quotient(numerator: i64, denominator: i32, bits in 0..64_u32) {
        for numerator in [numerator, numerator >> bits] {
            let volts = Volts::from_ratio(numerator, denominator);
            prop_assert_eq!(volts.to_bits(), exact(numerator, denominator), "{} / {}", numerator, denominator);
        }
    }
}
