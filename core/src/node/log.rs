//! The node's side of the log: sampling, making of records, and downloads.
//!
//! ```text
//!   slots 29 to 65 -> samples, every ms -> Entry -> Request::Append
//!   parameters 67, 68, 75 -> Request::Read -> Record -> frames, behind everything else
//!   parameter 76 -> Request::Erase, piece by piece
//! ```

use super::Node;
use crate::bus::Frame;
use crate::bus::narmotion::{FromDrive, Opcode, ParameterStatus, SIGNALS, Words};
use crate::dictionary::{Dictionary, number};
use crate::motor::machine::state::State;
use crate::storage::record::VALUES;
use crate::storage::{Entry, FlashTask, Memory, Record};
use core::num::NonZeroU64;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// An empty slot.
const NOTHING: u16 = 0xFFFF;
/// First slot value that names a word of a frame of the drive: the value is this + opcode * 4 + word.
const SIGNAL_FIRST: u16 = 0x2000;

/// Logging state (Table 8, bits 20:16).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
enum LogState {
    BootUp = 0,
    Init = 1,
    WaitPeriod = 2,
    Write = 3,
    ReadInit = 4,
    SendRead = 5,
    WaitRead = 7,
    SendFrames = 8,
    Erasing = 9,
    EraseEnd = 10,
    ReadEnd = 11,
}

/// Kind of value that is kept of a slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Keep {
    Live,
    Smallest,
    Largest,
    Mean,
}

/// The log.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Log {
    memory: Memory,
    /// Smallest, largest or sum of each slot since the last record.
    kept: Vec<i64, VALUES>,
    samples: u32,
    sampled: u64,
    /// No slot is chosen, according to the last search; a change of slots clears this.
    empty: bool,
    /// Tick of the next record, never 0; `None` while nothing is logged.
    due: Option<NonZeroU64>,
    /// A record that waits for the flash.
    entry: Option<Entry>,
    /// A record is being written.
    writing: bool,
    /// An erase was requested, or goes on.
    erase: bool,
    download: Option<Download>,
    /// Operation that has ended since the last status word.
    ended: Option<Ended>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Ended {
    Read,
    Erase,
}

/// A range of records on its way to the master.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Download {
    next: u32,
    end: u32,
    /// Frames of each record: the same for all, so that a master can compute a record's place.
    frames: u8,
    /// Words sent, modulo 2^16.
    counter: u16,
    step: Step,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant, reason = "one of them exists, and there is no heap")]
enum Step {
    Requested,
    Due,
    Asked,
    Sending { record: Record, frame: u8 },
}

impl Log {
    /// Takes the state of the log memory from the flash.
    pub(super) const fn set_memory(&mut self, memory: Memory) {
        self.memory = memory;
    }

    /// Begins sampling anew, because chosen slots or the period have changed.
    pub(super) fn restart(&mut self) {
        self.kept.clear();
        (self.samples, self.due, self.empty) = (0, None, false);
    }

    /// Returns the log's next request to the flash: new records first, because they have a fixed time.
    pub(super) fn next_request(&mut self, driving: bool) -> Option<FlashTask> {
        if !LOGS {
            return None;
        }
        if let Some(entry) = self.entry.take() {
            self.writing = true;
            return Some(FlashTask::Append(entry));
        }
        if (self.erase || self.memory.erasing.is_some()) && !driving {
            self.erase = true;
            return Some(FlashTask::Erase);
        }
        match &mut self.download {
            Some(Download { next, step: step @ (Step::Requested | Step::Due), .. }) => {
                *step = Step::Asked;
                Some(FlashTask::Read(*next))
            }
            _ => None,
        }
    }

    /// Takes the result of a written record or an erased piece, after [`Self::set_memory`]; returns false if
    /// the memory has failed.
    pub(super) fn finish(&mut self, done: bool) -> bool {
        if core::mem::take(&mut self.writing) {
            // A record that could not be written is lost; that is no failure of the memory.
            return true;
        }
        if self.memory.erasing.is_none() || !done {
            self.erase = false;
            self.ended = done.then_some(Ended::Erase);
        }
        done
    }

    /// Takes a record for the download. Zeros are sent in place of a record that is not whole or is too long
    /// for this download, and behind a shorter one.
    pub(super) fn handle_record(&mut self, record: Option<Record>) {
        let Some(download) = &mut self.download else { return };
        let fits = |record: &Record| record.frame(download.frames.into()).is_none();
        let record = record.filter(fits).unwrap_or_default();
        download.step = Step::Sending { record, frame: 0 };
    }

    /// The next frame of a download.
    fn frame(&mut self) -> Option<FromDrive> {
        let Download { counter, frames, step: Step::Sending { record, frame }, .. } =
            self.download.as_mut()?
        else {
            return None;
        };
        let data = record.frame((*frame).into()).unwrap_or_default();
        let message = FromDrive::LogData { counter: *counter, data };
        *frame += 1;
        *counter = counter.wrapping_add(3);
        if frame >= frames {
            self.go_on();
        }
        Some(message)
    }

    fn go_on(&mut self) {
        let Some(download) = &mut self.download else { return };
        download.next += 1;
        download.step = Step::Due;
        if download.next >= download.end {
            self.download = None;
            self.ended = Some(Ended::Read);
        }
    }

    fn is_idle(&self) -> bool {
        self.download.is_none() && !self.erase && self.memory.erasing.is_none()
    }

    fn state(&self) -> LogState {
        if self.memory.records == 0 {
            return LogState::BootUp;
        }
        if self.writing || self.entry.is_some() {
            return LogState::Write;
        }
        if let Some(download) = &self.download {
            return match download.step {
                Step::Requested => LogState::ReadInit,
                Step::Due => LogState::SendRead,
                Step::Asked => LogState::WaitRead,
                Step::Sending { .. } => LogState::SendFrames,
            };
        }
        match (self.ended, self.due) {
            _ if !self.is_idle() => LogState::Erasing,
            (Some(Ended::Erase), _) => LogState::EraseEnd,
            (Some(Ended::Read), _) => LogState::ReadEnd,
            (None, Some(_)) => LogState::WaitPeriod,
            (None, None) => LogState::Init,
        }
    }
}

/// True if this build logs.
pub(super) const LOGS: bool = cfg!(feature = "log");

/// Bits 24:16 of the status word.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LogStatus {
    pub(super) state: u8,
    pub(super) full: bool,
    pub(super) erased: bool,
    pub(super) read_enable: bool,
    pub(super) erase_enable: bool,
}

impl Node {
    /// The next frame of a download.
    pub(super) fn next_of_log(&mut self) -> Option<Frame> {
        if !LOGS {
            return None;
        }
        self.log.frame().map(|message| message.encode(self.addresses))
    }

    /// Samples the chosen slots, and makes a record when one is due.
    pub(super) fn run_log(&mut self, now: u64) {
        let memory = self.log.memory;
        let logs = self.flash.is_ready() && !memory.is_full() && memory.erasing.is_none() && !self.log.erase;
        if !LOGS || memory.records == 0 || !logs || !self.has_slots() {
            self.log.due = None;
            return;
        }
        let period = self.ticks(self.parameters.raw_u32(number::LOG_PERIOD).into());
        let Some(due) = self.log.due.map(NonZeroU64::get) else {
            self.log.restart();
            (self.log.due, self.log.sampled) = (NonZeroU64::new(now.saturating_add(period)), now);
            return;
        };
        if now.saturating_sub(self.log.sampled) < self.ticks(1) && now < due {
            return;
        }
        self.log.sampled = now;
        self.sample();
        if now < due {
            return;
        }
        let next = due.saturating_add(period);
        self.log.due = NonZeroU64::new(if next > now { next } else { now.saturating_add(period) });
        // While the flash is still busy with the previous record, this one is dropped.
        if self.log.entry.is_none() && !self.log.writing {
            self.log.entry = Some(self.entry(now));
        }
        self.log.kept.clear();
        self.log.samples = 0;
    }

    /// Returns whether a slot is chosen. The result is cached, because a search through all slots takes
    /// longer than the rest of most polls.
    fn has_slots(&mut self) -> bool {
        self.log.empty = self.log.empty || self.slots().next().is_none();
        !self.log.empty
    }

    /// Read-only parameters of the log.
    pub(super) fn read_log_parameter(&self, number: u16) -> Option<i32> {
        let memory = &self.log.memory;
        let value = match number {
            number::LOGGING_PACKAGE => memory.written.saturating_sub(1),
            number::LOG_RECORD_BYTES => self.record_size() as u32,
            number::LOG_INDEX_MAX => memory.records,
            number::LOG_WRITE_INDEX => memory.written,
            number::LOG_SUBSECTORS => memory.subsectors,
            number::LOG_ERASE_SUBSECTOR => memory.erasing.unwrap_or(0),
            number::LOG_MEMORY_FULL => memory.is_full().into(),
            _ => return None,
        };
        Some(value as i32)
    }

    /// Returns whether a slot is empty, or names an existing parameter or signal.
    pub(super) fn can_log(&self, slot: i32) -> bool {
        let what = slot as u16;
        what == NOTHING || if what < SIGNAL_FIRST { Dictionary::row(what).is_some() } else { is_signal(what) }
    }

    /// Begins a download, at a rising edge of parameter 75: parameters 67 and 68 select the records.
    pub(super) fn begin_download(&mut self) -> ParameterStatus {
        let start = self.parameters.raw_u32(number::LOG_READ_START);
        let count = self.parameters.raw_u32(number::LOG_READ_COUNT);
        let memory = self.log.memory;
        if !LOGS || !self.flash.is_ready() || memory.lost || !self.log.is_idle() {
            return ParameterStatus::Storage;
        }
        let end = start.saturating_add(count);
        if count == 0 || end > memory.written {
            return ParameterStatus::OutOfRange;
        }
        let frames = (self.record_size() / 6) as u8;
        self.log.download = Some(Download { next: start, end, frames, counter: 0, step: Step::Requested });
        ParameterStatus::Done
    }

    /// Aborts the download, when 0 is written to parameter 75.
    pub(super) fn abort_download(&mut self) {
        self.log.download = None;
    }

    /// Begins an erase, at a rising edge of parameter 76.
    pub(super) fn begin_erase(&mut self) -> ParameterStatus {
        if !LOGS || !self.flash.is_ready() || !self.log.is_idle() {
            return ParameterStatus::Storage;
        }
        self.log.entry = None;
        self.log.erase = true;
        ParameterStatus::Done
    }

    /// Returns the log's bits of the status word: zeros without a memory, and during initialization.
    pub(super) fn log_status(&self) -> LogStatus {
        let Log { memory, .. } = &self.log;
        if !LOGS || memory.records == 0 || self.status.state == State::Initialization {
            return LogStatus::default();
        }
        let idle = self.log.is_idle() && self.flash.is_ready();
        LogStatus {
            state: self.log.state() as u8,
            full: memory.is_full(),
            erased: memory.is_erased(),
            read_enable: idle && !memory.lost && memory.written > 0,
            erase_enable: idle && !self.status.state.is_driving(),
        }
    }

    /// Forgets the ended operation, after a status word has reported it.
    pub(super) const fn forget_log_end(&mut self) {
        self.log.ended = None;
    }

    /// Bytes of each record in a download: those of the longest record in the log, or of the next one if that
    /// is longer.
    fn record_size(&self) -> usize {
        let longest = (self.log.memory.values as usize).min(VALUES);
        Record::size(self.slots().count().max(longest))
    }

    /// Returns the chosen slots: source, and kind of value.
    fn slots(&self) -> impl Iterator<Item = (u16, Keep)> + '_ {
        (number::LOGGING_SLOT_FIRST..=number::LOGGING_SLOT_LAST).filter_map(|number| {
            let slot = self.parameters.raw(number);
            let keep = match slot >> 16 & 3 {
                0 => Keep::Live,
                1 => Keep::Smallest,
                2 => Keep::Largest,
                _ => Keep::Mean,
            };
            (slot as u16 != NOTHING).then_some((slot as u16, keep))
        })
    }

    /// Adds the present values to those that are kept until the next record.
    fn sample(&mut self) {
        let frames = self.measurement_words();
        let first = self.log.samples == 0;
        let mut kept: Vec<i64, VALUES> = Vec::new();
        for (place, (what, keep)) in self.slots().enumerate() {
            let value = self.value_of(what, &frames);
            let before = self.log.kept.get(place).copied().filter(|_| !first);
            let _ = kept.push(match (before, keep) {
                (None, _) | (_, Keep::Live) => value,
                (Some(before), Keep::Smallest) => before.min(value),
                (Some(before), Keep::Largest) => before.max(value),
                (Some(before), Keep::Mean) => before.saturating_add(value),
            });
        }
        self.log.kept = kept;
        self.log.samples = self.log.samples.saturating_add(1);
    }

    fn entry(&self, now: u64) -> Entry {
        let samples = i64::from(self.log.samples.max(1));
        let mut values = Vec::new();
        for ((what, keep), kept) in self.slots().zip(&self.log.kept) {
            let value = if keep == Keep::Mean { kept / samples } else { *kept };
            let _ = values.push((what & 0x3FFF | (keep as u16) << 14, value as i32));
        }
        Entry { time: (now * 1000 / u64::from(self.board.tick_rate.max(1))) as u32, values }
    }

    fn value_of(&self, what: u16, frames: &[Words; 6]) -> i64 {
        let Some(signal) = what.checked_sub(SIGNAL_FIRST) else {
            let raw = self.read_parameter(what).unwrap_or(0);
            return Dictionary::row(what).map_or(0, |row| row.kind.widen(raw));
        };
        let (opcode, word) = (signal >> 2, usize::from(signal & 3));
        match opcode {
            STATUS => self.status_word().encode().into(),
            FAULTS => self.status.faults.bits().into(),
            _ => {
                let words =
                    frames.get(usize::from(opcode.wrapping_sub(MEASUREMENT))).copied().unwrap_or_default();
                let at = |place: usize| words.0.get(place).copied().unwrap_or(0);
                if what == POSITION {
                    return i64::from((u32::from(at(1)) << 16 | u32::from(at(2))) as i32);
                }
                (at(word) as i16).into()
            }
        }
    }
}

const STATUS: u16 = Opcode::STATUS_WORD.raw();
const FAULTS: u16 = Opcode::FAULT_WORD.raw();
const MEASUREMENT: u16 = Opcode::MEASUREMENT_0.raw();
/// MEASUREMENT_1, words 1 and 2.
const POSITION: u16 = SIGNAL_FIRST + (MEASUREMENT + 1) * 4 + 1;

/// Returns whether a slot value names a signal: the status or fault word as a whole, or the first word of a
/// broadcast signal.
fn is_signal(what: u16) -> bool {
    let signal = what.wrapping_sub(SIGNAL_FIRST);
    let (opcode, word) = (signal >> 2, signal & 3);
    match opcode {
        STATUS | FAULTS => word == 0,
        _ => FIRST_WORDS.contains(&signal),
    }
}

/// First word of each signal, opcode * 4 + word: computed at compile time, so that no board carries the table
/// with its texts.
static FIRST_WORDS: [u16; SIGNALS.len()] = {
    let mut words = [0; SIGNALS.len()];
    let mut at = 0;
    while at < words.len() {
        words[at] = SIGNALS[at].opcode.raw() << 2 | SIGNALS[at].word as u16;
        at += 1;
    }
    words
};
