//! The slot as the node of narx-core asks for it (feature `node`).

use crate::slot::{Condition, Slot, SlotError, Verdict};
use crate::verify::Refused;
use crate::version::Version;
use core::fmt;
use crc::{CRC_32_ISO_HDLC, Crc, Digest, NoTable};
use embedded_storage::nor_flash::{NorFlash, NorFlashErrorKind};
use narx_core::bus::narmotion::update::{ImageVersion, UpdateCode};
use narx_core::node::update::{self, SlotReply, SlotTask, Slots};

/// Without a table: a kilobyte of flash is more than the milliseconds that it saves.
static CRC32: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);
/// Bytes that are read at once.
const CHUNK: usize = 128;

/// Serves a node's requests. Each is bounded: a page is erased, a piece written, a kilobyte read.
#[derive(Clone)]
pub struct Server<F> {
    slot: Slot<F>,
    sum: Digest<'static, u32, NoTable>,
}

impl<F: NorFlash> Server<F> {
    /// Over these slots.
    pub fn new(slot: Slot<F>) -> Self {
        Self { slot, sum: CRC32.digest() }
    }

    /// Reads the state of the slots that the node has to know at power-up: for
    /// [`narx_core::node::Node::attach_update`].
    ///
    /// # Errors
    /// The flash cannot be read.
    pub fn slots(&mut self) -> Result<Slots, SlotError> {
        let Condition { running, trial, marked, verdict } = self.slot.condition()?;
        let condition = match verdict {
            _ if trial => update::Condition::Trial,
            _ if marked => update::Condition::Marked,
            None => update::Condition::Settled(UpdateCode::Done),
            Some(Verdict::Reverted) => update::Condition::Settled(UpdateCode::Reverted),
            Some(Verdict::Refused(kind)) => update::Condition::Settled(code(kind)),
        };
        Ok(Slots {
            hardware: self.slot.hardware(),
            room: self.slot.room(),
            page: self.slot.page(),
            running: running.map(ImageVersion::from).unwrap_or_default(),
            condition,
        })
    }

    /// Does what the node asks for.
    pub fn execute(&mut self, request: &SlotTask) -> SlotReply {
        let done = match request {
            SlotTask::Clear => self.slot.begin(),
            SlotTask::Erase { offset } => self.slot.erase(*offset),
            SlotTask::Write { offset, data } => self.slot.write(*offset, data),
            SlotTask::Mark { length } => self.slot.inspect(*length).and_then(|_| self.slot.mark()),
            SlotTask::Confirm => self.slot.confirm(),
            SlotTask::Sum { offset, length } => {
                return self
                    .sum(*offset, *length)
                    .map_or_else(|error| SlotReply::Failed(error.into()), SlotReply::Sum);
            }
        };
        done.map_or_else(|error| SlotReply::Failed(error.into()), |()| SlotReply::Done)
    }

    /// The slots.
    pub const fn slot(&mut self) -> &mut Slot<F> {
        &mut self.slot
    }

    /// The slots, to keep.
    pub fn into_slot(self) -> Slot<F> {
        self.slot
    }

    fn sum(&mut self, offset: u32, length: u32) -> Result<u32, SlotError> {
        if offset == 0 {
            self.sum = CRC32.digest();
        }
        let end = offset.checked_add(length).ok_or(SlotError::Flash(NorFlashErrorKind::OutOfBounds))?;
        let mut at = offset;
        let mut chunk = [0; CHUNK];
        while at < end {
            let length = CHUNK.min((end - at) as usize);
            let Some(part) = chunk.get_mut(..length) else { break };
            self.slot.read(at, part)?;
            self.sum.update(part);
            at += length as u32;
        }
        Ok(self.sum.clone().finalize())
    }
}

impl<F: fmt::Debug> fmt::Debug for Server<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.slot.fmt(f)
    }
}

impl From<Version> for ImageVersion {
    fn from(version: Version) -> Self {
        let Version { major, minor, patch, build } = version;
        Self { major, minor, patch, build }
    }
}

impl From<SlotError> for UpdateCode {
    fn from(error: SlotError) -> Self {
        match error {
            SlotError::Flash(_) => Self::Flash,
            SlotError::Trial => Self::Trial,
            SlotError::Image(error) => code(error.kind()),
        }
    }
}

const fn code(kind: Refused) -> UpdateCode {
    match kind {
        Refused::NoImage => UpdateCode::NoImage,
        Refused::Hardware => UpdateCode::Hardware,
        Refused::TooLong => UpdateCode::Length,
        Refused::Signature => UpdateCode::Signature,
        Refused::Older => UpdateCode::Older,
    }
}
