//! Error messages: each code at most once a second, whatever happens, and again if it was lost with the bus.

use crate::bus::eddycan::ErrorCode;

/// Least time between two messages of the same code, microseconds.
const QUIET_US: u64 = 1_000_000;

/// Errors that are still to be told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Errors {
    codes: [Reports; ErrorCode::ALL.len()],
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Reports {
    report: Report,
    /// Not told again before this time.
    quiet_until: u64,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Report {
    /// There is nothing to tell.
    #[default]
    None,
    /// To be told when the second after the last one is over.
    Due,
    /// The controller went off the bus when the message was with it.
    Lost,
}

impl Errors {
    /// An error has occurred; it is forgotten if the same one was told less than a second ago.
    pub(super) fn note(&mut self, code: ErrorCode, now: u64) {
        for (own, reports) in ErrorCode::ALL.into_iter().zip(&mut self.codes) {
            if own == code && now >= reports.quiet_until {
                reports.report = Report::Due;
            }
        }
    }

    /// The next one to tell.
    pub(super) fn pop(&mut self, now: u64) -> Option<ErrorCode> {
        let mut all = ErrorCode::ALL.into_iter().zip(&mut self.codes);
        let (code, reports) =
            all.find(|(_, reports)| reports.report == Report::Due && reports.quiet_until <= now)?;
        *reports = Reports { report: Report::None, quiet_until: now.saturating_add(QUIET_US) };
        Some(code)
    }

    /// The controller has gone off the bus, and what it held is dropped. A node goes there by frames of its own, so what it was handed within the last
    /// second may be among them.
    pub(super) fn lose(&mut self, now: u64) {
        for reports in &mut self.codes {
            if reports.report == Report::None && now < reports.quiet_until {
                reports.report = Report::Lost;
            }
        }
    }

    /// A frame has arrived, so others would hear what was lost. Without one it is not tried again: a node at a wrong bitrate would go on destroying
    /// the frames of others.
    pub(super) fn hear(&mut self) {
        for reports in &mut self.codes {
            if reports.report == Report::Lost {
                reports.report = Report::Due;
            }
        }
    }

    /// When the next one becomes due after `now`.
    pub(super) fn due_after(&self, now: u64) -> Option<u64> {
        let waiting = self.codes.iter().filter(|reports| reports.report == Report::Due);
        waiting.map(|reports| reports.quiet_until).filter(|from| *from > now).min()
    }
}
