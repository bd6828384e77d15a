//! How much of the stack was ever used: what start-up painted and nobody has written since.

use core::ptr;

/// Bytes of stack used since power-up at most.
pub(super) fn high_water() -> usize {
    unsafe extern "C" {
        static _stack_end: u32;
        static _stack_start: u32;
    }
    let low = &raw const _stack_end;
    let high = &raw const _stack_start;
    let mut at = low;
    // SAFETY: the linker script's symbols enclose aligned words of RAM, which start-up has painted; what is above the
    // stack pointer belongs to callers and is only read.
    while at < high && unsafe { ptr::read_volatile(at) } == cortex_m_rt::STACK_PAINT_VALUE {
        at = at.wrapping_add(1);
    }
    high as usize - at as usize
}
