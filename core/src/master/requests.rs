//! What the caller asks of the drive, message by message, and what comes of it.

use super::error::{NotTaken, Refusal, RequestError};
use super::waiting::Waiting;
use crate::bus::narmotion::{DigitalOutputs, FromDrive, ParameterStatus, ToDrive, XmlCommand};
use crate::dictionary::{Dictionary, number};

/// Something that is asked of the drive once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// Read a parameter.
    Read {
        /// Its number.
        number: u16,
    },
    /// Write a parameter.
    Write {
        /// Its number.
        number: u16,
        /// Its raw value.
        raw: i32,
    },
    /// Run a command parameter: 0 is written, then 1.
    Run(Service),
    /// BUILD_INFO.
    BuildInfo,
    /// DEVICE_INFO.
    DeviceInfo,
    /// Length and CRC of the description, so that one that is known need not be downloaded: [`super::Report::description`].
    DescriptionInfo,
    /// Restart the drive. Asked once: it is not repeated.
    Reboot,
    /// Factory values for everything but what is the board's own.
    RestoreFactory {
        /// Serial number of the board that is meant (parameter 1).
        serial: u16,
    },
    /// Set the digital lines.
    DigitalOutputs(DigitalOutputs),
    /// Switch the hall supply off (true), or leave it to parameter 97.
    DisableHallSupply(bool),
    /// Arm the scope; when it is armed, force its trigger.
    TriggerScope,
}

/// Commands that are parameters: they act on a rising edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u16)]
pub enum Service {
    /// The present position becomes that of parameter 16.
    SetPosition = number::SET_POSITION,
    /// Erase the log.
    EraseLog = number::LOG_ERASE_REQUEST,
    /// Store every parameter but those of `StoreOnce`.
    Store = number::STORE,
    /// Store the device number and the calibration.
    StoreOnce = number::STORE_ONCE,
    /// Factory values for the calibration.
    ResetCalibration = number::RESET_CALIBRATION,
    /// Calibrate bus current and voltage with the bridge off.
    AutoCalibrate = number::AUTO_CALIBRATE,
    /// Let the next start calibrate the hall sensors.
    CalibrateHall = number::HALL_CALIBRATE,
}

impl Service {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::SetPosition,
        Self::EraseLog,
        Self::Store,
        Self::StoreOnce,
        Self::ResetCalibration,
        Self::AutoCalibrate,
        Self::CalibrateHall,
    ];
}

/// A request and what came of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer {
    /// What was asked for.
    pub request: Request,
    /// The raw value that the parameter has now; 0 where there is no parameter. Messages to which the protocol has no answer (RESTORE_FACTORY,
    /// DSIO_DATA_CMD, Disable_Hall_PS, the scope's trigger) are done when the drive has counted no refused frame since.
    pub result: Result<i32, RequestError>,
}

impl Request {
    /// Requests that need nothing besides, by the names that programs call them by.
    pub const NAMED: [(&'static str, Self); 14] = [
        ("build info", Self::BuildInfo),
        ("device info", Self::DeviceInfo),
        ("description info", Self::DescriptionInfo),
        ("reboot", Self::Reboot),
        ("trigger scope", Self::TriggerScope),
        ("disable hall supply", Self::DisableHallSupply(true)),
        ("enable hall supply", Self::DisableHallSupply(false)),
        ("set position", Self::Run(Service::SetPosition)),
        ("erase log", Self::Run(Service::EraseLog)),
        ("store", Self::Run(Service::Store)),
        ("store once", Self::Run(Service::StoreOnce)),
        ("reset calibration", Self::Run(Service::ResetCalibration)),
        ("auto-calibrate", Self::Run(Service::AutoCalibrate)),
        ("calibrate hall", Self::Run(Service::CalibrateHall)),
    ];

    /// Reads the parameter of that name; case does not matter.
    pub fn read(name: &str) -> Option<Self> {
        Some(Self::Read { number: Dictionary::find(name)?.number })
    }

    /// Writes a raw value to the parameter of that name; case does not matter.
    pub fn write(name: &str, raw: i32) -> Option<Self> {
        Some(Self::Write { number: Dictionary::find(name)?.number, raw })
    }

    /// The message that has no answer.
    const fn unanswered(self) -> Option<ToDrive> {
        Some(match self {
            Self::RestoreFactory { serial } => ToDrive::RestoreFactory { serial },
            Self::DigitalOutputs(outputs) => ToDrive::DigitalOutputs(outputs),
            Self::DisableHallSupply(disable) => ToDrive::DisableHallSupply(disable),
            Self::TriggerScope => ToDrive::TriggerScope,
            _ => return None,
        })
    }

    /// Whether many parameters have another value when this is done.
    const fn changes_parameters(self) -> bool {
        matches!(self, Self::Run(Service::ResetCalibration | Service::AutoCalibrate))
    }
}

/// What is sent next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Todo {
    /// A message that has an answer.
    Ask(ToDrive),
    /// A message that has none.
    Tell(ToDrive),
}

/// Requests from the call to the taken answer.
#[derive(Clone, Debug, Default)]
pub(super) struct Requests(Waiting<Request, Current, Answer>);

/// A request under way.
#[derive(Clone, Copy, Debug)]
struct Current {
    request: Request,
    /// Messages of it that are done.
    step: u8,
    /// Refused frames before a message without an answer.
    refused: i32,
}

impl Requests {
    pub(super) fn push(&mut self, request: Request) -> Result<(), NotTaken> {
        self.0.push(request)
    }

    pub(super) fn pop(&mut self) -> Option<Answer> {
        self.0.pop()
    }

    /// Whether there is something to send.
    pub(super) fn is_waiting(&self) -> bool {
        self.0.current.is_some() || !self.0.is_empty()
    }

    /// The next message; what was asked before has its answer.
    pub(super) fn next(&mut self) -> Option<Todo> {
        if self.0.current.is_none() {
            let request = self.0.next()?;
            self.0.current = Some(Current { request, step: 0, refused: 0 });
        }
        self.0.current.as_mut().map(Current::next)
    }

    /// The message under way was answered, or not. True if many parameters have changed.
    pub(super) fn finish(&mut self, answer: Option<&FromDrive>) -> bool {
        let Some(current) = &mut self.0.current else { return false };
        let result = match answer {
            Some(answer) => current.finish(answer),
            None => Some(Err(RequestError::NoAnswer)),
        };
        let Some(result) = result else { return false };
        let request = current.request;
        self.0.finish(Answer { request, result });
        result.is_ok() && request.changes_parameters()
    }
}

impl Current {
    fn next(&mut self) -> Todo {
        let Self { request, step, .. } = *self;
        if let Some(message) = request.unanswered() {
            if step == 1 {
                self.step = 2;
                return Todo::Tell(message);
            }
            return Todo::Ask(ToDrive::RequestParameter { number: number::REFUSED_FRAMES });
        }
        Todo::Ask(match request {
            Request::Read { number } => ToDrive::RequestParameter { number },
            Request::Write { number, raw } => ToDrive::SetParameter { number, value: raw },
            Request::Run(service) => ToDrive::SetParameter { number: service as u16, value: step.into() },
            Request::BuildInfo => ToDrive::RequestBuildInfo,
            Request::DeviceInfo => ToDrive::RequestDeviceInfo,
            Request::DescriptionInfo => ToDrive::DownloadXml(XmlCommand::Length),
            _ => ToDrive::Reboot,
        })
    }

    /// What came of the whole request; `None` when it has more messages.
    fn finish(&mut self, answer: &FromDrive) -> Option<Result<i32, RequestError>> {
        let FromDrive::Parameter { number, value, status } = *answer else { return Some(Ok(0)) };
        if self.request.unanswered().is_some() {
            // A drive that does not count answers 0 twice.
            if self.step == 0 {
                (self.step, self.refused) = (1, value);
                return None;
            }
            return Some(if value == self.refused { Ok(0) } else { Err(RequestError::NotObeyed) });
        }
        if status != ParameterStatus::Done {
            return Some(Err(RequestError::Refused(self.refusal(number, value, status))));
        }
        if matches!(self.request, Request::Run(_)) && self.step == 0 {
            self.step = 1;
            return None;
        }
        Some(Ok(value))
    }

    fn refusal(&self, number: u16, stored: i32, status: ParameterStatus) -> Refusal {
        let offered = match self.request {
            Request::Write { raw, .. } => Some(raw),
            Request::Run(_) => Some(self.step.into()),
            _ => None,
        };
        Refusal { number, parameter: Dictionary::row(number), status, offered, stored }
    }
}
