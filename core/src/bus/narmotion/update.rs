//! Programming over the bus: opcodes 160 to 167, which the specification leaves free (PROTOCOL.md, section
//! 11).

use super::id::{MessageKind, Opcode};
use super::words::{DecodeError, Words, long};
use core::fmt;
use serde::{Deserialize, Serialize};

/// Bytes of an image in a frame.
pub const BLOCK: usize = 6;

/// Request of a master that programs the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UpdateRequest {
    /// UPDATE_DEVICE, type 2.
    Device,
    /// UPDATE_VERSION, type 2.
    Version,
    /// UPDATE_BEGIN, type 1.
    Begin {
        /// Length of the image, bytes.
        length: u32,
        /// Hardware id in its header.
        hardware: u32,
    },
    /// UPDATE_DATA, type 1.
    Data {
        /// Number of the block, modulo 65 536. Block n begins at byte 6 n of the image.
        block: u16,
        /// Bytes of the image. Bytes behind its end are ignored.
        data: [u8; BLOCK],
    },
    /// UPDATE_STATUS, type 2.
    Status,
    /// UPDATE_END, type 1.
    End {
        /// CRC-32 (ISO-HDLC, as Ethernet and zip) of the image.
        crc: u32,
    },
    /// UPDATE_ABORT, type 1.
    Abort,
    /// UPDATE_CONFIRM, type 1.
    Confirm,
}

/// Answer of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UpdateAnswer {
    /// UPDATE_DEVICE.
    Device {
        /// Hardware id that an image must have.
        hardware: u32,
        /// Longest image, bytes.
        room: u32,
    },
    /// UPDATE_VERSION: version of the running image; zeros if it was not programmed over the bus.
    Version(ImageVersion),
    /// UPDATE_STATUS.
    Status(UpdateStatus),
}

/// Version of an image, compared number by number from left to right.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct ImageVersion {
    /// Major version.
    pub major: u8,
    /// Minor version.
    pub minor: u8,
    /// Patch level.
    pub patch: u16,
    /// Build number.
    pub build: u16,
}

/// Progress of an update.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct UpdateStatus {
    /// State of the update.
    pub state: UpdateState,
    /// Reason why the last request was refused, or the last update ended; [`UpdateCode::Done`] for neither.
    pub code: UpdateCode,
    /// Blocks that the drive has room for, from `offset` on.
    pub window: u16,
    /// Bytes of the image that are erased, received or verified, as the state says.
    pub offset: u32,
}

/// State of an update.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[repr(u8)]
pub enum UpdateState {
    /// 0: no update.
    #[default]
    Idle = 0,
    /// 1: erases the slot.
    Erasing = 1,
    /// 2: takes blocks.
    Receiving = 2,
    /// 3: reads back what it has written.
    Verifying = 3,
    /// 4: the next boot swaps the image in.
    Marked = 4,
    /// 5: the running image has not been confirmed.
    Trial = 5,
}

/// Reason why an update does not go on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[repr(u8)]
pub enum UpdateCode {
    /// 0: nothing is wrong.
    #[default]
    Done = 0,
    /// 1: the drive is not in Standby, nor in Fault at standstill.
    WrongState = 1,
    /// 2: not in this state of the update.
    NotNow = 2,
    /// 3: the running image is on trial, and the slot holds the one before.
    Trial = 3,
    /// 4: the image is for other hardware.
    Hardware = 4,
    /// 5: the image is longer than the slot, shorter than its header, or not as long as its header says.
    Length = 5,
    /// 6: blocks are missing from the offset on.
    Sequence = 6,
    /// 7: the flash failed.
    Flash = 7,
    /// 8: the written image does not match the CRC.
    Checksum = 8,
    /// 9: the written image has no header.
    NoImage = 9,
    /// 10: the image is older than the running one.
    Older = 10,
    /// 11: no block came for ten seconds.
    TimedOut = 11,
    /// 12: ended by the master.
    Aborted = 12,
    /// 13: the bootloader rejected the signature.
    Signature = 13,
    /// 14: the image was on trial and was not confirmed.
    Reverted = 14,
}

impl UpdateRequest {
    /// Message type and opcode.
    pub const fn kind(self) -> (MessageKind, Opcode) {
        use MessageKind::{DataRequest, DataSet};
        match self {
            Self::Device => (DataRequest, Opcode::UPDATE_DEVICE),
            Self::Version => (DataRequest, Opcode::UPDATE_VERSION),
            Self::Begin { .. } => (DataSet, Opcode::UPDATE_BEGIN),
            Self::Data { .. } => (DataSet, Opcode::UPDATE_DATA),
            Self::Status => (DataRequest, Opcode::UPDATE_STATUS),
            Self::End { .. } => (DataSet, Opcode::UPDATE_END),
            Self::Abort => (DataSet, Opcode::UPDATE_ABORT),
            Self::Confirm => (DataSet, Opcode::UPDATE_CONFIRM),
        }
    }

    pub(super) const fn encode(self) -> Words {
        match self {
            Self::Begin { length, hardware } => {
                Words::long_first(length, (hardware >> 16) as u16, hardware as u16)
            }
            Self::Data { block, data: [a, b, c, d, e, f] } => {
                let word = u16::from_be_bytes;
                Words([block, word([a, b]), word([c, d]), word([e, f])])
            }
            Self::End { crc } => Words::long_first(crc, 0, 0),
            Self::Device | Self::Version | Self::Status | Self::Abort | Self::Confirm => Words([0; 4]),
        }
    }

    /// Decodes a Data Set whose opcode no other message has.
    pub(crate) const fn decode_set(
        opcode: Opcode,
        Words([word0, word1, word2, word3]): Words,
    ) -> Result<Self, DecodeError> {
        Ok(match opcode {
            Opcode::UPDATE_BEGIN => Self::Begin { length: long(word0, word1), hardware: long(word2, word3) },
            Opcode::UPDATE_DATA => {
                let [[a, b], [c, d], [e, f]] =
                    [word1.to_be_bytes(), word2.to_be_bytes(), word3.to_be_bytes()];
                Self::Data { block: word0, data: [a, b, c, d, e, f] }
            }
            Opcode::UPDATE_END => Self::End { crc: long(word0, word1) },
            Opcode::UPDATE_ABORT => Self::Abort,
            Opcode::UPDATE_CONFIRM => Self::Confirm,
            _ => return Err(DecodeError::Opcode),
        })
    }

    /// Decodes a Data Request whose opcode no other message has.
    pub(crate) const fn decode_request(opcode: Opcode) -> Result<Self, DecodeError> {
        Ok(match opcode {
            Opcode::UPDATE_DEVICE => Self::Device,
            Opcode::UPDATE_VERSION => Self::Version,
            Opcode::UPDATE_STATUS => Self::Status,
            _ => return Err(DecodeError::Opcode),
        })
    }
}

impl UpdateAnswer {
    /// The opcode.
    pub const fn opcode(self) -> Opcode {
        match self {
            Self::Device { .. } => Opcode::UPDATE_DEVICE,
            Self::Version(_) => Opcode::UPDATE_VERSION,
            Self::Status(_) => Opcode::UPDATE_STATUS,
        }
    }

    pub(crate) const fn encode(self) -> Words {
        match self {
            Self::Device { hardware, room } => Words::long_first(hardware, (room >> 16) as u16, room as u16),
            Self::Version(ImageVersion { major, minor, patch, build }) => {
                Words([u16::from_be_bytes([major, minor]), patch, build, 0])
            }
            Self::Status(UpdateStatus { state, code, window, offset }) => {
                let first = u16::from_be_bytes([state as u8, code as u8]);
                Words([first, window, (offset >> 16) as u16, offset as u16])
            }
        }
    }

    /// Decodes an answer; `None` if the opcode is not that of one.
    pub(super) fn decode(
        opcode: Opcode,
        Words([word0, word1, word2, word3]): Words,
    ) -> Option<Result<Self, DecodeError>> {
        let [high, low] = word0.to_be_bytes();
        Some(match opcode {
            Opcode::UPDATE_DEVICE => {
                Ok(Self::Device { hardware: long(word0, word1), room: long(word2, word3) })
            }
            Opcode::UPDATE_VERSION => {
                Ok(Self::Version(ImageVersion { major: high, minor: low, patch: word1, build: word2 }))
            }
            Opcode::UPDATE_STATUS => match (UpdateState::of(high), UpdateCode::of(low)) {
                (Some(state), Some(code)) => {
                    Ok(Self::Status(UpdateStatus { state, code, window: word1, offset: long(word2, word3) }))
                }
                _ => Err(DecodeError::Value),
            },
            _ => return None,
        })
    }
}

impl UpdateState {
    const ALL: [Self; 6] =
        [Self::Idle, Self::Erasing, Self::Receiving, Self::Verifying, Self::Marked, Self::Trial];

    fn of(raw: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|state| *state as u8 == raw)
    }
}

impl UpdateCode {
    const ALL: [Self; 15] = [
        Self::Done,
        Self::WrongState,
        Self::NotNow,
        Self::Trial,
        Self::Hardware,
        Self::Length,
        Self::Sequence,
        Self::Flash,
        Self::Checksum,
        Self::NoImage,
        Self::Older,
        Self::TimedOut,
        Self::Aborted,
        Self::Signature,
        Self::Reverted,
    ];

    fn of(raw: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|code| *code as u8 == raw)
    }
}

impl fmt::Display for ImageVersion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { major, minor, patch, build } = self;
        write!(f, "{major}.{minor}.{patch}+{build}")
    }
}

impl fmt::Display for UpdateCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Done => "done",
            Self::WrongState => "the drive is not in Standby, nor in Fault at standstill",
            Self::NotNow => "not in this state of the update",
            Self::Trial => "the running image has not been confirmed",
            Self::Hardware => "the image is for other hardware",
            Self::Length => "the image does not have the announced length, or exceeds the slot",
            Self::Sequence => "a part of the image is missing",
            Self::Flash => "the flash failed",
            Self::Checksum => "the data written differ from the data sent",
            Self::NoImage => "the data sent are not an image",
            Self::Older => "the image is older than the running one",
            Self::TimedOut => "no data arrived for ten seconds",
            Self::Aborted => "the update was aborted",
            Self::Signature => "the board's bootloader does not accept the signature",
            Self::Reverted => "the image was not confirmed, and does not run any more",
        })
    }
}
