//! Makes a recording of the scope's inputs that were downloaded from a drive.

use super::{Header, Kind, RecordError, Recorder, Sink};
use crate::motor::drive::LAYOUT_VERSION;
use crate::motor::{Drive, Event, PwmCommand, Samples};
use crate::scope::{Inputs, MalformedInputs, Segment};
use core::fmt;
use heapless::Vec;

/// Largest serialised drive, bytes.
const STATE_MAX: usize = 4096;

/// A recording made of a download.
#[derive(Clone, Debug)]
pub struct Scoped<S> {
    /// The recording.
    pub sink: S,
    /// Number of its first tick since power-up.
    pub first: u64,
    /// Ticks in it.
    pub ticks: u64,
    /// True if the replay reproduces the drive: from the drive's second checkpoint on, its commands and those
    /// of the replay are the same. `None` where the record has no second checkpoint.
    pub agrees: Option<bool>,
}

/// Reason why a download gave no recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScopedError<E> {
    /// The words are malformed.
    Words(MalformedInputs),
    /// The state of the drive in segment `.0` cannot be read.
    State(usize),
    /// The recording cannot be written.
    Record(RecordError<E>),
}

impl<E: fmt::Display> fmt::Display for ScopedError<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Words(error) => error.fmt(f),
            Self::State(segment) => {
                write!(f, "the drive's state in segment {segment} of the record cannot be read")
            }
            Self::Record(error) => error.fmt(f),
        }
    }
}

impl<E: fmt::Debug + fmt::Display> core::error::Error for ScopedError<E> {}

/// Replays the inputs in `words` (of parameter 301) and records that run to `sink`. The digest is the
/// replay's.
///
/// # Errors
/// The words are damaged or of another version, the label is too long, or the sink refuses.
pub fn record_scoped<S: Sink>(
    words: &[u16],
    label: &str,
    sink: S,
) -> Result<Scoped<S>, ScopedError<S::Error>> {
    let inputs = Inputs::open(words).map_err(ScopedError::Words)?;
    let first = inputs.segments().next().ok_or(ScopedError::Words(MalformedInputs::Words))?;
    let header = Header {
        kind: Kind::Drive,
        behaviour_version: inputs.behaviour_version,
        layout_version: LAYOUT_VERSION,
        tick_rate: inputs.tick_rate,
        label,
    };
    let mut drive = read(first).ok_or(ScopedError::State(0))?;
    let state = bytes(first).ok_or(ScopedError::State(0))?;
    let mut recorder = Recorder::new(sink, &header, &state).map_err(ScopedError::Record)?;
    // The state that the drive kept in the middle shows whether the replay reproduces it.
    let mut witness = None;
    let mut agrees = true;
    for (place, segment) in inputs.segments().enumerate() {
        if place > 0 {
            witness = Some(read(segment).ok_or(ScopedError::State(place))?);
        }
        for tick in segment.ticks() {
            let (event, samples) = tick.map_err(ScopedError::Words)?;
            let command = step(&mut drive, event.as_ref(), &samples);
            if let Some(witness) = &mut witness {
                agrees &= step(witness, event.as_ref(), &samples) == command;
            }
            let status = drive.poll_status();
            recorder
                .record(event.as_ref(), &samples, &command, status.as_ref())
                .map_err(ScopedError::Record)?;
        }
    }
    let agrees = witness.is_some().then_some(agrees);
    let ticks = recorder.ticks();
    let sink = recorder.finish().map_err(ScopedError::Record)?;
    Ok(Scoped { sink, first: first.first, ticks, agrees })
}

fn bytes(segment: &Segment<'_>) -> Option<Vec<u8, STATE_MAX>> {
    let mut bytes = Vec::new();
    for byte in segment.state() {
        bytes.push(byte).ok()?;
    }
    Some(bytes)
}

fn read(segment: &Segment<'_>) -> Option<Drive> {
    match postcard::take_from_bytes(&bytes(segment)?) {
        Ok((drive, [])) => Some(drive),
        _ => None,
    }
}

fn step(drive: &mut Drive, event: Option<&Event>, samples: &Samples) -> PwmCommand {
    if let Some(event) = event {
        drive.handle_event(event.clone());
    }
    drive.step(samples)
}
