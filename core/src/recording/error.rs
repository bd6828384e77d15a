//! Errors, with the place where they occurred.

use super::{CHUNK_BYTES, CONTAINER_VERSION, LABEL_MAX};
use core::fmt;

/// Reason why bytes are not a recording that this version can read. Offsets count from the start of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReadError {
    /// The file does not begin with [`MAGIC`](super::MAGIC).
    NotARecording,
    /// Another container version, most likely a newer one.
    ContainerVersion {
        /// The version in the file.
        found: u8,
    },
    /// Recorded with another layout of the drive's state, or of the calls of a transcript.
    LayoutVersion {
        /// The version in the file.
        found: u16,
        /// The one that this narx reads.
        known: u16,
    },
    /// A recording of another kind than was asked for.
    Kind {
        /// The kind in the file.
        found: u8,
    },
    /// The file ends too early.
    Truncated {
        /// Length of the file.
        at: usize,
        /// The part that should have followed.
        expected: &'static str,
    },
    /// Bytes were changed, lost or moved.
    Checksum {
        /// Offset of the stored check value.
        at: usize,
        /// The check value in the file.
        stored: u32,
        /// The check value of the bytes before it.
        computed: u32,
    },
    /// A field has a value that no recorder writes.
    Malformed {
        /// Offset of the field.
        at: usize,
        /// The content that was expected.
        expected: &'static str,
    },
    /// The tick count in the end record is not that of the file.
    TickCount {
        /// The count in the end record.
        stored: u64,
        /// The ticks read.
        read: u64,
    },
    /// Something follows the end record.
    TrailingBytes {
        /// Offset of the first byte too many.
        at: usize,
    },
}

/// Reason why something could not be recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordError<E> {
    /// The label is longer than [`LABEL_MAX`] bytes.
    LabelTooLong,
    /// The initial state is longer than 65 535 bytes.
    StateTooLong,
    /// An event or a call does not fit in a chunk.
    EventTooLong,
    /// The sink refused.
    Sink(E),
}

/// Reason why a recording could not be replayed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReplayError {
    /// The recording cannot be read.
    Read(ReadError),
    /// The initial state is not one of this drive.
    State,
    /// The recorded node has other features than this build, so its answers would differ. Bits in the order
    /// of [`NodeSetup::features`](super::transcript::NodeSetup::features).
    Features {
        /// Features in the transcript.
        recorded: u8,
        /// Features of this build.
        here: u8,
    },
}

impl From<ReadError> for ReplayError {
    fn from(error: ReadError) -> Self {
        Self::Read(error)
    }
}

impl ReadError {
    /// Turns `Truncated` into `Malformed` where the payload of a whole chunk ended too early: the file did
    /// not.
    pub(super) const fn within_chunk(self) -> Self {
        match self {
            Self::Truncated { at, expected } => Self::Malformed { at, expected },
            other => other,
        }
    }
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NotARecording => write!(f, "not a narx recording: it does not begin with \"narxrec\""),
            Self::ContainerVersion { found } => {
                write!(f, "container version {found}, but this narx reads version {CONTAINER_VERSION}")
            }
            Self::LayoutVersion { found, known } => {
                let age = if found > known { "a newer" } else { "an older" };
                write!(f, "recorded by {age} narx: state layout {found}, but this one reads layout {known}")
            }
            Self::Kind { found } => {
                let name = match found {
                    1 => " (drive)",
                    2 => " (node)",
                    3 => " (TX-Driver)",
                    _ => "",
                };
                write!(f, "recording of kind {found}{name}, which is not replayed here")
            }
            Self::Truncated { at, expected } => {
                write!(f, "truncated: the file ends at byte {at}, expected {expected}")
            }
            Self::Checksum { at, stored, computed } => write!(
                f,
                "corrupt: the check value at byte {at} is {stored:08x}, but the bytes before it give {computed:08x}"
            ),
            Self::Malformed { at, expected } => write!(f, "corrupt at byte {at}: expected {expected}"),
            Self::TickCount { stored, read } => {
                write!(f, "corrupt: the end record counts {stored} ticks, the file holds {read}")
            }
            Self::TrailingBytes { at } => write!(f, "corrupt: bytes follow the end record at byte {at}"),
        }
    }
}

impl<E: fmt::Display> fmt::Display for RecordError<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LabelTooLong => write!(f, "the label is longer than {LABEL_MAX} bytes"),
            Self::StateTooLong => write!(f, "the initial state is longer than 65535 bytes"),
            Self::EventTooLong => {
                write!(f, "an event or a call does not fit in a chunk of {CHUNK_BYTES} bytes")
            }
            Self::Sink(error) => write!(f, "the recording could not be written: {error}"),
        }
    }
}

impl fmt::Display for ReplayError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read(error) => error.fmt(f),
            Self::State => write!(f, "the recording's initial state is not a state of this drive"),
            Self::Features { recorded, here } => write!(
                f,
                "recorded by a node with features {recorded:#04x}, but this one has {here:#04x} (accelerometer 1, description 2, log 4, scope 8, recorder 16)"
            ),
        }
    }
}

impl core::error::Error for ReadError {}
impl<E: fmt::Debug + fmt::Display> core::error::Error for RecordError<E> {}
impl core::error::Error for ReplayError {}
