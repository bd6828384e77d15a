//! Stack usage: start-up paints the stack, and what still has the paint was never used.

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
    // SAFETY: the linker script's symbols enclose aligned words of RAM, which start-up has painted; what is
    // above the stack pointer belongs to callers and is only read.
    while at < high && unsafe { ptr::read_volatile(at) } == cortex_m_rt::STACK_PAINT_VALUE {
        at = at.wrapping_add(1);
    }
    high as usize - at as usize
}

/// Writes the last word of the stack, as a stack that is too small would.
pub(super) fn spoil() {
    unsafe extern "C" {
        static _stack_end: u32;
    }
    // SAFETY: the lowest word of the stack, which is nobody's.
    unsafe { ptr::write_volatile((&raw const _stack_end).cast_mut(), 0) };
}

/// Runs `work` and tells how many bytes of stack it took, looking at `WINDOW` words: up to the lowest that
/// was written.
///
/// # Panics
/// It took more than the window.
#[inline(never)]
pub fn used<const WINDOW: usize, T>(work: impl FnOnce() -> T) -> (T, usize) {
    let top = cortex_m::register::msp::read() as usize;
    let low = (top - WINDOW * size_of::<u32>()) as *mut u32;
    for word in 0..WINDOW {
        // SAFETY: below the stack pointer is nobody's RAM: no interrupt is on in the images that measure, and
        // the window ends far above the statics. Calls that the compiler makes here are over before `work`
        // begins.
        unsafe { ptr::write_volatile(low.wrapping_add(word), cortex_m_rt::STACK_PAINT_VALUE) };
    }
    let result = work();
    let mut untouched = 0;
    // SAFETY: as above; it is only read.
    while untouched < WINDOW
        && unsafe { ptr::read_volatile(low.wrapping_add(untouched)) } == cortex_m_rt::STACK_PAINT_VALUE
    {
        untouched += 1;
    }
    assert!(untouched > 0, "more stack than the window");
    (result, (WINDOW - untouched) * size_of::<u32>())
}
