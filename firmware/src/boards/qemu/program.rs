//! Location of the image's own program.

use super::slots;
use core::ptr;

unsafe extern "C" {
    static __vector_table: u32;
}

/// Returns whether a bootloader has entered the program: its vector table lies in the slot then.
pub fn is_in_slot() -> bool {
    (&raw const __vector_table) as usize >= slots::START
}

/// Flips a bit of the program, in a word that nobody reads: this machine's flash can be written.
pub(super) fn spoil() {
    let reserved = (&raw const __vector_table).wrapping_add(7).cast_mut();
    // SAFETY: a vector that this processor does not have (ARMv7-M Architecture Reference Manual, B1.5.2).
    unsafe { ptr::write_volatile(reserved, ptr::read_volatile(reserved) ^ 1) };
}
