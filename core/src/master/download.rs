//! Bulk downloads: the description, the scope's record, the log. Each chunk states its place, so the caller
//! writes it where it belongs, and lost words are requested again.
//!
//! ```text
//!  description   length ----------------------------------> start --> stream --> gaps? start again
//!  scope         ------------------------------------------> start --> stream --> gaps? start again
//!  log           size of a record --> first, number, 0, 1 --> stream --> gaps? first, number, ... of the first gap
//! ```
//!
//! A log record counts as received once it is whole and its CRC is right.

use super::error::{DownloadError, NotTaken};
use super::requests::Todo;
use super::stream::{Piece, Stream};
use crate::bus::narmotion::FromDrive;
use crate::storage::record::RECORD_MAX;
use fixed::types::I4F12;
use heapless::Deque;

/// Chunks that may wait for the caller: as many as the longest log record has. A chunk without room is
/// requested again.
const CHUNKS: usize = RECORD_MAX / 6;

/// The data to download.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Download {
    /// The description of the drive (XML).
    Description,
    /// The scope's record.
    Scope {
        /// Its length: selected signals times samples, at most 65 536.
        words: u32,
    },
    /// Records of the log. Each has the size that parameter 69 states, and was checked; a record that the
    /// drive cannot read is all zeros.
    Log {
        /// Index of the first one.
        first: u32,
        /// Number of records.
        records: u32,
    },
}

/// Up to three words of a download.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chunk {
    /// Place of the first word in the download, words.
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

/// Progress of a download, words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Received so far.
    pub received: u32,
    /// Length of the whole.
    pub total: u32,
}

/// The download under way, its chunks, and its end.
#[derive(Clone, Debug, Default)]
pub(super) struct Transfer {
    stream: Option<Stream>,
    aborted: bool,
    chunks: Deque<Chunk, CHUNKS>,
    end: Option<Result<u32, DownloadError>>,
}

impl Transfer {
    pub(super) fn begin(&mut self, what: Download, attempts: u8) -> Result<(), NotTaken> {
        if self.stream.is_some() || self.end.is_some() {
            return Err(NotTaken::Full);
        }
        self.chunks.clear();
        self.aborted = false;
        self.stream = Some(Stream::new(what, attempts));
        self.end_if_complete();
        Ok(())
    }

    pub(super) fn pop(&mut self) -> Option<Chunk> {
        self.chunks.pop_front()
    }

    pub(super) fn progress(&self) -> Option<Progress> {
        let Stream { total, missing, .. } = self.stream.as_ref()?;
        (*total > 0).then(|| Progress { received: total - missing.count(), total: *total })
    }

    pub(super) fn poll_end(&mut self) -> Option<Result<u32, DownloadError>> {
        if self.chunks.is_empty() { self.end.take() } else { None }
    }

    pub(super) fn abort(&mut self) {
        if self.stream.is_some() {
            self.aborted = true;
            self.chunks.clear();
        }
    }

    /// Returns whether there is something to send.
    pub(super) fn is_sending(&self) -> bool {
        let waits = |stream: &Stream| stream.wants_room() && !self.chunks.is_empty();
        self.stream.as_ref().is_some_and(|stream| self.aborted || !(stream.is_listening() || waits(stream)))
    }

    /// Time at which the drive will have been silent for too long, microseconds.
    pub(super) fn deadline(&self) -> u64 {
        self.stream.as_ref().map_or(u64::MAX, Stream::deadline)
    }

    /// Requests the missing words once the drive has been silent for too long.
    pub(super) fn poll(&mut self, now: u64) {
        if now >= self.deadline() {
            self.again();
        }
    }

    /// Returns the next message, once the one before has its answer.
    pub(super) fn next(&mut self, now: u64) -> Option<Todo> {
        let stream = self.stream.as_mut()?;
        if self.aborted && !stream.stop() {
            self.end_with(Err(DownloadError::Aborted));
            return None;
        }
        if stream.wants_room() && !self.chunks.is_empty() {
            return None;
        }
        stream.next(now)
    }

    /// Takes the answer to the message under way; `None` if none came.
    pub(super) fn finish(&mut self, answer: Option<&FromDrive>, now: u64) {
        let Some(stream) = &mut self.stream else { return };
        let starting = stream.is_starting();
        let result = match answer {
            Some(answer) => stream.answer(answer, now),
            None => Err(DownloadError::NoAnswer),
        };
        match result {
            // A stream that has just begun has to be stopped first.
            Ok(()) if self.aborted && starting => {}
            _ if self.aborted => self.end_with(Err(DownloadError::Aborted)),
            Ok(()) => self.end_if_complete(),
            Err(error) => self.end_with(Err(error)),
        }
    }

    /// Takes the words of a message, if they belong to the download.
    pub(super) fn take(&mut self, message: &FromDrive, now: u64) {
        if self.aborted {
            return;
        }
        let Some(stream) = &mut self.stream else { return };
        let Some(piece) = stream.receive(message, now) else { return };
        let Piece { begin, end, data } = piece;
        let wanted = stream.take(&piece, CHUNKS - self.chunks.len());
        let is_last = stream.is_last(&piece);
        if wanted {
            // There is room: `take` was told how much.
            let _ = self.chunks.push_back(Chunk { offset: begin, data, length: (end - begin) as u8 });
        }
        self.end_if_complete();
        if is_last {
            self.again();
        }
    }

    /// Requests the missing words, or ends the download after too many attempts in vain.
    fn again(&mut self) {
        if let Some(stream) = &mut self.stream
            && !stream.again()
        {
            let failure = stream.failure();
            self.end_with(Err(failure));
        }
    }

    fn end_if_complete(&mut self) {
        if let Some(stream) = &self.stream
            && stream.is_complete()
        {
            let total = stream.total;
            self.end_with(Ok(total));
        }
    }

    fn end_with(&mut self, end: Result<u32, DownloadError>) {
        self.stream = None;
        self.end = Some(end);
    }
}
