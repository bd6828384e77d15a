//! Slots as the node of narx-core asks for them (feature `node`).

use crate::one_slot::{self, Addresses, OneSlot, Step};
use crate::slot::{Condition, Slot, SlotError, Verdict};
use crate::verify::Refused;
use crate::version::Version;
use core::fmt;
use crc::{CRC_32_ISO_HDLC, Crc, Digest, NoTable};
use embedded_storage::nor_flash::{NorFlash, NorFlashErrorKind};
use narx_core::bus::narmotion;
use narx_core::bus::narmotion::update::{ImageVersion, UpdateCode};
use narx_core::node::update::{self, Loader, SlotReply, SlotTask, Slots};

/// Without a table: a kilobyte of flash is more than the milliseconds that it saves.
static CRC32: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);
/// Bytes that are read at once.
const CHUNK: usize = 128;

/// A slot that can be programmed, as the node of narx-core asks for it.
pub trait Programs {
    /// Reads the state of the slots that the node has to know at power-up: for
    /// [`narx_core::node::Node::attach_update`].
    ///
    /// # Errors
    /// The flash cannot be read.
    fn slots(&mut self) -> Result<Slots, SlotError>;

    /// Does what the node asks for; sums are [`Server`]'s.
    ///
    /// # Errors
    /// It cannot be done.
    fn execute(&mut self, task: &SlotTask) -> Result<(), SlotError>;

    /// Reads what was written.
    ///
    /// # Errors
    /// The flash fails, or the slot ends before.
    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), SlotError>;
}

impl<F: NorFlash> Programs for Slot<F> {
    fn slots(&mut self) -> Result<Slots, SlotError> {
        let Condition { running, trial, marked, verdict } = self.condition()?;
        let condition = match verdict {
            _ if trial => update::Condition::Trial,
            _ if marked => update::Condition::Marked,
            verdict => update::Condition::Settled(code_of(verdict)),
        };
        Ok(Slots {
            hardware: self.hardware(),
            room: self.room(),
            page: self.page(),
            running: running.map(ImageVersion::from).unwrap_or_default(),
            condition,
        })
    }

    fn execute(&mut self, task: &SlotTask) -> Result<(), SlotError> {
        match task {
            SlotTask::Clear => self.begin(),
            SlotTask::Erase { offset } => self.erase(*offset),
            SlotTask::Write { offset, data } => self.write(*offset, data),
            SlotTask::Mark { length } => self.inspect(*length).and_then(|_| self.mark()),
            SlotTask::Confirm => self.confirm(),
            SlotTask::Sum { .. } | SlotTask::Leave => Err(NOT_OURS),
        }
    }

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), SlotError> {
        Self::read(self, offset, bytes)
    }
}

/// The slot in which the application stands that serves it.
#[derive(Clone, Debug)]
pub struct Inside<F> {
    /// The slot.
    pub slot: OneSlot<F>,
    /// Addresses at which the bootloader is to receive: those of the application.
    pub addresses: Addresses,
}

impl<F: NorFlash> Programs for Inside<F> {
    fn slots(&mut self) -> Result<Slots, SlotError> {
        let one_slot::Condition { step, .. } = self.slot.condition()?;
        let running = self.slot.header()?.map(|header| header.version.into());
        let settled = update::Condition::Settled(UpdateCode::Done);
        Ok(Slots {
            hardware: self.slot.hardware(),
            room: self.slot.room(),
            // It cannot erase what it runs from.
            page: 0,
            running: running.unwrap_or_default(),
            condition: if step == Step::Confirm { update::Condition::Trial } else { settled },
        })
    }

    fn execute(&mut self, task: &SlotTask) -> Result<(), SlotError> {
        match task {
            SlotTask::Leave => self.slot.leave(self.addresses),
            SlotTask::Confirm => self.slot.confirm(),
            _ => Err(NOT_OURS),
        }
    }

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), SlotError> {
        self.slot.read(offset, bytes)
    }
}

/// The slot that the bootloader fills.
impl<F: NorFlash> Programs for OneSlot<F> {
    fn slots(&mut self) -> Result<Slots, SlotError> {
        let one_slot::Condition { floor, verdict, .. } = self.condition()?;
        Ok(Slots {
            hardware: self.hardware(),
            room: self.room(),
            page: self.page(),
            // The last one that ran: an image that is older is refused.
            running: floor.map(ImageVersion::from).unwrap_or_default(),
            condition: update::Condition::Settled(code_of(verdict)),
        })
    }

    fn execute(&mut self, task: &SlotTask) -> Result<(), SlotError> {
        match task {
            SlotTask::Clear => {
                let addresses = self.condition()?.addresses;
                self.begin(addresses.unwrap_or(FACTORY))
            }
            SlotTask::Erase { offset } => self.erase(*offset),
            SlotTask::Write { offset, data } => self.write(*offset, data),
            SlotTask::Mark { length } => self.complete(*length),
            SlotTask::Sum { .. } | SlotTask::Confirm | SlotTask::Leave => Err(NOT_OURS),
        }
    }

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), SlotError> {
        Self::read(self, offset, bytes)
    }
}

/// Addresses of a drive that has never left.
const FACTORY: Addresses = [narmotion::Addresses::FACTORY.drive, narmotion::Addresses::FACTORY.master];
/// A task that this slot does not do.
const NOT_OURS: SlotError = SlotError::Flash(NorFlashErrorKind::Other);

impl<F: NorFlash> OneSlot<F> {
    /// The bus's side of it, in a bootloader.
    ///
    /// # Errors
    /// The flash cannot be read.
    pub fn loader(&mut self) -> Result<Loader, SlotError> {
        let [drive, master] = self.condition()?.addresses.unwrap_or(FACTORY);
        Ok(Loader::new(&self.slots()?, narmotion::Addresses { drive, master }))
    }
}

/// Serves a node's requests. Each is bounded: a page is erased, a piece written, a kilobyte read.
#[derive(Clone)]
pub struct Server<P> {
    slot: P,
    sum: Digest<'static, u32, NoTable>,
}

impl<P: Programs> Server<P> {
    /// Over this slot.
    pub fn new(slot: P) -> Self {
        Self { slot, sum: CRC32.digest() }
    }

    /// Reads the state of the slots: see [`Programs::slots`].
    ///
    /// # Errors
    /// The flash cannot be read.
    pub fn slots(&mut self) -> Result<Slots, SlotError> {
        self.slot.slots()
    }

    /// Does what the node asks for.
    pub fn execute(&mut self, task: &SlotTask) -> SlotReply {
        let done = match *task {
            SlotTask::Sum { offset, length } => self.sum(offset, length).map(SlotReply::Sum),
            _ => self.slot.execute(task).map(|()| SlotReply::Done),
        };
        done.unwrap_or_else(|error| SlotReply::Failed(error.into()))
    }

    /// The slot.
    pub const fn slot(&mut self) -> &mut P {
        &mut self.slot
    }

    /// The slot, to keep.
    pub fn into_slot(self) -> P {
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

impl<P: fmt::Debug> fmt::Debug for Server<P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.slot.fmt(f)
    }
}

fn code_of(verdict: Option<Verdict>) -> UpdateCode {
    match verdict {
        None => UpdateCode::Done,
        Some(Verdict::Reverted) => UpdateCode::Reverted,
        Some(Verdict::Refused(kind)) => code(kind),
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
