//! The application's side: it fills the slot that the bootloader looks at.
//!
//! ```text
//!  begin -> erase, page by page -> write, piece by piece -> crc -> mark -> reset -> (bootloader) -> confirm
//! ```
//!
//! Nothing of it needs the signature, which the bootloader verifies, alone: an application that could be
//! talked into skipping it must not matter.

use crate::Version;
use crate::boot;
use crate::image::{HEADER_LENGTH, Header};
use crate::map::{Map, MapError};
use crate::mark::{self, Mark};
use crate::verify::{self, ImageError, Refused};
use embedded_storage::nor_flash::{NorFlash, NorFlashError, NorFlashErrorKind};

/// The slots of a board, as its application has them.
#[derive(Clone, Debug)]
pub struct Slot<F> {
    flash: F,
    map: Map,
    hardware: u32,
}

/// Condition of the slots, as an application reads it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Condition {
    /// Version of the active image; `None` for one without a header, as a debugger loads it.
    pub running: Option<Version>,
    /// It waits for its confirmation.
    pub trial: bool,
    /// The next boot swaps.
    pub marked: bool,
    /// Reason why the last candidate was not taken; `None` without one.
    pub verdict: Option<Verdict>,
}

/// Reason why the last candidate does not run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The bootloader has refused it.
    Refused(Refused),
    /// It ran and was not confirmed.
    Reverted,
}

/// Reason why a step was not done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlotError {
    /// The flash does not do what it is told.
    Flash(NorFlashErrorKind),
    /// The active image is on trial: the slot holds the one before.
    Trial,
    /// There is no image to be marked, or not one for this board.
    Image(ImageError),
}

impl<F: NorFlash> Slot<F> {
    /// The slots in this flash, on a board with this hardware id.
    ///
    /// # Errors
    /// The flash cannot have this map, or the map has one slot.
    pub fn new(flash: F, map: Map, hardware: u32) -> Result<Self, MapError> {
        map.check(&flash)?;
        if map.dfu.is_empty() {
            return Err(MapError::Dfu);
        }
        Ok(Self { flash, map, hardware })
    }

    /// Longest image, header included, bytes.
    pub const fn room(&self) -> u32 {
        self.map.room()
    }

    /// Bytes that one [`erase`](Self::erase) erases.
    pub const fn page(&self) -> u32 {
        F::ERASE_SIZE as u32
    }

    /// The board that images must be for.
    pub const fn hardware(&self) -> u32 {
        self.hardware
    }

    /// Map of the flash, with the ranges of the slots.
    pub const fn map(&self) -> &Map {
        &self.map
    }

    /// The flash, to look at.
    pub const fn flash(&mut self) -> &mut F {
        &mut self.flash
    }

    /// The flash, to keep.
    pub fn into_flash(self) -> F {
        self.flash
    }

    /// Reads the condition of the slots.
    ///
    /// # Errors
    /// The flash cannot be read.
    pub fn condition(&mut self) -> Result<Condition, SlotError> {
        let mark = self.mark_state()?;
        let running = self.header(self.map.active.start)?.ok().map(|header| header.version);
        let verdict = match mark {
            Mark::Settled { reverted: true } => Some(Verdict::Reverted),
            Mark::Settled { reverted: false } => {
                let code = mark::verdict(&mut self.flash, &self.map).map_err(SlotError::Flash)?;
                Refused::of(code).map(Verdict::Refused)
            }
            _ => None,
        };
        Ok(Condition { running, trial: mark == Mark::Trial, marked: mark == Mark::Candidate, verdict })
    }

    /// Begins an update: what was marked is not any more.
    ///
    /// # Errors
    /// The active image is on trial, or the flash fails.
    pub fn begin(&mut self) -> Result<(), SlotError> {
        match self.mark_state()? {
            Mark::Settled { .. } => Ok(()),
            Mark::Candidate | Mark::Settling => {
                boot::confirm(&mut self.flash, &self.map).map_err(SlotError::Flash)
            }
            Mark::Trial | Mark::Swapping | Mark::Reverting => Err(SlotError::Trial),
        }
    }

    /// Erases the page at `offset` of the slot, bytes.
    ///
    /// # Errors
    /// The flash fails, or the slot has no such page.
    pub fn erase(&mut self, offset: u32) -> Result<(), SlotError> {
        let from = self.place(offset, self.page())?;
        self.flash.erase(from, from + self.page()).map_err(|error| SlotError::Flash(error.kind()))
    }

    /// Writes into erased flash. Offset and length are multiples of the word that the flash programs; 32 is
    /// one of every flash.
    ///
    /// # Errors
    /// The flash fails, or the slot ends before.
    pub fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), SlotError> {
        let from = self.place(offset, bytes.len() as u32)?;
        self.flash.write(from, bytes).map_err(|error| SlotError::Flash(error.kind()))
    }

    /// Reads back.
    ///
    /// # Errors
    /// The flash fails, or the slot ends before.
    pub fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), SlotError> {
        let from = self.place(offset, bytes.len() as u32)?;
        self.flash.read(from, bytes).map_err(|error| SlotError::Flash(error.kind()))
    }

    /// Looks at the header of what was received: an image of `length` bytes for this board, not older than
    /// the running one. All of it the bootloader looks at again, and at the signature; said here, it is said
    /// before the reset.
    ///
    /// # Errors
    /// It is not such an image, or the flash fails.
    pub fn inspect(&mut self, length: u32) -> Result<Header, SlotError> {
        let header = self.header(self.map.dfu.start)?.map_err(SlotError::Image)?;
        if header.image_length() != length {
            return Err(SlotError::Image(ImageError::TooLong(header.image_length())));
        }
        match self.header(self.map.active.start)? {
            Ok(running) if header.version < running.version => {
                Err(SlotError::Image(ImageError::Older(header.version)))
            }
            _ => Ok(header),
        }
    }

    /// Marks the image for the next boot. Look at it before.
    ///
    /// # Errors
    /// The active image is on trial, or the flash fails.
    pub fn mark(&mut self) -> Result<(), SlotError> {
        match self.mark_state()? {
            Mark::Candidate => Ok(()),
            Mark::Settled { .. } | Mark::Settling => {
                boot::mark_candidate(&mut self.flash, &self.map).map_err(SlotError::Flash)
            }
            Mark::Trial | Mark::Swapping | Mark::Reverting => Err(SlotError::Trial),
        }
    }

    /// Confirms the active image: it stays. Without a trial there is nothing to do.
    ///
    /// # Errors
    /// The flash fails.
    pub fn confirm(&mut self) -> Result<(), SlotError> {
        match self.mark_state()? {
            Mark::Trial | Mark::Settling => {
                boot::confirm(&mut self.flash, &self.map).map_err(SlotError::Flash)
            }
            _ => Ok(()),
        }
    }

    fn mark_state(&mut self) -> Result<Mark, SlotError> {
        Mark::read(&mut self.flash, &self.map).map_err(SlotError::Flash)
    }

    fn header(&mut self, from: u32) -> Result<Result<Header, ImageError>, SlotError> {
        let mut bytes = [0; HEADER_LENGTH];
        self.flash.read(from, &mut bytes).map_err(|error| SlotError::Flash(error.kind()))?;
        Ok(verify::inspect(&bytes, self.hardware, self.map.room()))
    }

    /// The place in the flash of a part of the slot.
    fn place(&self, offset: u32, length: u32) -> Result<u32, SlotError> {
        match offset.checked_add(length) {
            Some(end) if end <= self.map.room() => Ok(self.map.dfu.start + offset),
            _ => Err(SlotError::Flash(NorFlashErrorKind::OutOfBounds)),
        }
    }
}
