//! Errors of the master.

use crate::bus::narmotion::ParameterStatus;
use crate::dictionary::{Parameter, ParameterError};
use core::fmt;

/// Reason why a request was not done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RequestError {
    /// No answer to any attempt. A drive that refuses a reboot does not answer either.
    NoAnswer,
    /// The drive refuses to read or write a parameter.
    Refused(Refusal),
    /// The drive has refused a message that has no answer (parameter 274).
    NotObeyed,
}

/// A parameter that the drive did not read or write; nothing has changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// Number of the parameter.
    pub number: u16,
    /// Its row, if this library's dictionary has one.
    pub parameter: Option<&'static Parameter>,
    /// The drive's reason.
    pub status: ParameterStatus,
    /// The raw value that was to be written.
    pub offered: Option<i32>,
    /// The raw value that the drive has.
    pub stored: i32,
}

/// Reason why the master does not take a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotTaken {
    /// The master is silent.
    Silent,
    /// Too many answers were not taken yet.
    Full,
}

/// Reason why a download failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DownloadError {
    /// The drive sends nothing, or nothing more, after all attempts.
    NoAnswer,
    /// The drive refuses one of the log's parameters.
    Refused(Refusal),
    /// There is no log memory, or its records have another form: parameter 69 is no valid record size.
    NoLog,
    /// A record of the log was received whole, but its number or CRC is wrong, after all attempts.
    Spoiled {
        /// Its number.
        record: u32,
    },
    /// Ended by [`super::Master::abort_download`].
    Aborted,
}

impl fmt::Display for RequestError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoAnswer => f.write_str("the drive does not answer"),
            Self::Refused(refusal) => refusal.fmt(f),
            Self::NotObeyed => f.write_str("the drive has refused the request"),
        }
    }
}

impl fmt::Display for Refusal {
    /// Number, name, value and range.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { number, parameter, status, offered, .. } = *self;
        match (status, parameter, offered) {
            // A value that a command computes may be out of range, too.
            (ParameterStatus::OutOfRange, Some(parameter), Some(raw)) if !parameter.accepts(raw) => {
                ParameterError::OutOfRange { parameter, raw }.fmt(f)
            }
            (_, Some(row), _) => write!(f, "parameter {number} \"{}\": {status}", row.name()),
            (_, None, _) => write!(f, "parameter {number}: {status}"),
        }
    }
}

impl fmt::Display for NotTaken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Silent => "the master is silent",
            Self::Full => "earlier answers were not taken yet",
        })
    }
}

impl fmt::Display for DownloadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoAnswer => f.write_str("the drive sends no data, or has stopped sending"),
            Self::Refused(refusal) => refusal.fmt(f),
            Self::NoLog => f.write_str("there is no log memory"),
            Self::Spoiled { record } => write!(f, "record {record} of the log has a wrong number or CRC"),
            Self::Aborted => f.write_str("the download was aborted"),
        }
    }
}

impl core::error::Error for RequestError {}
impl core::error::Error for Refusal {}
impl core::error::Error for NotTaken {}
impl core::error::Error for DownloadError {}
