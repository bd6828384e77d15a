//! The watchdog (Arm, *Cortex-M System Design Kit*, APB watchdog): an interrupt that cannot be masked, then a
//! reset.

use super::register::Register;

// SAFETY: the watchdog of this machine (MPS2, application note 386) stands at 4000_8000h.
const LOAD: Register = unsafe { Register::new(0x4000_8000) };
// SAFETY: the same watchdog.
const CONTROL: Register = unsafe { Register::new(0x4000_8008) };
// SAFETY: the same watchdog.
const INTERRUPT_CLEAR: Register = unsafe { Register::new(0x4000_800C) };

/// Half of what it waits for, ms of the host's time, unless it is told another: an emulator may have to wait
/// for a busy host.
pub const PERIOD_MS: u32 = 4000;
/// Counting with interrupt, and reset at the second time.
const ENABLE: u32 = 0b11;

/// The watchdog, running: it interrupts a period after it was last fed, and resets after another one.
pub struct Watchdog(());

impl Watchdog {
    /// Starts it with a period of so many milliseconds, at most 171 000.
    pub fn start(period_ms: u32) -> Self {
        LOAD.write((super::CLOCK_HZ / 1000).saturating_mul(period_ms));
        CONTROL.write(ENABLE);
        Self(())
    }

    /// Starts its time anew.
    pub fn feed(&mut self) {
        INTERRUPT_CLEAR.write(1);
    }
}
