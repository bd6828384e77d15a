//! What the drive says of its parameters: the description, read as it streams in and in bounded memory, so that a small board
//! knows scales and ranges of a drive that is newer or older than itself.

use super::download::Chunk;
use super::markup::{Markup, Token, VALUE_MAX};
use crate::description::FORMAT;
use crate::dictionary::{Access, Decimal, Effect, Kind};
use core::fmt;
use heapless::String;

/// A parameter as the drive describes it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DescribedParameter {
    /// Number on the wire.
    pub number: u16,
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
    /// Who may write it, when.
    pub access: Access,
    /// Writing 0 then 1 is a command.
    pub command: bool,
    /// When a written value acts.
    pub effect: Effect,
}

impl DescribedParameter {
    /// Whether the 32 bits `raw` are a value within the range.
    pub const fn accepts(&self, raw: i32) -> bool {
        let value = self.kind.widen(raw);
        value >= self.min && value <= self.max
    }

    /// A raw value in the parameter's unit.
    pub const fn engineering(&self, raw: i32) -> Decimal {
        Decimal { digits: self.kind.widen(raw), exponent: self.exponent }
    }
}

/// Where and why a description cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DescriptionError {
    /// Line, the first one is 1.
    pub line: u32,
    /// Bytes of the document before the place.
    pub byte: u32,
    /// Why.
    pub reason: Reason,
}

/// Why a description cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// Markup that no description has.
    Markup,
    /// An element ends where another one is open, or there are too many inside each other.
    Nesting,
    /// A name or value that is too long.
    TooLong,
    /// This attribute is missing, stands there twice, or cannot have such a value.
    Attribute(&'static str),
    /// The document's form is not the one that this reader knows, or it is another document.
    Format,
    /// The chunk does not follow the one before.
    Gap,
    /// The document is not at its end.
    Incomplete,
}

/// Reads a description from its first byte to its last.
#[derive(Clone, Debug)]
pub struct DescriptionReader {
    markup: Markup,
    draft: Draft,
    line: u32,
    byte: u32,
    /// The document is a description of the known form.
    known: bool,
    /// What went wrong: there is no way on from there.
    failed: Option<DescriptionError>,
}

/// A parameter of which attributes are still to come.
#[derive(Clone, Debug, Default)]
struct Draft {
    number: Option<u16>,
    name: Option<String<VALUE_MAX>>,
    unit: Option<String<16>>,
    kind: Option<Kind>,
    exponent: Option<i8>,
    min: Option<Decimal>,
    max: Option<Decimal>,
    default: Option<Decimal>,
    access: Option<Access>,
    command: Option<bool>,
    effect: Option<Effect>,
}

const PARAMETER: [&str; 3] = ["description", "parameters", "parameter"];

impl Default for DescriptionReader {
    fn default() -> Self {
        Self::new()
    }
}

impl DescriptionReader {
    /// Before the first byte.
    pub fn new() -> Self {
        Self {
            markup: Markup::default(),
            draft: Draft::default(),
            line: 1,
            byte: 0,
            known: false,
            failed: None,
        }
    }

    /// Takes the next chunk of a download: at most one parameter is complete with it.
    ///
    /// # Errors
    /// What stands there is no description, or a chunk is missing before it. The same error comes again from then on.
    pub fn handle_chunk(&mut self, chunk: &Chunk) -> Result<Option<DescribedParameter>, DescriptionError> {
        if chunk.offset.saturating_mul(2) != self.byte {
            return Err(self.fail(Reason::Gap));
        }
        let mut complete = None;
        for byte in chunk.bytes() {
            if let Some(parameter) = self.handle_byte(byte)? {
                complete = Some(parameter);
            }
        }
        Ok(complete)
    }

    /// Takes the next byte: the parameter that is complete with it.
    ///
    /// # Errors
    /// What stands there is no description. The same error comes again from then on.
    pub fn handle_byte(&mut self, byte: u8) -> Result<Option<DescribedParameter>, DescriptionError> {
        if let Some(error) = self.failed {
            return Err(error);
        }
        let parameter = self.read(byte).map_err(|reason| self.fail(reason))?;
        self.byte = self.byte.saturating_add(1);
        self.line = self.line.saturating_add(u32::from(byte == b'\n'));
        Ok(parameter)
    }

    /// The end of the document has come.
    ///
    /// # Errors
    /// It is not the end, or there was an error before.
    pub fn finish(mut self) -> Result<(), DescriptionError> {
        let ended = self.failed.is_none() && self.markup.is_complete();
        if ended { Ok(()) } else { Err(self.fail(Reason::Incomplete)) }
    }

    /// The first thing that went wrong is what counts.
    fn fail(&mut self, reason: Reason) -> DescriptionError {
        let Self { line, byte, .. } = *self;
        *self.failed.get_or_insert(DescriptionError { line, byte, reason })
    }

    fn read(&mut self, byte: u8) -> Result<Option<DescribedParameter>, Reason> {
        let token = self.markup.handle_byte(byte)?;
        let in_parameter = self.markup.is_in(&PARAMETER);
        match token {
            Token::Nothing => {}
            // The root says first of what form it is.
            Token::Attribute if !self.known => {
                let (name, value) = self.markup.attribute();
                let form = name == "format" && value.parse() == Ok(FORMAT);
                self.known = form && self.markup.is_in(&["description"]);
            }
            Token::Attribute if in_parameter => {
                let (name, value) = self.markup.attribute();
                self.draft.put(name, value)?;
            }
            Token::Head if in_parameter => return core::mem::take(&mut self.draft).complete().map(Some),
            Token::Attribute | Token::Head => {}
        }
        if token == Token::Nothing || self.known { Ok(None) } else { Err(Reason::Format) }
    }
}

impl Draft {
    /// Attributes that it does not know are left to others.
    fn put(&mut self, name: &str, value: &str) -> Result<(), Reason> {
        let number = || Decimal::parse(value);
        match name {
            "number" => set("number", &mut self.number, value.parse().ok()),
            "name" => set("name", &mut self.name, String::try_from(value).ok()),
            "unit" => set("unit", &mut self.unit, String::try_from(value).ok()),
            "type" => set("type", &mut self.kind, kind(value)),
            "scale" => set("scale", &mut self.exponent, number().and_then(power_of_ten)),
            "min" => set("min", &mut self.min, number()),
            "max" => set("max", &mut self.max, number()),
            "factory" => set("factory", &mut self.default, number()),
            "access" => set("access", &mut self.access, access(value)),
            "command" => set("command", &mut self.command, (value == "1").then_some(true)),
            "acts" => set("acts", &mut self.effect, effect(value)),
            _ => Ok(()),
        }
    }

    fn complete(self) -> Result<DescribedParameter, Reason> {
        let exponent = self.exponent.ok_or(Reason::Attribute("scale"))?;
        let raw = |value: Option<Decimal>, name| {
            value.and_then(|value| value.rescaled(exponent)).ok_or(Reason::Attribute(name))
        };
        let parameter = DescribedParameter {
            number: self.number.ok_or(Reason::Attribute("number"))?,
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
}

/// An attribute has one value, and once.
fn set<T>(name: &'static str, place: &mut Option<T>, value: Option<T>) -> Result<(), Reason> {
    if place.is_some() || value.is_none() {
        return Err(Reason::Attribute(name));
    }
    *place = value;
    Ok(())
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

/// `None` if it is no power of ten.
fn power_of_ten(Decimal { mut digits, mut exponent }: Decimal) -> Option<i8> {
    while digits % 10 == 0 && digits != 0 {
        (digits, exponent) = (digits / 10, exponent.checked_add(1)?);
    }
    (digits == 1 && (-18..=18).contains(&exponent)).then_some(exponent)
}

impl fmt::Display for DescriptionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { line, byte, reason } = self;
        write!(f, "description, line {line}, byte {byte}: {reason}")
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Markup => "markup that no description has",
            Self::Nesting => "elements are not closed in their order",
            Self::TooLong => "a name or value is too long",
            Self::Attribute(name) => return write!(f, "attribute \"{name}\" is missing or wrong"),
            Self::Format => "a document of another form",
            Self::Gap => "a part before it is missing",
            Self::Incomplete => "the end is missing",
        })
    }
}

impl core::error::Error for DescriptionError {}
