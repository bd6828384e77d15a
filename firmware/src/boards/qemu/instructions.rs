//! Counts instructions exactly: under `-icount shift=7` one instruction takes 2^7 ns of the machine's time,
//! which are 3.2 counts of the 25 MHz system timer. Flash wait states and the pipeline are not in it.

use core::fmt;
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

/// Runs `work` and tells how many instructions it took, the measurement's own included; at most 5.2 million.
#[inline(always)]
pub fn count<T>(work: impl FnOnce() -> T) -> (T, u32) {
    let start = SYST::get_current();
    compiler_fence(Ordering::SeqCst);
    let result = work();
    compiler_fence(Ordering::SeqCst);
    let end = SYST::get_current();
    // Both readings are rounded down, so their difference is less than one count beside a multiple of 3.2.
    let counts = start.wrapping_sub(end) % MODULUS;
    (result, (counts * 10 + 16) / 32)
}

/// Instructions of many ticks: displays as `TICKS TOTAL WORST`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sum {
    /// Ticks.
    pub ticks: u64,
    /// Instructions of all of them.
    pub total: u64,
    /// Most of one.
    pub worst: u32,
}

impl Sum {
    /// Counts one tick.
    pub fn add(&mut self, instructions: u32) {
        self.ticks += 1;
        self.total += u64::from(instructions);
        self.worst = self.worst.max(instructions);
    }
}

impl fmt::Display for Sum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {} {}", self.ticks, self.total, self.worst)
    }
}
