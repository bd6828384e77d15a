//! Rows of a drive's description: like the rows of this library's own tables, but as the drive describes
//! itself.

use super::markup::VALUE_MAX;
use crate::bus::narmotion::{Field, Meaning, Words};
use crate::dictionary::{Access, Decimal, Effect, Kind};
use heapless::String;

/// A row of a description, in the order of the document: categories, parameters, fields of messages, signals
/// of the scope.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Described {
    /// A category of parameters.
    Category(DescribedCategory),
    /// A parameter.
    Parameter(DescribedParameter),
    /// A field of a message.
    Field(DescribedField),
    /// A signal of the scope.
    Signal(DescribedSignal),
}

/// A category of parameters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DescribedCategory {
    /// Its number as printed: "04".
    pub number: String<4>,
    /// Its name.
    pub name: String<VALUE_MAX>,
}

/// A parameter as the drive describes it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DescribedParameter {
    /// Number on the wire.
    pub number: u16,
    /// Number of its category as printed: "04".
    pub category: String<4>,
    /// Its name.
    pub name: String<VALUE_MAX>,
    /// Unit of the engineering value; empty without one.
    pub unit: String<16>,
    /// Type on the wire.
    pub kind: Kind,
    /// Engineering value = raw value * 10^exponent, exactly.
    pub exponent: i8,
    /// Smallest raw value.
    pub min: i64,
    /// Largest raw value.
    pub max: i64,
    /// Raw factory value.
    pub default: i64,
    /// Write access, and in which states.
    pub access: Access,
    /// Writing 0 then 1 is a command.
    pub command: bool,
    /// Time at which a written value takes effect: within a tick or two, at the next start, or after a
    /// reboot.
    pub effect: Effect,
}

impl DescribedParameter {
    /// Returns whether the 32 bits `raw` are a value within the range.
    pub const fn accepts(&self, raw: i32) -> bool {
        let value = self.kind.widen(raw);
        value >= self.min && value <= self.max
    }

    /// A raw value in the parameter's unit.
    pub const fn engineering(&self, raw: i32) -> Decimal {
        Decimal { digits: self.kind.widen(raw), exponent: self.exponent }
    }
}

/// A field of a message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DescribedField {
    /// Opcode of the message.
    pub opcode: u16,
    /// Sent by the drive, else by its master.
    pub from_drive: bool,
    /// Its name.
    pub name: String<VALUE_MAX>,
    /// Unit of the engineering value; empty without one.
    pub unit: String<16>,
    /// Place of its first and highest bit: 0 is the highest bit of word 0, 63 the lowest of word 3.
    pub first_bit: u8,
    /// Length in bits, 1..=48.
    pub bits: u8,
    /// Two's complement, or else unsigned.
    pub signed: bool,
    /// Engineering value = raw value * 10^exponent, exactly.
    pub exponent: i8,
}

/// A signal of the virtual scope.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DescribedSignal {
    /// Its bit in parameter 22, 0..=31.
    pub bit: u8,
    /// Its name.
    pub name: String<VALUE_MAX>,
    /// Unit of the samples; empty without one.
    pub unit: String<16>,
    /// Value of a sample of 1, in the unit.
    pub base: Decimal,
}

impl DescribedField {
    /// Returns the field's value, in its unit, from the words of its message.
    pub fn value(&self, words: Words) -> Decimal {
        let Self { first_bit, bits, signed, exponent, .. } = *self;
        let meaning = Meaning::Number;
        let field = Field { name: "", first_bit, bits, signed, unit: "-", exponent, meaning };
        Decimal { digits: field.raw(words), exponent }
    }
}

#[cfg(feature = "engineering")]
impl<'a> From<&'a DescribedParameter> for crate::dictionary::engineering::Scale<'a> {
    fn from(row: &'a DescribedParameter) -> Self {
        let DescribedParameter { number, name, unit, exponent, min, max, .. } = row;
        Self { number: *number, name, unit, exponent: *exponent, min: *min, max: *max }
    }
}
