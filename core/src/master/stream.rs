//! One download from its first request to its last word: the order of the messages, and the place of the
//! words.

use super::assembly::Assembly;
use super::download::Download;
use super::error::{DownloadError, Refusal};
use super::missing::Missing;
use super::requests::Todo;
use crate::bus::narmotion::{FromDrive, ParameterStatus, ToDrive, XmlCommand};
use crate::dictionary::{Dictionary, number};
use core::num::NonZeroU32;

/// Silence after which a stream has ended, microseconds.
const SILENCE: u64 = 500_000;
/// Words that 16-bit addresses reach.
const SCOPE_WORDS: u32 = 1 << 16;

/// A download under way.
#[derive(Clone, Debug)]
pub(super) struct Stream {
    what: Download,
    phase: Phase,
    /// Words of the whole; 0 before they are known.
    pub(super) total: u32,
    /// Words of a log record, when they are known.
    record: Option<NonZeroU32>,
    assembly: Assembly,
    /// A record was received whole, but its number or CRC was wrong.
    spoiled: bool,
    pub(super) missing: Missing,
    pass: Pass,
    /// Passes without a new word that are still allowed.
    left: u8,
    attempts: u8,
}

/// Next step of the download.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// Ask for the length of the whole, or of a log record.
    Length,
    /// Write the first record's index.
    First,
    /// Write the number of records.
    Count,
    /// Command the log: write 0.
    Lower,
    /// Command the log: write 1.
    Raise,
    /// Send the message that starts the stream.
    Start,
    /// The drive sends.
    Stream,
    /// Stop the stream.
    Stop,
}

/// One pass of the drive over the data: from a first word to, exclusive, an end.
#[derive(Clone, Copy, Debug, Default)]
struct Pass {
    begin: u32,
    end: u32,
    /// Place of the next word, if nothing is lost.
    next: u32,
    /// The pass has brought a missing word; for the log, a missing record.
    useful: bool,
    /// Time at which its last words were received, or at which it was started, microseconds.
    received: u64,
}

/// Words that belong to a download.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    /// Place of the first word.
    pub(super) begin: u32,
    /// Place behind the last word.
    pub(super) end: u32,
    pub(super) data: [u16; 3],
}

impl Stream {
    pub(super) fn new(what: Download, attempts: u8) -> Self {
        let left = attempts.max(1);
        let mut stream = Self {
            what,
            phase: Phase::Length,
            total: 0,
            record: None,
            assembly: Assembly::default(),
            spoiled: false,
            missing: Missing::default(),
            pass: Pass::default(),
            left,
            attempts: left,
        };
        if let Download::Scope { words } = what {
            stream.set_total(words.min(SCOPE_WORDS));
        }
        stream
    }

    /// Returns whether nothing is missing, and no answer is still awaited.
    pub(super) fn is_complete(&self) -> bool {
        matches!(self.phase, Phase::Stream | Phase::Start) && self.missing.is_empty()
    }

    /// Returns whether there is nothing to send.
    pub(super) fn is_listening(&self) -> bool {
        self.phase == Phase::Stream
    }

    /// Time at which the stream will have been silent for too long, microseconds; `u64::MAX` outside a
    /// stream.
    pub(super) const fn deadline(&self) -> u64 {
        match self.phase {
            Phase::Stream => self.pass.received.saturating_add(SILENCE),
            _ => u64::MAX,
        }
    }

    /// Returns the next message, once the one before has its answer.
    pub(super) fn next(&mut self, now: u64) -> Option<Todo> {
        if let Some((number, value)) = self.write() {
            return Some(Todo::Ask(ToDrive::SetParameter { number, value }));
        }
        match (self.phase, self.what) {
            (Phase::Length, Download::Log { .. }) => {
                Some(Todo::Ask(ToDrive::RequestParameter { number: number::LOG_RECORD_BYTES }))
            }
            // A request for the length ends a stream, too.
            (Phase::Length | Phase::Stop, _) => Some(Todo::Ask(ToDrive::DownloadXml(XmlCommand::Length))),
            (Phase::Start, _) => {
                self.phase = Phase::Stream;
                self.pass.received = now;
                Some(Todo::Tell(match self.what {
                    Download::Description => ToDrive::DownloadXml(XmlCommand::Start),
                    _ => ToDrive::DownloadScope,
                }))
            }
            _ => None,
        }
    }

    /// Takes the answer to the message under way.
    pub(super) fn answer(&mut self, answer: &FromDrive, now: u64) -> Result<(), DownloadError> {
        match (self.phase, *answer) {
            (_, FromDrive::Parameter { number, value, status }) if status != ParameterStatus::Done => {
                let (parameter, offered) = (Dictionary::row(number), self.write().map(|(_, value)| value));
                let refusal = Refusal { number, parameter, status, offered, stored: value };
                return Err(DownloadError::Refused(refusal));
            }
            (Phase::Length, FromDrive::Parameter { value, .. }) => self.set_record(value.unsigned_abs())?,
            (Phase::Length, FromDrive::XmlLength { words, .. }) => self.set_total(words.into()),
            (Phase::First, _) => self.phase = Phase::Count,
            (Phase::Count, _) => self.phase = Phase::Lower,
            (Phase::Lower, _) => self.phase = Phase::Raise,
            (Phase::Raise, _) => {
                self.phase = Phase::Stream;
                self.pass.received = now;
            }
            _ => {}
        }
        Ok(())
    }

    /// Returns the words of a message that belong to this download.
    pub(super) fn receive(&mut self, message: &FromDrive, now: u64) -> Option<Piece> {
        // The first words may arrive before the answer to the log's command.
        if !matches!(self.phase, Phase::Raise | Phase::Stream) {
            return None;
        }
        let (begin, data) = self.place(message)?;
        self.pass.received = now;
        let end = self.pass.end.min(begin.saturating_add(3));
        (begin < end).then_some(Piece { begin, end, data })
    }

    /// Takes a piece while there is room for `room` chunks; returns whether the caller gets it.
    pub(super) fn take(&mut self, piece: &Piece, room: usize) -> bool {
        if let Some(words) = self.record {
            return self.take_of_record(piece, words, room);
        }
        let taken = room > 0 && self.missing.take(piece.begin, piece.end);
        self.pass.useful |= taken;
        taken
    }

    /// Takes a piece of a log record; returns whether the caller gets it. A record counts once it is complete
    /// and its CRC is right. It is begun only if all of it has room, so that even a slow caller gets one
    /// record after the other.
    fn take_of_record(&mut self, piece: &Piece, words: NonZeroU32, room: usize) -> bool {
        let (place, offset) = (piece.begin / words, piece.begin % words);
        if !self.missing.wants(piece.begin, piece.end) {
            return false;
        }
        if !self.assembly.is_at(place) {
            if room < words.get() as usize / 3 {
                return false;
            }
            self.assembly.begin(place);
        }
        let new = self.assembly.put(offset, piece.data);
        if self.assembly.is_complete(words.get()) {
            let begin = place * words.get();
            let sound = self.assembly.is_sound(self.number_at(place));
            self.pass.useful |= sound && self.missing.take(begin, begin + words.get());
            self.spoiled |= !sound;
            self.assembly = Assembly::default();
        }
        new
    }

    /// Returns whether the pass ends with this piece.
    pub(super) fn is_last(&mut self, piece: &Piece) -> bool {
        let pass = &mut self.pass;
        // A late last piece of the previous pass does not end this one.
        let late = pass.next == pass.begin && piece.begin > pass.begin;
        pass.next = pass.next.max(piece.end);
        self.phase == Phase::Stream && piece.end == pass.end && !late
    }

    /// Returns the error with which the download is given up.
    pub(super) fn failure(&self) -> DownloadError {
        match (self.record, self.missing.first()) {
            (Some(words), Some((begin, _))) if self.spoiled => {
                DownloadError::Spoiled { record: self.number_at(begin / words) }
            }
            _ => DownloadError::NoAnswer,
        }
    }

    /// Returns whether it waits until the caller has taken all chunks: records need room.
    pub(super) fn wants_room(&self) -> bool {
        self.phase == Phase::First
    }

    /// Number of the record at this place of the download.
    fn number_at(&self, place: u32) -> u32 {
        match self.what {
            Download::Log { first, .. } => first.saturating_add(place),
            _ => place,
        }
    }

    /// Prepares another pass for the missing words; returns false after too many passes in vain.
    pub(super) fn again(&mut self) -> bool {
        self.left = if self.pass.useful { self.attempts } else { self.left.saturating_sub(1) };
        self.prepare();
        self.left > 0
    }

    /// Stops the download; returns true if the drive needs a message for that.
    pub(super) fn stop(&mut self) -> bool {
        let stops = self.phase == Phase::Stream && !matches!(self.what, Download::Scope { .. });
        if stops {
            self.phase = Phase::Stop;
        }
        stops
    }

    /// Returns whether the awaited answer begins a stream.
    pub(super) fn is_starting(&self) -> bool {
        self.phase == Phase::Raise
    }

    fn set_total(&mut self, words: u32) {
        self.total = words;
        self.missing = Missing::all(words);
        self.prepare();
    }

    fn set_record(&mut self, bytes: u32) -> Result<(), DownloadError> {
        let Download::Log { records, .. } = self.what else { return Ok(()) };
        let words = Assembly::words(bytes).and_then(NonZeroU32::new).ok_or(DownloadError::NoLog)?;
        self.record = Some(words);
        self.set_total(records.saturating_mul(words.get()));
        Ok(())
    }

    /// Prepares a pass: for the log over the first gap, in whole records; for the other downloads over
    /// everything.
    fn prepare(&mut self) {
        self.phase = Phase::Start;
        self.assembly = Assembly::default();
        self.pass = Pass { end: self.total, ..Pass::default() };
        if let (Some(record), Some((begin, end))) = (self.record, self.missing.first()) {
            self.phase = Phase::First;
            let begin = begin / record * record.get();
            let end = end.div_ceil(record.get()).saturating_mul(record.get()).min(self.total);
            self.pass = Pass { begin, next: begin, end, ..Pass::default() };
        }
    }

    /// The parameter to write now, and its value.
    fn write(&self) -> Option<(u16, i32)> {
        let (Download::Log { first, .. }, Some(record)) = (self.what, self.record) else { return None };
        let Pass { begin, end, .. } = self.pass;
        Some(match self.phase {
            Phase::First => (number::LOG_READ_START, first.saturating_add(begin / record) as i32),
            Phase::Count => (number::LOG_READ_COUNT, (end - begin).div_ceil(record.get()) as i32),
            Phase::Lower | Phase::Stop => (number::LOG_READ_REQUEST, 0),
            Phase::Raise => (number::LOG_READ_REQUEST, 1),
            _ => return None,
        })
    }

    /// Place of a message's first word in the whole, and its words.
    fn place(&self, message: &FromDrive) -> Option<(u32, [u16; 3])> {
        match (self.what, *message) {
            (Download::Description, FromDrive::XmlData { address, data })
            | (Download::Scope { .. }, FromDrive::ScopeData { address, data }) => {
                Some((address.into(), data))
            }
            (Download::Log { .. }, FromDrive::LogData { counter, data }) => {
                let words = self.record?;
                // The counter wraps: it means the place nearest to the expected word.
                let Pass { begin, next, .. } = self.pass;
                let ahead = counter.wrapping_sub((next - begin) as u16) as i16;
                let place = next.checked_add_signed(ahead.into())?;
                // A record consists of whole frames: words that do not begin at a frame of it are rejected.
                let is_frame = (place % words).is_multiple_of(3);
                (place >= begin && is_frame).then_some((place, data))
            }
            _ => None,
        }
    }
}
