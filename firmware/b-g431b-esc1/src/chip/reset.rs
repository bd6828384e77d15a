//! How the chip ends and begins: panic, faults, cause of the last reset, its number.

use super::power_stage;
use core::panic::PanicInfo;
use cortex_m::peripheral::{NVIC, SCB};
use cortex_m_rt::exception;
use stm32_metapac::rcc::regs::Csr;
use stm32_metapac::{FLASH, Interrupt, RCC, UID};

/// Why the chip began anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// Supply, reset pin, or a programmer.
    PowerUp,
    /// A request of the software: REBOOT, a panic, a fault.
    Software,
    /// The watchdog: control, CAN or background had stood still.
    Watchdog,
}

/// Why the chip began anew; the next call answers `PowerUp`.
pub fn cause() -> Cause {
    let flags = RCC.csr().read();
    RCC.csr().write_value({
        let mut clear = Csr(flags.0);
        clear.set_rmvf(true);
        clear
    });
    if flags.iwdgrstf() {
        Cause::Watchdog
    } else if flags.sftrstf() {
        Cause::Software
    } else {
        Cause::PowerUp
    }
}

/// 16 bits of the chip's own number that differ between boards of one batch, never 0.
pub fn serial() -> u16 {
    let words = [0, 1, 2].map(|word| UID.uid(word).read());
    let mixed = words
        .into_iter()
        .fold(0, |mixed: u32, word| (mixed ^ word).wrapping_mul(0x9E37_79B1).rotate_left(15));
    ((mixed >> 16 ^ mixed) as u16).max(1)
}

/// Resets the chip with the gates off.
pub fn reset() -> ! {
    power_stage::off();
    SCB::sys_reset()
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    reset()
}

// SAFETY: reached once at most, and it touches registers alone.
#[exception]
unsafe fn HardFault(_: &cortex_m_rt::ExceptionFrame) -> ! {
    reset()
}

// SAFETY: as above; it returns from a double bit error of the flash alone, whose reader sees by his own checks that the bytes are wrong. A store that
// was cut off leaves such bytes.
#[exception]
unsafe fn NonMaskableInt() {
    if FLASH.eccr().read().eccd() {
        FLASH.eccr().modify(|flags| flags.set_eccd(true));
        return;
    }
    // The crystal has stopped: TIM1 is broken already.
    reset()
}

// SAFETY: an interrupt that nobody has asked for.
#[exception]
unsafe fn DefaultHandler(_: i16) {
    reset()
}

/// Enters the image whose vector table stands at `vectors`.
pub fn enter(vectors: u32) -> ! {
    let core = cortex_m::Peripherals::take();
    // SAFETY: the caller has verified the image there. No interrupt is on, and nothing of this program is used again.
    unsafe {
        if let Some(core) = core {
            core.SCB.vtor.write(vectors);
        }
        cortex_m::asm::bootload(vectors as *const u32)
    }
}

/// Lets an interrupt in.
pub(super) fn enable(nvic: &mut NVIC, interrupt: Interrupt, urgency: u8) {
    // SAFETY: what the handlers own is given to them under a critical section; none relies on a priority being masked.
    unsafe {
        nvic.set_priority(interrupt, urgency);
        NVIC::unmask(interrupt);
    }
}
