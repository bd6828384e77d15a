//! A gain as mantissa x 2^-shift: any motor's range without float or division.

use crate::units::saturate64;
use serde::{Deserialize, Serialize};

/// Significant bits that a gain other than 0 must keep.
pub const SIGNIFICANT_BITS: u32 = 8;
const MANTISSA_BITS: u32 = 30;
const SHIFT_MAX: u32 = 62;

/// A factor: `mantissa` x 2^-`shift`. A gain in IQ24 is {gain, 24}, one in Q15 {gain, 15}.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(C)]
pub struct Gain {
    /// 0 to 2^30 - 1, so that the product with any 32-bit value fits 64 bits.
    mantissa: i32,
    /// Fraction bits, 0 to 62.
    shift: u32,
}

impl Gain {
    /// 0.
    pub const ZERO: Self = Self { mantissa: 0, shift: 0 };

    /// Largest mantissa.
    pub const MANTISSA_MAX: i32 = (1 << MANTISSA_BITS) - 1;

    /// The gain `mantissa x 2^-shift`: a Q-format with `shift` fraction bits. `None` unless the mantissa is 0
    /// to [`Self::MANTISSA_MAX`] and the shift 0 to 62.
    pub const fn new(mantissa: i32, shift: u32) -> Option<Self> {
        let fits = mantissa >= 0 && mantissa <= Self::MANTISSA_MAX && shift <= SHIFT_MAX;
        if fits { Some(Self { mantissa, shift }) } else { None }
    }

    /// The factor as an integer, in units of 2^-[`shift`](Self::shift).
    pub const fn mantissa(self) -> i32 {
        self.mantissa
    }

    /// Its fraction bits.
    pub const fn shift(self) -> u32 {
        self.shift
    }

    /// The gain `numerator / denominator`, its last bit rounded down. `None` if negative, too large (2^30 and
    /// more) or too small to keep [`SIGNIFICANT_BITS`]; and for what the arithmetic has no room for, a
    /// numerator of 2^64 or a denominator of 2^97 and more.
    pub const fn from_ratio(numerator: i128, denominator: i128) -> Option<Self> {
        if numerator < 0 || denominator <= 0 || numerator >> 64 != 0 || denominator >> 97 != 0 {
            return None;
        }
        if numerator == 0 {
            return Some(Self::ZERO);
        }
        // One bit of the quotient after the other, whole ones first: dividing 128 bits at once takes more
        // flash than the rest of building.
        let (mut rest, divisor) = (numerator as u128, (denominator as u128) << MANTISSA_BITS);
        if rest >= divisor {
            return None;
        }
        let (mut mantissa, mut bits) = (0, 0);
        while bits < MANTISSA_BITS
            || (mantissa >> (MANTISSA_BITS - 1) == 0 && bits < MANTISSA_BITS + SHIFT_MAX)
        {
            rest <<= 1;
            mantissa <<= 1;
            if rest >= divisor {
                rest -= divisor;
                mantissa |= 1;
            }
            bits += 1;
        }
        if mantissa < 1 << (SIGNIFICANT_BITS - 1) {
            return None;
        }
        Some(Self { mantissa, shift: bits - MANTISSA_BITS })
    }

    /// `self x value`, rounded down.
    #[inline]
    pub const fn apply(self, value: i32) -> i64 {
        (value as i64 * self.mantissa as i64) >> self.shift
    }

    /// `self x value`, rounded down, saturating.
    #[inline]
    pub const fn apply32(self, value: i32) -> i32 {
        let product = value as i64 * self.mantissa as i64;
        // Most gains are less than 1/4: then the upper word alone counts, and shifting all 64 bits would take
        // four times as long.
        if self.shift >= 32 {
            (product >> 32) as i32 >> (self.shift - 32)
        } else {
            saturate64(product >> self.shift)
        }
    }

    /// `self x value x 2^16`: the product with 16 extra fraction bits, saturating.
    #[inline]
    pub const fn apply_extended(self, value: i32) -> i64 {
        let product = value as i64 * self.mantissa as i64;
        if self.shift >= 16 {
            product >> (self.shift - 16)
        } else {
            product.saturating_mul(1 << (16 - self.shift))
        }
    }
}
