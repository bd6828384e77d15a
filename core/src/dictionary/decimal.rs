//! Exact decimal numbers for people: a raw value times a power of ten, without floating point.

use core::fmt;

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
        let power = 10_u128.pow(u32::from(self.exponent.unsigned_abs().min(18)));
        let magnitude = u128::from(self.digits.unsigned_abs());
        if self.digits < 0 {
            f.write_str("-")?;
        }
        if self.exponent >= 0 {
            return write!(f, "{}", magnitude * power);
        }
        write!(f, "{}", magnitude / power)?;
        let mut fraction = magnitude % power;
        let mut width = usize::from(self.exponent.unsigned_abs().min(18));
        if fraction == 0 {
            return Ok(());
        }
        while fraction % 10 == 0 {
            fraction /= 10;
            width -= 1;
        }
        write!(f, ".{fraction:0width$}")
    }
}
