//! Parser for the description's XML, byte by byte and in bounded memory. It reads elements and attributes,
//! and skips texts. Entities, comments and everything else that no description has are errors.

use super::described::Reason;
use heapless::{String, Vec};

/// Bytes of the longest name of an element or attribute.
const NAME_MAX: usize = 16;
/// Bytes of the longest value of an attribute.
pub(super) const VALUE_MAX: usize = 64;
/// Deepest nesting of elements.
const DEPTH_MAX: usize = 4;

type Name = String<NAME_MAX>;

/// Reads markup.
#[derive(Clone, Debug, Default)]
pub(super) struct Markup {
    at: At,
    /// The open elements, the innermost one last.
    open: Vec<Name, DEPTH_MAX>,
    /// The name that is being read, or that the value belongs to.
    name: Name,
    value: Vec<u8, VALUE_MAX>,
    /// The root element has begun.
    begun: bool,
}

/// State of the parser: the part of the markup to which the next byte belongs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum At {
    #[default]
    Text,
    /// Behind `<`.
    Open,
    /// In `<?...`; true behind its `?`.
    Declaration(bool),
    ElementName,
    /// Behind an element's name or a value: a space or the end of the tag.
    Behind,
    /// Behind a space in a tag.
    Space,
    AttributeName,
    /// Behind `=`.
    Equals,
    Value,
    /// Behind the `/` of an empty element.
    Empty,
    /// In `</...`.
    EndName,
}

/// Token that a byte completes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Token {
    /// Nothing yet.
    Nothing,
    /// An attribute of the innermost element: [`Markup::attribute`].
    Attribute,
    /// The attributes of the innermost element.
    Head,
}

impl Markup {
    /// Takes the next byte.
    pub(super) fn handle_byte(&mut self, byte: u8) -> Result<Token, Reason> {
        // An empty element ends right behind its head.
        if self.at == At::Empty {
            self.at = At::Text;
            self.open.pop();
            return if byte == b'>' { Ok(Token::Nothing) } else { Err(Reason::Markup) };
        }
        match (self.at, byte) {
            (At::Text, b'<') if self.is_complete() => return Err(Reason::Markup),
            (At::Text, b'<') => self.at = At::Open,
            (At::Text, b' ' | b'\n') => {}
            (At::Text, _) if self.open.is_empty() || !is_text(byte) => return Err(Reason::Markup),
            (At::Text, _) => {}
            (At::Open, b'?') if !self.begun => self.at = At::Declaration(false),
            (At::Open, b'/') => self.begin_name(At::EndName),
            (At::Open, _) => {
                self.begin_name(At::ElementName);
                self.push_name(byte)?;
            }
            (At::Declaration(true), b'>') => self.at = At::Text,
            (At::Declaration(_), _) => self.at = At::Declaration(byte == b'?'),
            (At::ElementName, b' ' | b'/' | b'>') => {
                self.begun = true;
                self.open.push(self.name.clone()).map_err(|_| Reason::Nesting)?;
                return self.go_on_in_tag(byte);
            }
            (At::Behind, b' ' | b'/' | b'>') => return self.go_on_in_tag(byte),
            (At::Space, _) => {
                self.begin_name(At::AttributeName);
                self.push_name(byte)?;
            }
            (At::AttributeName, b'=') => self.at = At::Equals,
            (At::ElementName | At::AttributeName | At::EndName, _) if byte != b'>' => self.push_name(byte)?,
            (At::Equals, b'"') => {
                self.value.clear();
                self.at = At::Value;
            }
            (At::Value, b'"') => {
                self.at = At::Behind;
                core::str::from_utf8(&self.value).map_err(|_| Reason::Markup)?;
                return Ok(Token::Attribute);
            }
            (At::Value, _) if is_text(byte) => self.value.push(byte).map_err(|_| Reason::TooLong)?,
            (At::EndName, b'>') => {
                if self.open.pop().as_ref() != Some(&self.name) {
                    return Err(Reason::Nesting);
                }
                self.at = At::Text;
            }
            _ => return Err(Reason::Markup),
        }
        Ok(Token::Nothing)
    }

    /// Name and value of the attribute that was just complete.
    pub(super) fn attribute(&self) -> (&str, &str) {
        (&self.name, core::str::from_utf8(&self.value).unwrap_or_default())
    }

    /// Returns whether these elements are open, from the root on.
    pub(super) fn is_in(&self, path: &[&str]) -> bool {
        self.open.iter().map(String::as_str).eq(path.iter().copied())
    }

    /// Returns whether the root element has ended.
    pub(super) fn is_complete(&self) -> bool {
        self.begun && self.open.is_empty() && self.at == At::Text
    }

    fn go_on_in_tag(&mut self, byte: u8) -> Result<Token, Reason> {
        self.at = match byte {
            b' ' => At::Space,
            b'/' => At::Empty,
            _ => At::Text,
        };
        Ok(if self.at == At::Space { Token::Nothing } else { Token::Head })
    }

    fn begin_name(&mut self, at: At) {
        self.name.clear();
        self.at = at;
    }

    fn push_name(&mut self, byte: u8) -> Result<(), Reason> {
        if !byte.is_ascii_lowercase() {
            return Err(Reason::Markup);
        }
        self.name.push(byte.into()).map_err(|_| Reason::TooLong)
    }
}

/// Returns whether a byte may occur in texts and values.
const fn is_text(byte: u8) -> bool {
    !byte.is_ascii_control() && !matches!(byte, b'<' | b'>' | b'&')
}
