//! Reads a transcript and replays it: every chunk is checked before anything in it is used.

use super::{AGAIN, Answers, CALLS_VERSION, Transcribable};
use crate::recording::bytes::Cursor;
use crate::recording::read::{Chunks, End, decode_header};
use crate::recording::{BEHAVIOUR_VERSION, Header, Outcome, Prefix, ReadError, ReplayError, tag};
use core::marker::PhantomData;

/// A transcript in memory.
#[derive(Clone, Debug)]
pub struct Transcript<'a> {
    header: Header<'a>,
    setup: &'a [u8],
    body: Chunks<'a>,
}

impl<'a> Transcript<'a> {
    /// Reads the header and the set-up of the device.
    ///
    /// # Errors
    /// The bytes are no recording, or one of a drive's ticks.
    pub fn open(file: &'a [u8]) -> Result<Self, ReadError> {
        let mut body = Chunks::open(file)?;
        let payload = body.expect(tag::HEADER, "a header chunk")?;
        let header = decode_header(payload).map_err(ReadError::within_chunk)?;
        if !header.kind.is_transcript() {
            return Err(ReadError::Kind { found: header.kind as u8 });
        }
        header.check_layout(CALLS_VERSION)?;
        let setup = body.expect(tag::STATE, "a state chunk")?.rest();
        Ok(Self { header, setup, body })
    }

    /// Header of the transcript.
    pub const fn header(&self) -> &Header<'a> {
        &self.header
    }

    /// The calls in order. Bytes that are none of this device's calls are an error in their place.
    pub fn calls<D: Transcribable>(&self) -> Calls<'a, D> {
        Calls {
            chunks: self.body.clone(),
            chunk: Cursor::new(&[], 0),
            last: None,
            again: 0,
            read: 0,
            end: None,
            device: PhantomData,
        }
    }

    /// Powers up the device as recorded.
    ///
    /// # Errors
    /// It is another device, or one of a build with other features.
    pub fn power_up<D: Transcribable>(&self) -> Result<D, ReplayError> {
        if self.header.kind != D::KIND {
            return Err(ReadError::Kind { found: self.header.kind as u8 }.into());
        }
        match postcard::take_from_bytes::<D::Setup>(self.setup) {
            Ok((setup, [])) => D::power_up(setup),
            _ => Err(ReplayError::State),
        }
    }
}

/// The calls of a transcript.
#[derive(Debug)]
pub struct Calls<'a, D: Transcribable> {
    chunks: Chunks<'a>,
    chunk: Cursor<'a>,
    last: Option<D::Call>,
    again: u64,
    read: u64,
    end: Option<End>,
    device: PhantomData<D>,
}

impl<D: Transcribable> Calls<'_, D> {
    /// Reads the next call; `None` after the last one, when the end record has been read.
    ///
    /// # Errors
    /// The transcript is damaged here.
    pub fn read(&mut self) -> Result<Option<&D::Call>, ReadError> {
        if self.end.is_some() {
            return Ok(None);
        }
        if self.again == 0 && !self.next()? {
            return Ok(None);
        }
        self.again -= 1;
        self.read = self.read.saturating_add(1);
        Ok(self.last.as_ref())
    }

    /// Reads a record: a call that is now to be made `again` times. False at the end.
    fn next(&mut self) -> Result<bool, ReadError> {
        const EXPECTED: &str = "a chunk of calls or the end chunk";
        while self.chunk.rest().is_empty() {
            let at = self.chunks.at();
            match self.chunks.read(EXPECTED)? {
                (tag::CALLS, payload) => self.chunk = payload,
                (tag::END, payload) => {
                    let end = End::read(payload).map_err(ReadError::within_chunk)?;
                    if end.ticks != self.read {
                        return Err(ReadError::TickCount { stored: end.ticks, read: self.read });
                    }
                    self.chunks.ended()?;
                    self.end = Some(end);
                    return Ok(false);
                }
                _ => return Err(ReadError::Malformed { at, expected: EXPECTED }),
            }
        }
        let at = self.chunk.at();
        if self.chunk.rest().first() == Some(&AGAIN) {
            self.chunk.take(1, "a repetition").map_err(ReadError::within_chunk)?;
            self.again =
                self.chunk.varint("how often a call is repeated").map_err(ReadError::within_chunk)?;
            if self.again == 0 || self.last.is_none() {
                return Err(ReadError::Malformed { at, expected: "a call that can be repeated" });
            }
            return Ok(true);
        }
        let rest = self.chunk.rest();
        let Ok((call, behind)) = postcard::take_from_bytes::<D::Call>(rest) else {
            return Err(ReadError::Malformed { at, expected: "a call that this device knows" });
        };
        self.chunk.take(rest.len() - behind.len(), "a call")?;
        (self.last, self.again) = (Some(call), 1);
        Ok(true)
    }
}

/// Replays the calls of a transcript to a device.
struct Player<'a, D: Transcribable> {
    device: D,
    calls: Calls<'a, D>,
    clock: u64,
    answers: Answers,
}

impl<'a, D: Transcribable> Player<'a, D> {
    fn new(transcript: &Transcript<'a>) -> Result<Self, ReplayError> {
        let (device, calls) = (transcript.power_up()?, transcript.calls());
        Ok(Self { device, calls, clock: 0, answers: Answers::default() })
    }

    /// Replays one call; false after the last one.
    fn step(&mut self) -> Result<bool, ReplayError> {
        let Some(call) = self.calls.read()? else { return Ok(false) };
        self.device.call(call, &mut self.clock, &mut self.answers);
        Ok(true)
    }

    /// The digest, including the device's visible state now.
    fn digest(mut self) -> u64 {
        self.device.show(&mut self.answers);
        self.answers.value()
    }
}

/// Powers up a device as recorded and repeats the calls of the transcript. In the outcome, `ticks` are calls.
///
/// # Errors
/// The transcript cannot be read, is one of another device, or needs features that this build does not have.
pub fn replay<D: Transcribable>(transcript: &Transcript<'_>) -> Result<Outcome, ReplayError> {
    let mut player = Player::<D>::new(transcript)?;
    while player.step()? {}
    let recorded_digest = player.calls.end.map_or(0, |end| end.digest);
    let version = transcript.header.behaviour_version;
    Ok(Outcome {
        ticks: player.calls.read,
        recorded_digest,
        digest: player.digest(),
        other_behaviour: (version != BEHAVIOUR_VERSION).then_some(version),
    })
}

/// Replays the first `calls` calls of a transcript: bisection finds the call in which two targets differ.
///
/// # Errors
/// As [`replay`], for as much as is read.
pub fn replay_until<D: Transcribable>(
    transcript: &Transcript<'_>,
    calls: u64,
) -> Result<Prefix, ReplayError> {
    let mut player = Player::<D>::new(transcript)?;
    while player.calls.read < calls && player.step()? {}
    Ok(Prefix { ticks: player.calls.read, digest: player.digest(), last: None })
}
