//! Layout of the flash of a board with a bootloader.

use crate::image::HEADER_LENGTH;
use core::fmt;
use core::ops::Range;
use embedded_storage::nor_flash::NorFlash;

/// Ranges of a flash, in bytes from its beginning.
///
/// ```text
///  0        bootloader | active | dfu | state | parameters        end
///                        runs     one page more than active
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Map {
    /// The bootloader, which nobody overwrites.
    pub bootloader: Range<u32>,
    /// The image that runs.
    pub active: Range<u32>,
    /// The image that is received, and after a swap the one before: one page longer than `active`. Empty in a
    /// flash with [one slot](crate::one_slot).
    pub dfu: Range<u32>,
    /// State pages: which swap is to be done, and how far it has come.
    pub state: Range<u32>,
    /// The drive's parameters, which an update does not touch; may be empty.
    pub parameters: Range<u32>,
}

/// Reason why a map is invalid, or does not fit the flash.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapError {
    /// A range has no page, does not begin and end on pages, or begins before the one before it ends.
    Range,
    /// The map ends behind the flash.
    Capacity,
    /// `dfu` is not a page longer than `active`.
    Dfu,
    /// `state` has no room for the progress of a swap.
    State,
    /// The flash programs less than 8 bytes at once, where a torn word could look like another, or more
    /// than 32.
    WriteSize,
}

/// Pages of the ST board's flash.
const ST_PAGE: u32 = 2 << 10;

impl Map {
    /// STM32G431CB of the B-G431B-ESC1: 128 KiB in pages of 2 KiB (RM0440, section 3.3).
    /// One slot: two of one size would leave an application 50 KiB.
    pub const B_G431B_ESC1: Self = Self::stacked([22 << 10, 96 << 10, 0, ST_PAGE, 8 << 10]);

    /// Bootloader, active, dfu, state and parameters of these lengths behind one another, from 0 on.
    pub const fn stacked(lengths: [u32; 5]) -> Self {
        let [bootloader, active, dfu, state, parameters] = lengths;
        let dfu_from = bootloader + active;
        let state_from = dfu_from + dfu;
        let parameters_from = state_from + state;
        Self {
            bootloader: 0..bootloader,
            active: bootloader..dfu_from,
            dfu: dfu_from..state_from,
            state: state_from..parameters_from,
            parameters: parameters_from..parameters_from + parameters,
        }
    }

    /// Longest image, header included, bytes.
    pub const fn room(&self) -> u32 {
        self.active.end.saturating_sub(self.active.start)
    }

    /// Offset of the vector table of the active image, right behind its header.
    pub const fn entry(&self) -> u32 {
        self.active.start + HEADER_LENGTH as u32
    }

    /// Checks that this flash can have the map.
    ///
    /// # Errors
    /// The first fault that is found.
    pub fn check<F: NorFlash>(&self, flash: &F) -> Result<(), MapError> {
        let (page, word) = (F::ERASE_SIZE as u32, F::WRITE_SIZE as u32);
        let Self { bootloader, active, dfu, state, parameters } = self;
        let mut free_from = 0;
        for range in [bootloader, active, dfu, state, parameters] {
            let is_aligned = range.start.is_multiple_of(page) && range.end.is_multiple_of(page);
            // These ranges may be empty: bootloader and parameters can lie in another flash, and a board with
            // one slot has no `dfu`.
            let may_be_empty = range == parameters || range == bootloader || range == dfu;
            if !is_aligned || range.end < range.start || (range.is_empty() && !may_be_empty) {
                return Err(MapError::Range);
            }
            if range.start < free_from {
                return Err(MapError::Range);
            }
            free_from = range.end;
        }
        if free_from as usize > flash.capacity() {
            return Err(MapError::Capacity);
        }
        if !dfu.is_empty() && dfu.end - dfu.start != active.end - active.start + page {
            return Err(MapError::Dfu);
        }
        if !(8..=32).contains(&word) || !page.is_multiple_of(word) {
            return Err(MapError::WriteSize);
        }
        // Two words each way for every page, behind magic and validity; the last word is the verdict's
        // (mark.rs). With one slot there is nothing to swap.
        let words = if dfu.is_empty() { 0 } else { 2 + 4 * (self.room() / page) + 1 };
        if words > (state.end - state.start) / word { Err(MapError::State) } else { Ok(()) }
    }
}

impl fmt::Display for MapError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Range => {
                "a range that is empty, not of whole pages, or begins before the one before it ends"
            }
            Self::Capacity => "the map ends behind the flash",
            Self::Dfu => "dfu is not one page longer than active",
            Self::State => "no room for the progress of a swap",
            Self::WriteSize => "the flash does not program 8 to 32 bytes at once",
        })
    }
}

impl core::error::Error for MapError {}
