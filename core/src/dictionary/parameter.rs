//! One row of the dictionary.

use super::category::Category;
use super::decimal::Decimal;
use super::row::Place;
use core::fmt;
use serde::{Deserialize, Serialize};

/// All properties of one parameter except its value. Range and factory value are places in a table of the few
/// distinct numbers, and texts are only in a build that has use for them: the table is in the flash of every
/// board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parameter {
    pub(super) min: Place,
    pub(super) max: Place,
    pub(super) default: Place,
    #[cfg(feature = "names")]
    pub(super) name: &'static str,
    #[cfg(feature = "names")]
    pub(super) unit: &'static str,
    #[cfg(feature = "description")]
    pub(super) description: &'static str,
    /// Number on the wire.
    pub number: u16,
    /// Category as printed.
    pub category: Category,
    /// Type on the wire.
    pub kind: Kind,
    /// Engineering value = raw value * 10^exponent, exactly.
    pub exponent: i8,
    /// Write access, and in which states.
    pub access: Access,
    /// Writing 0 then 1 is a command; nothing is configured by it.
    pub command: bool,
    /// Time at which a written value takes effect.
    pub effect: Effect,
}

/// Type of a value on the wire, always carried in 32 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Kind {
    /// Unsigned 16 bits, zero-extended.
    U16,
    /// Signed 32 bits, two's complement.
    I32,
    /// Unsigned 32 bits.
    U32,
}

/// Write access to a parameter, and in which states.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Access {
    /// The drive alone writes it.
    ReadOnly,
    /// In Standby, and in Fault at standstill.
    Stopped,
    /// At any time.
    Live,
}

/// Time at which a written value takes effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Effect {
    /// Within a control tick or two of the write.
    Immediately,
    /// The next time that the drive leaves Standby.
    NextStart,
    /// After it was stored and the drive rebooted.
    Reboot,
}

impl Kind {
    /// The number that 32 bits of this kind mean.
    pub const fn widen(self, raw: i32) -> i64 {
        match self {
            Self::U16 | Self::I32 => raw as i64,
            Self::U32 => raw as u32 as i64,
        }
    }

    /// The 32 bits that mean a number of this kind; an error of the compiler for any other number in the
    /// table.
    pub(super) const fn narrow(self, number: i64) -> i32 {
        assert!(number >= self.smallest() && number <= self.largest());
        number as i32
    }

    /// Smallest number of this kind.
    pub const fn smallest(self) -> i64 {
        match self {
            Self::U16 | Self::U32 => 0,
            Self::I32 => i32::MIN as i64,
        }
    }

    /// Largest number of this kind.
    pub const fn largest(self) -> i64 {
        match self {
            Self::U16 => u16::MAX as i64,
            Self::I32 => i32::MAX as i64,
            Self::U32 => u32::MAX as i64,
        }
    }

    /// Name as C and the data base files write it.
    pub const fn label(self) -> &'static str {
        match self {
            Self::U16 => "uint16",
            Self::I32 => "int32",
            Self::U32 => "uint32",
        }
    }
}

impl Access {
    /// Name as the description writes it.
    pub const fn label(self) -> &'static str {
        match self {
            Self::ReadOnly => "read-only",
            Self::Stopped => "stopped",
            Self::Live => "live",
        }
    }
}

impl Effect {
    /// Name as the description writes it.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Immediately => "at once",
            Self::NextStart => "next start",
            Self::Reboot => "reboot",
        }
    }
}

impl Parameter {
    /// Name as printed in Tables 10 and 11; empty without the feature `names`.
    pub const fn name(&self) -> &'static str {
        #[cfg(feature = "names")]
        return self.name;
        #[cfg(not(feature = "names"))]
        ""
    }

    /// Suffix of a value of this parameter in a sentence: a space and its unit, or nothing.
    pub const fn unit_suffix(&self) -> UnitSuffix {
        UnitSuffix(self.unit())
    }

    /// Unit of the engineering value; "-" without one, and without the feature `names`.
    pub const fn unit(&self) -> &'static str {
        #[cfg(feature = "names")]
        return self.unit;
        #[cfg(not(feature = "names"))]
        "-"
    }

    /// Meaning in one or two sentences; empty without the feature `description`.
    pub const fn description(&self) -> &'static str {
        #[cfg(feature = "description")]
        return self.description;
        #[cfg(not(feature = "description"))]
        ""
    }

    /// Smallest raw value.
    pub const fn min(&self) -> i64 {
        self.kind.widen(self.min.number())
    }

    /// Largest raw value.
    pub const fn max(&self) -> i64 {
        self.kind.widen(self.max.number())
    }

    /// Raw factory value.
    pub const fn default(&self) -> i64 {
        self.kind.widen(self.default.number())
    }

    /// The factory value as 32 bits.
    pub const fn factory_raw(&self) -> i32 {
        self.default.number()
    }

    /// Returns whether its value is kept over a restart: not that of a command, nor one that the drive itself
    /// writes.
    pub(crate) const fn is_stored(&self) -> bool {
        !matches!(self.access, Access::ReadOnly) && !self.command
    }

    /// Returns whether the 32 bits `raw` are a value within the range.
    pub const fn accepts(&self, raw: i32) -> bool {
        let value = self.kind.widen(raw);
        value >= self.min() && value <= self.max()
    }

    /// A raw value in the parameter's unit.
    pub const fn engineering(&self, raw: i32) -> Decimal {
        Decimal { digits: self.kind.widen(raw), exponent: self.exponent }
    }
}

impl fmt::Display for Parameter {
    /// Number and name, as errors tell them.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { number, .. } = self;
        match self.name() {
            "" => write!(f, "parameter {number}"),
            name => write!(f, "parameter {number} \"{name}\""),
        }
    }
}

/// Result of [`Parameter::unit_suffix`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnitSuffix(&'static str);

impl fmt::Display for UnitSuffix {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            "-" => Ok(()),
            unit => write!(f, " {unit}"),
        }
    }
}
