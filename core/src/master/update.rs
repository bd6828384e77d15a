//! Programs the drive: sends an image, has it swapped in, and confirms it once the drive has answered again.
//!
//! ```text
//!  device -> version -> begin -> erasing -> sending -> end -> verifying -> reboot -> waiting -> checking -> confirm
//!            hardware,                      blocks, as far                           on trial:  the image's
//!            room, age                      as the window says                       swapped in version?
//! ```
//!
//! Each stage repeats one message until the drive's status shows the next stage, so neither a lost request
//! nor a lost answer matters. Blocks are sent beside set-points and requests, no faster than [`PACE`].

use super::error::NotTaken;
use crate::bus::narmotion::update::{
    BLOCK, ImageVersion, UpdateAnswer, UpdateCode, UpdateRequest, UpdateState, UpdateStatus,
};
use crate::bus::narmotion::{FromDrive, ToDrive};
use crate::storage::record::CRC32;
use core::fmt;

/// Average time from one block to the next, microseconds. A block takes at most 320 of them on the bus; a
/// fifth of the bus is left to other traffic.
pub const PACE: u64 = 400;
/// Blocks that may follow a late block without a pause.
const BURST: u64 = 8;
/// Time without progress after which the drive counts as gone, microseconds. It is long because the drive, or
/// the device that carries its frames, may be busy with something else for a while.
const SILENCE: u64 = 5_000_000;
/// Time without a first answer after which the drive counts as gone, microseconds: a drive without a
/// bootloader never answers.
const NO_ANSWER: u64 = 2_000_000;
/// Time after a reboot request from which a status shows that the drive has not restarted, microseconds. An
/// earlier status may be a late answer: a drive that was busy then answers each request that has waited.
const SETTLED: u64 = 1_000_000;
/// Period and duration of the search for the drive after its reboot, microseconds: two images are copied
/// meanwhile.
const LOOK: u64 = 200_000;
const BOOT: u64 = 60_000_000;

/// An image to send: data of its header, and length and CRC of its bytes.
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
    /// Describes the image `bytes`, whose header states `hardware` and `version`.
    pub fn new(hardware: u32, version: ImageVersion, bytes: &[u8]) -> Self {
        let length = u32::try_from(bytes.len()).unwrap_or(u32::MAX);
        Self { hardware, version, length, crc: CRC32.checksum(bytes) }
    }
}

/// Reason why a drive does not run the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UpdateError {
    /// The drive does not answer. A drive without a bootloader never does.
    NoAnswer,
    /// The drive has answered before, but does not any more.
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
    /// The drive has refused the image, or given up the update.
    Refused(UpdateCode),
    /// The drive no longer knows the image: it has restarted before the image was complete, or lost the
    /// bootloader's result.
    Forgotten,
    /// After the reboot another version runs.
    OtherVersion(ImageVersion),
    /// Ended by [`super::Master::abort_update`].
    Aborted,
}

/// Stage of an update.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UpdateStage {
    /// Asks whether the drive takes the image.
    Asking,
    /// The drive is asked to erase its slot, and erases it.
    Erasing,
    /// Blocks are sent.
    Sending,
    /// The drive reads back what it has written.
    Verifying,
    /// The drive restarts, and its bootloader swaps the image in.
    Restarting,
}

impl UpdateStage {
    /// All stages, in the order of an update.
    pub const ALL: [Self; 5] =
        [Self::Asking, Self::Erasing, Self::Sending, Self::Verifying, Self::Restarting];

    /// Name of the stage.
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

/// Progress of an update.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UpdateProgress {
    /// Present stage.
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

/// The update, from its beginning until its result is taken.
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
    /// Time at which the stage's message is due next.
    due: u64,
    /// Time at which the drive last made progress, or was asked to restart.
    received: u64,
    /// Longest time until an answer, microseconds.
    timeout: u32,
    /// Attempts that every message has at least.
    attempts: u8,
    /// Bytes of the stage that are done, as the drive last reported them.
    offset: u32,
    /// The next byte to send.
    next: u32,
    /// End of the room for blocks, bytes.
    limit: u32,
    /// The status was requested while blocks are sent.
    asked: bool,
    /// The caller has aborted the update.
    aborted: bool,
    /// Earliest time of the next block.
    block_due: u64,
    /// Time by which the drive must be back.
    back_by: u64,
}

impl fmt::Display for UpdateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoAnswer => f.write_str("the drive does not answer; it may have no bootloader"),
            Self::Silent => f.write_str("the drive has stopped answering"),
            Self::Hardware { image, drive } => {
                write!(f, "the image is for hardware {image:08X}h, the drive is {drive:08X}h")
            }
            Self::TooLong { length, room } => {
                write!(f, "the image has {length} bytes, the drive has room for {room}")
            }
            Self::Older { image, running } => {
                write!(f, "the image is version {image}, older than the running version {running}")
            }
            Self::Refused(code) => code.fmt(f),
            Self::Forgotten => f.write_str("the drive has restarted before the image was complete"),
            Self::OtherVersion(running) => write!(f, "version {running} runs after the restart"),
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
            // Counted from the first message on, whose time is not known yet.
            received: u64::MAX,
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
            Stage::Device | Stage::Version => UpdateStage::Asking,
            Stage::Begin | Stage::Erasing => UpdateStage::Erasing,
            Stage::Sending => UpdateStage::Sending,
            Stage::End | Stage::Verifying => UpdateStage::Verifying,
            Stage::Reboot | Stage::Waiting | Stage::Checking | Stage::Confirm => UpdateStage::Restarting,
        };
        Some(UpdateProgress { stage, done: *offset, total: image.length })
    }

    /// Time of the next message or block; `u64::MAX` if there is none.
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

    /// Returns the next block that is due, from the bytes of the image.
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
        // After the last block with room the drive's answer is awaited.
        under_way.due = now.saturating_add(under_way.timeout.into());
        Some(ToDrive::Update(UpdateRequest::Data { block, data }))
    }

    /// Takes a message of the drive.
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

    /// Returns whether the drive counts as gone: it has made no progress, or has not returned, in time.
    fn is_gone(&mut self, now: u64) -> bool {
        self.received = self.received.min(now);
        let patience = match self.stage {
            Stage::Waiting => return now >= self.back_by,
            Stage::Device => NO_ANSWER,
            _ => SILENCE,
        };
        now - self.received >= patience.max(u64::from(self.timeout) * u64::from(self.attempts))
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
                // The answer may be lost, and a drive that restarts cannot repeat it: its status shows
                // whether it has restarted.
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

    /// Enters a stage, whose message is due at once.
    fn enter(&mut self, stage: Stage, now: u64) {
        (self.stage, self.due, self.offset, self.received) = (stage, now, 0, now);
    }

    fn wait_for_boot(&mut self, now: u64) {
        if self.stage != Stage::Waiting {
            let back_by = self.back_by.min(now.saturating_add(BOOT));
            self.enter(Stage::Waiting, now.saturating_add(LOOK));
            (self.back_by, self.received) = (back_by, now);
        }
    }

    /// Takes an answer, which may lead to the next stage; returns true at the end of the update.
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
            // The status was not requested, or belongs to an earlier stage.
            (Stage::Device | Stage::Version | Stage::Checking, _) => {}
            (Stage::Confirm, UpdateState::Idle) => return Ok(true),
            (Stage::Confirm, UpdateState::Trial) if code == UpdateCode::Done => {}
            (Stage::Confirm, UpdateState::Trial) => return Err(UpdateError::Refused(code)),
            // The status of an earlier update, sent before the request.
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
            // The drive has not restarted: the request was lost, or refused.
            (Stage::Waiting, UpdateState::Marked) if now >= self.received.saturating_add(SETTLED) => {
                self.enter(Stage::Reboot, now);
            }
            (Stage::Waiting, UpdateState::Trial) => self.enter(Stage::Checking, now),
            (_, UpdateState::Trial) => return Err(UpdateError::Refused(UpdateCode::Trial)),
            _ => {}
        }
        Ok(false)
    }

    /// Notes the drive's progress, which extends its time.
    fn note_progress(&mut self, status: &UpdateStatus, now: u64) {
        if status.offset != self.offset {
            (self.offset, self.received) = (status.offset, now);
        }
    }

    fn note_received(&mut self, status: &UpdateStatus, now: u64) {
        let UpdateStatus { code, window, offset, .. } = *status;
        if offset > self.offset {
            (self.offset, self.received) = (offset, now);
        }
        // A block is missing, or the answer had to be requested: go on from the drive's offset. The drive
        // ignores blocks that it has already.
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
