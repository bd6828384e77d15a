//! Records the inputs of a drive, tick by tick, and replays them to the same outputs.
//!
//! ```text
//!  Samples, Event ──> Recorder ──> bytes ──> Recording ──> replay ──> the same PwmCommands
//!  PwmCommand, Status ──> Digest ─────────────────── compared with ──────┘
//! ```
//!
//! # Container, version 1
//!
//! All numbers little endian. The file is [`MAGIC`], one byte [`CONTAINER_VERSION`], then chunks:
//!
//! | bytes | field |
//! |---|---|
//! | 1 | tag: `H` header, `S` state, `T` ticks, `E` end |
//! | 2 | payload length n |
//! | n | payload |
//! | 4 | CRC-32 (ISO-HDLC) of every byte of the file so far but the CRC fields themselves |
//!
//! Order: one `H`, one `S`, any number of `T`, one `E`, end of file. Because the check runs on from the
//! start, chunks that are lost, repeated or exchanged are noticed like changed bytes; because each chunk
//! carries it, no tick is handed out that was not checked.
//!
//! | chunk | payload |
//! |---|---|
//! | `H` | kind (1 drive; 2 node and 3 TX-Driver: [`transcript`]) u8, behaviour version u16, layout version u16, tick rate in Hz u32, label length u8, label UTF-8 |
//! | `S` | initial state, postcard |
//! | `T` | tick records, whole ones, at most [`CHUNK_BYTES`] together |
//! | `E` | number of ticks u64, output digest u64 ([`Digest`]) |
//!
//! A tick record is the difference to the tick before (the first: to
//! [`Samples::default`](crate::motor::Samples)): a change mask as varint, then in the order of the mask's
//! bits what has changed.
//!
//! | bit | field | written as |
//! |---|---|---|
//! | 0..=2 | phase voltage A, B, C | zigzag varint of the wrapping 16-bit difference |
//! | 3, 4 | bus voltage, bus current | the same |
//! | 5 | hall | u8 |
//! | 6 | edges, unless there are none | count u8, then each: instant u16, varint of code x 2 + source (0 hall, 1 comparator) |
//! | 7 | an event was taken before the tick | length u16, postcard |
//! | 8 | tick number, unless one more than the last | zigzag varint of the wrapping difference to that |
//! | 9, 10 | sample mode, current mode | nothing: it is the other one of the two |
//! | 11 | skew | u16 |
//! | 12 | edges lost, unless 0 | u8 |
//! | 13 | digital lines | u8 |
//!
//! Varints are LEB128: seven bits a byte, low ones first, the top bit says that more follow.

mod any;
mod bytes;
mod digest;
mod error;
mod outputs;
mod read;
mod replay;
mod scoped;
mod tick;
pub mod transcript;
mod write;

pub use crate::motor::drive::{BEHAVIOUR_VERSION, LAYOUT_VERSION};
pub use any::{replay_any, replay_any_until};
pub use digest::Digest;
pub use error::{ReadError, RecordError, ReplayError};
pub use outputs::Outputs;
pub use read::{End, Recording, Tick, Ticks, header};
pub use replay::{Outcome, Player, Prefix, Replayable, replay, replay_until, replay_with};
pub use scoped::{Scoped, ScopedError, record_scoped};
pub use write::{Full, Recorder, Sink};

use crc::{CRC_32_ISO_HDLC, Crc};

/// The first eight bytes of every recording. The line feed shows a file that was mangled as text.
pub const MAGIC: [u8; 8] = *b"narxrec\n";

/// Version of the container described here.
pub const CONTAINER_VERSION: u8 = 1;

/// Largest payload of a chunk of ticks, bytes; one tick with its event fits.
pub const CHUNK_BYTES: usize = 1024;

/// Longest label, bytes.
pub const LABEL_MAX: usize = 64;

/// Check value of every chunk.
static CRC32: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Device whose inputs were recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// The control tick: samples and events.
    Drive = 1,
    /// The node around it: frames, time, store results, status.
    Node = 2,
    /// A TX-Driver: frames, time, samples, store results.
    TxDriver = 3,
}

impl Kind {
    /// Returns whether the recording is a [`transcript`].
    #[must_use]
    pub const fn is_transcript(self) -> bool {
        !matches!(self, Self::Drive)
    }
}

/// Header of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header<'a> {
    /// Device whose inputs were recorded.
    pub kind: Kind,
    /// [`BEHAVIOUR_VERSION`] of the recorder.
    pub behaviour_version: u16,
    /// [`LAYOUT_VERSION`] of the recorder.
    pub layout_version: u16,
    /// Control ticks a second.
    pub tick_rate: u32,
    /// Free text, at most [`LABEL_MAX`] bytes.
    pub label: &'a str,
}

impl<'a> Header<'a> {
    /// Checks that its state or calls have the layout that is known here.
    const fn check_layout(&self, known: u16) -> Result<(), ReadError> {
        let found = self.layout_version;
        if found == known { Ok(()) } else { Err(ReadError::LayoutVersion { found, known }) }
    }

    /// Header of a drive recorded by this version. `tick_rate` in Hz.
    pub const fn drive(tick_rate: u32, label: &'a str) -> Self {
        Self {
            kind: Kind::Drive,
            behaviour_version: BEHAVIOUR_VERSION,
            layout_version: LAYOUT_VERSION,
            tick_rate,
            label,
        }
    }
}

/// Chunk tags.
mod tag {
    pub(super) const HEADER: u8 = b'H';
    pub(super) const STATE: u8 = b'S';
    pub(super) const TICKS: u8 = b'T';
    pub(super) const CALLS: u8 = b'C';
    pub(super) const END: u8 = b'E';
}
