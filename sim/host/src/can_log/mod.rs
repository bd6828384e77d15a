//! Logs of a CAN bus, decoded: frames in, columns out.
//!
//! [`CanLog::push`] takes a frame that was read from anywhere; [`CanLog::read_candump`] reads a whole log of
//! can-utils, on several processors. Every frame is kept in [`Frames`], with the table that its message
//! stands in, and every line that is no frame in `errors`: nothing is lost without being told.

mod candump;
mod column;
mod drive;
mod frames;
mod name;
pub mod node;

pub use column::{Signal, Table, Value, Values};
pub use drive::Ends;
pub use frames::{Frames, Logged, flag};
pub use name::{identifier, message_name};

use drive::Plans;
use narx_core::bus::narmotion::MESSAGES;
use narx_core::bus::{Frame, Id};
use std::sync::Arc;

/// Settings for decoding a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Config {
    /// The drive and its master.
    pub ends: Ends,
    /// TX-Drivers whose PDOs of 8 bytes carry two positions of 24 bits and the encoder, not two of 32 bits:
    /// bit n is node-id n.
    pub encoders: u128,
}

/// Kind of a frame that stands in no table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// Of no protocol that is looked for, or between other addresses.
    Unknown = 255,
    /// It has the identifier of a message, and not its shape: length, remote, or a value without a meaning.
    Malformed = 254,
    /// An error frame.
    Error = 253,
}

/// A line that is no frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LineError {
    /// Its number; the first line has 1.
    pub line: usize,
    /// The line, or its beginning.
    pub text: String,
    /// Reason why the line is no frame.
    pub reason: &'static str,
}

/// A log, as far as it was read.
#[derive(Clone)]
pub struct CanLog {
    config: Config,
    plans: Arc<Plans>,
    /// Every frame, in the order of the log.
    pub frames: Frames,
    /// The drive's messages in the order of [`MESSAGES`], then those of [`node::MESSAGES`].
    pub tables: Vec<Table>,
    /// Lines that are no frame.
    pub errors: Vec<LineError>,
    /// Lines so far.
    pub lines: usize,
    /// Beginning of a candump line whose end comes with the next part.
    tail: Vec<u8>,
    /// The last candump line that is not blank has a direction.
    is_directed: bool,
}

impl CanLog {
    /// Nothing yet.
    pub fn new(config: Config) -> Self {
        Self::with(config, Arc::new(Plans::new(config.ends)))
    }

    fn with(config: Config, plans: Arc<Plans>) -> Self {
        let tables = drive::tables().chain(node::tables()).collect();
        let frames = Frames::default();
        Self {
            config,
            plans,
            frames,
            tables,
            errors: Vec::new(),
            lines: 0,
            tail: Vec::new(),
            is_directed: false,
        }
    }

    /// Takes the next frame.
    pub fn push(&mut self, logged: &Logged<'_>) {
        let message = match self.decode(logged) {
            Ok(place) => place as u8,
            Err(kind) => kind as u8,
        };
        self.frames.push(logged, message);
    }

    /// Adds a row to the table of the frame's message, and says which.
    fn decode(&mut self, logged: &Logged<'_>) -> Result<usize, Kind> {
        if logged.flags & flag::ERROR != 0 {
            return Err(Kind::Error);
        }
        if logged.flags & flag::FD != 0 {
            return Err(Kind::Unknown);
        }
        if logged.flags & flag::EXTENDED != 0 {
            let place = self.plans.place(logged.id).ok_or(Kind::Unknown)?;
            // A remote frame has no data.
            let data = logged.data.try_into().map_err(|_| Kind::Malformed)?;
            self.plans.push(place, &mut self.tables[place], logged.time, data);
            return Ok(place);
        }
        let id = u16::try_from(logged.id).ok().and_then(Id::standard).ok_or(Kind::Unknown)?;
        let remote = logged.flags & flag::REMOTE != 0;
        let frame = if remote { Frame::remote(id, logged.dlc) } else { Frame::data(id, logged.data) };
        let frame = frame.ok_or(Kind::Unknown)?;
        let encoder = self.config.encoders >> (logged.id & 0x7F) & 1 != 0;
        let decoded = node::decode(&frame, encoder).map_err(Kind::from)?;
        let place = MESSAGES.len() + decoded.place;
        let table = &mut self.tables[place];
        table.time.push(logged.time);
        table.columns.iter_mut().zip(decoded.values()).for_each(|(values, value)| values.push(*value));
        Ok(place)
    }

    /// Moves out all that was read; the log is empty then.
    pub fn take(&mut self) -> Self {
        let empty = Self::with(self.config, self.plans.clone());
        core::mem::replace(self, empty)
    }

    /// Appends the part that comes after it in the same log.
    fn append(&mut self, other: Self) {
        self.frames.append(other.frames);
        self.tables.iter_mut().zip(other.tables).for_each(|(table, others)| table.append(others));
        let lines = self.lines;
        self.errors
            .extend(other.errors.into_iter().map(|error| LineError { line: lines + error.line, ..error }));
        self.lines += other.lines;
    }
}

impl From<narx_core::bus::eddycan::DecodeError> for Kind {
    fn from(error: narx_core::bus::eddycan::DecodeError) -> Self {
        use narx_core::bus::eddycan::DecodeError::{ExtendedId, Identifier};
        if matches!(error, ExtendedId | Identifier) { Self::Unknown } else { Self::Malformed }
    }
}
