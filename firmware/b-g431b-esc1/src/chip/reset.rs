//! Resets of the chip: on request, by a panic or a fault; cause of the last reset; the chip's own number.

use super::power_stage;
use core::panic::PanicInfo;
use cortex_m::peripheral::{NVIC, SCB};
use cortex_m_rt::exception;
use narx_core::node::ResetCause;
use stm32_metapac::rcc::regs::Csr;
use stm32_metapac::tamp::regs::Bkpr;
use stm32_metapac::{FLASH, Interrupt, PWR, RCC, TAMP, UID};

/// Note in a backup register, which outlives a reset: the program has come to where it must not.
const PROGRAM: u32 = u32::from_be_bytes(*b"fail");

/// Returns the cause of the last reset (RM0440, section 7.4.28; bits as in ST's stm32g431xx.h) and clears it,
/// so that the next call does not know it.
pub fn cause() -> ResetCause {
    let flags = RCC.csr().read();
    RCC.csr().write_value({
        let mut clear = Csr(flags.0);
        clear.set_rmvf(true);
        clear
    });
    open_note();
    let by_program = TAMP.bkpr(0).read().0 == PROGRAM;
    TAMP.bkpr(0).write_value(Bkpr(0));
    // Every reset pulls the pin, too.
    match () {
        () if flags.iwdgrstf() => ResetCause::Watchdog,
        () if flags.sftrstf() && by_program => ResetCause::Program,
        () if flags.sftrstf() => ResetCause::Requested,
        () if flags.borrstf() => ResetCause::PowerUp,
        () if flags.pinrstf() => ResetCause::Pin,
        () => ResetCause::Unknown,
    }
}

/// Lets the backup registers be written.
fn open_note() {
    RCC.apb1enr1().modify(|enable| {
        enable.set_pwren(true);
        enable.set_rtcapben(true);
    });
    PWR.cr1().modify(|control| control.set_dbp(true));
}

/// 16 bits of the chip's own number that differ between boards of one batch, never 0.
pub fn serial() -> u16 {
    let words = [0, 1, 2].map(|word| UID.uid(word).read());
    let mixed = words
        .into_iter()
        .fold(0, |mixed: u32, word| (mixed ^ word).wrapping_mul(0x9E37_79B1).rotate_left(15));
    ((mixed >> 16 ^ mixed) as u16).max(1)
}

/// Resets the chip with the gates off, because somebody asks for it.
pub fn reset() -> ! {
    power_stage::off();
    SCB::sys_reset()
}

/// Resets the chip with the gates off, because the program cannot go on; notes it, so that the next start
/// reports it.
pub fn fail() -> ! {
    power_stage::off();
    open_note();
    TAMP.bkpr(0).write_value(Bkpr(PROGRAM));
    SCB::sys_reset()
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    fail()
}

// SAFETY: reached once at most, and it touches registers alone.
#[exception]
unsafe fn HardFault(_: &cortex_m_rt::ExceptionFrame) -> ! {
    fail()
}

// SAFETY: as above; it returns from a double bit error of the flash alone, whose reader sees by his own
// checks that the bytes are wrong. A store that was cut off leaves such bytes.
#[exception]
unsafe fn NonMaskableInt() {
    if FLASH.eccr().read().eccd() {
        FLASH.eccr().modify(|flags| flags.set_eccd(true));
        return;
    }
    // The crystal has stopped: TIM1 is broken already.
    fail()
}

// SAFETY: an interrupt that nobody has asked for.
#[exception]
unsafe fn DefaultHandler(_: i16) {
    fail()
}

/// Enters the image whose vector table stands at `vectors`.
pub fn enter(vectors: u32) -> ! {
    let core = cortex_m::Peripherals::take();
    // SAFETY: the caller has verified the image there. No interrupt is on, and nothing of this program is
    // used again.
    unsafe {
        if let Some(core) = core {
            core.SCB.vtor.write(vectors);
        }
        cortex_m::asm::bootload(vectors as *const u32)
    }
}

/// Lets an interrupt in.
pub(super) fn enable(nvic: &mut NVIC, interrupt: Interrupt, urgency: u8) {
    // SAFETY: what the handlers own is given to them under a critical section; none relies on a priority
    // being masked.
    unsafe {
        nvic.set_priority(interrupt, urgency);
        NVIC::unmask(interrupt);
    }
}
