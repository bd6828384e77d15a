//! Reader of the drive's description, as it streams in and in bounded memory. With it a small board knows
//! parameters, scales and ranges of a drive that is newer or older than itself. The caller gets the rows and
//! keeps those that it needs.

use super::download::Chunk;
use super::draft::{Draft, Element};
use super::markup::{Markup, Token};
use super::rows::Described;
use crate::description::FORMAT;
use core::fmt;

/// Place at which a description cannot be read, and the reason.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DescriptionError {
    /// Line, the first one is 1.
    pub line: u32,
    /// Bytes of the document before the place.
    pub byte: u32,
    /// The reason.
    pub reason: Reason,
}

/// Reason why a description cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// Markup that no description has.
    Markup,
    /// An element ends while another one inside it is open, or elements are nested too deeply.
    Nesting,
    /// A name or value that is too long.
    TooLong,
    /// This attribute is missing, occurs twice, or cannot have such a value.
    Attribute(&'static str),
    /// The document has a format that this reader does not know, or is no description.
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
    /// The first error: nothing is read after it.
    failed: Option<DescriptionError>,
}

impl Default for DescriptionReader {
    fn default() -> Self {
        Self::new()
    }
}

impl DescriptionReader {
    /// Makes a reader that expects the first byte.
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

    /// Takes the next chunk of a download, and returns the row that it completes: at most one.
    ///
    /// # Errors
    /// The text is no description, or a chunk is missing before it. Later calls return the same error.
    pub fn handle_chunk(&mut self, chunk: &Chunk) -> Result<Option<Described>, DescriptionError> {
        if chunk.offset.saturating_mul(2) != self.byte {
            return Err(self.fail(Reason::Gap));
        }
        let mut complete = None;
        for byte in chunk.bytes() {
            if let Some(row) = self.handle_byte(byte)? {
                complete = Some(row);
            }
        }
        Ok(complete)
    }

    /// Takes the next byte, and returns the row that it completes. That is the last byte of the row's tag; a
    /// parameter's own text follows.
    ///
    /// # Errors
    /// The text is no description. Later calls return the same error.
    pub fn handle_byte(&mut self, byte: u8) -> Result<Option<Described>, DescriptionError> {
        if let Some(error) = self.failed {
            return Err(error);
        }
        let row = self.read(byte).map_err(|reason| self.fail(reason))?;
        self.byte = self.byte.saturating_add(1);
        self.line = self.line.saturating_add(u32::from(byte == b'\n'));
        Ok(row)
    }

    /// Checks that the document is complete.
    ///
    /// # Errors
    /// The document is incomplete, or there was an error before.
    pub fn finish(mut self) -> Result<(), DescriptionError> {
        let ended = self.failed.is_none() && self.markup.is_complete();
        if ended { Ok(()) } else { Err(self.fail(Reason::Incomplete)) }
    }

    /// Keeps the first error, and returns it.
    fn fail(&mut self, reason: Reason) -> DescriptionError {
        let Self { line, byte, .. } = *self;
        *self.failed.get_or_insert(DescriptionError { line, byte, reason })
    }

    fn read(&mut self, byte: u8) -> Result<Option<Described>, Reason> {
        let token = self.markup.handle_byte(byte)?;
        if token == Token::Nothing {
            return Ok(None);
        }
        if token == Token::Attribute && !self.known {
            // The root's first attribute is its format.
            let (name, value) = self.markup.attribute();
            let form = name == "format" && value.parse() == Ok(FORMAT);
            self.known = form && self.markup.is_in(&["description"]);
        }
        if !self.known {
            return Err(Reason::Format);
        }
        let Some(element) = Element::of(&self.markup) else { return Ok(None) };
        if token == Token::Head {
            return self.draft.complete(element);
        }
        let (name, value) = self.markup.attribute();
        self.draft.put(element, name, value)?;
        Ok(None)
    }
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
            Self::Markup => "markup that a description cannot have",
            Self::Nesting => "elements are not closed in their order",
            Self::TooLong => "a name or value is too long",
            Self::Attribute(name) => return write!(f, "attribute \"{name}\" is missing or wrong"),
            Self::Format => "not a description of the known format",
            Self::Gap => "a part before it is missing",
            Self::Incomplete => "the end is missing",
        })
    }
}

impl core::error::Error for DescriptionError {}
