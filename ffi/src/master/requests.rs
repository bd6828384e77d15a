//! Requests to a drive, each sent once, and their answers.

use super::narx_master_t;
use crate::handle;
use crate::pointer;
use crate::status::narx_status_t::{self, *};
use narx_core::bus::narmotion::DigitalOutputs;
use narx_core::master::{Answer, NotTaken, Request, RequestError, Service};

/// Kind of a request to a drive.
#[repr(u8)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum narx_request_kind_t {
    /// Read parameter `number`.
    Read = 0,
    /// Write `value` to parameter `number`.
    Write = 1,
    /// Run the command parameter `number`: NARX_PARAMETER_STORE and others of its kind.
    Run = 2,
    /// Read BUILD_INFO; its content is in the frame that answers: narx_message_decode.
    BuildInfo = 3,
    /// Read DEVICE_INFO; its content is in the frame that answers: narx_message_decode.
    DeviceInfo = 4,
    /// Restart the drive.
    Reboot = 5,
    /// Restore factory values; `value` is the serial number of the addressed board.
    RestoreFactory = 6,
    /// Set the digital lines: `value` bit 0 enables DSIO1, bit 1 is its level, bits 2 and 3 are the same for
    /// DSIO2.
    DigitalOutputs = 7,
    /// Switch the hall supply off (`value` 1), or leave it to parameter 97 (0).
    DisableHallSupply = 8,
    /// Arm the scope; if it is armed, force its trigger.
    TriggerScope = 9,
    /// Read length and CRC-32 of the description; they are in the frame that answers: narx_message_decode.
    DescriptionInfo = 10,
}

/// A request to a drive.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_request_t {
    /// Kind: a narx_request_kind_t.
    pub kind: u8,
    /// Number of the parameter, if the request is about one.
    pub number: u16,
    /// Raw value, if the request has one.
    pub value: i32,
}

/// Answer to a request.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_answer_t {
    /// The request.
    pub request: narx_request_t,
    /// NARX_OK, NARX_ERROR_NO_ANSWER, NARX_ERROR_NOT_OBEYED, or the reason why the drive refuses the
    /// parameter.
    pub status: narx_status_t,
    /// The raw value that the parameter has now; 0 for a request without a parameter.
    pub value: i32,
}

/// Queues a request to the drive. Answers come in the order of the requests. Returns NARX_ERROR_FULL while
/// there are eight requests whose answers were not taken, NARX_ERROR_SILENT for a silent master,
/// NARX_ERROR_REQUEST for an undefined kind or number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_request(
    master: *mut narx_master_t,
    request: *const narx_request_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let master = handle::object(master)?;
        master.request(pointer::read(request)?.try_into()?)?;
        Ok(())
    };
    pointer::status(run())
}

/// Writes the next answer, or returns NARX_NOTHING.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_poll_answer(
    master: *mut narx_master_t,
    answer: *mut narx_answer_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { handle::poll(master, answer, |master| Some(master.poll_answer()?.into())) }
}

impl From<Answer> for narx_answer_t {
    fn from(Answer { request, result }: Answer) -> Self {
        let (status, value) = match result {
            Ok(value) => (NARX_OK, value),
            Err(RequestError::NoAnswer) => (NARX_ERROR_NO_ANSWER, 0),
            Err(RequestError::NotObeyed) => (NARX_ERROR_NOT_OBEYED, 0),
            Err(RequestError::Refused(refusal)) => (refusal.status.into(), refusal.stored),
        };
        Self { request: request.into(), status, value }
    }
}

use narx_request_kind_t as Kind;

impl TryFrom<&narx_request_t> for Request {
    type Error = narx_status_t;

    fn try_from(&narx_request_t { kind, number, value }: &narx_request_t) -> Result<Self, narx_status_t> {
        let bit = |place: u32| value >> place & 1 != 0;
        Ok(match kind {
            kind if kind == Kind::Read as u8 => Self::Read { number },
            kind if kind == Kind::Write as u8 => Self::Write { number, raw: value },
            kind if kind == Kind::Run as u8 => {
                let service = Service::ALL.into_iter().find(|service| *service as u16 == number);
                Self::Run(service.ok_or(NARX_ERROR_REQUEST)?)
            }
            kind if kind == Kind::BuildInfo as u8 => Self::BuildInfo,
            kind if kind == Kind::DeviceInfo as u8 => Self::DeviceInfo,
            kind if kind == Kind::DescriptionInfo as u8 => Self::DescriptionInfo,
            kind if kind == Kind::Reboot as u8 => Self::Reboot,
            kind if kind == Kind::RestoreFactory as u8 => {
                Self::RestoreFactory { serial: u16::try_from(value).map_err(|_| NARX_ERROR_REQUEST)? }
            }
            kind if kind == Kind::DigitalOutputs as u8 && (0..16).contains(&value) => {
                Self::DigitalOutputs(DigitalOutputs {
                    enable1: bit(0),
                    value1: bit(1),
                    enable2: bit(2),
                    value2: bit(3),
                })
            }
            kind if kind == Kind::DisableHallSupply as u8 && (0..2).contains(&value) => {
                Self::DisableHallSupply(value != 0)
            }
            kind if kind == Kind::TriggerScope as u8 => Self::TriggerScope,
            _ => return Err(NARX_ERROR_REQUEST),
        })
    }
}

impl From<Request> for narx_request_t {
    fn from(request: Request) -> Self {
        let (kind, number, value) = match request {
            Request::Read { number } => (Kind::Read, number, 0),
            Request::Write { number, raw } => (Kind::Write, number, raw),
            Request::Run(service) => (Kind::Run, service as u16, 0),
            Request::BuildInfo => (Kind::BuildInfo, 0, 0),
            Request::DeviceInfo => (Kind::DeviceInfo, 0, 0),
            Request::DescriptionInfo => (Kind::DescriptionInfo, 0, 0),
            Request::Reboot => (Kind::Reboot, 0, 0),
            Request::RestoreFactory { serial } => (Kind::RestoreFactory, 0, serial.into()),
            Request::DigitalOutputs(DigitalOutputs { enable1, value1, enable2, value2 }) => {
                let bits = [enable1, value1, enable2, value2].map(i32::from);
                (Kind::DigitalOutputs, 0, bits[0] | bits[1] << 1 | bits[2] << 2 | bits[3] << 3)
            }
            Request::DisableHallSupply(disable) => (Kind::DisableHallSupply, 0, disable.into()),
            Request::TriggerScope => (Kind::TriggerScope, 0, 0),
        };
        Self { kind: kind as u8, number, value }
    }
}

impl From<NotTaken> for narx_status_t {
    fn from(reason: NotTaken) -> Self {
        match reason {
            NotTaken::Silent => NARX_ERROR_SILENT,
            NotTaken::Full => NARX_ERROR_FULL,
        }
    }
}
