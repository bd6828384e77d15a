//! The description that the drive serves: an XML document of its parameters, messages, states, faults, scope
//! signals and log records. It is rendered from the tables as it is streamed, so there is no copy of it in
//! memory.
//!
//! ```text
//!   SECTIONS --line by line--> Window --bytes--> frames
//!      |                         ^
//!      +-- dictionary, MESSAGES, Cause::TABLE ...    Cursor: line, bytes of it that are gone
//! ```
//!
//! A line is rendered anew for each piece that is read of it. That costs time, of which a drive has plenty
//! during a download, and saves memory, which is scarce. `docs/narx.xsd` is the document's schema.

mod identity;
mod log;
mod sections;
mod window;

pub use identity::Identity;
pub use log::{LOG_RECORD, LogEntry};
pub use window::Measure;

use crate::bus::narmotion::Addresses;
use core::fmt;
use serde::{Deserialize, Serialize};
use window::Window;

/// Version of the document's format: a reader is made for one version.
pub const FORMAT: u16 = 1;

/// The document of one drive. Nothing in it changes until the drive reboots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Document {
    /// Firmware and board.
    pub identity: Identity,
    /// Addresses of the drive and its master: identifiers of messages depend on them.
    pub addresses: Addresses,
    /// Control ticks per second.
    pub tick_rate: u32,
}

/// A place in a document.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Cursor {
    line: u16,
    /// Bytes of the line that have been read.
    offset: u16,
}

impl Document {
    /// Reads on from `cursor` into `out`; returns the number of bytes, which is less than `out` holds only at
    /// the end.
    pub fn read(&self, cursor: &mut Cursor, out: &mut [u8]) -> usize {
        let mut filled = 0;
        while let Some(room) = out.get_mut(filled..).filter(|room| !room.is_empty())
            && usize::from(cursor.line) < sections::LINES
        {
            let mut window = Window::new(cursor.offset, room);
            // An error says that the window is full.
            let whole = self.write_line(cursor.line, &mut window).is_ok();
            let written = window.written();
            filled += written;
            *cursor = if whole {
                Cursor { line: cursor.line + 1, offset: 0 }
            } else {
                Cursor { offset: cursor.offset + written as u16, ..*cursor }
            };
        }
        filled
    }

    /// Adds a line to `measure`, after the lines before it; false behind the last one.
    pub fn measure_line(&self, line: u16, measure: &mut Measure) -> bool {
        // Counting does not fail.
        usize::from(line) < sections::LINES && self.write_line(line, measure).is_ok()
    }

    /// Writes the whole document.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        (0..sections::LINES as u16).try_for_each(|line| self.write_line(line, out))
    }
}
