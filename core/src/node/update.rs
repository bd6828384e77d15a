//! Receives an image and has the shell write it into the bootloader's slot. The motor never runs while the
//! flash is written: starts are refused during the reception, and while an image is on trial.
//!
//! ```text
//!  BEGIN            +-> Clear, Erase ... -> Write ... -> Sum ... -> Mark          tasks of the shell, one at a time,
//!  DATA ...  Node --+                                                             each answered by a reply
//!  END              +<- STATUS: erasing, receiving, verifying, marked
//! ```

use super::Node;
use super::requests::Refused;
use super::storage::SETTLE_MS;
use crate::bus::narmotion::update::{
    BLOCK, ImageVersion, UpdateAnswer, UpdateCode, UpdateRequest, UpdateState, UpdateStatus,
};
use crate::bus::narmotion::{FromDrive, MotorMode};
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
/// reverts the swap.
const TRIAL_MS: u64 = 60_000;

/// State of the slots at power-up, from the shell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Slots {
    /// Hardware id that an image must have.
    pub hardware: u32,
    /// Longest image, header included, bytes.
    pub room: u32,
    /// Bytes that one [`Request::Erase`] erases.
    pub page: u32,
    /// Version of the running image; zeros if the running program is no image.
    pub running: ImageVersion,
    /// State that the bootloader has left.
    pub condition: Condition,
}

/// State that the bootloader has left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Condition {
    /// Nothing is under way. The code is the reason why the last image does not run, or [`UpdateCode::Done`].
    Settled(UpdateCode),
    /// An image is marked for the next boot.
    Marked,
    /// The running image needs a confirmation.
    Trial,
}

impl Default for Condition {
    fn default() -> Self {
        Self::Settled(UpdateCode::Done)
    }
}

/// Task of the shell for the slot. Offsets are bytes from the slot's beginning.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SlotTask {
    /// Remove the mark, if there is one.
    Clear,
    /// Erase a page.
    Erase {
        /// Beginning of the page.
        offset: u32,
    },
    /// Write into erased flash. The last piece is filled up with ones to a whole number of 32 bytes.
    Write {
        /// Place of the data.
        offset: u32,
        /// The data.
        data: Vec<u8, PIECE>,
    },
    /// Read back bytes and continue the CRC-32 (ISO-HDLC) with them; at offset 0 the CRC begins anew.
    Sum {
        /// Place of the bytes: behind those of the request before.
        offset: u32,
        /// Number of bytes.
        length: u32,
    },
    /// Look at the header, and mark the image for the next boot.
    Mark {
        /// Length of the image, bytes.
        length: u32,
    },
    /// Keep the running image.
    Confirm,
}

/// Reply to a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SlotReply {
    /// Done.
    Done,
    /// The CRC-32 so far.
    Sum(u32),
    /// Not done.
    Failed(UpdateCode),
}

/// The node's side of the slot.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Update {
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
    /// The master's request that waits: remove the mark, or keep the running image.
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
}

impl Update {
    /// Returns whether a request is a start that is forbidden: during an update, and while an image is on
    /// trial.
    pub(super) fn forbids(&self, mode: MotorMode) -> bool {
        let starts = matches!(mode, MotorMode::Drive | MotorMode::Reverse);
        starts && (self.is_busy() || self.state == UpdateState::Trial)
    }

    const fn is_busy(&self) -> bool {
        matches!(self.state, UpdateState::Erasing | UpdateState::Receiving | UpdateState::Verifying)
    }

    fn status(&self, code: UpdateCode) -> UpdateStatus {
        let (window, offset) = match self.state {
            UpdateState::Erasing | UpdateState::Verifying => (0, self.offset.min(self.length)),
            UpdateState::Receiving => ((self.room() / BLOCK) as u16, self.offset),
            UpdateState::Marked => (0, self.length),
            UpdateState::Idle | UpdateState::Trial => (0, 0),
        };
        UpdateStatus { state: self.state, code, window, offset }
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
}

impl Node {
    /// Connects the node to its slots, at power-up: from now on [`Node::poll_update`] returns requests. The
    /// device reports the version of the running image as its own (BUILD_INFO, DEVICE_INFO, parameters 5 and
    /// 6).
    pub fn attach_update(&mut self, slots: &Slots) {
        let (state, code) = match slots.condition {
            Condition::Settled(code) => (UpdateState::Idle, code),
            Condition::Marked => (UpdateState::Marked, UpdateCode::Done),
            Condition::Trial => (UpdateState::Trial, UpdateCode::Done),
        };
        self.update = Update { slots: Some(*slots), state, code, ..Update::default() };
        if slots.running != ImageVersion::default() {
            let ImageVersion { major, minor, build, .. } = slots.running;
            (self.identity.software_release, self.identity.build_number) =
                (u16::from_be_bytes([major, minor]), build);
            self.show_identity();
        }
    }

    /// Returns the next request about the slot; at most one is under way.
    pub fn poll_update(&mut self) -> Option<SlotTask> {
        let waits = self.update.state == UpdateState::Erasing && self.flash.now() < self.update.due;
        if self.update.slots.is_none() || self.update.asked.is_some() || waits {
            return None;
        }
        // Nothing is written while a motor turns.
        if self.update.is_busy() && !self.is_stopped() {
            self.end_update(UpdateCode::WrongState);
            return None;
        }
        let (asked, request) = self.update.next()?;
        self.update.asked = Some(asked);
        Some(request)
    }

    /// Takes the report on the last request.
    pub fn handle_update(&mut self, report: SlotReply) {
        let Some(asked) = self.update.asked.take() else { return };
        if core::mem::take(&mut self.update.stale) {
            return;
        }
        match (report, asked) {
            (SlotReply::Failed(code), Asked::Confirm) => self.tell_update(code),
            (SlotReply::Failed(code), _) => self.end_update(code),
            (SlotReply::Sum(crc), Asked::Sum) => self.note_sum(crc),
            (_, Asked::Clear) if self.update.state == UpdateState::Erasing => self.update.cleared = true,
            (_, Asked::Clear) => self.end_update(UpdateCode::Aborted),
            (_, Asked::Erase) => self.note_erased(),
            (_, Asked::Write) => {
                self.update.drop_piece();
                if self.update.state == UpdateState::Receiving {
                    self.tell_update(UpdateCode::Done);
                }
            }
            (_, Asked::Mark) => {
                self.update.state = UpdateState::Marked;
                self.tell_update(UpdateCode::Done);
            }
            (_, Asked::Confirm) => self.end_update(UpdateCode::Done),
            (_, Asked::Sum) => self.end_update(UpdateCode::Flash),
        }
    }

    /// Handles a message. A refused one is answered with the reason, so it is not counted.
    pub(super) fn handle_update_message(&mut self, request: UpdateRequest) -> Result<(), Refused> {
        let Some(slots) = self.update.slots else { return Err(Refused) };
        let code = match request {
            UpdateRequest::Device => {
                let Slots { hardware, room, .. } = slots;
                self.send(FromDrive::Update(UpdateAnswer::Device { hardware, room }));
                return Ok(());
            }
            UpdateRequest::Version => {
                self.send(FromDrive::Update(UpdateAnswer::Version(slots.running)));
                return Ok(());
            }
            UpdateRequest::Data { block, data } => return self.take_block(block, data),
            UpdateRequest::Status => self.update.code,
            UpdateRequest::Begin { length, hardware } => self.begin_update(&slots, length, hardware),
            UpdateRequest::End { crc } => self.end_of_image(crc),
            UpdateRequest::Abort => self.abort_update(),
            UpdateRequest::Confirm => self.confirm_image(),
        };
        self.tell_update(code);
        Ok(())
    }

    /// Checks the time-outs of receiving and of the trial.
    pub(super) fn run_update(&mut self) {
        let is_due = self.flash.now() >= self.update.due;
        match self.update.state {
            // The clock of a shell need not begin at 0.
            UpdateState::Trial if self.update.due == 0 => self.update.due = self.update_tick(TRIAL_MS),
            UpdateState::Receiving if is_due => self.end_update(UpdateCode::TimedOut),
            UpdateState::Trial if is_due && self.update.asked.is_none() => {
                self.update.due = u64::MAX;
                self.pending.reboot = true;
            }
            _ => {}
        }
    }

    fn begin_update(&mut self, slots: &Slots, length: u32, hardware: u32) -> UpdateCode {
        let Update { state, offset, .. } = self.update;
        // Asked again, because the answer was lost.
        let is_begun = state == UpdateState::Erasing || (state == UpdateState::Receiving && offset == 0);
        match state {
            UpdateState::Trial => UpdateCode::Trial,
            _ if !self.is_stopped() => UpdateCode::WrongState,
            _ if hardware != slots.hardware => UpdateCode::Hardware,
            _ if length < SHORTEST || length > slots.room => UpdateCode::Length,
            UpdateState::Verifying => UpdateCode::NotNow,
            _ if is_begun && length == self.update.length => UpdateCode::Done,
            _ => {
                let not_before = self.update_tick(SETTLE_MS);
                self.update.begin(length, not_before);
                UpdateCode::Done
            }
        }
    }

    fn take_block(&mut self, block: u16, data: [u8; BLOCK]) -> Result<(), Refused> {
        if self.update.state != UpdateState::Receiving {
            // An answer to every block would fill the bus.
            return Err(Refused);
        }
        self.update.due = self.update_tick(SILENCE_MS);
        if self.update.take_block(block, data) {
            self.tell_update(UpdateCode::Sequence);
        }
        Ok(())
    }

    fn end_of_image(&mut self, crc: u32) -> UpdateCode {
        match self.update.state {
            UpdateState::Receiving if self.update.offset < self.update.length => UpdateCode::Sequence,
            UpdateState::Receiving => {
                (self.update.state, self.update.crc, self.update.offset) = (UpdateState::Verifying, crc, 0);
                UpdateCode::Done
            }
            // Asked again, because the answer was lost.
            UpdateState::Verifying | UpdateState::Marked if self.update.crc == crc => UpdateCode::Done,
            _ => UpdateCode::NotNow,
        }
    }

    fn abort_update(&mut self) -> UpdateCode {
        match self.update.state {
            UpdateState::Trial => UpdateCode::NotNow,
            // A mark that is being written cannot be stopped; once it is written it can be removed.
            _ if self.update.asked == Some(Asked::Mark) => UpdateCode::NotNow,
            UpdateState::Marked => {
                self.update.wanted = Some(Asked::Clear);
                UpdateCode::Done
            }
            UpdateState::Idle => self.update.code,
            UpdateState::Erasing | UpdateState::Receiving | UpdateState::Verifying => {
                self.update.end(UpdateCode::Aborted);
                UpdateCode::Aborted
            }
        }
    }

    fn confirm_image(&mut self) -> UpdateCode {
        match self.update.state {
            UpdateState::Trial => {
                self.update.wanted = Some(Asked::Confirm);
                UpdateCode::Done
            }
            UpdateState::Idle => self.update.code,
            _ => UpdateCode::NotNow,
        }
    }

    fn note_erased(&mut self) {
        let page = self.update.slots.map_or(0, |slots| slots.page);
        self.update.offset = self.update.offset.saturating_add(page);
        if self.update.offset >= self.update.length {
            (self.update.state, self.update.offset) = (UpdateState::Receiving, 0);
            self.update.due = self.update_tick(SILENCE_MS);
            self.tell_update(UpdateCode::Done);
        }
    }

    fn note_sum(&mut self, crc: u32) {
        self.update.offset += self.update.summed();
        if self.update.offset >= self.update.length && crc != self.update.crc {
            self.end_update(UpdateCode::Checksum);
        }
    }

    fn end_update(&mut self, code: UpdateCode) {
        self.update.end(code);
        self.tell_update(code);
    }

    fn tell_update(&mut self, code: UpdateCode) {
        let status = self.update.status(code);
        self.send(FromDrive::Update(UpdateAnswer::Status(status)));
    }

    /// Returns the tick that is `milliseconds` ahead.
    fn update_tick(&self, milliseconds: u64) -> u64 {
        self.flash.now().saturating_add(self.ticks(milliseconds))
    }
}
