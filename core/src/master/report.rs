//! Last messages of the drive, with their times.

use crate::bus::narmotion::{ControlMode, FromDrive, MotorMode, StatusWord};
use crate::motor::guard::fault::{Cause, CauseRow, FaultWord};
use crate::motor::machine::state::State;

/// A received value, and its time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Received<T> {
    /// The value.
    pub value: T,
    /// Time of reception, microseconds.
    pub at: u64,
}

impl<T> Received<T> {
    /// Time since the reception, microseconds.
    pub const fn age(&self, now: u64) -> u64 {
        now.saturating_sub(self.at)
    }
}

/// The last message of every kind; `None` where there was none yet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// STATUS_WORD.
    pub status: Option<Received<StatusWord>>,
    /// FAULT_WORD: live and latched faults.
    pub faults: Option<Received<FaultWord>>,
    /// CRITICAL_FAULT: sent for each new critical fault and never withdrawn; `faults` shows whether it still
    /// holds.
    pub critical: Option<Received<CriticalFault>>,
    /// The echo of MOTOR_CMD: the set-point that the drive uses, rpm.
    pub accepted_speed: Option<Received<u16>>,
    /// BUILD_INFO.
    pub build: Option<Received<BuildInfo>>,
    /// DEVICE_INFO.
    pub device: Option<Received<DeviceInfo>>,
    /// XML_DOWNLOAD_ANSWER: the drive's description.
    pub description: Option<Received<DescriptionInfo>>,
    /// Time at which the drive last acknowledged a reboot, microseconds.
    pub reboot: Option<u64>,
    /// Time at which any message was last received, microseconds.
    pub last: Option<u64>,
}

/// CRITICAL_FAULT.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CriticalFault {
    /// Latched critical faults.
    pub faults: FaultWord,
    /// Extended fault code: fault bit * 256 + cause.
    pub code: u16,
}

impl CriticalFault {
    /// Returns the cause that the code stands for, if this firmware knows it.
    pub fn cause(&self) -> Option<CauseRow> {
        Cause::TABLE.into_iter().find(|row| row.cause as u16 == self.code)
    }
}

/// BUILD_INFO.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuildInfo {
    /// Build number.
    pub number: u16,
    /// Built from sources that were not committed.
    pub modified: bool,
    /// Date of the build, YYYYMMDD in decimal.
    pub date: u32,
}

/// XML_DOWNLOAD_ANSWER.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DescriptionInfo {
    /// Length, words.
    pub words: u16,
    /// CRC-32 (ISO-HDLC) of the words, high byte first; 0 from a drive that does not tell it.
    pub check: u32,
}

/// DEVICE_INFO.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DeviceInfo {
    /// Release of the board.
    pub hardware: u16,
    /// Release of the firmware, major in the high byte.
    pub software: u16,
    /// Serial number.
    pub device_number: u16,
    /// Address of the drive.
    pub address: u16,
}

impl Report {
    pub(super) fn note(&mut self, message: &FromDrive, at: u64) {
        self.last = Some(at);
        match *message {
            FromDrive::Status(value) => self.status = Some(Received { value, at }),
            FromDrive::Faults(value) => self.faults = Some(Received { value, at }),
            FromDrive::CriticalFault { faults, code } => {
                self.critical = Some(Received { value: CriticalFault { faults, code }, at });
            }
            FromDrive::MotorCommand { speed } => self.accepted_speed = Some(Received { value: speed, at }),
            FromDrive::BuildInfo { number, modified, date } => {
                self.build = Some(Received { value: BuildInfo { number, modified, date }, at });
            }
            FromDrive::DeviceInfo { hardware, software, device_number, address } => {
                let value = DeviceInfo { hardware, software, device_number, address };
                self.device = Some(Received { value, at });
            }
            FromDrive::XmlLength { words, check } => {
                self.description = Some(Received { value: DescriptionInfo { words, check }, at });
            }
            FromDrive::Reboot => self.reboot = Some(at),
            FromDrive::Parameter { .. }
            | FromDrive::ScopeData { .. }
            | FromDrive::XmlData { .. }
            | FromDrive::LogData { .. }
            | FromDrive::Measurement(_) => {}
            #[cfg(feature = "update")]
            FromDrive::Update(_) => {}
        }
    }

    /// Returns whether the drive is known to drive its motor.
    pub(super) fn drives(&self) -> bool {
        self.status.is_some_and(|status| matches!(status.value.mode, MotorMode::Drive | MotorMode::Reverse))
    }

    /// Returns the exact state: from the status word alone if that is unambiguous, else from parameter 261
    /// (`exact`) if that agrees with the status word.
    pub(super) fn state(&self, exact: Option<i32>) -> Option<State> {
        let StatusWord { mode, control, .. } = self.status?.value;
        let candidates = match (mode, control) {
            (MotorMode::Fault, _) => return Some(State::Fault),
            (_, ControlMode::Hall) => return Some(State::HallClosedLoop),
            (_, ControlMode::Off) => [State::Initialization, State::Standby],
            (_, ControlMode::OpenLoop) => [State::RotorLock, State::OpenLoop],
            (_, ControlMode::Sensorless) => [State::SensorlessClosedLoop, State::SensorlessAutoRestart],
        };
        candidates.into_iter().find(|state| exact == Some(*state as i32))
    }
}
