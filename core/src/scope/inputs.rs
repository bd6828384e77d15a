//! One tick's inputs in words: both directions, side by side.
//!
//! The format is made for the tick that writes it: values that are the same in nearly every tick cost
//! nothing, and nothing is packed:
//!
//! | words | what |
//! |---|---|
//! | 5 | converter codes: phases A, B, C, bus voltage, bus current |
//! | 1 | hall code, and which of the following are there |
//! | 2 each | edges: instant; code x 2 + source (0 hall, 1 comparator) |
//! | 1 | digital lines, where they changed |
//! | 1 | skew, where it changed |
//! | 1 | edges lost, unless 0 |
//! | 4 | tick number, unless one more than the last |
//! | 1 to 5 | event: its kind, and what it carries |
//!
//! "Changed" is against the tick before; before the first, digital lines and skew are 0. Numbers of several
//! words: low word first.

use crate::motor::machine::event::{Command, Event, RunRequest, SlowMeasurements};
use crate::motor::{CurrentMode, Edge, EdgeSource, Lines, SampleMode, Samples};
use crate::units::{Celsius, ElectricalSpeed, Volts};

/// Largest number of words of a tick.
pub(super) const WORDS_MAX: usize = 6 + 2 * 4 + 1 + 1 + 1 + 4 + 5;

/// Bits of the sixth word above the hall code.
const ON_TIME_SAMPLE: u16 = 1 << 8;
const ON_TIME_CURRENT: u16 = 1 << 9;
/// Number of edges, at most 4.
const EDGES_SHIFT: u32 = 10;
const EDGES: u16 = 7 << EDGES_SHIFT;
const RARE: u16 = 1 << 13;
const EVENT: u16 = 1 << 14;
const ALL: u16 = (1 << 15) - 1;

/// Bits of the word that [`RARE`] announces.
const LINES: u16 = 1 << 0;
const SKEW: u16 = 1 << 1;
const EDGES_LOST: u16 = 1 << 2;
const TICK: u16 = 1 << 3;

/// An event as it is kept.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Note {
    /// There was none.
    #[default]
    Nothing,
    Command(Command),
    SetPoint(ElectricalSpeed),
    Slow(SlowMeasurements),
    CalibrateHall(bool),
    CoefficientsRejected,
    /// Too large, or too rare, to be kept: a new checkpoint is cheaper.
    Checkpoint,
}

impl From<&Event> for Note {
    fn from(event: &Event) -> Self {
        match *event {
            Event::Command(command) => Self::Command(command),
            Event::SetPoint(speed) => Self::SetPoint(speed),
            Event::Slow(slow) => Self::Slow(slow),
            Event::CalibrateHall(on) => Self::CalibrateHall(on),
            Event::CoefficientsRejected => Self::CoefficientsRejected,
            Event::Coefficients(_) | Event::Health(_) => Self::Checkpoint,
        }
    }
}

impl Note {
    /// Returns the event.
    fn event(self) -> Option<Event> {
        Some(match self {
            Self::Nothing | Self::Checkpoint => return None,
            Self::Command(command) => Event::Command(command),
            Self::SetPoint(speed) => Event::SetPoint(speed),
            Self::Slow(slow) => Event::Slow(slow),
            Self::CalibrateHall(on) => Event::CalibrateHall(on),
            Self::CoefficientsRejected => Event::CoefficientsRejected,
        })
    }
}

/// Values of the last tick, with which the next one is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Before {
    pub(super) tick: u64,
    pub(super) lines: Lines,
    pub(super) skew: u16,
}

impl Before {
    pub(super) const START: Self = Self { tick: 0, lines: Lines::empty(), skew: 0 };

    fn of(samples: &Samples) -> Self {
        Self { tick: samples.tick, lines: samples.lines, skew: samples.skew }
    }
}

/// Writes one tick to the beginning of `words`, which has room for [`WORDS_MAX`]; returns the number of words
/// written.
#[inline]
pub(super) fn write(words: &mut [u16], note: Note, samples: &Samples, before: &mut Before) -> usize {
    let Samples { hall, sample_mode, current_mode, .. } = *samples;
    let rare = (*before != Before { tick: samples.tick.wrapping_sub(1), ..Before::of(samples) })
        || samples.edges_lost != 0;
    let mut what = u16::from(hall) | (samples.edges.len() as u16) << EDGES_SHIFT;
    what |= if sample_mode == SampleMode::OnTime { ON_TIME_SAMPLE } else { 0 };
    what |= if current_mode == CurrentMode::OnTime { ON_TIME_CURRENT } else { 0 };
    what |= if rare { RARE } else { 0 };
    what |= if note == Note::Nothing { 0 } else { EVENT };
    let [a, b, c] = samples.phase_voltage;
    let Some((always, rest)) = words.split_first_chunk_mut() else { return 0 };
    *always = [a, b, c, samples.bus_voltage, samples.bus_current, what];
    let more =
        if what & (EDGES | RARE | EVENT) == 0 { 0 } else { write_more(rest, rare, note, samples, before) };
    before.tick = samples.tick;
    always.len() + more
}

#[inline(never)]
fn write_more(words: &mut [u16], rare: bool, note: Note, samples: &Samples, before: &mut Before) -> usize {
    let mut out = Out { words, at: 0 };
    for edge in &samples.edges {
        let source = match edge.source {
            EdgeSource::Hall => 0,
            EdgeSource::Comparator => 1,
        };
        out.push(edge.instant);
        out.push(u16::from(edge.code) << 1 | source);
    }
    if rare {
        let changes = [
            (LINES, before.lines != samples.lines),
            (SKEW, before.skew != samples.skew),
            (EDGES_LOST, samples.edges_lost != 0),
            (TICK, before.tick.wrapping_add(1) != samples.tick),
        ];
        let what = changes.into_iter().fold(0, |what, (bit, is)| if is { what | bit } else { what });
        out.push(what);
        if what & LINES != 0 {
            out.push(samples.lines.bits().into());
        }
        if what & SKEW != 0 {
            out.push(samples.skew);
        }
        if what & EDGES_LOST != 0 {
            out.push(samples.edges_lost.into());
        }
        if what & TICK != 0 {
            out.long(samples.tick as u32);
            out.long((samples.tick >> 32) as u32);
        }
        *before = Before::of(samples);
    }
    write_note(&mut out, note);
    out.at
}

fn write_note(out: &mut Out<'_>, note: Note) {
    match note {
        Note::Nothing | Note::Checkpoint => {}
        Note::Command(Command { request, speed }) => {
            out.push((request as u16) << 8);
            out.long(speed.to_bits() as u32);
        }
        Note::SetPoint(speed) => {
            out.push(1);
            out.long(speed.to_bits() as u32);
        }
        Note::Slow(SlowMeasurements { temperature, pressure }) => {
            out.push(2);
            out.long(temperature.to_bits() as u32);
            out.long(pressure.to_bits() as u32);
        }
        Note::CalibrateHall(on) => out.push(3 | u16::from(on) << 8),
        Note::CoefficientsRejected => out.push(4),
    }
}

/// Reads one tick; `None` if the words are malformed.
pub(super) fn read(words: &mut In<'_>, before: &mut Before) -> Option<(Option<Event>, Samples)> {
    let [a, b, c, bus_voltage, bus_current, what] = words.take()?;
    if what & !ALL != 0 {
        return None;
    }
    let mut samples = Samples {
        tick: before.tick.wrapping_add(1),
        phase_voltage: [a, b, c],
        bus_voltage,
        bus_current,
        sample_mode: if what & ON_TIME_SAMPLE != 0 { SampleMode::OnTime } else { SampleMode::OffTime },
        current_mode: if what & ON_TIME_CURRENT != 0 { CurrentMode::OnTime } else { CurrentMode::Average },
        skew: before.skew,
        hall: what as u8,
        lines: before.lines,
        ..Samples::default()
    };
    for _ in 0..(what & EDGES) >> EDGES_SHIFT {
        let [instant, code] = words.take()?;
        let source = if code & 1 == 0 { EdgeSource::Hall } else { EdgeSource::Comparator };
        let code = u8::try_from(code >> 1).ok()?;
        samples.edges.push(Edge { instant, source, code }).ok()?;
    }
    if what & RARE != 0 {
        let [rare] = words.take()?;
        let byte = |[word]: [u16; 1]| u8::try_from(word).ok();
        if rare & LINES != 0 {
            samples.lines = Lines::from_bits_retain(byte(words.take()?)?);
        }
        if rare & SKEW != 0 {
            [samples.skew] = words.take()?;
        }
        if rare & EDGES_LOST != 0 {
            samples.edges_lost = byte(words.take()?)?;
        }
        if rare & TICK != 0 {
            samples.tick = u64::from(words.long()?) | u64::from(words.long()?) << 32;
        }
    }
    let note = if what & EVENT != 0 { read_note(words)? } else { Note::Nothing };
    *before = Before::of(&samples);
    Some((note.event(), samples))
}

fn read_note(words: &mut In<'_>) -> Option<Note> {
    let [kind] = words.take()?;
    let [detail, kind] = kind.to_be_bytes();
    let mut speed = || Some(ElectricalSpeed::from_bits(words.long()? as i32));
    Some(match (kind, detail) {
        (0, request) => {
            let request = match request {
                0 => RunRequest::Standby,
                1 => RunRequest::Drive,
                2 => RunRequest::Reverse,
                3 => RunRequest::Shutdown,
                _ => return None,
            };
            Note::Command(Command { request, speed: speed()? })
        }
        (1, 0) => Note::SetPoint(speed()?),
        (2, 0) => Note::Slow(SlowMeasurements {
            temperature: Celsius::from_bits(words.long()? as i32),
            pressure: Volts::from_bits(words.long()? as i32),
        }),
        (3, on @ 0..=1) => Note::CalibrateHall(on == 1),
        (4, 0) => Note::CoefficientsRejected,
        _ => return None,
    })
}

/// Destination of words.
struct Out<'a> {
    words: &'a mut [u16],
    at: usize,
}

impl Out<'_> {
    fn push(&mut self, word: u16) {
        if let Some(place) = self.words.get_mut(self.at) {
            *place = word;
            self.at += 1;
        }
    }

    fn long(&mut self, long: u32) {
        self.push(long as u16);
        self.push((long >> 16) as u16);
    }
}

/// Source of words.
#[derive(Clone, Debug)]
pub(super) struct In<'a>(pub(super) &'a [u16]);

impl<'a> In<'a> {
    pub(super) fn take<const N: usize>(&mut self) -> Option<[u16; N]> {
        let (first, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*first)
    }

    pub(super) fn slice(&mut self, words: usize) -> Option<&'a [u16]> {
        let (first, rest) = self.0.split_at_checked(words)?;
        self.0 = rest;
        Some(first)
    }

    pub(super) fn long(&mut self) -> Option<u32> {
        let [low, high] = self.take()?;
        Some(u32::from(low) | u32::from(high) << 16)
    }
}
