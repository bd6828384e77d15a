//! One message that needs an answer: repeated when none comes, given up after some attempts.

use crate::bus::narmotion::{FromDrive, ParameterStatus, ToDrive, XmlCommand};
use crate::dictionary::number;

/// Attempts of a store: it is answered when it is done, after up to ten seconds on a flash that must be
/// erased first.
const STORE_ATTEMPTS: u8 = 100;

/// Originator of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Owner {
    /// The caller.
    Request,
    /// The job of the motor.
    Job,
    /// The job of the scope or the log.
    Record,
    /// The download.
    Download,
    /// Reading in the background.
    Reader,
}

/// Next step of an exchange.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// Nothing is under way.
    Idle,
    /// The answer may still come.
    Wait,
    /// Send this message again.
    Send(ToDrive),
    /// No answer came.
    Expired(Owner),
}

/// The message under way, if there is one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Exchange(Option<UnderWay>);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct UnderWay {
    message: ToDrive,
    owner: Owner,
    /// Time of the last transmission, microseconds.
    sent: u64,
    /// Attempts left.
    left: u8,
}

impl Exchange {
    /// Sends `message`, for the first time at `now`.
    pub(super) const fn begin(&mut self, message: ToDrive, owner: Owner, attempts: u8, now: u64) {
        let left = match message {
            // A second reboot would restart the drive once more.
            ToDrive::Reboot => 0,
            ToDrive::SetParameter { number: number::STORE | number::STORE_ONCE, value: 1 }
                if attempts < STORE_ATTEMPTS =>
            {
                STORE_ATTEMPTS - 1
            }
            _ => attempts.saturating_sub(1),
        };
        self.0 = Some(UnderWay { message, owner, sent: now, left });
    }

    /// Returns the next step at time `now`.
    pub(super) fn poll(&mut self, now: u64, timeout: u64) -> Step {
        let Some(under_way) = &mut self.0 else { return Step::Idle };
        if now < under_way.sent.saturating_add(timeout) {
            return Step::Wait;
        }
        let UnderWay { message, owner, .. } = *under_way;
        if let Some(left) = under_way.left.checked_sub(1) {
            (under_way.left, under_way.sent) = (left, now);
            return Step::Send(message);
        }
        self.0 = None;
        Step::Expired(owner)
    }

    /// Time at which the message under way is repeated or given up, microseconds; `None` without one.
    pub(super) fn deadline(&self, timeout: u64) -> Option<u64> {
        self.0.map(|under_way| under_way.sent.saturating_add(timeout))
    }

    /// Ends the exchange if this is its answer, and returns the originator; `None` if it is not.
    pub(super) fn answer(&mut self, answer: &FromDrive) -> Option<Owner> {
        let UnderWay { message, owner, .. } = self.0?;
        if !answers(answer, &message) {
            return None;
        }
        self.0 = None;
        Some(owner)
    }
}

fn answers(answer: &FromDrive, message: &ToDrive) -> bool {
    use ParameterStatus::{Done, UnknownNumber};
    match (*answer, *message) {
        (FromDrive::BuildInfo { .. }, ToDrive::RequestBuildInfo)
        | (FromDrive::DeviceInfo { .. }, ToDrive::RequestDeviceInfo)
        | (FromDrive::Reboot, ToDrive::Reboot)
        | (FromDrive::XmlLength { .. }, ToDrive::DownloadXml(XmlCommand::Length)) => true,
        (FromDrive::Parameter { number, status, .. }, ToDrive::RequestParameter { number: asked }) => {
            number == asked && matches!(status, Done | UnknownNumber)
        }
        // The answer to a completed write has the written value: another value is a late answer to an earlier
        // message.
        (
            FromDrive::Parameter { number, value, status },
            ToDrive::SetParameter { number: asked, value: written },
        ) => number == asked && (status != Done || value == written),
        _ => false,
    }
}
