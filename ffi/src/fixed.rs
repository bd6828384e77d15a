//! Conversion between the core's fixed-point formats and those of DSP code; the crate `fixed` does the
//! arithmetic.

use fixed::traits::ToFixed;
use fixed::types::{I1F15, I4F12, I8F24, I16F16};

/// 1 in Q16 (I16F16), the library's volts, amperes, degrees Celsius and revolutions per second: -32 768 to
/// 32 767.99998.
pub const NARX_Q16_ONE: i32 = 1 << 16;
/// 1 in IQ24 (I8F24), as DSP libraries have it: -128 to 127.99999994.
pub const NARX_IQ24_ONE: i32 = 1 << 24;
/// 1 in Q15 (I1F15), which is one more than its largest value, 32 767: -1 to 0.99997.
pub const NARX_Q15_ONE: i32 = 1 << 15;
/// 1 in Q12 (I4F12), the virtual scope's samples: -8 to 7.9998.
pub const NARX_Q12_ONE: i32 = 1 << 12;
/// 1 in U1F15, a duty: 0 to 1.
pub const NARX_DUTY_ONE: u16 = 1 << 15;
/// 1 turn of an electrical angle, a wrapping uint16_t.
pub const NARX_TURN: i32 = 1 << 16;

const _: () = assert!(
    I16F16::from_bits(NARX_Q16_ONE).to_bits() == I16F16::ONE.to_bits()
        && I8F24::from_bits(NARX_IQ24_ONE).to_bits() == I8F24::ONE.to_bits()
        && I4F12::from_bits(NARX_Q12_ONE as i16).to_bits() == I4F12::ONE.to_bits()
        && fixed::types::U1F15::from_bits(NARX_DUTY_ONE).to_bits() == fixed::types::U1F15::ONE.to_bits(),
    "the header has 1 of every format as a plain number: set it to the core's"
);

/// Converts a whole number of thousandths (mV, mA, 0.001 degrees) to Q16, rounded to nearest; saturates
/// beyond 32 767 999. Any context.
#[unsafe(no_mangle)]
pub extern "C" fn narx_q16_from_milli(milli: i32) -> i32 {
    narx_core::units::Volts::from_milli(milli).to_bits()
}

/// Converts a Q16 to thousandths, rounded to nearest; saturates. Any context.
#[unsafe(no_mangle)]
pub extern "C" fn narx_milli_from_q16(value: i32) -> i32 {
    narx_core::units::Volts::from_bits(value).scaled(1000)
}

/// Returns the sum of two Q16, saturating. Any context.
#[unsafe(no_mangle)]
pub extern "C" fn narx_q16_add(a: i32, b: i32) -> i32 {
    q16(a).saturating_add(q16(b)).to_bits()
}

/// Returns the difference of two Q16, saturating. Any context.
#[unsafe(no_mangle)]
pub extern "C" fn narx_q16_subtract(a: i32, b: i32) -> i32 {
    q16(a).saturating_sub(q16(b)).to_bits()
}

/// Returns the product of two Q16, rounded down, saturating. Any context.
#[unsafe(no_mangle)]
pub extern "C" fn narx_q16_multiply(a: i32, b: i32) -> i32 {
    q16(a).saturating_mul(q16(b)).to_bits()
}

/// Returns the quotient of two Q16, rounded towards 0, saturating; a division by 0 gives the largest or
/// smallest value, or 0 for 0 / 0. Not for a control interrupt: a processor without a 64-bit division takes
/// hundreds of instructions. Any context.
#[unsafe(no_mangle)]
pub extern "C" fn narx_q16_divide(a: i32, b: i32) -> i32 {
    match (a.signum(), b) {
        (0, _) => 0,
        (1, 0) => i32::MAX,
        (_, 0) => i32::MIN,
        _ => q16(a).saturating_div(q16(b)).to_bits(),
    }
}

/// Converts a Q16 to IQ24, exactly; saturates beyond 127.99999994. Any context.
#[unsafe(no_mangle)]
pub extern "C" fn narx_iq24_from_q16(value: i32) -> i32 {
    q16(value).saturating_to_fixed::<I8F24>().to_bits()
}

/// Converts an IQ24 to Q16, rounded down. Any context.
#[unsafe(no_mangle)]
pub extern "C" fn narx_q16_from_iq24(value: i32) -> i32 {
    I8F24::from_bits(value).saturating_to_fixed::<I16F16>().to_bits()
}

/// Converts a Q16 to Q15, rounded down; saturates beyond 0.99997. Any context.
#[unsafe(no_mangle)]
pub extern "C" fn narx_q15_from_q16(value: i32) -> i16 {
    q16(value).saturating_to_fixed::<I1F15>().to_bits()
}

/// Converts a Q15 to Q16, exactly. Any context.
#[unsafe(no_mangle)]
pub extern "C" fn narx_q16_from_q15(value: i16) -> i32 {
    I1F15::from_bits(value).saturating_to_fixed::<I16F16>().to_bits()
}

/// Converts a Q16 to Q12, rounded down; saturates beyond 7.9998. Any context.
#[unsafe(no_mangle)]
pub extern "C" fn narx_q12_from_q16(value: i32) -> i16 {
    q16(value).saturating_to_fixed::<I4F12>().to_bits()
}

/// Converts a Q12 to Q16, exactly. Any context.
#[unsafe(no_mangle)]
pub extern "C" fn narx_q16_from_q12(value: i16) -> i32 {
    I4F12::from_bits(value).saturating_to_fixed::<I16F16>().to_bits()
}

fn q16(bits: i32) -> I16F16 {
    I16F16::from_bits(bits)
}
