//! Programs the drive: sends an image, has it swapped in, and confirms it once the drive has spoken again.
//!
//! ```text
//!  device -> version -> begin -> erasing -> sending -> end -> verifying -> reboot -> waiting -> checking -> confirm
//!            hardware,                      blocks, as far                           on trial:  the image's
//!            room, age                      as the window says                       swapped in version?
//! ```
//!
//! In every stage there is one message that is sent until the drive's status says that the next stage is reached, so that neither a lost
//! question nor a lost answer matters. Blocks are sent beside set-points and requests, no faster than [`PACE`].

use super::error::NotTaken;
use crate::bus::narmotion::update::{
    BLOCK, ImageVersion, UpdateAnswer, UpdateCode, UpdateRequest, UpdateState, UpdateStatus,
};
use crate::bus::narmotion::{FromDrive, ToDrive};
use crate::storage::record::CRC32;
use core::fmt;

/// From one block to the next on average, microseconds: a block takes at most 320 of them on the bus, and a fifth is left to others.
pub const PACE: u64 = 400;
/// Blocks that are sent without a pause after one that was late.
const BURST: u64 = 8;
/// A drive that tells nothing new for so long is gone, microseconds: whoever it is, and whoever carries its frames, may be busy with something else for a while.
const SILENCE: u64 = 5_000_000;
/// The same of one that has not answered yet, as none without a bootloader does.
const NO_ANSWER: u64 = 2_000_000;
/// A drive that has not restarted so long after it was asked to was not reached, microseconds. Earlier it may be an answer from before: each of the questions that it was too busy
/// to hear gets one.
const SETTLED: u64 = 1_000_000;
/// How often the drive is looked for after its reboot, and for how long, microseconds: two images are copied meanwhile.
const LOOK: u64 = 200_000;
const BOOT: u64 = 60_000_000;

/// An image to be sent: what its header says, and what its bytes are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Image {
    /// Hardware id in its header.
    pub hardware: u32,
    /// Version in its header.
    pub version: ImageVersion,
    /// Length, header included, bytes.
    pub length: u32,
    /// CRC-32 (ISO-HDLC) of all of it.
    pub crc: u32,
}

impl Image {
    /// That of these bytes, whose header says so.
    pub fn new(hardware: u32, version: ImageVersion, bytes: &[u8]) -> Self {
        let length = u32::try_from(bytes.len()).unwrap_or(u32::MAX);
        Self { hardware, version, length, crc: CRC32.checksum(bytes) }
    }
}

/// Why a drive does not run the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UpdateError {
    /// The drive does not answer. One without a bootloader does not either.
    NoAnswer,
    /// It has answered, and does not any more.
    Silent,
    /// The image is for other hardware.
    Hardware {
        /// Hardware id of the image.
        image: u32,
        /// Hardware id of the drive.
        drive: u32,
    },
    /// The image does not fit.
    TooLong {
        /// Its length, bytes.
        length: u32,
        /// The longest that the drive takes.
        room: u32,
    },
    /// The image is older than the one that runs.
    Older {
        /// Version of the image.
        image: ImageVersion,
        /// Version that runs.
        running: ImageVersion,
    },
    /// The drive has refused it, or given it up.
    Refused(UpdateCode),
    /// The drive knows nothing of the image any more: it has restarted before it was there, or lost what its bootloader said.
    Forgotten,
    /// After the reboot another version runs.
    OtherVersion(ImageVersion),
    /// Ended by [`super::Master::abort_update`].
    Aborted,
}

/// What an update is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UpdateStage {
    /// Asks whether the drive takes the image.
    Asking,
    /// The drive erases its slot.
    Erasing,
    /// Blocks are sent.
    Sending,
    /// The drive reads back what it has written.
    Verifying,
    /// The drive restarts, and its bootloader swaps the image in.
    Restarting,
}

impl UpdateStage {
    /// In the order of an update.
    pub const ALL: [Self; 5] =
        [Self::Asking, Self::Erasing, Self::Sending, Self::Verifying, Self::Restarting];

    /// What it is called.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Asking => "asking",
            Self::Erasing => "erasing",
            Self::Sending => "sending",
            Self::Verifying => "verifying",
            Self::Restarting => "restarting",
        }
    }
}

/// How far an update is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UpdateProgress {
    /// What it is about.
    pub stage: UpdateStage,
    /// Bytes of the stage that are done: erased, received or verified.
    pub done: u32,
    /// Length of the image, bytes.
    pub total: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Device,
    Version,
    Begin,
    Erasing,
    Sending,
    End,
    Verifying,
    Reboot,
    Waiting,
    Checking,
    Confirm,
}

/// The update, from its beginning until its end has been told.
#[derive(Clone, Debug, Default)]
pub(super) enum Update {
    #[default]
    None,
    UnderWay(UnderWay),
    Ended(Result<(), UpdateError>),
}

#[derive(Clone, Copy, Debug)]
pub(super) struct UnderWay {
    image: Image,
    stage: Stage,
    /// When the stage's message is due, again.
    due: u64,
    /// When the drive said something new, or was asked to restart.
    heard: u64,
    /// Of an answer, microseconds.
    timeout: u32,
    /// That every message has at least.
    attempts: u8,
    /// What the drive said last of the stage's bytes.
    offset: u32,
    /// The next byte to send.
    next: u32,
    /// Up to here there is room.
    limit: u32,
    /// The drive has been asked where it is.
    asked: bool,
    /// The caller has had enough.
    aborted: bool,
    /// When the next block may be sent.
    block_due: u64,
    /// When the drive must be back.
    back_by: u64,
}

impl fmt::Display for UpdateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoAnswer => f.write_str("the drive does not answer; one without a bootloader never does"),
            Self::Silent => f.write_str("the drive has stopped answering"),
            Self::Hardware { image, drive } => {
                write!(f, "the image is for hardware {image:08X}h, the drive is {drive:08X}h")
            }
            Self::TooLong { length, room } => {
                write!(f, "the image has {length} bytes, the drive has room for {room}")
            }
            Self::Older { image, running } => {
                write!(f, "the image is version {image}, older than the {running} that runs")
            }
            Self::Refused(code) => code.fmt(f),
            Self::Forgotten => f.write_str("the drive has restarted before the image was complete"),
            Self::OtherVersion(running) => write!(f, "after the restart version {running} runs"),
            Self::Aborted => f.write_str("the update was aborted"),
        }
    }
}

impl core::error::Error for UpdateError {}

impl Update {
    pub(super) fn begin(&mut self, image: Image, attempts: u8, timeout: u64) -> Result<(), NotTaken> {
        if !matches!(self, Self::None) {
            return Err(NotTaken::Full);
        }
        *self = Self::UnderWay(UnderWay {
            image,
            stage: Stage::Device,
            due: 0,
            // Counted from the first question on, whose time is not known yet.
            heard: u64::MAX,
            timeout: u32::try_from(timeout).unwrap_or(u32::MAX),
            attempts: attempts.max(1),
            offset: 0,
            next: 0,
            limit: 0,
            asked: false,
            aborted: false,
            block_due: 0,
            back_by: u64::MAX,
        });
        Ok(())
    }

    pub(super) fn poll_end(&mut self) -> Option<Result<(), UpdateError>> {
        let Self::Ended(end) = *self else { return None };
        *self = Self::None;
        Some(end)
    }

    pub(super) const fn abort(&mut self) {
        if let Self::UnderWay(under_way) = self {
            under_way.aborted = true;
        }
    }

    pub(super) fn progress(&self) -> Option<UpdateProgress> {
        let Self::UnderWay(UnderWay { image, stage, offset, .. }) = self else { return None };
        let stage = match stage {
            Stage::Device | Stage::Version | Stage::Begin => UpdateStage::Asking,
            Stage::Erasing => UpdateStage::Erasing,
            Stage::Sending => UpdateStage::Sending,
            Stage::End | Stage::Verifying => UpdateStage::Verifying,
            Stage::Reboot | Stage::Waiting | Stage::Checking | Stage::Confirm => UpdateStage::Restarting,
        };
        Some(UpdateProgress { stage, done: *offset, total: image.length })
    }

    /// When there is something to send; never is the end of time.
    pub(super) fn due(&self) -> u64 {
        let Self::UnderWay(under_way) = self else { return u64::MAX };
        match under_way.has_block() {
            _ if under_way.aborted => 0,
            true => under_way.due.min(under_way.block_due),
            false => under_way.due,
        }
    }

    /// The next message that is due; blocks are sent by [`Self::next_block`].
    pub(super) fn next(&mut self, now: u64) -> Option<ToDrive> {
        let Self::UnderWay(under_way) = self else { return None };
        if under_way.aborted {
            self.finish(Err(UpdateError::Aborted));
            return Some(ToDrive::Update(UpdateRequest::Abort));
        }
        if now < under_way.due {
            return None;
        }
        if under_way.is_gone(now) {
            let silent = under_way.stage != Stage::Device;
            self.finish(Err(if silent { UpdateError::Silent } else { UpdateError::NoAnswer }));
            return None;
        }
        Some(under_way.message(now))
    }

    /// The next block that is due, of the bytes of the image.
    pub(super) fn next_block(&mut self, now: u64, image: &[u8]) -> Option<ToDrive> {
        let Self::UnderWay(under_way) = self else { return None };
        if under_way.aborted || !under_way.has_block() || now < under_way.block_due {
            return None;
        }
        let rest = image.get(under_way.next as usize..)?;
        let mut data = [0xFF; BLOCK];
        data.iter_mut().zip(rest).for_each(|(place, byte)| *place = *byte);
        let block = (under_way.next / BLOCK as u32) as u16;
        under_way.next += BLOCK as u32;
        under_way.block_due = (under_way.block_due + PACE).max(now.saturating_sub(BURST * PACE));
        // The answer to the last block that there is room for is waited for.
        under_way.due = now.saturating_add(under_way.timeout.into());
        Some(ToDrive::Update(UpdateRequest::Data { block, data }))
    }

    /// Takes what the drive says.
    pub(super) fn take(&mut self, message: &FromDrive, now: u64) {
        let Self::UnderWay(under_way) = self else { return };
        let result = match message {
            FromDrive::Update(answer) => under_way.take(answer, now),
            FromDrive::Reboot if under_way.stage == Stage::Reboot => {
                under_way.wait_for_boot(now);
                Ok(false)
            }
            _ => return,
        };
        match result {
            Ok(false) => {}
            Ok(true) => self.finish(Ok(())),
            Err(error) => self.finish(Err(error)),
        }
    }

    fn finish(&mut self, end: Result<(), UpdateError>) {
        *self = Self::Ended(end);
    }
}

impl UnderWay {
    fn has_block(&self) -> bool {
        self.stage == Stage::Sending && self.next < self.limit.min(self.image.length)
    }

    /// Whether the drive has had time enough.
    fn is_gone(&mut self, now: u64) -> bool {
        self.heard = self.heard.min(now);
        let patience = match self.stage {
            Stage::Waiting => return now >= self.back_by,
            Stage::Device => NO_ANSWER,
            _ => SILENCE,
        };
        now - self.heard >= patience.max(u64::from(self.timeout) * u64::from(self.attempts))
    }

    /// The stage's message, sent at `now`.
    fn message(&mut self, now: u64) -> ToDrive {
        self.due = now.saturating_add(self.timeout.into());
        self.asked = self.stage == Stage::Sending;
        ToDrive::Update(match self.stage {
            Stage::Device => UpdateRequest::Device,
            Stage::Version | Stage::Checking => UpdateRequest::Version,
            Stage::Begin => UpdateRequest::Begin { length: self.image.length, hardware: self.image.hardware },
            Stage::Erasing | Stage::Sending | Stage::Verifying => UpdateRequest::Status,
            Stage::End => UpdateRequest::End { crc: self.image.crc },
            Stage::Reboot => {
                // Its answer may be lost, and a drive that restarts cannot repeat it: whether it has, its status tells.
                self.wait_for_boot(now);
                return ToDrive::Reboot;
            }
            Stage::Waiting => {
                self.due = now.saturating_add(LOOK);
                UpdateRequest::Status
            }
            Stage::Confirm => UpdateRequest::Confirm,
        })
    }

    /// The next stage, whose message is due at once.
    fn enter(&mut self, stage: Stage, now: u64) {
        (self.stage, self.due, self.offset, self.heard) = (stage, now, 0, now);
    }

    fn wait_for_boot(&mut self, now: u64) {
        if self.stage != Stage::Waiting {
            let back_by = self.back_by.min(now.saturating_add(BOOT));
            self.enter(Stage::Waiting, now.saturating_add(LOOK));
            (self.back_by, self.heard) = (back_by, now);
        }
    }

    /// What an answer makes of the stage; true at the end.
    fn take(&mut self, answer: &UpdateAnswer, now: u64) -> Result<bool, UpdateError> {
        let Image { hardware, version, length, .. } = self.image;
        match (*answer, self.stage) {
            (UpdateAnswer::Device { hardware: drive, .. }, Stage::Device) if drive != hardware => {
                return Err(UpdateError::Hardware { image: hardware, drive });
            }
            (UpdateAnswer::Device { room, .. }, Stage::Device) if length > room => {
                return Err(UpdateError::TooLong { length, room });
            }
            (UpdateAnswer::Device { .. }, Stage::Device) => self.enter(Stage::Version, now),
            (UpdateAnswer::Version(running), Stage::Version) if version < running => {
                return Err(UpdateError::Older { image: version, running });
            }
            (UpdateAnswer::Version(_), Stage::Version) => self.enter(Stage::Begin, now),
            (UpdateAnswer::Version(running), Stage::Checking) if running != version => {
                return Err(UpdateError::OtherVersion(running));
            }
            (UpdateAnswer::Version(_), Stage::Checking) => self.enter(Stage::Confirm, now),
            (UpdateAnswer::Status(status), _) => return self.take_status(&status, now),
            _ => {}
        }
        Ok(false)
    }

    fn take_status(&mut self, status: &UpdateStatus, now: u64) -> Result<bool, UpdateError> {
        let UpdateStatus { state, code, .. } = *status;
        match (self.stage, state) {
            // It was not asked for, or belongs to what was before.
            (Stage::Device | Stage::Version | Stage::Checking, _) => {}
            (Stage::Confirm, UpdateState::Idle) => return Ok(true),
            (Stage::Confirm, UpdateState::Trial) if code == UpdateCode::Done => {}
            (Stage::Confirm, UpdateState::Trial) => return Err(UpdateError::Refused(code)),
            // Another update's, from before the question.
            (Stage::Begin, UpdateState::Idle) if code == UpdateCode::Done => {}
            (_, UpdateState::Idle) if code == UpdateCode::Done => return Err(UpdateError::Forgotten),
            (_, UpdateState::Idle) => return Err(UpdateError::Refused(code)),
            (Stage::Begin, _) if code != UpdateCode::Done => return Err(UpdateError::Refused(code)),
            (Stage::Begin, UpdateState::Erasing) => {
                self.enter(Stage::Erasing, now);
                self.due = now.saturating_add(self.timeout.into());
            }
            (Stage::Erasing, UpdateState::Erasing) => self.note_progress(status, now),
            (Stage::Begin | Stage::Erasing, UpdateState::Receiving) => {
                self.enter(Stage::Sending, now);
                self.note_received(status, now);
            }
            (Stage::Sending, UpdateState::Receiving) => self.note_received(status, now),
            (Stage::End, UpdateState::Receiving) if code == UpdateCode::Sequence => {
                self.enter(Stage::Sending, now);
                self.note_received(status, now);
            }
            (Stage::End, UpdateState::Verifying) => {
                self.enter(Stage::Verifying, now);
                self.due = now.saturating_add(self.timeout.into());
            }
            (Stage::Verifying, UpdateState::Verifying) => self.note_progress(status, now),
            (Stage::End | Stage::Verifying, UpdateState::Marked) => self.enter(Stage::Reboot, now),
            // It has not restarted: the request was lost, or refused.
            (Stage::Waiting, UpdateState::Marked) if now >= self.heard.saturating_add(SETTLED) => {
                self.enter(Stage::Reboot, now);
            }
            (Stage::Waiting, UpdateState::Trial) => self.enter(Stage::Checking, now),
            (_, UpdateState::Trial) => return Err(UpdateError::Refused(UpdateCode::Trial)),
            _ => {}
        }
        Ok(false)
    }

    /// A drive that gets on is given time.
    fn note_progress(&mut self, status: &UpdateStatus, now: u64) {
        if status.offset != self.offset {
            (self.offset, self.heard) = (status.offset, now);
        }
    }

    fn note_received(&mut self, status: &UpdateStatus, now: u64) {
        let UpdateStatus { code, window, offset, .. } = *status;
        if offset > self.offset {
            (self.offset, self.heard) = (offset, now);
        }
        // A block is missing, or nothing came any more: on from where the drive is. What it has had it does not count again.
        if code == UpdateCode::Sequence || core::mem::take(&mut self.asked) {
            self.next = offset;
        }
        self.next = self.next.max(offset);
        self.limit = offset.saturating_add(u32::from(window) * BLOCK as u32);
        self.due = now.saturating_add(self.timeout.into());
        if offset >= self.image.length {
            self.enter(Stage::End, now);
        }
    }
}
