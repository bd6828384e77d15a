//! Codes of error messages (Table 13), and reasons why a frame cannot be decoded.

use super::nmt::Target;
use core::fmt;

/// Code of an error message (Table 13).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u16)]
pub enum ErrorCode {
    /// 1000h: generic error. Here: the configuration could not be stored.
    Generic = 0x1000,
    /// 8120h: the CAN controller has become error passive.
    Passive = 0x8120,
    /// 8200h: an NMT command that does not exist.
    Protocol = 0x8200,
}

/// Reason why a frame cannot be decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DecodeError {
    /// A 29-bit identifier.
    ExtendedId,
    /// An identifier that Table 3 does not list, or not in this direction.
    Identifier,
    /// A remote frame where data is expected, or the reverse.
    Remote,
    /// The wrong number of data bytes.
    Length,
    /// An NMT command that Table 11 does not list, and to whom it goes.
    NmtCommand(Target),
    /// A field holds a value without a meaning.
    Value,
}

impl ErrorCode {
    /// Every code in the order of Table 13.
    pub const ALL: [Self; 3] = [Self::Generic, Self::Passive, Self::Protocol];

    /// The code of this number, if Table 13 lists it.
    pub fn decode(raw: u16) -> Option<Self> {
        Self::ALL.into_iter().find(|code| *code as u16 == raw)
    }

    /// Meaning of the code in words.
    pub const fn meaning(self) -> &'static str {
        match self {
            Self::Generic => "generic error",
            Self::Passive => "CAN controller error passive",
            Self::Protocol => "protocol error",
        }
    }
}

impl fmt::Display for ErrorCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04X}h: {}", *self as u16, self.meaning())
    }
}

impl fmt::Display for DecodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ExtendedId => "a 29-bit identifier",
            Self::Identifier => "an identifier that does not exist in this direction",
            Self::Remote => "a remote frame in place of data, or the reverse",
            Self::Length => "the wrong number of data bytes",
            Self::NmtCommand(_) => "an NMT command that does not exist",
            Self::Value => "a field with an undefined value",
        })
    }
}

impl core::error::Error for DecodeError {}
