//! Service data objects (Figure 6, Tables 5 and 10): one entry of up to four bytes, read or written.
//!
//! ```text
//!  byte     0    |  1  2 |    3     | 4 .. 7
//!        command | index | subindex | data
//! ```

use core::fmt;

/// A request for one entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SdoRequest {
    /// Index of the entry.
    pub index: u16,
    /// Its subindex.
    pub subindex: u8,
    /// Requested action.
    pub action: SdoAction,
}

/// Action that a master requests on an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SdoAction {
    /// 40h: read the value.
    Read,
    /// 22h, or with a size 23h, 27h, 2Bh, 2Fh: write the value.
    Write {
        /// Number of valid bytes, 1..=4; `None` if only the node knows it.
        size: Option<u8>,
        /// Low byte first.
        data: [u8; 4],
    },
    /// 80h: abort.
    Abort {
        /// Abort code.
        code: u32,
    },
    /// Any other command.
    Unknown {
        /// The command byte.
        command: u8,
    },
}

/// The answer to a request, with its index and subindex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SdoAnswer {
    /// Index as requested.
    pub index: u16,
    /// Subindex as requested.
    pub subindex: u8,
    /// Outcome of the request.
    pub outcome: SdoOutcome,
}

/// Outcome of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SdoOutcome {
    /// 60h: written.
    Written,
    /// 43h, 4Bh, 4Fh: read.
    Value(SdoValue),
    /// 80h: not done. [`AbortCode::decode`] knows the codes of Table 10.
    Aborted {
        /// Abort code.
        code: u32,
    },
}

/// A value as it is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SdoValue {
    size: u8,
    data: [u8; 4],
}

/// Reason why a request was refused (Table 10).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum AbortCode {
    /// 05040001h: Table 5 has no such command.
    CommandUnknown = 0x0504_0001,
    /// 06020000h: no entry has this index.
    IndexUnknown = 0x0602_0000,
    /// 06090011h: the entry has not this subindex.
    SubindexUnknown = 0x0609_0011,
    /// 06090030h: the value is outside the range, or has reserved bits.
    RangeExceeded = 0x0609_0030,
    /// 06010001h: the entry can only be written.
    WriteOnly = 0x0601_0001,
    /// 06010002h: the entry can only be read.
    ReadOnly = 0x0601_0002,
    /// 08000000h: not in this state, or with another size than the entry's.
    General = 0x0800_0000,
}

/// Commands of masters.
const READ: u8 = 0x40;
const WRITE: u8 = 0x22;
/// Commands of nodes.
const WRITTEN: u8 = 0x60;
/// Commands of both.
const ABORT: u8 = 0x80;

impl SdoRequest {
    /// The 8 bytes.
    pub const fn encode(self) -> [u8; 8] {
        let (command, data) = match self.action {
            SdoAction::Read => (READ, [0; 4]),
            SdoAction::Write { size, data } => (write_command(size), data),
            SdoAction::Abort { code } => (ABORT, code.to_le_bytes()),
            SdoAction::Unknown { command } => (command, [0; 4]),
        };
        join(command, self.index, self.subindex, data)
    }

    /// Decodes a request from 8 bytes.
    pub const fn decode([command, low, high, subindex, a, b, c, d]: [u8; 8]) -> Self {
        let data = [a, b, c, d];
        let action = match command {
            READ => SdoAction::Read,
            WRITE => SdoAction::Write { size: None, data },
            0x23 => SdoAction::Write { size: Some(4), data },
            0x27 => SdoAction::Write { size: Some(3), data },
            0x2B => SdoAction::Write { size: Some(2), data },
            0x2F => SdoAction::Write { size: Some(1), data },
            ABORT => SdoAction::Abort { code: u32::from_le_bytes(data) },
            command => SdoAction::Unknown { command },
        };
        Self { index: u16::from_le_bytes([low, high]), subindex, action }
    }
}

/// Command byte of a write; a size that no frame has room for counts as no size.
const fn write_command(size: Option<u8>) -> u8 {
    match size {
        Some(4) => 0x23,
        Some(3) => 0x27,
        Some(2) => 0x2B,
        Some(1) => 0x2F,
        _ => WRITE,
    }
}

impl SdoAnswer {
    /// The 8 bytes.
    pub const fn encode(self) -> [u8; 8] {
        let (command, data) = match self.outcome {
            SdoOutcome::Written => (WRITTEN, [0; 4]),
            SdoOutcome::Value(value) => (value.command(), value.data),
            SdoOutcome::Aborted { code } => (ABORT, code.to_le_bytes()),
        };
        join(command, self.index, self.subindex, data)
    }

    /// Decodes an answer from 8 bytes; `None` for a command that no answer has. 42h and 47h, which other
    /// nodes send for a value without a size and for one of three bytes, are understood too.
    pub const fn decode([command, low, high, subindex, a, b, c, d]: [u8; 8]) -> Option<Self> {
        let data = [a, b, c, d];
        let outcome = match command {
            WRITTEN => SdoOutcome::Written,
            0x42 | 0x43 => SdoOutcome::Value(SdoValue { size: 4, data }),
            0x47 => SdoOutcome::Value(SdoValue { size: 3, data: [a, b, c, 0] }),
            0x4B => SdoOutcome::Value(SdoValue { size: 2, data: [a, b, 0, 0] }),
            0x4F => SdoOutcome::Value(SdoValue { size: 1, data: [a, 0, 0, 0] }),
            ABORT => SdoOutcome::Aborted { code: u32::from_le_bytes(data) },
            _ => return None,
        };
        Some(Self { index: u16::from_le_bytes([low, high]), subindex, outcome })
    }
}

impl SdoValue {
    /// A value of one byte.
    pub const fn byte(value: u8) -> Self {
        Self { size: 1, data: [value, 0, 0, 0] }
    }

    /// A value of two bytes.
    pub const fn word(value: u16) -> Self {
        let [a, b] = value.to_le_bytes();
        Self { size: 2, data: [a, b, 0, 0] }
    }

    /// A value of four bytes.
    pub const fn long(value: u32) -> Self {
        Self { size: 4, data: value.to_le_bytes() }
    }

    /// Number of valid bytes: 1, 2 or 4, or 3 from other nodes.
    pub const fn size(self) -> u8 {
        self.size
    }

    /// The number, zero-extended.
    pub const fn number(self) -> u32 {
        u32::from_le_bytes(self.data)
    }

    const fn command(self) -> u8 {
        match self.size {
            1 => 0x4F,
            2 => 0x4B,
            3 => 0x47,
            _ => 0x43,
        }
    }
}

impl AbortCode {
    /// Every code in the order of Table 10.
    pub const ALL: [Self; 7] = [
        Self::CommandUnknown,
        Self::IndexUnknown,
        Self::SubindexUnknown,
        Self::RangeExceeded,
        Self::WriteOnly,
        Self::ReadOnly,
        Self::General,
    ];

    /// The code of this number, if Table 10 lists it. The last one is printed with seven digits, so 00800000h
    /// is understood as it, too.
    pub fn decode(raw: u32) -> Option<Self> {
        if raw == 0x0080_0000 {
            return Some(Self::General);
        }
        Self::ALL.into_iter().find(|code| *code as u32 == raw)
    }

    /// Meaning of the code in words.
    pub const fn meaning(self) -> &'static str {
        match self {
            Self::CommandUnknown => "command unknown",
            Self::IndexUnknown => "index does not exist",
            Self::SubindexUnknown => "subindex does not exist",
            Self::RangeExceeded => "value out of range",
            Self::WriteOnly => "entry cannot be read",
            Self::ReadOnly => "entry cannot be written",
            Self::General => "not in this state, or wrong size",
        }
    }
}

impl fmt::Display for AbortCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:08X}h: {}", *self as u32, self.meaning())
    }
}

impl core::error::Error for AbortCode {}

const fn join(command: u8, index: u16, subindex: u8, [a, b, c, d]: [u8; 4]) -> [u8; 8] {
    let [low, high] = index.to_le_bytes();
    [command, low, high, subindex, a, b, c, d]
}
