//! Encodes a record as words for the bus, and decodes the words of a recording.
//!
//! For signals, the words are the samples. For inputs (numbers of several words: low word first):
//!
//! | words | what |
//! |---|---|
//! | 1 | [`FORMAT`] |
//! | 2 | [`LAYOUT_VERSION`], [`BEHAVIOUR_VERSION`] |
//! | 2 | control ticks a second |
//! | 1 | number of segments, 1 or 2, each: |
//! | 4 | number of its first tick |
//! | 3 | number of its ticks; bytes of the state; words of the inputs |
//! | | state of the drive before its first tick, postcard, two bytes a word, low byte first |
//! | | inputs, tick by tick |
//!
//! The second segment goes on where the first ends. Its state shows whether a replay of the first reproduces
//! the drive.

use super::inputs::{self, Before, In};
use super::memory::{Half, Memory, Record};
use super::{Block, RECORDER};
use crate::motor::drive::{BEHAVIOUR_VERSION, LAYOUT_VERSION};
use crate::motor::{Drive, Event, Samples};
use core::fmt;
use heapless::Vec;

/// First word of a recording.
const FORMAT: u16 = 0x4e01;

const HEAD: usize = 6;
const SEGMENT_HEAD: usize = 7;

/// Bytes of one piece of a state. The state is serialised anew for each piece, because there is no room for
/// all of it.
const PIECE: usize = 96;

/// Reads a record word by word, from the first.
#[derive(Clone, Debug)]
pub(super) struct Reader {
    address: u16,
    words: u16,
    /// Bytes of each state.
    states: [u16; 2],
    piece: Vec<u8, PIECE>,
    /// Segment and first byte of the piece.
    at: (usize, usize),
}

impl Memory {
    /// Words of the record.
    pub(super) fn record_words(&self) -> u16 {
        Reader::new(self).words
    }

    /// Reads the record from its first word.
    pub(super) fn read(&mut self) {
        self.reader = Some(Reader::new(self));
    }

    /// Reads the next three words, while the record is downloaded.
    pub(super) fn next(&mut self) -> Option<Block> {
        let mut reader = self.reader.take()?;
        let block = reader.next(self)?;
        self.reader = (!block.last).then_some(reader);
        Some(block)
    }
}

impl Reader {
    fn new(memory: &Memory) -> Self {
        let mut states = [0; 2];
        let words = match memory.record {
            Record::Nothing => 0,
            Record::Signals { words, .. } => words,
            Record::Inputs { halves, count, .. } if RECORDER => {
                let mut words = HEAD;
                for (half, bytes) in halves.iter().take(count.into()).zip(&mut states) {
                    *bytes = checkpoint(memory, *half).map_or(0, size);
                    words += SEGMENT_HEAD + usize::from(bytes.div_ceil(2)) + usize::from(half.words);
                }
                words as u16
            }
            Record::Inputs { .. } => 0,
        };
        Self { address: 0, words, states, piece: Vec::new(), at: (0, 0) }
    }

    fn next(&mut self, memory: &Memory) -> Option<Block> {
        let from = self.address;
        if from >= self.words {
            return None;
        }
        let mut block = Block { address: from, ..Block::default() };
        for (word, place) in block.words.iter_mut().zip(from..self.words) {
            *word = self.word(memory, place.into());
        }
        self.address = from.saturating_add(block.words.len() as u16);
        block.last = self.address >= self.words;
        Some(block)
    }

    fn word(&mut self, memory: &Memory, place: usize) -> u16 {
        match memory.record {
            Record::Nothing => 0,
            Record::Signals { oldest, words } => {
                let place = place + usize::from(oldest);
                let place = place.checked_sub(words.into()).unwrap_or(place);
                memory.words.get(place).copied().unwrap_or(0)
            }
            Record::Inputs { rate, halves, count } if RECORDER => {
                let head = [
                    FORMAT,
                    LAYOUT_VERSION,
                    BEHAVIOUR_VERSION,
                    rate as u16,
                    (rate >> 16) as u16,
                    count.into(),
                ];
                if let Some(word) = head.get(place) {
                    return *word;
                }
                let mut place = place - HEAD;
                for (segment, half) in halves.into_iter().take(count.into()).enumerate() {
                    match self.word_of(memory, segment, half, place) {
                        Ok(word) => return word,
                        Err(rest) => place = rest,
                    }
                }
                0
            }
            Record::Inputs { .. } => 0,
        }
    }

    /// A word of a segment; if `place` is behind the segment, `Err` with the place counted from its end.
    fn word_of(&mut self, memory: &Memory, segment: usize, half: Half, place: usize) -> Result<u16, usize> {
        let bytes = self.states.get(segment).copied().unwrap_or(0);
        let [a, b, c, d] = [0, 16, 32, 48].map(|shift| (half.first >> shift) as u16);
        let head = [a, b, c, d, half.ticks, bytes, half.words];
        if let Some(word) = head.get(place) {
            return Ok(*word);
        }
        let place = place - SEGMENT_HEAD;
        let state = usize::from(bytes.div_ceil(2));
        if place < state {
            let low = self.byte(memory, segment, half, place * 2);
            let high = self.byte(memory, segment, half, place * 2 + 1);
            return Ok(u16::from_le_bytes([low, high]));
        }
        memory
            .inputs(half)
            .get(place - state)
            .copied()
            .ok_or((place - state).saturating_sub(half.words.into()))
    }

    /// A byte of a state.
    fn byte(&mut self, memory: &Memory, segment: usize, half: Half, place: usize) -> u8 {
        let begin = place - place % PIECE;
        if self.at != (segment, begin) || self.piece.is_empty() {
            self.piece.clear();
            self.at = (segment, begin);
            if let Some(drive) = checkpoint(memory, half) {
                let (piece, mut before) = (&mut self.piece, begin);
                drive.write_state(&mut |byte| match before.checked_sub(1) {
                    Some(left) => {
                        before = left;
                        true
                    }
                    None => piece.push(byte).is_ok(),
                });
            }
        }
        self.piece.get(place - begin).copied().unwrap_or(0)
    }
}

fn checkpoint(memory: &Memory, half: Half) -> Option<&Drive> {
    memory.checkpoints.get(usize::from(half.place))?.as_ref()
}

/// Bytes of the drive's serialised state.
fn size(drive: &Drive) -> u16 {
    let mut bytes = 0;
    drive.write_state(&mut |_| {
        bytes += 1;
        true
    });
    bytes
}

/// A recording as it was downloaded: words of parameter 301.
#[derive(Clone, Debug)]
pub struct Inputs<'a> {
    /// Control ticks a second.
    pub tick_rate: u32,
    /// [`BEHAVIOUR_VERSION`] of the drive that recorded it.
    pub behaviour_version: u16,
    segments: [Option<Segment<'a>>; 2],
}

/// Inputs since a checkpoint.
#[derive(Clone, Debug)]
pub struct Segment<'a> {
    /// Number of the first tick.
    pub first: u64,
    /// Number of ticks.
    pub ticks: u16,
    /// State of the drive before the first tick: postcard, two bytes a word.
    state: &'a [u16],
    state_bytes: usize,
    inputs: &'a [u16],
}

/// Reason why the words are no recording of this version.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MalformedInputs {
    /// The first word is not that of a recording.
    Format(u16),
    /// Another layout of the state.
    Layout(u16),
    /// The words end too early, or have impossible values.
    Words,
}

impl fmt::Display for MalformedInputs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Format(word) => {
                write!(f, "word 0 of the record is {word:#06x}, a recording begins with {FORMAT:#06x}")
            }
            Self::Layout(found) => {
                write!(f, "the drive's state has layout {found}, this version reads layout {LAYOUT_VERSION}")
            }
            Self::Words => write!(f, "the record ends too early or is damaged"),
        }
    }
}

impl core::error::Error for MalformedInputs {}

impl<'a> Inputs<'a> {
    /// Reads the head and finds the segments. Words behind the last one are ignored.
    ///
    /// # Errors
    /// See [`MalformedInputs`]; inputs of the ticks are looked at by [`Segment::ticks`].
    pub fn open(words: &'a [u16]) -> Result<Self, MalformedInputs> {
        let mut from = In(words);
        let malformed = MalformedInputs::Words;
        let [format, layout, behaviour_version] = from.take().ok_or(malformed)?;
        if format != FORMAT {
            return Err(MalformedInputs::Format(format));
        }
        if layout != LAYOUT_VERSION {
            return Err(MalformedInputs::Layout(layout));
        }
        let tick_rate = from.long().ok_or(malformed)?;
        let [count] = from.take().ok_or(malformed)?;
        if !(1..=2).contains(&count) {
            return Err(malformed);
        }
        let mut segments = [None, None];
        for segment in segments.iter_mut().take(count.into()) {
            *segment = Some(Segment::open(&mut from).ok_or(malformed)?);
        }
        Ok(Self { tick_rate, behaviour_version, segments })
    }

    /// The one or two segments, in order.
    pub fn segments(&self) -> impl Iterator<Item = &Segment<'a>> {
        self.segments.iter().flatten()
    }
}

impl<'a> Segment<'a> {
    fn open(from: &mut In<'a>) -> Option<Self> {
        let [low, high] = [from.long()?, from.long()?];
        let [ticks, bytes, words] = from.take()?;
        let state = from.slice(bytes.div_ceil(2).into())?;
        let inputs = from.slice(words.into())?;
        Some(Self {
            first: u64::from(low) | u64::from(high) << 32,
            ticks,
            state,
            state_bytes: bytes.into(),
            inputs,
        })
    }

    /// The state's bytes: postcard.
    pub fn state(&self) -> impl Iterator<Item = u8> + 'a {
        self.state.iter().flat_map(|word| word.to_le_bytes()).take(self.state_bytes)
    }

    /// Its ticks: the event that the drive took, and its samples.
    pub fn ticks(&self) -> impl Iterator<Item = Result<(Option<Event>, Samples), MalformedInputs>> + 'a {
        let mut from = In(self.inputs);
        let mut before = Before { tick: self.first.wrapping_sub(1), ..Before::START };
        (0..self.ticks).map(move |_| inputs::read(&mut from, &mut before).ok_or(MalformedInputs::Words))
    }
}
