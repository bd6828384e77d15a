//! Reads a recording: every chunk is checked before anything in it is used.

use super::bytes::Cursor;
use super::{
    BEHAVIOUR_VERSION, CONTAINER_VERSION, CRC32, Header, Kind, LABEL_MAX, LAYOUT_VERSION, MAGIC, ReadError,
    tag, tick,
};
use crate::motor::Samples;
use crate::motor::machine::event::Event;
use core::fmt;

/// A recording in memory.
#[derive(Clone, Debug)]
pub struct Recording<'a> {
    header: Header<'a>,
    state: &'a [u8],
    body: Chunks<'a>,
}

/// One recorded tick.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// The event that the drive took before it.
    pub event: Option<Event>,
    /// Samples that the drive was given.
    pub samples: Samples,
}

/// The end record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct End {
    /// Ticks in the recording.
    pub ticks: u64,
    /// Digest of the outputs ([`Digest`](super::Digest)).
    pub digest: u64,
}

impl End {
    /// The payload of the end chunk.
    pub(super) fn read(mut payload: Cursor<'_>) -> Result<Self, ReadError> {
        let end = Self { ticks: payload.u64("the tick count")?, digest: payload.u64("the output digest")? };
        if payload.rest().is_empty() {
            Ok(end)
        } else {
            Err(ReadError::Malformed { at: payload.at(), expected: "the end of the end chunk" })
        }
    }
}

/// Reads the header of a recording of any kind.
///
/// # Errors
/// The bytes are not a recording.
pub fn header(file: &[u8]) -> Result<Header<'_>, ReadError> {
    let payload = Chunks::open(file)?.expect(tag::HEADER, "a header chunk")?;
    decode_header(payload).map_err(ReadError::within_chunk)
}

impl<'a> Recording<'a> {
    /// Reads header and initial state. Ticks are checked as [`ticks`](Self::ticks) hands them out, or all at
    /// once by [`verify`](Self::verify).
    pub fn open(file: &'a [u8]) -> Result<Self, ReadError> {
        let mut body = Chunks::open(file)?;
        let payload = body.expect(tag::HEADER, "a header chunk")?;
        let header = decode_header(payload).map_err(ReadError::within_chunk)?;
        if header.kind != Kind::Drive {
            return Err(ReadError::Kind { found: header.kind as u8 });
        }
        header.check_layout(LAYOUT_VERSION)?;
        let state = body.expect(tag::STATE, "a state chunk")?.rest();
        Ok(Self { header, state, body })
    }

    /// Header of the recording.
    pub const fn header(&self) -> &Header<'a> {
        &self.header
    }

    /// The drive's serialised state before the first tick.
    pub const fn state(&self) -> &'a [u8] {
        self.state
    }

    /// Returns whether it was recorded with the behaviour version of this build. If not, outputs may rightly
    /// differ: a replay reports it and goes on.
    pub const fn same_behaviour(&self) -> bool {
        self.header.behaviour_version == BEHAVIOUR_VERSION
    }

    /// The ticks in order.
    pub fn ticks(&self) -> Ticks<'a> {
        Ticks {
            chunks: self.body.clone(),
            chunk: Cursor::new(&[], 0),
            before: Samples::default(),
            read: 0,
            end: None,
            failed: false,
        }
    }

    /// Reads everything and returns the end record.
    pub fn verify(&self) -> Result<End, ReadError> {
        let mut ticks = self.ticks();
        for tick in &mut ticks {
            tick?;
        }
        // An iteration without an error has seen the end record.
        ticks.end().ok_or(ReadError::Truncated { at: ticks.chunks.file.at(), expected: "an end chunk" })
    }
}

/// Iterates over the ticks of a recording; after an error it ends.
#[derive(Clone, Debug)]
pub struct Ticks<'a> {
    chunks: Chunks<'a>,
    chunk: Cursor<'a>,
    before: Samples,
    read: u64,
    end: Option<End>,
    failed: bool,
}

impl Ticks<'_> {
    /// The end record, once every tick was read without an error.
    pub const fn end(&self) -> Option<End> {
        self.end
    }

    fn read(&mut self) -> Result<Option<Tick>, ReadError> {
        while self.chunk.rest().is_empty() {
            let at = self.chunks.file.at();
            match self.chunks.read("a chunk of ticks or the end chunk")? {
                (tag::TICKS, payload) => self.chunk = payload,
                (tag::END, payload) => {
                    self.end = Some(self.finish(payload).map_err(ReadError::within_chunk)?);
                    return Ok(None);
                }
                _ => return Err(ReadError::Malformed { at, expected: "a chunk of ticks or the end chunk" }),
            }
        }
        let tick = tick::decode(&mut self.chunk, &self.before).map_err(ReadError::within_chunk)?;
        self.before.clone_from(&tick.samples);
        self.read = self.read.saturating_add(1);
        Ok(Some(tick))
    }

    fn finish(&self, payload: Cursor<'_>) -> Result<End, ReadError> {
        let end = End::read(payload)?;
        if end.ticks != self.read {
            return Err(ReadError::TickCount { stored: end.ticks, read: self.read });
        }
        self.chunks.ended()?;
        Ok(end)
    }
}

impl Iterator for Ticks<'_> {
    type Item = Result<Tick, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.failed || self.end.is_some() {
            return None;
        }
        let tick = self.read().transpose();
        self.failed = matches!(tick, Some(Err(_)));
        tick
    }
}

/// The chunks of a file, each checked before it is handed out.
#[derive(Clone)]
pub(super) struct Chunks<'a> {
    file: Cursor<'a>,
    crc: crc::Digest<'static, u32>,
}

impl fmt::Debug for Chunks<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Chunks").field("at", &self.file.at()).finish_non_exhaustive()
    }
}

impl<'a> Chunks<'a> {
    pub(super) fn open(bytes: &'a [u8]) -> Result<Self, ReadError> {
        let mut file = Cursor::new(bytes, 0);
        // A file that ends inside the magic is cut short only if what is there agrees.
        if !MAGIC.starts_with(bytes) && !bytes.starts_with(&MAGIC) {
            return Err(ReadError::NotARecording);
        }
        let mut crc = CRC32.digest();
        crc.update(file.take(MAGIC.len(), "the magic \"narxrec\"")?);
        let version = file.u8("the container version")?;
        if version != CONTAINER_VERSION {
            return Err(ReadError::ContainerVersion { found: version });
        }
        crc.update(&[version]);
        Ok(Self { file, crc })
    }

    /// Offset of the next chunk in the file.
    pub(super) const fn at(&self) -> usize {
        self.file.at()
    }

    /// Checks that nothing follows.
    pub(super) const fn ended(&self) -> Result<(), ReadError> {
        if self.file.rest().is_empty() {
            Ok(())
        } else {
            Err(ReadError::TrailingBytes { at: self.file.at() })
        }
    }

    /// The next chunk's tag and payload.
    pub(super) fn read(&mut self, expected: &'static str) -> Result<(u8, Cursor<'a>), ReadError> {
        let start = self.file.clone();
        let tag = self.file.u8(expected)?;
        let length = self.file.u16("a chunk's length")?;
        let payload_at = self.file.at();
        let payload = self.file.take(usize::from(length), "the whole of a chunk")?;
        let at = self.file.at();
        let stored = self.file.u32("a chunk's check value")?;
        let mut head = start;
        self.crc.update(head.take(3, expected)?);
        self.crc.update(payload);
        let computed = self.crc.clone().finalize();
        if stored != computed {
            return Err(ReadError::Checksum { at, stored, computed });
        }
        Ok((tag, Cursor::new(payload, payload_at)))
    }

    /// The next chunk's payload if it has this tag.
    pub(super) fn expect(&mut self, tag: u8, expected: &'static str) -> Result<Cursor<'a>, ReadError> {
        let at = self.file.at();
        match self.read(expected)? {
            (found, payload) if found == tag => Ok(payload),
            _ => Err(ReadError::Malformed { at, expected }),
        }
    }
}

pub(super) fn decode_header(mut from: Cursor<'_>) -> Result<Header<'_>, ReadError> {
    let kind = match from.u8("the kind")? {
        1 => Kind::Drive,
        2 => Kind::Node,
        3 => Kind::TxDriver,
        found => return Err(ReadError::Kind { found }),
    };
    let behaviour_version = from.u16("the behaviour version")?;
    let layout_version = from.u16("the layout version")?;
    let tick_rate = from.u32("the tick rate")?;
    let at = from.at();
    let length = usize::from(from.u8("the label's length")?);
    let label = from.take(length, "the label")?;
    match core::str::from_utf8(label) {
        Ok(label) if length <= LABEL_MAX && from.rest().is_empty() => {
            Ok(Header { kind, behaviour_version, layout_version, tick_rate, label })
        }
        _ => Err(ReadError::Malformed { at, expected: "a label in UTF-8 that ends the header" }),
    }
}
