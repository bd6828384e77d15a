//! Request word and status word (Table 8).
//!
//! ```text
//!  bit  31..25 |   24   |  23  |   22   |  21  | 20..16 | 15..12 | 11..8 | 7..4 | 3..0
//!              | erase  | read | erased | full | logging|        |control|      | motor
//!              |    logging memory / enable    | state  |        |  mode |      | mode
//! ```
//!
//! In a request only the motor mode counts: the logging parameters command the log, every other bit is
//! ignored.

use super::words::DecodeError;

/// Request of the master: bits 3..0. Every other bit is sent as 0 and ignored when received.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct RequestWord {
    /// Requested motor mode; [`MotorMode::Fault`] commands a shutdown.
    pub mode: MotorMode,
}

/// Bits 3..0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum MotorMode {
    /// 0: PWM off.
    #[default]
    Standby = 0,
    /// 1: forward.
    Drive = 1,
    /// 2: reverse.
    Reverse = 2,
    /// 3: PWM off because of a critical fault; in a request a commanded shutdown.
    Fault = 3,
}

/// Bits 11..8.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum ControlMode {
    /// 0: control off.
    #[default]
    Off = 0,
    /// 1: rotor lock or open loop.
    OpenLoop = 1,
    /// 2: sensorless closed loop or its auto-restart.
    Sensorless = 2,
    /// 3: hall closed loop.
    Hall = 3,
}

/// Status of the drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct StatusWord {
    /// Present motor mode.
    pub mode: MotorMode,
    /// Present control mode.
    pub control: ControlMode,
    /// Logging state, 0..=31; Table 8 names 0 to 11.
    pub logging: u8,
    /// The log memory is full.
    pub memory_full: bool,
    /// The log memory is erased.
    pub memory_erased: bool,
    /// A log download may be requested.
    pub read_enable: bool,
    /// A log erase may be requested.
    pub erase_enable: bool,
}

impl RequestWord {
    /// The 32 bits.
    pub const fn encode(self) -> u32 {
        self.mode as u32
    }

    /// Decodes a request from 32 bits.
    ///
    /// # Errors
    /// Motor modes 4 to 15 do not exist.
    pub const fn decode(bits: u32) -> Result<Self, DecodeError> {
        match MotorMode::decode(bits) {
            Ok(mode) => Ok(Self { mode }),
            Err(error) => Err(error),
        }
    }
}

impl StatusWord {
    /// The 32 bits.
    pub const fn encode(self) -> u32 {
        self.mode as u32
            | (self.control as u32) << 8
            | (self.logging as u32 & 0x1F) << 16
            | (self.memory_full as u32) << 21
            | (self.memory_erased as u32) << 22
            | (self.read_enable as u32) << 23
            | (self.erase_enable as u32) << 24
    }

    /// Decodes a status from 32 bits; reserved bits are ignored.
    ///
    /// # Errors
    /// A motor or control mode that Table 8 does not list.
    pub const fn decode(bits: u32) -> Result<Self, DecodeError> {
        let mode = match MotorMode::decode(bits) {
            Ok(mode) => mode,
            Err(error) => return Err(error),
        };
        let control = match bits >> 8 & 0xF {
            0 => ControlMode::Off,
            1 => ControlMode::OpenLoop,
            2 => ControlMode::Sensorless,
            3 => ControlMode::Hall,
            _ => return Err(DecodeError::Value),
        };
        Ok(Self {
            mode,
            control,
            logging: (bits >> 16 & 0x1F) as u8,
            memory_full: bits >> 21 & 1 != 0,
            memory_erased: bits >> 22 & 1 != 0,
            read_enable: bits >> 23 & 1 != 0,
            erase_enable: bits >> 24 & 1 != 0,
        })
    }
}

impl MotorMode {
    const fn decode(bits: u32) -> Result<Self, DecodeError> {
        match bits & 0xF {
            0 => Ok(Self::Standby),
            1 => Ok(Self::Drive),
            2 => Ok(Self::Reverse),
            3 => Ok(Self::Fault),
            _ => Err(DecodeError::Value),
        }
    }
}
