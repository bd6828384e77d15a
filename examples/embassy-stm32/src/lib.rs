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

/// A word of the flash whose check bits do not fit: power failed while it was written, and now it was read.
/// Its reader sees by a checksum of its own that it is void.
///
/// # Safety
/// It touches a flag and the gates alone.
#[cfg(target_os = "none")]
#[cortex_m_rt::exception]
unsafe fn NonMaskableInt() {
    let flags = embassy_stm32::pac::FLASH.eccr();
    if !flags.read().eccd() {
        panic!("nobody has asked for this interrupt");
    }
    // Cleared by a 1.
    flags.modify(|flags| flags.set_eccd(true));
}
