//! Layout of a record of the log.

use crate::dictionary::{Kind, number};

/// A part of a log record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LogEntry {
    /// Name of the part.
    pub name: &'static str,
    /// Type of its value, big endian.
    pub kind: Kind,
    /// Unit of its value; "-" without one.
    pub unit: &'static str,
    /// First and last of the parameters that define its content.
    pub parameters: Option<(u16, u16)>,
    /// The part appears once for each logged value, next to the other such parts.
    pub per_value: bool,
}

/// The parts of a record in their order: `storage::Record` in words. The CRC is that of ISO-HDLC (zlib), over
/// all bytes before it.
pub const LOG_RECORD: [LogEntry; 8] = [
    entry("Start marker", Kind::U16).of(number::LOGGING_START, number::LOGGING_START),
    entry("Record number", Kind::U32).of(number::LOGGING_PACKAGE, number::LOGGING_PACKAGE),
    LogEntry { unit: "ms", ..entry("Time since power-up", Kind::U32) },
    entry("Number of values", Kind::U16),
    each("What is logged", Kind::U16).of(number::LOGGING_SLOT_FIRST, number::LOGGING_SLOT_LAST),
    each("Value", Kind::I32),
    entry("CRC-32", Kind::U32),
    entry("End marker", Kind::U16).of(number::LOGGING_END, number::LOGGING_END),
];

impl LogEntry {
    const fn of(self, first: u16, last: u16) -> Self {
        Self { parameters: Some((first, last)), ..self }
    }
}

const fn entry(name: &'static str, kind: Kind) -> LogEntry {
    LogEntry { name, kind, unit: "-", parameters: None, per_value: false }
}

const fn each(name: &'static str, kind: Kind) -> LogEntry {
    LogEntry { per_value: true, ..entry(name, kind) }
}
