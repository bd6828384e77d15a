//! Numbers in texts, short and small. The standard formatting of floating-point numbers prints every digit
//! exactly, which costs the browser 8 KB; so does `f64::clamp`, whose panic prints its bounds (the plant
//! takes `max` and `min`).

use core::fmt::{self, Write};

/// A number as a reader wants it.
#[derive(Clone, Copy, Debug)]
pub enum Shown {
    /// With so many decimals.
    Rounded(f64, u32),
    /// With up to six significant digits.
    Plain(f64),
}

/// Digits of a number that is shown plainly, less one.
const DIGITS: i32 = 5;
/// Larger powers of ten are told as such.
const LARGE: i32 = 15;
const SMALL: i32 = -6;

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Rounded(value, _) | Self::Plain(value) if !value.is_finite() => {
                f.write_str(if value.is_nan() {
                    "NaN"
                } else if value > 0.0 {
                    "inf"
                } else {
                    "-inf"
                })
            }
            Self::Rounded(value, decimals) => fixed(f, value, decimals, false),
            Self::Plain(value) => plain(f, value),
        }
    }
}

fn plain(f: &mut fmt::Formatter<'_>, value: f64) -> fmt::Result {
    let mut power = 0;
    let mut mantissa = value.abs();
    while mantissa >= 10.0 {
        mantissa /= 10.0;
        power += 1;
    }
    while mantissa > 0.0 && mantissa < 1.0 {
        mantissa *= 10.0;
        power -= 1;
    }
    if (SMALL..LARGE).contains(&power) {
        return fixed(f, value, (DIGITS - power).max(0).unsigned_abs(), true);
    }
    fixed(f, mantissa.copysign(value), DIGITS.unsigned_abs(), true)?;
    write!(f, "e{power}")
}

/// With `decimals`; `short` leaves out zeros at the end.
fn fixed(f: &mut fmt::Formatter<'_>, value: f64, decimals: u32, short: bool) -> fmt::Result {
    // Not zero for the compiler either, which would else look for it in every division.
    let unit = 10_u64.saturating_pow(decimals).max(1);
    let scaled = libm::round(value.abs() * unit as f64) as u64;
    if value < 0.0 && scaled > 0 {
        f.write_str("-")?;
    }
    let (whole, mut rest, mut width) = (scaled / unit, scaled % unit, decimals as usize);
    while short && width > 0 && rest % 10 == 0 {
        (rest, width) = (rest / 10, width - 1);
    }
    write!(f, "{whole}")?;
    if width > 0 {
        f.write_str(".")?;
    }
    // Digit by digit: a width that is known only here could be too large for `write!`, and it would panic.
    (0..width as u32).rev().try_for_each(|place| {
        let digit = rest / 10_u64.saturating_pow(place).max(1) % 10;
        f.write_char(char::from(b'0' + digit as u8))
    })
}
