//! The exponential function of numbers that are not positive, from basic operations only.

/// Below this the exponential counts as this one's, about 1e-304.
const LEAST: f64 = -700.0;
const LN_2_HIGH: f64 = 0.693_147_180_369_123_8;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;
/// 1.5 x 2^52: what is added to it is rounded to a whole number, which then stands in the lowest bits of the sum.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// exp(x) of two numbers that are not positive, to 1e-12: both go the same way, so that one instruction can serve two.
///
/// x = n ln 2 + r with a whole n and |r| <= ln 2 / 2, and the series of exp(r), in an order that keeps several
/// multiplications under way at once.
#[cfg_attr(not(target_arch = "wasm32"), inline(always))]
pub(crate) fn falling(x: [f64; 2]) -> [f64; 2] {
    let x = x.map(|x| if x > LEAST { x } else { LEAST });
    let sum = x.map(|x| x * core::f64::consts::LOG2_E + ROUND);
    let n = sum.map(|sum| sum - ROUND);
    let r = [0, 1].map(|k| (x[k] - n[k] * LN_2_HIGH) - n[k] * LN_2_LOW);
    let series = r.map(|r| {
        let (r2, r4) = (r * r, (r * r) * (r * r));
        let a = (1.0 + r) + r2 * (1.0 / 2.0 + r * (1.0 / 6.0));
        let b = (1.0 / 24.0 + r * (1.0 / 120.0)) + r2 * (1.0 / 720.0 + r * (1.0 / 5040.0));
        let c = (1.0 / 40_320.0 + r * (1.0 / 362_880.0)) + r2 * (1.0 / 3_628_800.0);
        a + r4 * (b + r4 * c)
    });
    // 2^n from its exponent: n is at least -1010.
    let power = sum.map(|sum| f64::from_bits(sum.to_bits().wrapping_add(1023) << 52));
    [series[0] * power[0], series[1] * power[1]]
}
