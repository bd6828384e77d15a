//! Bulk downloads: the description, the scope's record, the log. Words come with their place, so the caller writes each
//! chunk where it belongs, and what was lost is asked for again.
//!
//! ```text
//!  description   length ----------------------------------> start --> stream --> gaps? start again
//!  scope         ------------------------------------------> start --> stream --> gaps? start again
//!  log           size of a record --> first, number, 0, 1 --> stream --> gaps? first, number, ... of the first gap
//! ```

use super::missing::Missing;
use super::requests::{NotTaken, Refusal, Todo};
use crate::bus::narmotion::{FromDrive, ParameterStatus, ToDrive, XmlCommand};
use crate::dictionary::{Dictionary, number};
use core::fmt;
use core::num::NonZeroU32;
use fixed::types::I4F12;
use heapless::Deque;

/// Chunks that may wait for the caller; what finds no room is asked for again.
const CHUNKS: usize = 16;
/// What 16-bit addresses reach.
const SCOPE_WORDS: u32 = 1 << 16;
/// A stream that says nothing for so long has ended, microseconds.
const SILENCE: u64 = 500_000;

/// What to download.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Download {
    /// The description of the drive (XML).
    Description,
    /// The scope's record.
    Scope {
        /// Its length: selected signals times samples, at most 65 536.
        words: u32,
    },
    /// Records of the log.
    Log {
        /// Index of the first one.
        first: u32,
        /// How many.
        records: u32,
    },
}

/// Up to three words of a download.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chunk {
    /// Place of the first one in the download, words.
    pub offset: u32,
    data: [u16; 3],
    length: u8,
}

impl Chunk {
    /// The words.
    pub fn words(&self) -> &[u16] {
        self.data.get(..usize::from(self.length)).unwrap_or(&self.data)
    }

    /// The words as bytes, high byte first: the description's text.
    pub fn bytes(&self) -> impl Iterator<Item = u8> + '_ {
        self.words().iter().flat_map(|word| word.to_be_bytes())
    }

    /// The words as samples of the scope, per unit of the signal's base (Q3.12).
    pub fn samples(&self) -> impl Iterator<Item = I4F12> + '_ {
        self.words().iter().map(|word| I4F12::from_bits(*word as i16))
    }
}

/// How far a download is, words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Received so far.
    pub received: u32,
    /// Length of the whole.
    pub total: u32,
}

/// Why a download came to nothing, or not to its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DownloadError {
    /// Nothing comes, or nothing more, however often it is asked for.
    NoAnswer,
    /// The drive refuses one of the log's parameters.
    Refused(Refusal),
    /// There is no log memory: a record has no size.
    NoLog,
    /// Ended by [`super::Master::abort_download`].
    Aborted,
}

/// The download under way, its chunks, and its end.
#[derive(Clone, Debug, Default)]
pub(super) struct Transfer {
    active: Option<Active>,
    chunks: Deque<Chunk, CHUNKS>,
    end: Option<Result<u32, DownloadError>>,
}

#[derive(Clone, Debug)]
struct Active {
    what: Download,
    phase: Phase,
    aborted: bool,
    /// Words of the whole; 0 before they are known.
    total: u32,
    missing: Missing,
    pass: Pass,
    /// Passes without a new word that are left.
    left: u8,
    attempts: u8,
}

/// One stream of the drive: from a first word to, exclusive, an end.
#[derive(Clone, Copy, Debug, Default)]
struct Pass {
    begin: u32,
    end: u32,
    /// What comes next, if nothing is lost.
    next: u32,
    /// It has brought a word that was missing.
    useful: bool,
    /// When something was last heard of it, microseconds.
    heard: u64,
}

/// What is asked, or done, next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// How long is it, or a record of it?
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

impl Transfer {
    pub(super) fn begin(&mut self, what: Download, attempts: u8) -> Result<(), NotTaken> {
        if self.active.is_some() || self.end.is_some() {
            return Err(NotTaken::Full);
        }
        let attempts = attempts.max(1);
        let mut active = Active {
            what,
            phase: Phase::Length,
            aborted: false,
            total: 0,
            missing: Missing::default(),
            pass: Pass::default(),
            left: attempts,
            attempts,
        };
        self.chunks.clear();
        if let Download::Scope { words } = what {
            active.set_total(words.min(SCOPE_WORDS));
        }
        self.active = Some(active);
        if matches!(what, Download::Scope { words: 0 }) {
            self.finish_with(Ok(0));
        }
        Ok(())
    }

    pub(super) fn pop(&mut self) -> Option<Chunk> {
        self.chunks.pop_front()
    }

    pub(super) fn progress(&self) -> Option<Progress> {
        let Active { total, missing, .. } = self.active.as_ref()?;
        (*total > 0).then(|| Progress { received: total - missing.count(), total: *total })
    }

    pub(super) fn poll_end(&mut self) -> Option<Result<u32, DownloadError>> {
        if self.chunks.is_empty() { self.end.take() } else { None }
    }

    pub(super) fn abort(&mut self) {
        if let Some(active) = &mut self.active {
            active.aborted = true;
            self.chunks.clear();
        }
    }

    /// Whether there is something to send.
    pub(super) fn is_sending(&self) -> bool {
        self.active.as_ref().is_some_and(|active| active.aborted || active.phase != Phase::Stream)
    }

    /// When a stream has been silent for too long.
    pub(super) fn deadline(&self) -> u64 {
        match &self.active {
            Some(active) if active.phase == Phase::Stream => active.pass.heard.saturating_add(SILENCE),
            _ => u64::MAX,
        }
    }

    /// A stream that is silent has ended.
    pub(super) fn poll(&mut self, now: u64) {
        if now >= self.deadline() {
            self.next_pass();
        }
    }

    /// The next message; what was asked before has its answer.
    pub(super) fn next(&mut self, now: u64) -> Option<Todo> {
        let active = self.active.as_mut()?;
        if active.aborted {
            if active.stop().is_none() {
                self.finish_with(Err(DownloadError::Aborted));
                return None;
            }
            active.phase = Phase::Stop;
        }
        active.next(now)
    }

    /// The message under way was answered, or not.
    pub(super) fn finish(&mut self, answer: Option<&FromDrive>, now: u64) {
        let Some(active) = &mut self.active else { return };
        if active.aborted {
            // A stream that begins with this answer has to be stopped; everything else ends here.
            if active.phase == Phase::Raise {
                active.phase = Phase::Stream;
            } else {
                self.finish_with(Err(DownloadError::Aborted));
            }
            return;
        }
        match answer.ok_or(DownloadError::NoAnswer).and_then(|answer| active.answered(answer, now)) {
            Ok(()) if active.is_complete() => self.finish_with(Ok(self.total())),
            Ok(()) => {}
            Err(error) => self.finish_with(Err(error)),
        }
    }

    /// Takes the words of a message, if they belong to the download.
    pub(super) fn take(&mut self, message: &FromDrive, now: u64) {
        let Some(active) = &mut self.active else { return };
        if active.aborted || !matches!(active.phase, Phase::Raise | Phase::Stream) {
            return;
        }
        let Some((begin, data)) = active.place(message) else { return };
        active.pass.heard = now;
        let end = active.pass.end.min(begin.saturating_add(3));
        if begin >= end {
            return;
        }
        if !self.chunks.is_full() && active.missing.take(begin, end) {
            active.pass.useful = true;
            // Room was just seen.
            let _ = self.chunks.push_back(Chunk { offset: begin, data, length: (end - begin) as u8 });
        }
        // The late end of the pass before is no end of this one.
        let is_first = active.pass.next == active.pass.begin && begin > active.pass.begin;
        active.pass.next = active.pass.next.max(end);
        if active.phase != Phase::Stream {
            return;
        }
        if active.is_complete() {
            self.finish_with(Ok(self.total()));
        } else if end == active.pass.end && !is_first {
            self.next_pass();
        }
    }

    fn total(&self) -> u32 {
        self.active.as_ref().map_or(0, |active| active.total)
    }

    /// Asks for what is missing, unless that was in vain too often.
    fn next_pass(&mut self) {
        let Some(active) = &mut self.active else { return };
        active.left = if active.pass.useful { active.attempts } else { active.left.saturating_sub(1) };
        if active.left == 0 {
            self.finish_with(Err(DownloadError::NoAnswer));
        } else {
            active.prepare_pass();
        }
    }

    fn finish_with(&mut self, end: Result<u32, DownloadError>) {
        self.active = None;
        self.end = Some(end);
    }
}

impl Active {
    fn set_total(&mut self, words: u32) {
        self.total = words;
        self.missing = Missing::all(words);
        self.prepare_pass();
    }

    fn is_complete(&self) -> bool {
        matches!(self.phase, Phase::Stream | Phase::Start) && self.missing.is_empty()
    }

    /// The log is asked for its first gap, in whole records; of the others the drive sends everything.
    fn prepare_pass(&mut self) {
        self.phase = Phase::Start;
        self.pass = Pass { end: self.total, ..Pass::default() };
        let Some((size, _)) = self.log() else { return };
        self.phase = Phase::First;
        if let Some((begin, end)) = self.missing.first() {
            let records = begin / size..end.div_ceil(size.get());
            let begin = records.start * size.get();
            self.pass =
                Pass { begin, next: begin, end: records.end.saturating_mul(size.get()), ..Pass::default() };
        }
    }

    /// Words of a log record, and index of the first one asked for.
    fn log(&self) -> Option<(NonZeroU32, u32)> {
        let Download::Log { first, records } = self.what else { return None };
        let size = NonZeroU32::new(self.total.checked_div(records)?)?;
        Some((size, first))
    }

    /// Index of the first record of this pass, and how many.
    fn records(&self) -> (u32, u32) {
        let Some((size, first)) = self.log() else { return (0, 0) };
        let Pass { begin, end, .. } = self.pass;
        (first.saturating_add(begin / size), (end - begin) / size)
    }

    fn next(&mut self, now: u64) -> Option<Todo> {
        let set = |number, value| Some(Todo::Ask(ToDrive::SetParameter { number, value }));
        let (first, count) = self.records();
        match self.phase {
            Phase::Length => Some(Todo::Ask(match self.what {
                Download::Log { .. } => ToDrive::RequestParameter { number: number::LOG_RECORD_BYTES },
                _ => ToDrive::DownloadXml(XmlCommand::Length),
            })),
            Phase::First => set(number::LOG_READ_START, first as i32),
            Phase::Count => set(number::LOG_READ_COUNT, count as i32),
            Phase::Lower => set(number::LOG_READ_REQUEST, 0),
            Phase::Raise => set(number::LOG_READ_REQUEST, 1),
            Phase::Start => {
                self.phase = Phase::Stream;
                self.pass.heard = now;
                Some(Todo::Tell(match self.what {
                    Download::Description => ToDrive::DownloadXml(XmlCommand::Start),
                    _ => ToDrive::DownloadScope,
                }))
            }
            Phase::Stream => None,
            Phase::Stop => self.stop(),
        }
    }

    /// What stops a stream; nothing stops the scope's, and there is none before the start.
    fn stop(&self) -> Option<Todo> {
        if !matches!(self.phase, Phase::Stream | Phase::Stop) {
            return None;
        }
        Some(Todo::Ask(match self.what {
            Download::Description => ToDrive::DownloadXml(XmlCommand::Length),
            Download::Scope { .. } => return None,
            Download::Log { .. } => ToDrive::SetParameter { number: number::LOG_READ_REQUEST, value: 0 },
        }))
    }

    fn answered(&mut self, answer: &FromDrive, now: u64) -> Result<(), DownloadError> {
        let value = match *answer {
            FromDrive::Parameter { number, value, status } if status != ParameterStatus::Done => {
                let parameter = Dictionary::row(number);
                let refusal = Refusal { number, parameter, status, offered: None, stored: value };
                return Err(DownloadError::Refused(refusal));
            }
            FromDrive::Parameter { value, .. } => value.unsigned_abs(),
            FromDrive::XmlLength { words } => words.into(),
            _ => 0,
        };
        self.phase = match (self.phase, self.what) {
            (Phase::Length, Download::Log { records, .. }) => {
                if value == 0 {
                    return Err(DownloadError::NoLog);
                }
                self.set_total(records.saturating_mul(value.div_ceil(2)));
                return Ok(());
            }
            (Phase::Length, _) => {
                self.set_total(value);
                return Ok(());
            }
            (Phase::First, _) => Phase::Count,
            (Phase::Count, _) => Phase::Lower,
            (Phase::Lower, _) => Phase::Raise,
            (Phase::Raise, _) => {
                self.pass.heard = now;
                Phase::Stream
            }
            (phase, _) => phase,
        };
        Ok(())
    }

    /// Place of a message's first word in the whole, and its words.
    fn place(&self, message: &FromDrive) -> Option<(u32, [u16; 3])> {
        match (self.what, *message) {
            (Download::Description, FromDrive::XmlData { address, data })
            | (Download::Scope { .. }, FromDrive::ScopeData { address, data }) => {
                Some((address.into(), data))
            }
            (Download::Log { .. }, FromDrive::LogData { counter, data }) => {
                // The counter wraps: the nearest place to what comes next.
                let Pass { begin, next, .. } = self.pass;
                let ahead = counter.wrapping_sub((next - begin) as u16) as i16;
                let place = next.checked_add_signed(ahead.into())?;
                (place >= begin).then_some((place, data))
            }
            _ => None,
        }
    }
}

impl fmt::Display for DownloadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoAnswer => f.write_str("nothing comes from the drive, or nothing more"),
            Self::Refused(refusal) => refusal.fmt(f),
            Self::NoLog => f.write_str("there is no log memory"),
            Self::Aborted => f.write_str("the download was aborted"),
        }
    }
}

impl core::error::Error for DownloadError {}
