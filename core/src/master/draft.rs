//! A row of the description while its attributes are being read.

use super::described::Reason;
use super::markup::{Markup, VALUE_MAX};
use super::rows::{Described, DescribedCategory, DescribedField, DescribedParameter, DescribedSignal};
use crate::dictionary::{Access, Decimal, Effect, Kind};
use heapless::String;

/// Elements that a reader takes; it passes over the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Element {
    Category,
    Parameter,
    Message,
    Field,
    Signal,
}

const ELEMENTS: [(Element, &[&str]); 5] = [
    (Element::Category, &["description", "categories", "category"]),
    (Element::Parameter, &["description", "parameters", "parameter"]),
    (Element::Message, &["description", "messages", "message"]),
    (Element::Field, &["description", "messages", "message", "field"]),
    (Element::Signal, &["description", "scope", "signal"]),
];

impl Element {
    /// Returns the innermost open element, if the reader takes it.
    pub(super) fn of(markup: &Markup) -> Option<Self> {
        ELEMENTS.into_iter().find(|(_, path)| markup.is_in(path)).map(|(element, _)| element)
    }
}

/// The attributes read so far, of an element of any kind.
#[derive(Clone, Debug, Default)]
pub(super) struct Draft {
    /// The message whose fields are read: opcode, and whether the drive sends it.
    message: (u16, bool),
    row: Attributes,
}

#[derive(Clone, Debug, Default)]
struct Attributes {
    number: Option<u16>,
    category: Option<String<4>>,
    name: Option<String<VALUE_MAX>>,
    unit: Option<String<16>>,
    kind: Option<Kind>,
    signed: Option<bool>,
    from_drive: Option<bool>,
    bit: Option<u8>,
    bits: Option<u8>,
    exponent: Option<i8>,
    min: Option<Decimal>,
    /// Largest value of a parameter, or base of a signal.
    max: Option<Decimal>,
    default: Option<Decimal>,
    access: Option<Access>,
    command: Option<bool>,
    effect: Option<Effect>,
}

impl Draft {
    /// Takes an attribute; unknown ones are ignored.
    pub(super) fn put(&mut self, element: Element, name: &str, value: &str) -> Result<(), Reason> {
        use Element::{Category, Field, Message, Parameter, Signal};
        let row = &mut self.row;
        let number = || Decimal::parse(value);
        let text = || String::try_from(value).ok();
        match (element, name) {
            (Parameter, "number") | (Message, "opcode") => {
                set(if element == Message { "opcode" } else { "number" }, &mut row.number, value.parse().ok())
            }
            (Category, "number") | (Parameter, "category") => set(
                if element == Category { "number" } else { "category" },
                &mut row.category,
                String::try_from(value).ok(),
            ),
            (Category | Parameter | Field | Signal, "name") => set("name", &mut row.name, text()),
            (Parameter | Field | Signal, "unit") => set("unit", &mut row.unit, String::try_from(value).ok()),
            (Parameter, "type") => set("type", &mut row.kind, kind(value)),
            (Field, "type") => set("type", &mut row.signed, one_of(value, ["uint", "int"])),
            (Message, "from") => set("from", &mut row.from_drive, one_of(value, ["master", "drive"])),
            (Field | Signal, "bit") => set("bit", &mut row.bit, value.parse().ok()),
            (Field, "bits") => set("bits", &mut row.bits, value.parse().ok()),
            (Parameter | Field, "scale") => set("scale", &mut row.exponent, number().and_then(power_of_ten)),
            (Signal, "base") => set("base", &mut row.max, number().filter(|base| base.digits > 0)),
            (Parameter, "min") => set("min", &mut row.min, number()),
            (Parameter, "max") => set("max", &mut row.max, number()),
            (Parameter, "factory") => set("factory", &mut row.default, number()),
            (Parameter, "access") => set("access", &mut row.access, access(value)),
            (Parameter, "command") => set("command", &mut row.command, (value == "1").then_some(true)),
            (Parameter, "acts") => set("acts", &mut row.effect, effect(value)),
            _ => Ok(()),
        }
    }

    /// Returns the row that these attributes make; a message alone makes none.
    pub(super) fn complete(&mut self, element: Element) -> Result<Option<Described>, Reason> {
        let row = core::mem::take(&mut self.row);
        Ok(Some(match element {
            Element::Category => Described::Category(DescribedCategory {
                number: row.category.ok_or(Reason::Attribute("number"))?,
                name: row.name.ok_or(Reason::Attribute("name"))?,
            }),
            Element::Parameter => Described::Parameter(row.parameter()?),
            Element::Message => {
                let opcode = row.number.ok_or(Reason::Attribute("opcode"))?;
                self.message = (opcode, row.from_drive.ok_or(Reason::Attribute("from"))?);
                return Ok(None);
            }
            Element::Field => Described::Field(row.field(self.message)?),
            Element::Signal => Described::Signal(DescribedSignal {
                bit: row.bit.filter(|bit| *bit < 32).ok_or(Reason::Attribute("bit"))?,
                name: row.name.ok_or(Reason::Attribute("name"))?,
                unit: row.unit.unwrap_or_default(),
                base: row.max.ok_or(Reason::Attribute("base"))?,
            }),
        }))
    }
}

impl Attributes {
    fn parameter(self) -> Result<DescribedParameter, Reason> {
        let exponent = self.exponent.ok_or(Reason::Attribute("scale"))?;
        let raw = |value: Option<Decimal>, name| {
            value.and_then(|value| value.rescaled(exponent)).ok_or(Reason::Attribute(name))
        };
        let parameter = DescribedParameter {
            number: self.number.ok_or(Reason::Attribute("number"))?,
            category: self.category.ok_or(Reason::Attribute("category"))?,
            name: self.name.ok_or(Reason::Attribute("name"))?,
            unit: self.unit.unwrap_or_default(),
            kind: self.kind.ok_or(Reason::Attribute("type"))?,
            exponent,
            min: raw(self.min, "min")?,
            max: raw(self.max, "max")?,
            default: raw(self.default, "factory")?,
            access: self.access.ok_or(Reason::Attribute("access"))?,
            command: self.command.unwrap_or(false),
            effect: self.effect.unwrap_or(Effect::Immediately),
        };
        let DescribedParameter { kind, min, max, default, .. } = parameter;
        if min < kind.smallest() || max > kind.largest() || min > max {
            return Err(Reason::Attribute("max"));
        }
        if !(min..=max).contains(&default) {
            return Err(Reason::Attribute("factory"));
        }
        Ok(parameter)
    }

    fn field(self, (opcode, from_drive): (u16, bool)) -> Result<DescribedField, Reason> {
        let first_bit = self.bit.filter(|bit| *bit < 64).ok_or(Reason::Attribute("bit"))?;
        let fits = |bits: &u8| (1..=48).contains(bits) && first_bit + bits <= 64;
        Ok(DescribedField {
            opcode,
            from_drive,
            name: self.name.ok_or(Reason::Attribute("name"))?,
            unit: self.unit.unwrap_or_default(),
            first_bit,
            bits: self.bits.filter(fits).ok_or(Reason::Attribute("bits"))?,
            signed: self.signed.ok_or(Reason::Attribute("type"))?,
            // Numbers without a unit, and named values, have no scale.
            exponent: self.exponent.unwrap_or(0),
        })
    }
}

/// Sets an attribute; an error if it has no valid value, or was set before.
fn set<T>(name: &'static str, place: &mut Option<T>, value: Option<T>) -> Result<(), Reason> {
    if place.is_some() || value.is_none() {
        return Err(Reason::Attribute(name));
    }
    *place = value;
    Ok(())
}

/// Returns true if a text is the second of two words, false if it is the first; `None` if it is neither.
fn one_of(text: &str, [no, yes]: [&str; 2]) -> Option<bool> {
    if text == yes { Some(true) } else { (text == no).then_some(false) }
}

fn kind(text: &str) -> Option<Kind> {
    [Kind::U16, Kind::I32, Kind::U32].into_iter().find(|kind| kind.label() == text)
}

fn access(text: &str) -> Option<Access> {
    [Access::ReadOnly, Access::Stopped, Access::Live].into_iter().find(|access| access.label() == text)
}

fn effect(text: &str) -> Option<Effect> {
    [Effect::NextStart, Effect::Reboot].into_iter().find(|effect| effect.label() == text)
}

/// Exponent of a power of ten from -18 to 18; `None` for any other number.
fn power_of_ten(Decimal { mut digits, mut exponent }: Decimal) -> Option<i8> {
    while digits % 10 == 0 && digits != 0 {
        (digits, exponent) = (digits / 10, exponent.checked_add(1)?);
    }
    (digits == 1 && (-18..=18).contains(&exponent)).then_some(exponent)
}
