//! The chip's own flash as memory. While a page is erased (22 ms) or a word is programmed (0.1 ms) the
//! processor stands still, because its code is in the same flash: it is for a drive at rest.

use super::wait_for;
use crate::flash_map::{PAGE, START, WORD};
use core::ops::Range;
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};
use stm32_metapac::FLASH;
use stm32_metapac::flash::regs::Sr;

/// A part of the flash.
#[derive(Debug)]
pub struct Region {
    range: Range<u32>,
}

/// Reason why the flash did not do what it was told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// Beyond the region, or not on the border of a page or word.
    Address,
    /// Protected, or written twice.
    Refused,
}

impl NorFlashError for Error {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Address => NorFlashErrorKind::OutOfBounds,
            Self::Refused => NorFlashErrorKind::Other,
        }
    }
}

/// Errors of the last operation: FLASH_SR, bits 1 to 9.
const ERRORS: u32 = 0x3FA;

impl Region {
    /// The pages of `range`, of which nobody else makes a region.
    pub const fn new(range: Range<u32>) -> Self {
        Self { range }
    }

    /// The address of `offset`, if there are `length` bytes behind it.
    fn address(&self, offset: u32, length: u32, unit: u32) -> Result<u32, Error> {
        let end = offset.checked_add(length).ok_or(Error::Address)?;
        let fits = end <= self.range.end - self.range.start
            && offset.is_multiple_of(unit)
            && end.is_multiple_of(unit);
        if fits { Ok(START + self.range.start + offset) } else { Err(Error::Address) }
    }
}

/// Does `work` with the flash unlocked, and forgets what the data cache knows.
fn unlocked(work: impl FnOnce()) -> Result<(), Error> {
    wait_for(|| !FLASH.sr().read().bsy());
    for key in [0x4567_0123, 0xCDEF_89AB] {
        FLASH.keyr().write_value(key);
    }
    FLASH.sr().write_value(Sr(ERRORS));
    work();
    wait_for(|| !FLASH.sr().read().bsy());
    let refused = FLASH.sr().read().0 & ERRORS != 0;
    FLASH.cr().modify(|control| {
        control.set_pg(false);
        control.set_per(false);
        control.set_lock(true);
    });
    FLASH.acr().modify(|access| access.set_dcen(false));
    FLASH.acr().modify(|access| access.set_dcrst(true));
    FLASH.acr().modify(|access| {
        access.set_dcrst(false);
        access.set_dcen(true);
    });
    if refused { Err(Error::Refused) } else { Ok(()) }
}

fn erase_page(page: u32) -> Result<(), Error> {
    unlocked(|| {
        FLASH.cr().modify(|control| {
            control.set_per(true);
            control.set_pnb(page as u8);
        });
        FLASH.cr().modify(|control| control.set_strt(true));
    })
}

fn write_word(address: u32, [low, high]: [u32; 2]) -> Result<(), Error> {
    unlocked(|| {
        FLASH.cr().modify(|control| control.set_pg(true));
        // SAFETY: the address lies in the region, on a word's border; code does not.
        unsafe {
            (address as *mut u32).write_volatile(low);
            cortex_m::asm::isb();
            ((address + 4) as *mut u32).write_volatile(high);
        }
    })
}

impl ErrorType for Region {
    type Error = Error;
}

impl ReadNorFlash for Region {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Error> {
        let address = self.address(offset, bytes.len() as u32, 1)?;
        for (byte, at) in bytes.iter_mut().zip(address..) {
            // SAFETY: the address lies in the region, and every byte of flash may be read.
            *byte = unsafe { (at as *const u8).read_volatile() };
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        (self.range.end - self.range.start) as usize
    }
}

impl NorFlash for Region {
    const WRITE_SIZE: usize = WORD as usize;
    const ERASE_SIZE: usize = PAGE as usize;

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Error> {
        let address = self.address(offset, bytes.len() as u32, WORD)?;
        let (words, _) = bytes.as_chunks::<8>();
        for ([a, b, c, d, e, f, g, h], at) in words.iter().zip((address..).step_by(WORD as usize)) {
            write_word(at, [u32::from_le_bytes([*a, *b, *c, *d]), u32::from_le_bytes([*e, *f, *g, *h])])?;
        }
        Ok(())
    }

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Error> {
        let address = self.address(from, to.saturating_sub(from), PAGE)?;
        let first = (address - START) / PAGE;
        for page in first..first + to.saturating_sub(from) / PAGE {
            erase_page(page)?;
        }
        Ok(())
    }
}
