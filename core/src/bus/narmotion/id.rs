//! The 29-bit identifier (Annex A, section 1).
//!
//! ```text
//!  bit   28 27 | 26 .. 19 | 18 ..  11 | 10  9 | 8 .. 0
//!     priority |  source  |destination|  type | opcode
//! ```

use super::words::DecodeError;
use crate::bus::{Frame, Id};
use serde::{Deserialize, Serialize};

/// Fields of an identifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MessageId {
    /// Arbitration priority; receivers ignore it.
    pub priority: Priority,
    /// Address of the sender.
    pub source: u8,
    /// Address of the receiver.
    pub destination: u8,
    /// Message type.
    pub kind: MessageKind,
    /// Subject of the message.
    pub opcode: Opcode,
}

/// Bits 28 and 27.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Priority {
    /// 0: not used by any printed message.
    Highest = 0,
    /// 1: messages of masters.
    High = 1,
    /// 2: messages of drives.
    Low = 2,
    /// 3: not used by any printed message.
    Lowest = 3,
}

/// Bits 10 and 9. Type 3 does not exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum MessageKind {
    /// 0, "Slave Tx": drive to master.
    SlaveTx = 0,
    /// 1, "Data Set": the master sets something.
    DataSet = 1,
    /// 2, "Data Request": the master asks for something.
    DataRequest = 2,
}

/// Bits 8 to 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "u16", into = "u16")]
pub struct Opcode(u16);

impl Opcode {
    /// Build number and date of the firmware.
    pub const BUILD_INFO: Self = Self(0);
    /// Releases, serial number, address.
    pub const DEVICE_INFO: Self = Self(1);
    /// Requested motor mode.
    pub const REQUEST_WORD: Self = Self(2);
    /// Present motor, control and logging state.
    pub const STATUS_WORD: Self = Self(3);
    /// Faults.
    pub const FAULT_WORD: Self = Self(4);
    /// Critical faults and their extended code.
    pub const CRITICAL_FAULT: Self = Self(5);
    /// Reset of the drive.
    pub const REBOOT: Self = Self(101);
    /// Speed set-point.
    pub const MOTOR_CMD: Self = Self(102);
    /// Digital outputs.
    pub const DSIO_DATA_CMD: Self = Self(103);
    /// Supply of the hall sensors.
    pub const DISABLE_HALL_PS: Self = Self(104);
    /// Parameter read and write.
    pub const PARAMETER: Self = Self(110);
    /// Virtual scope.
    pub const LOG_VIRTUAL_SCOPE: Self = Self(112);
    /// Factory values.
    pub const RESTORE_FACTORY_SETTING: Self = Self(113);
    /// Download of the description: request and its answer.
    pub const XML_DOWNLOAD_REQUEST: Self = Self(130);
    /// Download of the description: data.
    pub const XML_DOWNLOAD_DATA: Self = Self(131);
    /// Download of the log: data.
    pub const EXT_MEM_LOG_READ_DATA: Self = Self(140);
    /// Programming: hardware id and room.
    pub const UPDATE_DEVICE: Self = Self(160);
    /// Programming: version of the running image.
    pub const UPDATE_VERSION: Self = Self(161);
    /// Programming: begin.
    pub const UPDATE_BEGIN: Self = Self(162);
    /// Programming: a block of the image.
    pub const UPDATE_DATA: Self = Self(163);
    /// Programming: progress.
    pub const UPDATE_STATUS: Self = Self(164);
    /// Programming: the image is complete.
    pub const UPDATE_END: Self = Self(165);
    /// Programming: end without an image.
    pub const UPDATE_ABORT: Self = Self(166);
    /// Programming: the running image stays.
    pub const UPDATE_CONFIRM: Self = Self(167);
    /// First of the measurement frames, 200 to 205 and the reserved 207 and 208.
    pub const MEASUREMENT_0: Self = Self(200);

    /// An opcode, or `None` above 511.
    pub const fn new(raw: u16) -> Option<Self> {
        if raw < 512 { Some(Self(raw)) } else { None }
    }

    /// The opcode of the low 9 bits.
    pub(super) const fn masked(raw: u32) -> Self {
        Self((raw & 0x1FF) as u16)
    }

    /// The number, 0..=511.
    pub const fn raw(self) -> u16 {
        self.0
    }
}

impl From<Opcode> for u16 {
    fn from(opcode: Opcode) -> Self {
        opcode.raw()
    }
}

impl TryFrom<u16> for Opcode {
    type Error = DecodeError;

    fn try_from(raw: u16) -> Result<Self, DecodeError> {
        Self::new(raw).ok_or(DecodeError::Opcode)
    }
}

/// Addresses of a drive and its master.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Addresses {
    /// Address of the drive (parameter 2).
    pub drive: u8,
    /// Address of its master (parameter 3).
    pub master: u8,
}

impl Addresses {
    /// As Figure 9 and Figure 14 print them: drive 170, master 85.
    pub const FACTORY: Self = Self { drive: 0xAA, master: 0x55 };

    /// Identifier of a message from the drive.
    pub const fn from_drive(self, opcode: Opcode) -> MessageId {
        MessageId {
            priority: Priority::Low,
            source: self.drive,
            destination: self.master,
            kind: MessageKind::SlaveTx,
            opcode,
        }
    }

    /// Identifier of a message from the master.
    pub const fn to_drive(self, kind: MessageKind, opcode: Opcode) -> MessageId {
        MessageId { priority: Priority::High, source: self.master, destination: self.drive, kind, opcode }
    }
}

impl MessageId {
    /// The identifier on the bus.
    pub const fn encode(self) -> Id {
        Id::extended_masked(
            (self.priority as u32) << 27
                | (self.source as u32) << 19
                | (self.destination as u32) << 11
                | (self.kind as u32) << 9
                | self.opcode.raw() as u32,
        )
    }

    /// Decodes an identifier.
    ///
    /// # Errors
    /// An 11-bit identifier, or type 3.
    pub const fn decode(id: Id) -> Result<Self, DecodeError> {
        if !id.is_extended() {
            return Err(DecodeError::StandardId);
        }
        let raw = id.raw();
        let kind = match raw >> 9 & 3 {
            0 => MessageKind::SlaveTx,
            1 => MessageKind::DataSet,
            2 => MessageKind::DataRequest,
            _ => return Err(DecodeError::Kind),
        };
        let priority = match raw >> 27 {
            0 => Priority::Highest,
            1 => Priority::High,
            2 => Priority::Low,
            _ => Priority::Lowest,
        };
        let opcode = Opcode::masked(raw);
        Ok(Self { priority, source: (raw >> 19) as u8, destination: (raw >> 11) as u8, kind, opcode })
    }

    /// Decodes the identifier of a frame.
    ///
    /// # Errors
    /// As [`MessageId::decode`].
    pub const fn of(frame: &Frame) -> Result<Self, DecodeError> {
        Self::decode(frame.id())
    }
}
