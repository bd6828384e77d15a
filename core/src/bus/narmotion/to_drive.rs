//! Messages of masters (Figure 14, types 1 and 2).

use super::id::{Addresses, MessageId, MessageKind, Opcode};
#[cfg(feature = "update")]
use super::update::UpdateRequest;
use super::word::RequestWord;
use super::words::{DecodeError, Words, long};
use crate::bus::Frame;
use serde::{Deserialize, Serialize};

/// A message of the master. Words that Figure 14 prints as 0x0000 are sent as 0 and ignored when received.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToDrive {
    /// BUILD_INFO, type 2.
    RequestBuildInfo,
    /// DEVICE_INFO, type 2.
    RequestDeviceInfo,
    /// REQUEST_WORD, type 1.
    RequestWord(RequestWord),
    /// REBOOT, type 1.
    Reboot,
    /// MOTOR_CMD, type 1.
    MotorCommand {
        /// Magnitude of the mechanical speed set-point, rpm.
        speed: u16,
    },
    /// DSIO_DATA_CMD, type 1.
    DigitalOutputs(DigitalOutputs),
    /// Disable_Hall_PS, type 1: true switches the hall supply off.
    DisableHallSupply(bool),
    /// PARAMETER, type 1.
    SetParameter {
        /// Parameter number.
        number: u16,
        /// Raw value.
        value: i32,
    },
    /// PARAMETER, type 2.
    RequestParameter {
        /// Parameter number.
        number: u16,
    },
    /// LOG VIRTUAL SCOPE, type 1: arm, then force.
    TriggerScope,
    /// LOG VIRTUAL SCOPE, type 2.
    DownloadScope,
    /// RESTORE_FACTORY_SETTING, type 1.
    RestoreFactory {
        /// Serial number of the board that is meant.
        serial: u16,
    },
    /// XML_DOWNLOAD_REQUEST, type 2.
    DownloadXml(XmlCommand),
    /// UPDATE_*: programming.
    #[cfg(feature = "update")]
    Update(UpdateRequest),
}

/// DSIO_DATA_CMD: a line is an input while its output enable is false.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct DigitalOutputs {
    /// DSIO1 drives its line.
    pub enable1: bool,
    /// Level of DSIO1.
    pub value1: bool,
    /// DSIO2 drives its line.
    pub enable2: bool,
    /// Level of DSIO2.
    pub value2: bool,
}

/// Word 0 of XML_DOWNLOAD_REQUEST.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u16)]
pub enum XmlCommand {
    /// 0: send the length of the file.
    Length = 0,
    /// 1: send the file.
    Start = 1,
}

impl ToDrive {
    /// Message type and opcode.
    pub const fn kind(self) -> (MessageKind, Opcode) {
        use MessageKind::{DataRequest, DataSet};
        match self {
            Self::RequestBuildInfo => (DataRequest, Opcode::BUILD_INFO),
            Self::RequestDeviceInfo => (DataRequest, Opcode::DEVICE_INFO),
            Self::RequestWord(_) => (DataSet, Opcode::REQUEST_WORD),
            Self::Reboot => (DataSet, Opcode::REBOOT),
            Self::MotorCommand { .. } => (DataSet, Opcode::MOTOR_CMD),
            Self::DigitalOutputs(_) => (DataSet, Opcode::DSIO_DATA_CMD),
            Self::DisableHallSupply(_) => (DataSet, Opcode::DISABLE_HALL_PS),
            Self::SetParameter { .. } => (DataSet, Opcode::PARAMETER),
            Self::RequestParameter { .. } => (DataRequest, Opcode::PARAMETER),
            Self::TriggerScope => (DataSet, Opcode::LOG_VIRTUAL_SCOPE),
            Self::DownloadScope => (DataRequest, Opcode::LOG_VIRTUAL_SCOPE),
            Self::RestoreFactory { .. } => (DataSet, Opcode::RESTORE_FACTORY_SETTING),
            Self::DownloadXml(_) => (DataRequest, Opcode::XML_DOWNLOAD_REQUEST),
            #[cfg(feature = "update")]
            Self::Update(request) => request.kind(),
        }
    }

    /// The frame, as the master sends it.
    pub fn encode(self, addresses: Addresses) -> Frame {
        let words = match self {
            Self::RequestWord(word) => Words::long_first(word.encode(), 0, 0),
            Self::MotorCommand { speed } => Words([speed, 0, 0, 0]),
            Self::DigitalOutputs(outputs) => {
                let DigitalOutputs { enable1, value1, enable2, value2 } = outputs;
                Words([enable1, value1, enable2, value2].map(u16::from))
            }
            Self::DisableHallSupply(disable) => Words([u16::from(disable), 0, 0, 0]),
            Self::SetParameter { number, value } => Words([number, (value >> 16) as u16, value as u16, 0]),
            Self::RequestParameter { number } => Words([number, 0, 0, 0]),
            Self::RestoreFactory { serial } => Words([serial, 0, 0, 0]),
            Self::DownloadXml(command) => Words([command as u16, 0, 0, 0]),
            Self::RequestBuildInfo
            | Self::RequestDeviceInfo
            | Self::Reboot
            | Self::TriggerScope
            | Self::DownloadScope => Words::default(),
            #[cfg(feature = "update")]
            Self::Update(request) => request.encode(),
        };
        let (kind, opcode) = self.kind();
        words.frame(addresses.to_drive(kind, opcode))
    }

    /// Decodes a frame; returns its identifier, with sender and receiver, and its message.
    ///
    /// # Errors
    /// The frame is malformed, or no message of a master.
    pub fn decode(frame: &Frame) -> Result<(MessageId, Self), DecodeError> {
        let (id, words) = Words::of(frame)?;
        let message = match id.kind {
            MessageKind::SlaveTx => Err(DecodeError::Kind),
            MessageKind::DataSet => Self::decode_set(id.opcode, words),
            MessageKind::DataRequest => Self::decode_request(id.opcode, words),
        };
        Ok((id, message?))
    }

    fn decode_set(opcode: Opcode, words: Words) -> Result<Self, DecodeError> {
        let Words([word0, word1, word2, word3]) = words;
        Ok(match opcode {
            Opcode::REQUEST_WORD => Self::RequestWord(RequestWord::decode(long(word0, word1))?),
            Opcode::REBOOT => Self::Reboot,
            Opcode::MOTOR_CMD => Self::MotorCommand { speed: word0 },
            Opcode::DSIO_DATA_CMD => Self::DigitalOutputs(DigitalOutputs {
                enable1: flag(word0)?,
                value1: flag(word1)?,
                enable2: flag(word2)?,
                value2: flag(word3)?,
            }),
            Opcode::DISABLE_HALL_PS => Self::DisableHallSupply(flag(word0)?),
            Opcode::PARAMETER => Self::SetParameter { number: word0, value: long(word1, word2) as i32 },
            Opcode::LOG_VIRTUAL_SCOPE => Self::TriggerScope,
            Opcode::RESTORE_FACTORY_SETTING => Self::RestoreFactory { serial: word0 },
            #[cfg(feature = "update")]
            _ => Self::Update(UpdateRequest::decode_set(opcode, words)?),
            #[cfg(not(feature = "update"))]
            _ => return Err(DecodeError::Opcode),
        })
    }

    fn decode_request(opcode: Opcode, Words([word0, ..]): Words) -> Result<Self, DecodeError> {
        Ok(match opcode {
            Opcode::BUILD_INFO => Self::RequestBuildInfo,
            Opcode::DEVICE_INFO => Self::RequestDeviceInfo,
            Opcode::PARAMETER => Self::RequestParameter { number: word0 },
            Opcode::LOG_VIRTUAL_SCOPE => Self::DownloadScope,
            Opcode::XML_DOWNLOAD_REQUEST => match word0 {
                0 => Self::DownloadXml(XmlCommand::Length),
                1 => Self::DownloadXml(XmlCommand::Start),
                _ => return Err(DecodeError::Value),
            },
            #[cfg(feature = "update")]
            _ => Self::Update(UpdateRequest::decode_request(opcode)?),
            #[cfg(not(feature = "update"))]
            _ => return Err(DecodeError::Opcode),
        })
    }
}

/// A word that must be 0 or 1.
pub(super) const fn flag(word: u16) -> Result<bool, DecodeError> {
    match word {
        0 => Ok(false),
        1 => Ok(true),
        _ => Err(DecodeError::Value),
    }
}
