//! The narx drive on ST's NUCLEO-G474RE with the power board X-NUCLEO-IHM08M1, as tasks of embassy.
//!
//! ```text
//!  pure, tested on the host                 registers (chip)
//!  board   counts, scales, description ───> bridge TIM1, TIM2; converter ADC1, ADC2; pins
//!  frames  narx's frames and embassy's <──> FDCAN2, in two tasks
//! ```
//!
//! The control tick runs in the converters' interrupt, above everything of embassy. The node runs in a task.
#![no_std]

pub mod board;
#[cfg(target_os = "none")]
pub mod bridge;
#[cfg(target_os = "none")]
pub mod clock;
#[cfg(target_os = "none")]
pub mod converter;
#[cfg(target_os = "none")]
pub mod frames;
#[cfg(target_os = "none")]
pub mod pins;
#[cfg(target_os = "none")]
pub mod sides;

/// A panic turns the gates off; the watchdog resets.
#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    bridge::off();
    loop {}
}
