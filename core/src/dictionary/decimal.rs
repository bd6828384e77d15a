//! Exact decimal numbers for people: a raw value times a power of ten, without floating point.

use core::fmt;
use core::num::NonZeroU64;

/// `digits` * 10^`exponent`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decimal {
    /// The number without its decimal point.
    pub digits: i64,
    /// The power of ten, -18..=18.
    pub exponent: i8,
}

impl Decimal {
    /// Parses a text in plain decimal notation; `None` if it is no such text, or too long.
    pub fn parse(text: &str) -> Option<Self> {
        let (sign, magnitude) = text.strip_prefix('-').map_or((1, text), |magnitude| (-1, magnitude));
        let (whole, fraction) = magnitude.split_once('.').unwrap_or((magnitude, ""));
        if whole.is_empty() || magnitude.ends_with('.') {
            return None;
        }
        let mut digits = 0_i64;
        for byte in whole.bytes().chain(fraction.bytes()) {
            let digit = byte.checked_sub(b'0').filter(|digit| *digit < 10)?;
            digits = digits.checked_mul(10)?.checked_add(digit.into())?;
        }
        let exponent = i8::try_from(fraction.len()).ok().filter(|places| *places <= 18)?;
        Some(Self { digits: sign * digits, exponent: -exponent })
    }

    /// Its digits at another power of ten; `None` where that is no whole number, or one that is too large.
    pub fn rescaled(self, exponent: i8) -> Option<i64> {
        let shift = i16::from(self.exponent) - i16::from(exponent);
        let power = 10_i64.checked_pow(shift.unsigned_abs().into());
        if shift >= 0 {
            return if self.digits == 0 { Some(0) } else { self.digits.checked_mul(power?) };
        }
        let whole = power.is_some_and(|power| self.digits.checked_rem(power) == Some(0));
        if whole { self.digits.checked_div(power?) } else { (self.digits == 0).then_some(0) }
    }
}

impl fmt::Display for Decimal {
    /// Plain decimal notation, without trailing zeros after the point.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.digits < 0 {
            f.write_str("-")?;
        }
        let magnitude = self.digits.unsigned_abs();
        if self.exponent >= 0 {
            write!(f, "{magnitude}")?;
            let zeros = if magnitude == 0 { 0 } else { self.exponent };
            return (0..zeros).try_for_each(|_| f.write_str("0"));
        }
        let places = self.exponent.unsigned_abs().min(18);
        let mut power = (0..places).fold(NonZeroU64::MIN, |power, _| power.saturating_mul(TEN));
        write!(f, "{}", magnitude / power)?;
        let mut fraction = magnitude % power;
        if fraction != 0 {
            f.write_str(".")?;
        }
        while fraction != 0 {
            power = NonZeroU64::new(power.get() / 10).unwrap_or(NonZeroU64::MIN);
            write!(f, "{}", fraction / power)?;
            fraction %= power;
        }
        Ok(())
    }
}

const TEN: NonZeroU64 = NonZeroU64::MIN.saturating_add(9);
