//! The flash inside a microcontroller (STM32G4, RM0440 section 3.3): words of 8 bytes that are programmed
//! once an erase, pages, and a power that fails anywhere.

use crate::flash::{Memory, Tear};
use crate::random::Random;
use core::fmt;
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};

/// Bytes of a word.
pub const WORD: usize = 8;
/// A word is programmed in this time, ns (DS12589, section 5.3.12, typical).
pub const PROGRAM_NS: u64 = 85_000;
/// A page is erased in this time, ns (likewise).
pub const ERASE_NS: u64 = 22_000_000;

/// The flash, in pages of `PAGE` bytes.
#[derive(Clone, Debug)]
pub struct InternalFlash<M, const PAGE: usize = 2048> {
    memory: M,
    capacity: u32,
    busy: u64,
    steps: u64,
    cut: Option<(u64, Tear)>,
    off: bool,
    random: Random,
}

/// Reason why an operation failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InternalFlashError {
    /// The power is gone, until [`InternalFlash::restore_power`].
    PowerLost,
    /// Not whole words, or whole pages.
    NotAligned,
    /// Beyond the end.
    Range,
    /// A word that is programmed already; the hardware takes zeros alone then (PROGERR).
    ProgrammedTwice,
}

impl<M: Memory, const PAGE: usize> InternalFlash<M, PAGE> {
    /// A flash of `capacity` bytes around some memory.
    pub const fn new(memory: M, capacity: u32, seed: u64) -> Self {
        Self { memory, capacity, busy: 0, steps: 0, cut: None, off: false, random: Random::new(seed) }
    }

    /// Writes as a debugger does, whatever was there.
    pub fn load(&mut self, address: u32, bytes: &[u8]) {
        (address..).zip(bytes).for_each(|(at, byte)| self.memory.set(at, *byte));
    }

    /// Lets the power fail in step `steps` from now: each word that is programmed is one, and each page that
    /// is erased.
    pub const fn cut_after(&mut self, steps: u64, tear: Tear) {
        self.cut = Some((self.steps + steps, tear));
    }

    /// The power is back.
    pub const fn restore_power(&mut self) {
        (self.off, self.cut) = (false, None);
    }

    /// Returns whether the cut has happened.
    pub const fn is_off(&self) -> bool {
        self.off
    }

    /// Steps since it was made: the places where a cut can strike.
    pub const fn steps(&self) -> u64 {
        self.steps
    }

    /// Time that operations have taken since the last call, ns.
    pub const fn take_busy(&mut self) -> u64 {
        core::mem::replace(&mut self.busy, 0)
    }

    /// The memory, to look at.
    pub const fn memory(&self) -> &M {
        &self.memory
    }

    fn check(&self, from: u32, length: usize, unit: usize) -> Result<(), InternalFlashError> {
        let end = u64::from(from) + length as u64;
        match () {
            () if self.off => Err(InternalFlashError::PowerLost),
            () if !(from as usize).is_multiple_of(unit) || !length.is_multiple_of(unit) => {
                Err(InternalFlashError::NotAligned)
            }
            () if end > u64::from(self.capacity) => Err(InternalFlashError::Range),
            () => Ok(()),
        }
    }

    /// Time goes on by one step; whether the power fails in it, and what that leaves.
    fn step(&mut self) -> Option<Tear> {
        let struck = self.cut.filter(|(at, _)| *at == self.steps);
        self.steps += 1;
        self.off |= struck.is_some();
        struck.map(|(_, tear)| tear)
    }

    /// One byte of what a step changes.
    fn change(&mut self, address: u32, wanted: u8, torn: Option<Tear>) {
        let mut old = [0xFF];
        self.memory.read(address, &mut old);
        let [old] = old;
        let new = match torn {
            None => wanted,
            Some(Tear::Nothing) => old,
            Some(Tear::Partial) => {
                let changed = self.random.bits() as u8;
                (old & !changed) | (wanted & changed)
            }
            Some(Tear::Garbage) => self.random.bits() as u8,
        };
        self.memory.set(address, new);
    }

    fn program(&mut self, address: u32, word: &[u8]) -> Result<(), InternalFlashError> {
        let mut old = [0; WORD];
        self.memory.read(address, &mut old);
        if old != [0xFF; WORD] && word.iter().any(|byte| *byte != 0) {
            return Err(InternalFlashError::ProgrammedTwice);
        }
        self.busy += PROGRAM_NS;
        let torn = self.step();
        (address..).zip(word).for_each(|(at, wanted)| self.change(at, *wanted, torn));
        if torn.is_some() { Err(InternalFlashError::PowerLost) } else { Ok(()) }
    }
}

impl<M, const PAGE: usize> ErrorType for InternalFlash<M, PAGE> {
    type Error = InternalFlashError;
}

impl<M: Memory, const PAGE: usize> ReadNorFlash for InternalFlash<M, PAGE> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), InternalFlashError> {
        self.check(offset, bytes.len(), Self::READ_SIZE)?;
        self.memory.read(offset, bytes);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.capacity as usize
    }
}

impl<M: Memory, const PAGE: usize> NorFlash for InternalFlash<M, PAGE> {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = PAGE;

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), InternalFlashError> {
        self.check(offset, bytes.len(), WORD)?;
        for (at, word) in (offset..).step_by(WORD).zip(bytes.chunks(WORD)) {
            self.program(at, word)?;
        }
        Ok(())
    }

    fn erase(&mut self, from: u32, to: u32) -> Result<(), InternalFlashError> {
        self.check(from, to.saturating_sub(from) as usize, PAGE)?;
        for page in (from..to).step_by(PAGE) {
            self.busy += ERASE_NS;
            match self.step() {
                None => self.memory.clear(page, page + PAGE as u32),
                torn => {
                    (page..page + PAGE as u32).for_each(|at| self.change(at, 0xFF, torn));
                    return Err(InternalFlashError::PowerLost);
                }
            }
        }
        Ok(())
    }
}

impl NorFlashError for InternalFlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::NotAligned => NorFlashErrorKind::NotAligned,
            Self::Range => NorFlashErrorKind::OutOfBounds,
            Self::PowerLost | Self::ProgrammedTwice => NorFlashErrorKind::Other,
        }
    }
}

impl fmt::Display for InternalFlashError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::PowerLost => "the power failed",
            Self::NotAligned => "not a whole number of words or pages",
            Self::Range => "beyond the end of the flash",
            Self::ProgrammedTwice => "a word was programmed twice without an erase",
        })
    }
}

impl core::error::Error for InternalFlashError {}
