//! Error messages: each code at most once a second, whatever happens.

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
    waiting: bool,
    /// Not told again before this time.
    quiet_until: u64,
}

impl Errors {
    /// An error has occurred; it is forgotten if the same one was told less than a second ago.
    pub(super) fn note(&mut self, code: ErrorCode, now: u64) {
        for (own, reports) in ErrorCode::ALL.into_iter().zip(&mut self.codes) {
            if own == code && now >= reports.quiet_until {
                *reports = Reports { waiting: true, quiet_until: now.saturating_add(QUIET_US) };
            }
        }
    }

    /// The next one to tell.
    pub(super) fn pop(&mut self) -> Option<ErrorCode> {
        let mut waiting = ErrorCode::ALL.into_iter().zip(&mut self.codes);
        let (code, reports) = waiting.find(|(_, reports)| reports.waiting)?;
        reports.waiting = false;
        Some(code)
    }
}
