//! The watchdog (Arm, *Cortex-M System Design Kit*, APB watchdog): an interrupt that cannot be masked, then a reset.

use super::register::Register;

// SAFETY: the watchdog of this machine (MPS2, application note 386) stands at 4000_8000h.
const LOAD: Register = unsafe { Register::new(0x4000_8000) };
// SAFETY: the same watchdog.
const CONTROL: Register = unsafe { Register::new(0x4000_8008) };
// SAFETY: the same watchdog.
const INTERRUPT_CLEAR: Register = unsafe { Register::new(0x4000_800C) };

/// Counts of the 25 MHz clock, four seconds of the host's time: an emulator may have to wait for a busy host.
const PERIOD: u32 = 4 * super::CLOCK_HZ;
/// Counting with interrupt, and reset at the second time.
const ENABLE: u32 = 0b11;

/// The watchdog, running: it resets eight seconds after it was last fed.
pub struct Watchdog(());

impl Watchdog {
    /// Starts it.
    pub fn start() -> Self {
        LOAD.write(PERIOD);
        CONTROL.write(ENABLE);
        Self(())
    }

    /// Starts its time anew.
    pub fn feed(&mut self) {
        INTERRUPT_CLEAR.write(1);
    }
}
