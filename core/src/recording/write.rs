//! Writing a recording, chunk by chunk.

use super::bytes::Payload;
use super::{CONTAINER_VERSION, CRC32, Digest, Header, LABEL_MAX, MAGIC, RecordError, tag, tick};
use crate::motor::machine::event::{Event, Status};
use crate::motor::{PwmCommand, Samples};
use core::fmt;
use heapless::Vec;

/// Destination of a recording.
pub trait Sink {
    /// Error of the sink.
    type Error;
    /// Appends all of `bytes`.
    fn write(&mut self, bytes: &[u8]) -> Result<(), Self::Error>;
}

/// A sink of fixed size has no room left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Full;

impl fmt::Display for Full {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "no room left")
    }
}

impl<const N: usize> Sink for Vec<u8, N> {
    type Error = Full;
    fn write(&mut self, bytes: &[u8]) -> Result<(), Full> {
        self.extend_from_slice(bytes).map_err(|_| Full)
    }
}

/// Records one drive: [`new`](Self::new), [`record`](Self::record) once a tick, [`finish`](Self::finish).
#[derive(Clone, Debug)]
pub struct Recorder<S> {
    output: Output<S>,
    payload: Payload,
    before: Samples,
    ticks: u64,
    digest: Digest,
}

impl<S: Sink> Recorder<S> {
    /// Begins a recording with the drive's serialised `state` before the first recorded tick.
    pub fn new(sink: S, header: &Header<'_>, state: &[u8]) -> Result<Self, RecordError<S::Error>> {
        Ok(Self {
            output: Output::begin(sink, header, state)?,
            payload: Payload::new(),
            before: Samples::default(),
            ticks: 0,
            digest: Digest::default(),
        })
    }

    /// Records a tick: the event taken before it, its samples, and (in the digest) its answer.
    pub fn record(
        &mut self,
        event: Option<&Event>,
        samples: &Samples,
        command: &PwmCommand,
        status: Option<&Status>,
    ) -> Result<(), RecordError<S::Error>> {
        if !self.append(event, samples) {
            self.flush()?;
            if !self.append(event, samples) {
                return Err(RecordError::EventTooLong);
            }
        }
        self.before.clone_from(samples);
        self.ticks = self.ticks.saturating_add(1);
        self.digest.update(command, status);
        Ok(())
    }

    /// Ticks recorded so far.
    pub const fn ticks(&self) -> u64 {
        self.ticks
    }

    /// Digest of the outputs so far.
    pub fn digest(&self) -> u64 {
        self.digest.value()
    }

    /// Writes the end record and hands the sink back.
    pub fn finish(mut self) -> Result<S, RecordError<S::Error>> {
        self.flush()?;
        self.output.end(self.ticks, self.digest.value())
    }

    /// Appends to the chunk in the making; false, with nothing changed, when it does not fit.
    fn append(&mut self, event: Option<&Event>, samples: &Samples) -> bool {
        let mark = self.payload.len();
        let fits = tick::encode(&mut self.payload, event, samples, &self.before).is_some();
        if !fits {
            self.payload.truncate(mark);
        }
        fits
    }

    fn flush(&mut self) -> Result<(), RecordError<S::Error>> {
        if !self.payload.is_empty() {
            self.output.chunk(tag::TICKS, &self.payload)?;
            self.payload.clear();
        }
        Ok(())
    }
}

/// The sink with the running check.
#[derive(Clone)]
pub(super) struct Output<S> {
    sink: S,
    crc: crc::Digest<'static, u32>,
}

impl<S: fmt::Debug> fmt::Debug for Output<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Output").field("sink", &self.sink).finish_non_exhaustive()
    }
}

impl<S: Sink> Output<S> {
    /// Writes everything before the first tick or call.
    pub(super) fn begin(sink: S, header: &Header<'_>, state: &[u8]) -> Result<Self, RecordError<S::Error>> {
        let mut output = Self { sink, crc: CRC32.digest() };
        output.write(&MAGIC)?;
        output.write(&[CONTAINER_VERSION])?;
        let payload = encode_header(header).ok_or(RecordError::LabelTooLong)?;
        output.chunk(tag::HEADER, &payload)?;
        if state.len() > usize::from(u16::MAX) {
            return Err(RecordError::StateTooLong);
        }
        output.chunk(tag::STATE, state)?;
        Ok(output)
    }

    /// Writes the end record and hands the sink back.
    pub(super) fn end(mut self, count: u64, digest: u64) -> Result<S, RecordError<S::Error>> {
        let mut end = Vec::<u8, 16>::new();
        // Sixteen bytes fit in sixteen.
        let _ = end.extend_from_slice(&count.to_le_bytes());
        let _ = end.extend_from_slice(&digest.to_le_bytes());
        self.chunk(tag::END, &end)?;
        Ok(self.sink)
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), RecordError<S::Error>> {
        self.crc.update(bytes);
        self.sink.write(bytes).map_err(RecordError::Sink)
    }

    /// Writes a chunk; `payload` is no longer than 65 535 bytes.
    pub(super) fn chunk(&mut self, tag: u8, payload: &[u8]) -> Result<(), RecordError<S::Error>> {
        let [low, high] = (payload.len() as u16).to_le_bytes();
        self.write(&[tag, low, high])?;
        self.write(payload)?;
        let check = self.crc.clone().finalize();
        self.sink.write(&check.to_le_bytes()).map_err(RecordError::Sink)
    }
}

fn encode_header(header: &Header<'_>) -> Option<Vec<u8, { LABEL_MAX + 10 }>> {
    let mut out = Vec::new();
    out.push(header.kind as u8).ok()?;
    out.extend_from_slice(&header.behaviour_version.to_le_bytes()).ok()?;
    out.extend_from_slice(&header.layout_version.to_le_bytes()).ok()?;
    out.extend_from_slice(&header.tick_rate.to_le_bytes()).ok()?;
    out.push(header.label.len() as u8).ok()?;
    out.extend_from_slice(header.label.as_bytes()).ok()?;
    Some(out)
}
