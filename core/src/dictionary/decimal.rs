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
