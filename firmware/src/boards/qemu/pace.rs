//! Keeps simulated time from running ahead of the clock on the wall.

use super::kept;
use core::num::NonZeroU64;
use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

/// Milliseconds since power-up, wrapping.
static MILLISECONDS: AtomicU32 = AtomicU32::new(0);
/// A simulation that is this late does not try to make up for it, ms.
const LATE_MAX: u64 = 20;

/// The body of the system timer's interrupt.
pub fn count_millisecond() {
    MILLISECONDS.fetch_add(1, Ordering::Relaxed);
    kept::count_hanging();
}

/// Milliseconds since power-up, wrapping.
pub fn milliseconds() -> u32 {
    MILLISECONDS.load(Ordering::Relaxed)
}

/// Counts a millisecond where the system timer's interrupt does not come.
pub fn look_for_millisecond() {
    const COUNT_FLAG: u32 = 1 << 16;
    // SAFETY: reading the register is one access of the bus, and clears the flag, for which nobody else
    // looks.
    if unsafe { (*SYST::PTR).csr.read() } & COUNT_FLAG != 0 {
        count_millisecond();
    }
}

/// Compares ticks with milliseconds since an instant at which both were together.
pub struct Pace {
    tick_rate: NonZeroU64,
    tick: u64,
    millisecond: u32,
}

impl Pace {
    /// Starts the system timer, which interrupts once a millisecond. `tick_rate`: control ticks a second.
    pub fn start(mut timer: SYST, tick_rate: u16) -> Self {
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(super::CLOCK_HZ / 1000 - 1);
        timer.clear_current();
        timer.enable_interrupt();
        timer.enable_counter();
        Self {
            tick_rate: NonZeroU64::new(tick_rate.into()).unwrap_or(NonZeroU64::MIN),
            tick: 0,
            millisecond: 0,
        }
    }

    /// Sleeps while `tick` is ahead of the clock.
    pub fn wait_for(&mut self, tick: u64) {
        loop {
            let now = MILLISECONDS.load(Ordering::Relaxed);
            let passed = u64::from(now.wrapping_sub(self.millisecond));
            let due = tick.wrapping_sub(self.tick) * 1000 / self.tick_rate;
            if due <= passed {
                if passed - due > LATE_MAX {
                    *self = Self { tick, millisecond: now, ..*self };
                }
                return;
            }
            cortex_m::asm::wfi();
        }
    }
}
