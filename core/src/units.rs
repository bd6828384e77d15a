//! Physical quantities as newtypes over fixed point. A quantity never mixes with another by accident, and
//! every operation says what happens at the edge of its range: core neither panics nor wraps unnoticed.

use fixed::types::{I16F16, U1F15};
use serde::{Deserialize, Serialize};

/// One newtype per quantity, all with the same few operations: a macro, because Rust has no newtype deriving.
macro_rules! quantity {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
        pub struct $name(I16F16);

        impl $name {
            /// Zero.
            pub const ZERO: Self = Self(I16F16::ZERO);
            /// The largest value: 32 767.99998.
            pub const MAX: Self = Self(I16F16::MAX);
            /// The raw bits: units of 2^-16.
            #[inline]
            pub const fn to_bits(self) -> i32 {
                self.0.to_bits()
            }
            /// From raw bits: units of 2^-16.
            #[inline]
            pub const fn from_bits(bits: i32) -> Self {
                Self(I16F16::from_bits(bits))
            }
            /// From thousandths of the unit, rounded to nearest, saturating.
            #[inline]
            pub const fn from_milli(milli: i32) -> Self {
                Self::from_ratio(milli as i64, 1000)
            }
            /// `numerator / denominator` of the unit, rounded to nearest, saturating; a denominator of 0
            /// counts as 1.
            pub const fn from_ratio(numerator: i64, denominator: i32) -> Self {
                Self::from_bits(ratio(numerator, denominator))
            }
            /// The value in units of 1 / `per_unit`, rounded to nearest, saturating.
            pub const fn scaled(self, per_unit: i32) -> i32 {
                saturate64((self.to_bits() as i64 * per_unit as i64 + 0x8000) >> 16)
            }
            /// Sum, saturating.
            #[inline]
            #[must_use]
            pub const fn saturating_add(self, other: Self) -> Self {
                Self(self.0.saturating_add(other.0))
            }
            /// Difference, saturating.
            #[inline]
            #[must_use]
            pub const fn saturating_sub(self, other: Self) -> Self {
                Self(self.0.saturating_sub(other.0))
            }
            /// Negation, saturating.
            #[inline]
            #[must_use]
            pub const fn saturating_neg(self) -> Self {
                Self(self.0.saturating_neg())
            }
            /// Magnitude, saturating.
            #[inline]
            #[must_use]
            pub const fn abs(self) -> Self {
                Self(self.0.saturating_abs())
            }
        }
    };
}

quantity!(
    /// Volts, I16F16.
    Volts
);
quantity!(
    /// Amperes, I16F16.
    Amps
);
quantity!(
    /// Degrees Celsius, I16F16.
    Celsius
);
quantity!(
    /// Watts, I16F16.
    Watts
);
quantity!(
    /// Electrical speed in revolutions per second, I16F16; negative turns in reverse. Revolutions per minute
    /// exist at the bus boundary only.
    ElectricalSpeed
);

/// PWM duty cycle, U1F15, 0..=1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Duty(U1F15);

impl Duty {
    /// Never on.
    pub const ZERO: Self = Self(U1F15::ZERO);
    /// Always on.
    pub const ONE: Self = Self(U1F15::ONE);

    /// Units of 2^-15, 0..=32 768.
    #[inline]
    pub const fn to_bits(self) -> u16 {
        self.0.to_bits()
    }
    /// From units of 2^-15; more than 32 768 becomes 1.
    #[inline]
    pub const fn from_bits(bits: u16) -> Self {
        if bits > Self::ONE.to_bits() { Self::ONE } else { Self(U1F15::from_bits(bits)) }
    }
    /// From units of 2^-15 that are known to be no more than 32 768.
    #[inline]
    pub(crate) const fn from_bits_within(bits: u16) -> Self {
        debug_assert!(bits <= Self::ONE.to_bits());
        Self(U1F15::from_bits(bits))
    }
}

/// Electrical angle, one turn = 65 536; wraps. 0 is the rising zero crossing of phase A's back-EMF.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ElectricalAngle(pub u16);

impl ElectricalAngle {
    /// From whole degrees, -360..=360.
    pub const fn from_degrees(degrees: i32) -> Self {
        Self(((degrees * 65_536) / 360) as u16)
    }
    /// Signed distance from `other` to `self`, -32 768..=32 767.
    #[inline]
    pub const fn wrapping_distance(self, other: Self) -> i16 {
        self.0.wrapping_sub(other.0) as i16
    }
}

/// Raw I16F16 of a quotient, rounded to nearest, halves away from zero, saturating; a denominator of 0 counts
/// as 1.
#[inline(never)]
pub(crate) const fn ratio(numerator: i64, denominator: i32) -> i32 {
    let denominator = if denominator == 0 { 1 } else { denominator as i64 };
    let half = denominator.abs() / 2;
    // A larger numerator saturates with every denominator, and has no room to be shifted.
    let most = 1_i64 << 46;
    let numerator = if numerator > most {
        most
    } else if numerator < -most {
        -most
    } else {
        numerator
    } << 16;
    saturate64(quotient(if numerator < 0 { numerator - half } else { numerator + half }, denominator))
}

/// `numerator / denominator`, rounded towards 0; 0 for a denominator of 0. `i64::MIN` / -1, which does not
/// fit 64 bits, does not occur.
#[inline]
pub(crate) const fn quotient(numerator: i64, denominator: i64) -> i64 {
    match numerator.checked_div(denominator) {
        Some(quotient) => quotient,
        None => 0,
    }
}

/// The nearest `i32`.
#[inline]
pub(crate) const fn saturate64(value: i64) -> i32 {
    if value > i32::MAX as i64 {
        i32::MAX
    } else if value < i32::MIN as i64 {
        i32::MIN
    } else {
        value as i32
    }
}
