//! The four words of a frame, and the reasons why a frame cannot be decoded.

use super::id::MessageId;
use crate::bus::Frame;
use core::fmt;
use serde::{Deserialize, Serialize};

/// The data of a frame: words 0 to 3.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Words(pub [u16; 4]);

/// Reason why a frame cannot be decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DecodeError {
    /// An 11-bit identifier.
    StandardId,
    /// A remote frame.
    Remote,
    /// Not 8 data bytes.
    Length,
    /// A message type that does not exist, or not in this direction.
    Kind,
    /// No message of this direction and type has this opcode.
    Opcode,
    /// A field holds a value without a meaning.
    Value,
}

impl Words {
    /// The frame's identifier and words.
    ///
    /// # Errors
    /// The frame has not the shape of a NarMotion-X message.
    pub fn of(frame: &Frame) -> Result<(MessageId, Self), DecodeError> {
        let id = MessageId::of(frame)?;
        if frame.is_remote() {
            return Err(DecodeError::Remote);
        }
        let [a, b, c, d, e, f, g, h] = frame.full_payload().ok_or(DecodeError::Length)?;
        let words = [[a, b], [c, d], [e, f], [g, h]].map(u16::from_be_bytes);
        Ok((id, Self(words)))
    }

    /// A frame with these words.
    pub fn frame(self, id: MessageId) -> Frame {
        let [[a, b], [c, d], [e, f], [g, h]] = self.0.map(u16::to_be_bytes);
        Frame::full(id.encode(), [a, b, c, d, e, f, g, h])
    }

    /// Words 0 and 1 as one number, then words 2 and 3.
    pub(super) const fn long_first(high: u32, word2: u16, word3: u16) -> Self {
        Self([(high >> 16) as u16, high as u16, word2, word3])
    }
}

/// A 32-bit number from its high and low word.
pub(super) const fn long(high: u16, low: u16) -> u32 {
    (high as u32) << 16 | low as u32
}

impl DecodeError {
    /// Returns whether the frame breaks the format: one that only has an unknown opcode or value does not.
    pub const fn is_malformed(self) -> bool {
        !matches!(self, Self::Opcode | Self::Value)
    }
}

impl fmt::Display for DecodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::StandardId => "an 11-bit identifier",
            Self::Remote => "a remote frame",
            Self::Length => "not 8 data bytes",
            Self::Kind => "a message type that does not exist in this direction",
            Self::Opcode => "an opcode that does not exist in this direction",
            Self::Value => "a field with an undefined value",
        })
    }
}

impl core::error::Error for DecodeError {}
