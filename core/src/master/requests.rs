//! The caller's requests to the drive, message by message, and their results.

use super::error::{NotTaken, Refusal, RequestError};
use super::waiting::Waiting;
use crate::bus::narmotion::{DigitalOutputs, FromDrive, ParameterStatus, ToDrive, XmlCommand};
use crate::dictionary::{Dictionary, number};

/// A request to the drive, answered once.
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
    /// Read length and CRC of the description, so that a known one need not be downloaded:
    /// [`super::Report::description`].
    DescriptionInfo,
    /// Restart the drive. The message is sent once and not repeated.
    Reboot,
    /// Restore factory values, except for the board's own parameters.
    RestoreFactory {
        /// Serial number of the addressed board (parameter 1).
        serial: u16,
    },
    /// Set the digital lines.
    DigitalOutputs(DigitalOutputs),
    /// Switch the hall supply off (true), or leave it to parameter 97.
    DisableHallSupply(bool),
    /// Arm the scope; when it is armed, force its trigger.
    TriggerScope,
}

/// Command parameters: they act on a rising edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u16)]
pub enum Service {
    /// Set the present position to parameter 16.
    SetPosition = number::SET_POSITION,
    /// Erase the log.
    EraseLog = number::LOG_ERASE_REQUEST,
    /// Store every parameter but those of `StoreOnce`.
    Store = number::STORE,
    /// Store the device number and the calibration.
    StoreOnce = number::STORE_ONCE,
    /// Restore the factory values of the calibration.
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

/// A request and its result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer {
    /// The request.
    pub request: Request,
    /// The raw value that the parameter has now; 0 for a request without a parameter. Messages without an
    /// answer in the protocol (RESTORE_FACTORY, DSIO_DATA_CMD, Disable_Hall_PS, the scope's trigger) count as
    /// done if the drive has counted no refused frame since.
    pub result: Result<i32, RequestError>,
}

impl Request {
    /// Requests without arguments, with the names that programs use for them.
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

    /// Returns the message of a request without an answer; `None` for any other request.
    const fn unanswered(self) -> Option<ToDrive> {
        Some(match self {
            Self::RestoreFactory { serial } => ToDrive::RestoreFactory { serial },
            Self::DigitalOutputs(outputs) => ToDrive::DigitalOutputs(outputs),
            Self::DisableHallSupply(disable) => ToDrive::DisableHallSupply(disable),
            Self::TriggerScope => ToDrive::TriggerScope,
            _ => return None,
        })
    }

    /// Returns whether the request changes many parameters.
    const fn changes_parameters(self) -> bool {
        matches!(self, Self::Run(Service::ResetCalibration | Service::AutoCalibrate))
    }
}

/// The next message to send.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Todo {
    /// A message that has an answer.
    Ask(ToDrive),
    /// A message that has none.
    Tell(ToDrive),
}

/// Queue of requests: from the call until the answer is taken.
#[derive(Clone, Debug, Default)]
pub(super) struct Requests(Waiting<Request, Current, Answer>);

/// A request under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Current {
    request: Request,
    /// Number of its messages that are done.
    step: u8,
    /// The drive's count of refused frames before a message without an answer.
    refused: i32,
}

impl Requests {
    pub(super) fn push(&mut self, request: Request) -> Result<(), NotTaken> {
        self.0.push(request)
    }

    pub(super) fn pop(&mut self) -> Option<Answer> {
        self.0.pop()
    }

    /// Returns whether there is something to send.
    pub(super) fn is_waiting(&self) -> bool {
        self.0.current.is_some() || !self.0.is_empty()
    }

    /// Returns the next message, once the one before has its answer.
    pub(super) fn next(&mut self) -> Option<Todo> {
        if self.0.current.is_none() {
            let request = self.0.next()?;
            self.0.current = Some(Current::new(request));
        }
        self.0.current.as_mut().map(Current::next)
    }

    /// Takes the answer to the message under way, `None` if none came; returns true if many parameters have
    /// changed.
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
    pub(super) const fn new(request: Request) -> Self {
        Self { request, step: 0, refused: 0 }
    }

    /// Returns the next message, once the one before has its answer.
    pub(super) fn next(&mut self) -> Todo {
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

    /// Returns the result of the whole request; `None` if it has more messages.
    pub(super) fn finish(&mut self, answer: &FromDrive) -> Option<Result<i32, RequestError>> {
        let FromDrive::Parameter { number, value, status } = *answer else { return Some(Ok(0)) };
        if self.request.unanswered().is_some() {
            // A drive without this counter answers 0 both times.
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
