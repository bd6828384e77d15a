//! What a record of the log consists of.

use crate::dictionary::{Kind, number};

/// A part of a log record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LogEntry {
    /// What it is called.
    pub name: &'static str,
    /// Type of its values.
    pub kind: Kind,
    /// The parameters that say what it holds: one value for each of them that names something to log.
    pub parameters: (u16, u16),
}

/// The parts of a record in their order (category 15).
pub const LOG_RECORD: [LogEntry; 4] = [
    entry("Start marker", Kind::U16, number::LOGGING_START, number::LOGGING_START),
    entry("Record number", Kind::U32, number::LOGGING_PACKAGE, number::LOGGING_PACKAGE),
    entry("Logged values", Kind::I32, number::LOGGING_SLOT_FIRST, number::LOGGING_SLOT_LAST),
    entry("End marker", Kind::U16, number::LOGGING_END, number::LOGGING_END),
];

const fn entry(name: &'static str, kind: Kind, first: u16, last: u16) -> LogEntry {
    LogEntry { name, kind, parameters: (first, last) }
}
