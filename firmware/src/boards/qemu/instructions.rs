//! Counts instructions exactly: under `-icount shift=10` one instruction takes 2^10 ns of the machine's time, which are
//! 25.6 counts of the 25 MHz system timer. Flash wait states and the pipeline are not in it.

use core::sync::atomic::{Ordering, compiler_fence};
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

/// Modulus of the system timer, which counts down.
const MODULUS: u32 = 1 << 24;

/// Starts the timer. Returns what a measurement costs itself, instructions: take it off of each.
pub fn start(timer: &mut SYST) -> u32 {
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(MODULUS - 1);
    timer.clear_current();
    timer.enable_counter();
    count(|| {}).1
}

/// Runs `work` and tells how many instructions it took, the measurement's own included; at most 655 000.
#[inline(always)]
pub fn count<T>(work: impl FnOnce() -> T) -> (T, u32) {
    let start = SYST::get_current();
    compiler_fence(Ordering::SeqCst);
    let result = work();
    compiler_fence(Ordering::SeqCst);
    let end = SYST::get_current();
    // Both readings are rounded down, so their difference is less than one count beside a multiple of 25.6.
    let counts = start.wrapping_sub(end) % MODULUS;
    (result, (counts * 10 + 128) / 256)
}
