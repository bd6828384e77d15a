//! Messages of drives (Figure 14, type 0).

use super::id::{Addresses, MessageId, MessageKind, Opcode};
use super::measurement::Measurement;
use super::to_drive::flag;
#[cfg(feature = "update")]
use super::update::UpdateAnswer;
use super::word::StatusWord;
use super::words::{DecodeError, Words, long};
use crate::bus::Frame;
use crate::motor::guard::fault::FaultWord;
use core::fmt;
use serde::{Deserialize, Serialize};

/// A message of the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FromDrive {
    /// BUILD_INFO.
    BuildInfo {
        /// Build number.
        number: u16,
        /// Built from sources that were not committed.
        modified: bool,
        /// Date of the build, YYYYMMDD in decimal.
        date: u32,
    },
    /// DEVICE_INFO.
    DeviceInfo {
        /// Release of the board.
        hardware: u16,
        /// Release of the firmware, major in the high byte.
        software: u16,
        /// Serial number.
        device_number: u16,
        /// Address of the drive.
        address: u16,
    },
    /// STATUS_WORD.
    Status(StatusWord),
    /// FAULT_WORD: live and latched faults.
    Faults(FaultWord),
    /// CRITICAL_FAULT.
    CriticalFault {
        /// Latched critical faults.
        faults: FaultWord,
        /// Extended fault code: fault bit * 256 + cause.
        code: u16,
    },
    /// REBOOT: acknowledged, the drive restarts.
    Reboot,
    /// MOTOR_CMD: the accepted set-point.
    MotorCommand {
        /// Magnitude after the saturation of the control mode, rpm.
        speed: u16,
    },
    /// PARAMETER: answer to a read or a write.
    Parameter {
        /// Parameter number.
        number: u16,
        /// Raw value that is stored now; 0 for an unknown number.
        value: i32,
        /// Result of the request: done, or the reason why not.
        status: ParameterStatus,
    },
    /// LOG VIRTUAL SCOPE.
    ScopeData {
        /// Address of the first of the three words.
        address: u16,
        /// Samples, Q3.12.
        data: [u16; 3],
    },
    /// XML_DOWNLOAD_ANSWER.
    XmlLength {
        /// Length of the file in words.
        words: u16,
        /// CRC-32 (ISO-HDLC) of these words, high byte first; 0 from a drive that does not tell it.
        check: u32,
    },
    /// XML_DOWNLOAD_DATA.
    XmlData {
        /// Address of the first of the three words.
        address: u16,
        /// Text, high byte first.
        data: [u16; 3],
    },
    /// EXT_MEM_LOG_READ_DATA.
    LogData {
        /// Running word counter.
        counter: u16,
        /// Words of log records.
        data: [u16; 3],
    },
    /// UPDATE_*: programming.
    #[cfg(feature = "update")]
    Update(UpdateAnswer),
    /// MEASUREMENT_0 to MEASUREMENT_8.
    Measurement(Measurement),
}

/// Word 3 of the answer to PARAMETER.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(u16)]
pub enum ParameterStatus {
    /// 0: done.
    #[default]
    Done = 0,
    /// 1: no parameter has this number.
    UnknownNumber = 1,
    /// 2: the drive alone writes it.
    ReadOnly = 2,
    /// 3: the value is outside the range.
    OutOfRange = 3,
    /// 4: not in this state.
    WrongState = 4,
    /// 5: the parameter store is missing, busy or failed.
    Storage = 5,
    /// 6: the board lacks what the value needs.
    NotEquipped = 6,
}

impl FromDrive {
    /// The opcode.
    pub const fn opcode(self) -> Opcode {
        match self {
            Self::BuildInfo { .. } => Opcode::BUILD_INFO,
            Self::DeviceInfo { .. } => Opcode::DEVICE_INFO,
            Self::Status(_) => Opcode::STATUS_WORD,
            Self::Faults(_) => Opcode::FAULT_WORD,
            Self::CriticalFault { .. } => Opcode::CRITICAL_FAULT,
            Self::Reboot => Opcode::REBOOT,
            Self::MotorCommand { .. } => Opcode::MOTOR_CMD,
            Self::Parameter { .. } => Opcode::PARAMETER,
            Self::ScopeData { .. } => Opcode::LOG_VIRTUAL_SCOPE,
            Self::XmlLength { .. } => Opcode::XML_DOWNLOAD_REQUEST,
            Self::XmlData { .. } => Opcode::XML_DOWNLOAD_DATA,
            Self::LogData { .. } => Opcode::EXT_MEM_LOG_READ_DATA,
            #[cfg(feature = "update")]
            Self::Update(answer) => answer.opcode(),
            Self::Measurement(measurement) => measurement.opcode(),
        }
    }

    /// The frame, as the drive sends it.
    pub fn encode(self, addresses: Addresses) -> Frame {
        self.addressless().frame(addresses)
    }

    /// Opcode and words of the message, without addresses.
    pub(crate) fn addressless(self) -> Addressless {
        let words = match self {
            Self::BuildInfo { number, modified, date } => {
                Words([number, u16::from(modified), (date >> 16) as u16, date as u16])
            }
            Self::DeviceInfo { hardware, software, device_number, address } => {
                Words([hardware, software, device_number, address])
            }
            Self::Status(word) => Words::long_first(word.encode(), 0, 0),
            Self::Faults(faults) => Words::long_first(faults.bits(), 0, 0),
            Self::CriticalFault { faults, code } => Words::long_first(faults.bits(), code, 0),
            Self::Reboot => Words([1, 0, 0, 0]),
            Self::MotorCommand { speed } => Words([speed, 0, 0, 0]),
            Self::Parameter { number, value, status } => {
                Words([number, (value >> 16) as u16, value as u16, status as u16])
            }
            Self::XmlLength { words, check } => Words([words, 0, (check >> 16) as u16, check as u16]),
            Self::ScopeData { address, data: [a, b, c] }
            | Self::XmlData { address, data: [a, b, c] }
            | Self::LogData { counter: address, data: [a, b, c] } => Words([address, a, b, c]),
            #[cfg(feature = "update")]
            Self::Update(answer) => answer.encode(),
            Self::Measurement(measurement) => measurement.encode(),
        };
        Addressless { opcode: self.opcode(), words }
    }

    /// Decodes a frame; returns its identifier, with sender and receiver, and its message.
    ///
    /// # Errors
    /// The frame is malformed, or no message of a drive.
    pub fn decode(frame: &Frame) -> Result<(MessageId, Self), DecodeError> {
        let (id, words) = Words::of(frame)?;
        if id.kind != MessageKind::SlaveTx {
            return Err(DecodeError::Kind);
        }
        let Words([word0, word1, word2, word3]) = words;
        let data = [word1, word2, word3];
        let message = match id.opcode {
            Opcode::BUILD_INFO => {
                Self::BuildInfo { number: word0, modified: flag(word1)?, date: long(word2, word3) }
            }
            Opcode::DEVICE_INFO => {
                Self::DeviceInfo { hardware: word0, software: word1, device_number: word2, address: word3 }
            }
            Opcode::STATUS_WORD => Self::Status(StatusWord::decode(long(word0, word1))?),
            Opcode::FAULT_WORD => Self::Faults(FaultWord::from_bits_retain(long(word0, word1))),
            Opcode::CRITICAL_FAULT => {
                Self::CriticalFault { faults: FaultWord::from_bits_retain(long(word0, word1)), code: word2 }
            }
            Opcode::REBOOT if word0 == 1 => Self::Reboot,
            Opcode::REBOOT => return Err(DecodeError::Value),
            Opcode::MOTOR_CMD => Self::MotorCommand { speed: word0 },
            Opcode::PARAMETER => Self::Parameter {
                number: word0,
                value: long(word1, word2) as i32,
                status: ParameterStatus::decode(word3)?,
            },
            Opcode::LOG_VIRTUAL_SCOPE => Self::ScopeData { address: word0, data },
            Opcode::XML_DOWNLOAD_REQUEST => Self::XmlLength { words: word0, check: long(word2, word3) },
            Opcode::XML_DOWNLOAD_DATA => Self::XmlData { address: word0, data },
            Opcode::EXT_MEM_LOG_READ_DATA => Self::LogData { counter: word0, data },
            #[cfg(feature = "update")]
            opcode if let Some(answer) = UpdateAnswer::decode(opcode, words) => Self::Update(answer?),
            opcode => Self::Measurement(Measurement::decode(opcode, words)?),
        };
        Ok((id, message))
    }
}

/// A message of a drive without the addresses, which are the same in all of them: 10 bytes where a frame has
/// 16, and dozens wait in a queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Addressless {
    opcode: Opcode,
    words: Words,
}

impl Addressless {
    /// The opcode.
    pub(crate) const fn opcode(self) -> Opcode {
        self.opcode
    }

    /// The frame.
    pub(crate) fn frame(self, addresses: Addresses) -> Frame {
        self.words.frame(addresses.from_drive(self.opcode))
    }
}

impl ParameterStatus {
    const fn decode(word: u16) -> Result<Self, DecodeError> {
        Ok(match word {
            0 => Self::Done,
            1 => Self::UnknownNumber,
            2 => Self::ReadOnly,
            3 => Self::OutOfRange,
            4 => Self::WrongState,
            5 => Self::Storage,
            6 => Self::NotEquipped,
            _ => return Err(DecodeError::Value),
        })
    }
}

impl fmt::Display for ParameterStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Done => "done",
            Self::UnknownNumber => "there is no such parameter",
            Self::ReadOnly => "only the drive writes it",
            Self::OutOfRange => "out of range",
            Self::WrongState => "not in this state of the drive",
            Self::Storage => "the parameter store or log memory is missing, busy or failed",
            Self::NotEquipped => "the board lacks what this value needs",
        })
    }
}
