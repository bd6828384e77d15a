//! The exponential function of numbers that are not positive, from basic operations only.

/// Below this the exponential counts as this one's, about 1e-304.
const LEAST: f64 = -700.0;
const LN_2_HIGH: f64 = 0.693_147_180_369_123_8;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;
/// 1.5 x 2^52: what is added to it is rounded to a whole number, which then stands in the lowest bits of the
/// sum.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// exp(x) for any x that is not positive, to 1e-9.
///
/// x = n ln 2 + r with a whole n and |r| <= ln 2 / 2, and the series of exp(r), its even and odd powers side
/// by side.
#[cfg_attr(not(target_arch = "wasm32"), inline(always))]
pub(crate) fn falling(x: f64) -> f64 {
    let x = if x > LEAST { x } else { LEAST };
    let sum = x * core::f64::consts::LOG2_E + ROUND;
    let n = sum - ROUND;
    let r = (x - n * LN_2_HIGH) - n * LN_2_LOW;
    let y = r * r;
    let y2 = y * y;
    let even = (1.0 + y * (1.0 / 2.0)) + y2 * ((1.0 / 24.0 + y * (1.0 / 720.0)) + y2 * (1.0 / 40_320.0));
    let odd = (1.0 + y * (1.0 / 6.0)) + y2 * (1.0 / 120.0 + y * (1.0 / 5040.0));
    let series = even + r * odd;
    // 2^n from its exponent: n is at least -1010.
    series * f64::from_bits(sum.to_bits().wrapping_add(1023) << 52)
}

/// exp(x) for an x that is not positive and small, as it is where an interval is much shorter than a time
/// constant: Pade's approximant of order 3, to 1e-8 at -0.35 and to 1e-12 at a quarter of it.
#[cfg_attr(not(target_arch = "wasm32"), inline(always))]
pub(crate) fn falling_little(x: f64) -> f64 {
    let y = x * x;
    let (even, odd) = (120.0 + 12.0 * y, x * (60.0 + y));
    (even + odd) / (even - odd)
}
