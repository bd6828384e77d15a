//! Receives an image and has the shell write it into the bootloader's slot. The motor never runs while the
//! flash is written: starts are refused during the reception, and while an image is on trial.
//!
//! ```text
//!  BEGIN                +-> Clear, Erase ... -> Write ... -> Sum ... -> Mark      tasks of the shell, one at a time,
//!  DATA ...  Receiver --+                                                         each answered by a reply
//!  END                  +<- STATUS: erasing, receiving, verifying, marked
//! ```
//!
//! A program that stands where the image will be leaves instead: BEGIN -> Leave -> restart. It does not
//! answer, so the master repeats BEGIN until the bootloader has it.

use super::{Condition, SlotReply, SlotTask, Slots};
use crate::bus::narmotion::MotorMode;
use crate::bus::narmotion::update::{
    BLOCK, UpdateAnswer, UpdateCode, UpdateRequest, UpdateState, UpdateStatus,
};
use crate::node::requests::Refused;
use crate::node::storage::SETTLE_MS;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Bytes that the shell writes at once: whole blocks, and whole words of any flash up to 32 bytes.
pub const PIECE: usize = 96;
/// Bytes that may wait to be written: one piece is filled while another is written.
const HELD: usize = 2 * PIECE;
/// Bytes that are read back at once.
const SUMMED: u32 = 1024;
/// Shortest image: a header of 512 bytes and the shortest body.
const SHORTEST: u32 = 520;
/// Time without a block after which the update ends, ms.
const SILENCE_MS: u64 = 10_000;
/// Time without a confirmation after which an image on trial restarts the drive, ms; the bootloader then
/// takes it back.
const TRIAL_MS: u64 = 60_000;

/// Time and motor at a call of the receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Moment {
    /// Time, ticks.
    pub(crate) now: u64,
    /// Ticks per second.
    pub(crate) tick_rate: u32,
    /// The motor stands, and no command lets it start by itself.
    pub(crate) is_stopped: bool,
}

impl Moment {
    /// Returns the tick that is `milliseconds` ahead.
    fn after(self, milliseconds: u64) -> u64 {
        self.now.saturating_add(milliseconds * u64::from(self.tick_rate) / 1000)
    }
}

/// Next step after a call of the receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub(crate) enum Next {
    /// Nothing.
    Nothing,
    /// Send the status, with this code.
    Tell(UpdateCode),
    /// Restart the device.
    Restart,
}

/// The bus's side of the slot.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Receiver {
    /// The slots; `None` without a shell that does the tasks.
    slots: Option<Slots>,
    state: UpdateState,
    code: UpdateCode,
    length: u32,
    crc: u32,
    /// Bytes that are done: erased, then received, then read back.
    offset: u32,
    /// Bytes that were received and are not written yet.
    held: Vec<u8, HELD, u8>,
    asked: Option<Asked>,
    /// The task under way belongs to an update that is over.
    stale: bool,
    /// A mark has been removed.
    cleared: bool,
    /// The master's request that waits: remove the mark, keep the running image, or leave for the bootloader.
    wanted: Option<Asked>,
    /// The master was told that a block is missing.
    gap_told: bool,
    /// Tick before which no page is erased, or at which receiving or the trial ends.
    due: u64,
}

/// The request under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Asked {
    Clear,
    Erase,
    Write,
    Sum,
    Mark,
    Confirm,
    Leave,
}

impl Receiver {
    /// Over slots in this condition.
    pub(crate) fn new(slots: &Slots) -> Self {
        let (state, code) = match slots.condition {
            Condition::Settled(code) => (UpdateState::Idle, code),
            Condition::Marked => (UpdateState::Marked, UpdateCode::Done),
            Condition::Trial => (UpdateState::Trial, UpdateCode::Done),
        };
        Self { slots: Some(*slots), state, code, ..Self::default() }
    }

    /// Returns whether nothing is to be done until the next message.
    pub(crate) fn is_quiet(&self) -> bool {
        matches!(self.state, UpdateState::Idle | UpdateState::Marked) && self.wanted.is_none()
    }

    /// Returns the next task for the slot; at most one is under way.
    ///
    /// # Errors
    /// The update has ended because the motor turns: send the status with this code.
    pub(crate) fn poll(&mut self, moment: Moment) -> Result<Option<SlotTask>, UpdateCode> {
        let settles = self.state == UpdateState::Erasing || self.wanted == Some(Asked::Leave);
        if self.slots.is_none() || self.asked.is_some() || (settles && moment.now < self.due) {
            return Ok(None);
        }
        // Nothing is written while a motor turns.
        if self.is_busy() && !moment.is_stopped {
            self.end(UpdateCode::WrongState);
            return Err(UpdateCode::WrongState);
        }
        let Some((asked, request)) = self.next() else { return Ok(None) };
        self.asked = Some(asked);
        Ok(Some(request))
    }

    /// Takes the reply to the last task.
    pub(crate) fn handle_reply(&mut self, reply: SlotReply, moment: Moment) -> Next {
        let Some(asked) = self.asked.take() else { return Next::Nothing };
        if core::mem::take(&mut self.stale) {
            return Next::Nothing;
        }
        match (reply, asked) {
            (SlotReply::Failed(code), Asked::Confirm) => Next::Tell(code),
            (SlotReply::Failed(code), _) => self.tell_end(code),
            (SlotReply::Sum(crc), Asked::Sum) => self.note_sum(crc),
            (_, Asked::Clear) if self.state == UpdateState::Erasing => {
                self.cleared = true;
                Next::Nothing
            }
            (_, Asked::Clear) => self.tell_end(UpdateCode::Aborted),
            (_, Asked::Erase) => self.note_erased(moment),
            (_, Asked::Write) => {
                self.drop_piece();
                if self.state == UpdateState::Receiving {
                    Next::Tell(UpdateCode::Done)
                } else {
                    Next::Nothing
                }
            }
            (_, Asked::Mark) => {
                self.state = UpdateState::Marked;
                Next::Tell(UpdateCode::Done)
            }
            (_, Asked::Confirm) => self.tell_end(UpdateCode::Done),
            (_, Asked::Leave) => Next::Restart,
            (_, Asked::Sum) => self.tell_end(UpdateCode::Flash),
        }
    }

    /// Handles a message; returns its answer, if it has one.
    ///
    /// # Errors
    /// Nobody waits for this message.
    pub(crate) fn handle(
        &mut self,
        request: UpdateRequest,
        moment: Moment,
    ) -> Result<Option<UpdateAnswer>, Refused> {
        let Some(slots) = self.slots else { return Err(Refused) };
        let code = match request {
            UpdateRequest::Device => {
                let Slots { hardware, room, .. } = slots;
                return Ok(Some(UpdateAnswer::Device { hardware, room }));
            }
            UpdateRequest::Version => return Ok(Some(UpdateAnswer::Version(slots.running))),
            UpdateRequest::Data { block, data } => return self.handle_block(block, data, moment),
            UpdateRequest::Begin { length, hardware } => {
                match self.begin_if_possible(&slots, length, hardware, moment) {
                    UpdateCode::Done if self.wanted == Some(Asked::Leave) => return Ok(None),
                    code => code,
                }
            }
            UpdateRequest::Status => self.code,
            UpdateRequest::End { crc } => self.end_of_image(crc),
            UpdateRequest::Abort => self.abort(),
            UpdateRequest::Confirm => self.confirm(),
        };
        Ok(Some(self.status(code)))
    }

    /// Checks the time-outs of receiving and of the trial.
    pub(crate) fn run(&mut self, moment: Moment) -> Next {
        let is_due = moment.now >= self.due;
        match self.state {
            // The clock of a shell need not begin at 0.
            UpdateState::Trial if self.due == 0 => self.due = moment.after(TRIAL_MS),
            UpdateState::Receiving if is_due => return self.tell_end(UpdateCode::TimedOut),
            UpdateState::Trial if is_due && self.asked.is_none() => {
                self.due = u64::MAX;
                return Next::Restart;
            }
            _ => {}
        }
        Next::Nothing
    }

    /// The answer UPDATE_STATUS, with this code.
    pub(crate) fn status(&self, code: UpdateCode) -> UpdateAnswer {
        let (window, offset) = match self.state {
            UpdateState::Erasing | UpdateState::Verifying => (0, self.offset.min(self.length)),
            UpdateState::Receiving => ((self.room() / BLOCK) as u16, self.offset),
            UpdateState::Marked => (0, self.length),
            UpdateState::Idle | UpdateState::Trial => (0, 0),
        };
        UpdateAnswer::Status(UpdateStatus { state: self.state, code, window, offset })
    }

    /// Returns whether a request is a start that is forbidden: during an update, and while an image is on
    /// trial.
    pub(crate) fn forbids(&self, mode: MotorMode) -> bool {
        let starts = matches!(mode, MotorMode::Drive | MotorMode::Reverse);
        starts && (self.is_busy() || self.is_leaving() || self.state == UpdateState::Trial)
    }

    /// Returns whether the running program makes way for the image.
    fn is_leaving(&self) -> bool {
        [self.asked, self.wanted].contains(&Some(Asked::Leave))
    }

    const fn is_busy(&self) -> bool {
        matches!(self.state, UpdateState::Erasing | UpdateState::Receiving | UpdateState::Verifying)
    }

    /// Bytes for which there is still room.
    fn room(&self) -> usize {
        HELD - self.held.len()
    }

    fn begin(&mut self, length: u32, not_before: u64) {
        let Self { slots, asked, .. } = self;
        let (slots, asked) = (slots.take(), asked.take());
        let stale = asked.is_some();
        *self = Self {
            slots,
            asked,
            stale,
            state: UpdateState::Erasing,
            length,
            due: not_before,
            ..Self::default()
        };
    }

    /// Ends the update, for this reason.
    fn end(&mut self, code: UpdateCode) {
        let Self { slots, asked, .. } = self;
        let (slots, asked) = (slots.take(), asked.take());
        let stale = asked.is_some();
        *self = Self { slots, asked, stale, code, ..Self::default() };
    }

    /// Takes a block; returns true if its sender must be told that an earlier one is missing.
    fn take_block(&mut self, block: u16, data: [u8; BLOCK]) -> bool {
        let expected = (self.offset / BLOCK as u32) as u16;
        // An earlier block: it was received before.
        if (block.wrapping_sub(expected) as i16) < 0 {
            return false;
        }
        let bytes = data.get(..BLOCK.min((self.length - self.offset) as usize)).unwrap_or(&data);
        if block != expected || bytes.is_empty() || self.held.extend_from_slice(bytes).is_err() {
            return !core::mem::replace(&mut self.gap_told, true);
        }
        self.offset += bytes.len() as u32;
        self.gap_told = false;
        false
    }

    /// The next request of an update under way.
    fn next(&mut self) -> Option<(Asked, SlotTask)> {
        let is_complete = self.received() == self.length;
        match self.state {
            UpdateState::Erasing if !self.cleared => Some((Asked::Clear, SlotTask::Clear)),
            UpdateState::Erasing => Some((Asked::Erase, SlotTask::Erase { offset: self.offset })),
            UpdateState::Receiving | UpdateState::Verifying
                if self.held.len() >= PIECE || (is_complete && !self.held.is_empty()) =>
            {
                let mut data = Vec::new();
                let piece = self.held.get(..PIECE).unwrap_or(&self.held);
                let _ = data.extend_from_slice(piece);
                // There is room: a piece is a multiple of 32 bytes.
                let _ = data.resize(data.len().next_multiple_of(32), 0xFF);
                Some((Asked::Write, SlotTask::Write { offset: self.written(), data }))
            }
            UpdateState::Verifying if self.offset < self.length => {
                Some((Asked::Sum, SlotTask::Sum { offset: self.offset, length: self.summed() }))
            }
            UpdateState::Verifying => Some((Asked::Mark, SlotTask::Mark { length: self.length })),
            _ => match self.wanted.take()? {
                Asked::Confirm => Some((Asked::Confirm, SlotTask::Confirm)),
                Asked::Leave => Some((Asked::Leave, SlotTask::Leave)),
                _ => Some((Asked::Clear, SlotTask::Clear)),
            },
        }
    }

    /// Bytes received: all of them, while they are verified.
    fn received(&self) -> u32 {
        if self.state == UpdateState::Verifying { self.length } else { self.offset }
    }

    /// Bytes written.
    fn written(&self) -> u32 {
        self.received().saturating_sub(self.held.len() as u32)
    }

    /// Number of bytes to read back next.
    fn summed(&self) -> u32 {
        SUMMED.min(self.length.saturating_sub(self.offset))
    }

    /// Drops the piece that was written.
    fn drop_piece(&mut self) {
        // Copied instead of rotated in place: a rotation takes 1.6 KB of a board's flash.
        self.held = self.held.get(PIECE..).and_then(|rest| Vec::from_slice(rest).ok()).unwrap_or_default();
    }

    fn begin_if_possible(&mut self, slots: &Slots, length: u32, hardware: u32, moment: Moment) -> UpdateCode {
        // Asked again, because the answer was lost.
        let is_begun =
            self.state == UpdateState::Erasing || (self.state == UpdateState::Receiving && self.offset == 0);
        match self.state {
            UpdateState::Trial => UpdateCode::Trial,
            _ if !moment.is_stopped => UpdateCode::WrongState,
            _ if hardware != slots.hardware => UpdateCode::Hardware,
            _ if length < SHORTEST || length > slots.room => UpdateCode::Length,
            UpdateState::Verifying => UpdateCode::NotNow,
            _ if is_begun && length == self.length => UpdateCode::Done,
            _ if slots.page == 0 => {
                if !self.is_leaving() {
                    (self.wanted, self.due) = (Some(Asked::Leave), moment.after(SETTLE_MS));
                }
                UpdateCode::Done
            }
            _ => {
                self.begin(length, moment.after(SETTLE_MS));
                UpdateCode::Done
            }
        }
    }

    fn handle_block(
        &mut self,
        block: u16,
        data: [u8; BLOCK],
        moment: Moment,
    ) -> Result<Option<UpdateAnswer>, Refused> {
        if self.state != UpdateState::Receiving {
            // An answer to every block would fill the bus.
            return Err(Refused);
        }
        self.due = moment.after(SILENCE_MS);
        Ok(self.take_block(block, data).then(|| self.status(UpdateCode::Sequence)))
    }

    fn end_of_image(&mut self, crc: u32) -> UpdateCode {
        match self.state {
            UpdateState::Receiving if self.offset < self.length => UpdateCode::Sequence,
            UpdateState::Receiving => {
                (self.state, self.crc, self.offset) = (UpdateState::Verifying, crc, 0);
                UpdateCode::Done
            }
            // Asked again, because the answer was lost.
            UpdateState::Verifying | UpdateState::Marked if self.crc == crc => UpdateCode::Done,
            _ => UpdateCode::NotNow,
        }
    }

    fn abort(&mut self) -> UpdateCode {
        match self.state {
            UpdateState::Trial => UpdateCode::NotNow,
            // A mark that is being written cannot be stopped; once it is written it can be removed.
            _ if self.asked == Some(Asked::Mark) => UpdateCode::NotNow,
            UpdateState::Marked => {
                self.wanted = Some(Asked::Clear);
                UpdateCode::Done
            }
            UpdateState::Idle => self.code,
            UpdateState::Erasing | UpdateState::Receiving | UpdateState::Verifying => {
                self.end(UpdateCode::Aborted);
                UpdateCode::Aborted
            }
        }
    }

    fn confirm(&mut self) -> UpdateCode {
        match self.state {
            UpdateState::Trial => {
                self.wanted = Some(Asked::Confirm);
                UpdateCode::Done
            }
            UpdateState::Idle => self.code,
            _ => UpdateCode::NotNow,
        }
    }

    fn note_erased(&mut self, moment: Moment) -> Next {
        let page = self.slots.map_or(0, |slots| slots.page);
        self.offset = self.offset.saturating_add(page);
        if self.offset < self.length {
            return Next::Nothing;
        }
        (self.state, self.offset) = (UpdateState::Receiving, 0);
        self.due = moment.after(SILENCE_MS);
        Next::Tell(UpdateCode::Done)
    }

    fn note_sum(&mut self, crc: u32) -> Next {
        self.offset += self.summed();
        if self.offset >= self.length && crc != self.crc {
            return self.tell_end(UpdateCode::Checksum);
        }
        Next::Nothing
    }

    fn tell_end(&mut self, code: UpdateCode) -> Next {
        self.end(code);
        Next::Tell(code)
    }
}
