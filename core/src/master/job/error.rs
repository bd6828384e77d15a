//! Reasons why a job has failed, their texts and kinds.

use super::Job;
use crate::bus::narmotion::ParameterStatus as Status;
use crate::dictionary::{Decimal, Dictionary};
use crate::master::error::RequestError;
use crate::master::requests::Request;
use crate::motor::guard::fault::{Cause, FaultWord};
use crate::motor::machine::state::State;
use crate::scope::{self, SIGNALS_A_TICK, period};
use core::fmt::{self, Write as _};

/// Reason why a job has failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JobError {
    /// The drive is in Fault.
    Fault {
        /// Latched faults.
        faults: FaultWord,
        /// Extended code of the last critical fault.
        code: u16,
    },
    /// The drive refuses the start.
    StartRefused {
        /// Value of the parameter Start refusal.
        reason: i32,
        /// Parameter that does not fit the others, for reason 2.
        parameter: Option<u16>,
    },
    /// The job has taken too long.
    TimedOut {
        /// The job.
        job: Job,
        /// Its longest time, microseconds.
        within: u64,
        /// State of the drive; `None` while unknown.
        state: Option<State>,
    },
    /// The hall calibration has not found the sensors.
    NotCalibrated {
        /// State in which it ended.
        state: Option<State>,
        /// Extended code of the fault in which it ended.
        code: Option<u16>,
    },
    /// The scope is armed or recording, and cannot be set up.
    ScopeBusy(scope::State),
    /// The scope is not armed, and cannot be forced.
    NotArmed(scope::State),
    /// The drive has no memory for the scope.
    NoScopeMemory,
    /// The scope's memory has no room for so many samples, or there are none.
    Samples {
        /// Samples of each signal.
        samples: u16,
        /// Number of signals.
        signals: u8,
        /// Words of the memory.
        room: u16,
    },
    /// Reading the signals takes more ticks than the prescaler leaves.
    Prescaler {
        /// Control ticks from one sample to the next.
        prescaler: u16,
        /// Number of signals.
        signals: u8,
    },
    /// All samples are before the trigger.
    Before {
        /// Samples from before the trigger.
        before: u16,
        /// Samples of each signal.
        samples: u16,
    },
    /// The drive refuses to arm or to force the scope.
    ScopeRefused(scope::Refusal),
    /// The scope's record was not complete in time.
    NoTrigger {
        /// State of the scope.
        state: scope::State,
        /// Longest time, microseconds.
        within: u64,
    },
    /// The drive was lost while it erased its log.
    LostErasing,
    /// This request of the job was not done.
    Request(Request, RequestError),
    /// Another command has ended this job.
    Aborted(Job),
}

/// Kind of an error, for programs that have a class for each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ErrorKind {
    /// The motor did not start, or was not calibrated.
    Start,
    /// The drive refuses the request now.
    Refused,
    /// The drive does not answer, or not in time.
    NoAnswer,
    /// A parameter of the drive is not one that it has, or cannot be written.
    Parameter,
    /// A value is out of its range.
    Range,
}

impl JobError {
    /// Kind of this error.
    pub const fn kind(&self) -> ErrorKind {
        match self {
            Self::TimedOut { job: Job::Reboot, .. }
            | Self::NoTrigger { .. }
            | Self::LostErasing
            | Self::Request(_, RequestError::NoAnswer) => ErrorKind::NoAnswer,
            Self::Samples { .. } | Self::Prescaler { .. } | Self::Before { .. } => ErrorKind::Range,
            Self::Request(_, RequestError::Refused(refusal)) => match refusal.status {
                Status::OutOfRange => ErrorKind::Range,
                Status::WrongState | Status::Storage | Status::NotEquipped => ErrorKind::Refused,
                _ => ErrorKind::Parameter,
            },
            Self::ScopeBusy(_)
            | Self::NotArmed(_)
            | Self::NoScopeMemory
            | Self::ScopeRefused(_)
            | Self::Request(_, RequestError::NotObeyed) => ErrorKind::Refused,
            Self::Aborted(job) if job.is_record() => ErrorKind::Refused,
            Self::Fault { .. }
            | Self::StartRefused { .. }
            | Self::TimedOut { .. }
            | Self::NotCalibrated { .. }
            | Self::Aborted(_) => ErrorKind::Start,
        }
    }
}

impl fmt::Display for JobError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Fault { faults, code } => write_fault(f, faults, code),
            Self::StartRefused { reason, parameter } => write_refused_start(f, reason, parameter),
            Self::TimedOut { job, within, state } => {
                let what = if job == Job::Reboot { "not ready after a reboot" } else { "no start" };
                write!(f, "{what} within {}: ", Seconds(within))?;
                match state {
                    Some(state) => write!(f, "the drive is in {}", state.name()),
                    None => f.write_str("no frames were received from the drive"),
                }
            }
            Self::NotCalibrated { state, code } => {
                let state = state.map_or("an unknown state", State::name);
                write!(f, "the hall calibration failed: the drive is in {state}")?;
                match code {
                    Some(code) => f.write_str(": ").and_then(|()| write_cause(f, code)),
                    None => Ok(()),
                }
            }
            Self::ScopeBusy(state) => {
                write!(f, "the scope is {}: force it, or wait until it is done", state.name())
            }
            Self::NotArmed(state) => {
                write!(f, "the scope is {}: only an armed scope can be forced", state.name())
            }
            Self::NoScopeMemory => f.write_str("the drive has no memory for the scope"),
            Self::Samples { samples, signals, room } => {
                let most = room.checked_div(signals.into()).unwrap_or(0);
                write!(
                    f,
                    "samples {samples}: must be 1 to {most} for {}, because the memory holds {room} words; \
                     prescaler {} or more",
                    Signals(signals),
                    period(signals.into(), 0)
                )
            }
            Self::Prescaler { prescaler, signals } => write!(
                f,
                "prescaler {prescaler}: must be at least {} for {}: the drive reads {SIGNALS_A_TICK} signals \
                 per control tick",
                period(signals.into(), 0),
                Signals(signals)
            ),
            Self::Before { before, samples } => {
                let most = samples.saturating_sub(1);
                write!(f, "before {before}: must be 0 to {most}, fewer than samples {samples}")
            }
            Self::ScopeRefused(refusal) => write!(f, "{}: {}", RequestError::NotObeyed, refusal.meaning()),
            Self::NoTrigger { state, within } => write!(
                f,
                "the scope is {} after {}: the trigger has not occurred",
                state.name(),
                Seconds(within)
            ),
            Self::LostErasing => f.write_str("the connection to the drive was lost while it erased its log"),
            Self::Request(Request::Reboot, error @ RequestError::NoAnswer) => {
                write!(f, "{error}: it is off the bus, or driving")
            }
            Self::Request(
                Request::Read { number } | Request::Write { number, .. },
                error @ RequestError::NoAnswer,
            ) => write!(f, "parameter {number}: {error}"),
            Self::Request(_, error) => error.fmt(f),
            Self::Aborted(job) => write!(f, "the {} was ended by another command", job.name()),
        }
    }
}

impl core::error::Error for JobError {}

/// Writes the meaning of an extended fault code, or the code itself.
fn write_cause(f: &mut fmt::Formatter<'_>, code: u16) -> fmt::Result {
    match Cause::TABLE.into_iter().find(|row| row.cause as u16 == code) {
        Some(row) => f.write_str(row.meaning),
        None => write!(f, "code {code:#06x}"),
    }
}

/// Writes a fault: its cause, and the set bits.
fn write_fault(f: &mut fmt::Formatter<'_>, faults: FaultWord, code: u16) -> fmt::Result {
    f.write_str("the drive is in Fault: ")?;
    write_cause(f, code)?;
    for (place, (name, _)) in faults.iter_names().enumerate() {
        f.write_str(if place == 0 { " (" } else { ", " })?;
        name.chars().try_for_each(|letter| f.write_char(letter.to_ascii_lowercase()))?;
    }
    f.write_str(if faults.is_empty() { "" } else { ")" })
}

/// Writes the reason of a refused start.
fn write_refused_start(f: &mut fmt::Formatter<'_>, reason: i32, parameter: Option<u16>) -> fmt::Result {
    f.write_str("the drive refused the start: ")?;
    match (reason, parameter) {
        (1, _) => f.write_str("no mode is enabled"),
        (2, Some(number)) => {
            let name = Dictionary::row(number).map_or("", |row| row.name());
            write!(f, "parameter {number} \"{name}\" does not fit the others")
        }
        (2, None) => f.write_str("parameters do not fit together"),
        (4, _) => f.write_str("Standby was not requested before"),
        _ => write!(f, "reason {reason}"),
    }
}

/// A time in microseconds, as a text in seconds.
struct Seconds(u64);

impl fmt::Display for Seconds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let digits = i64::try_from(self.0).unwrap_or(i64::MAX);
        write!(f, "{} s", Decimal { digits, exponent: -6 })
    }
}

/// A number of signals, as a text.
struct Signals(u8);

impl fmt::Display for Signals {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} signal{}", self.0, if self.0 == 1 { "" } else { "s" })
    }
}
