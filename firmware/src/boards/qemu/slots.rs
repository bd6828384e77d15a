//! The slots of the board and the flash in which they lie: its PSRAM, which a reset leaves alone and no image
//! is loaded to. The emulator can keep it in a file, and then it outlives that, too. It behaves like the
//! flash inside a microcontroller: words of 8 bytes, written once after an erase, or with zeros.

use core::ptr;
use cortex_m::peripheral::SCB;
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};
use narx_boot::Map;

/// The PSRAM (MPS2, application note 386).
pub(super) const START: usize = 0x2100_0000;
const PAGE: u32 = 4 << 10;
/// A megabyte that runs, and what its swap needs. The bootloader stands at 0, and the parameters have a chip
/// of their own.
pub const MAP: Map = Map::stacked([0, 1 << 20, (1 << 20) + PAGE, 3 * PAGE, 0]);

/// The flash of the slots.
#[derive(Clone, Debug)]
pub struct Slots(());

/// A word is programmed that was not erased.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlotsError {
    /// A request that the checks of `embedded_storage` reject.
    Request(NorFlashErrorKind),
    /// A word was programmed before.
    NotErased,
}

impl NorFlashError for SlotsError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Request(kind) => *kind,
            Self::NotErased => NorFlashErrorKind::Other,
        }
    }
}

impl Default for Slots {
    fn default() -> Self {
        Self::new()
    }
}

impl Slots {
    /// The flash.
    pub const fn new() -> Self {
        Self(())
    }

    fn word(offset: u32) -> *mut u64 {
        (START + offset as usize) as *mut u64
    }
}

impl ErrorType for Slots {
    type Error = SlotsError;
}

impl ReadNorFlash for Slots {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), SlotsError> {
        check_read(self, offset, bytes.len()).map_err(SlotsError::Request)?;
        let from = (START + offset as usize) as *const u8;
        for (index, byte) in bytes.iter_mut().enumerate() {
            // SAFETY: within the flash, as was checked; any bits are a byte.
            *byte = unsafe { ptr::read_volatile(from.wrapping_add(index)) };
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        MAP.state.end as usize
    }
}

impl NorFlash for Slots {
    const WRITE_SIZE: usize = 8;
    const ERASE_SIZE: usize = PAGE as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), SlotsError> {
        check_erase(self, from, to).map_err(SlotsError::Request)?;
        for offset in (from..to).step_by(8) {
            // SAFETY: a word of the flash, as was checked. Who erases the program that runs has been told not
            // to.
            unsafe { ptr::write_volatile(Self::word(offset), u64::MAX) };
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), SlotsError> {
        check_write(self, offset, bytes.len()).map_err(SlotsError::Request)?;
        for (chunk, offset) in bytes.as_chunks().0.iter().zip((offset..).step_by(8)) {
            let (place, word) = (Self::word(offset), u64::from_le_bytes(*chunk));
            // SAFETY: a word of the flash, as was checked.
            let before = unsafe { ptr::read_volatile(place) };
            if before != u64::MAX && word != 0 {
                return Err(SlotsError::NotErased);
            }
            // SAFETY: as above.
            unsafe { ptr::write_volatile(place, word) };
        }
        Ok(())
    }
}

/// Enters the image in the active slot, which was verified.
pub fn enter() -> ! {
    let entry = (START + MAP.entry() as usize) as *const u32;
    // SAFETY: a vector table begins there: a stack pointer and the address of a function that never returns.
    // Nothing that the bootloader has is used any more, and no interrupt of its is on.
    unsafe {
        (*SCB::PTR).vtor.write(entry as u32);
        cortex_m::asm::bootload(entry)
    }
}
