//! 170 MHz from the crystal of 8 MHz, watched: 8 / 2 x 85 / 2 MHz (RM0440, sections 6.1.5 and 7.2).

use super::wait_for;
use stm32_metapac::flash::vals::Latency;
use stm32_metapac::rcc::vals::{Fdcansel, Hpre, Pllm, Plln, Pllr, Pllsrc, Sw};
use stm32_metapac::{DBGMCU, FLASH, PWR, RCC, SYSCFG};

/// Clocks a microsecond after [`start`].
pub(super) const PER_US: u32 = crate::timing::CLOCK_HZ / 1_000_000;

pub(super) fn start() {
    RCC.apb1enr1().modify(|enable| enable.set_pwren(true));
    // Range 1 with boost, which 170 MHz need: R1MODE = 0, bit 8 (RM0440, section 6.4.5; stm32-metapac 21 has
    // it at bit 0).
    const R1MODE: u32 = 1 << 8;
    PWR.cr5().modify(|control| control.0 &= !R1MODE);
    // The hall lines' pins have pull-downs of the USB Type-C part, until that is told that it is not used.
    PWR.cr3().modify(|control| control.set_ucpd1_dbdis(true));
    FLASH.acr().modify(|access| {
        access.set_latency(Latency::WS4);
        access.set_prften(true);
        access.set_icen(true);
        access.set_dcen(true);
    });
    RCC.cr().modify(|control| control.set_hseon(true));
    wait_for(|| RCC.cr().read().hserdy());
    RCC.pllcfgr().modify(|pll| {
        pll.set_pllsrc(Pllsrc::HSE);
        pll.set_pllm(Pllm::DIV2);
        pll.set_plln(Plln::MUL85);
        pll.set_pllr(Pllr::DIV2);
        pll.set_pllren(true);
    });
    RCC.cr().modify(|control| control.set_pllon(true));
    wait_for(|| RCC.cr().read().pllrdy());
    // Above 80 MHz in two steps, a microsecond apart.
    RCC.cfgr().modify(|clocks| {
        clocks.set_hpre(Hpre::DIV2);
        clocks.set_sw(Sw::PLL1_R);
    });
    wait_for(|| RCC.cfgr().read().sws() == Sw::PLL1_R);
    cortex_m::asm::delay(PER_US);
    RCC.cfgr().modify(|clocks| clocks.set_hpre(Hpre::DIV1));
    // A crystal that stops is a non-maskable interrupt, and TIM1 breaks.
    RCC.cr().modify(|control| control.set_csson(true));
    enable();
}

fn enable() {
    RCC.ahb2enr().modify(|enable| {
        enable.set_gpioaen(true);
        enable.set_gpioben(true);
        enable.set_gpiocen(true);
        enable.set_adc12en(true);
        enable.set_dac3en(true);
    });
    RCC.apb1enr1().modify(|enable| {
        enable.set_tim4en(true);
        enable.set_fdcanen(true);
    });
    RCC.apb2enr().modify(|enable| {
        enable.set_syscfgen(true);
        enable.set_tim1en(true);
    });
    // Bits of the crystal's own, without the jitter of the PLL.
    RCC.ccipr().modify(|select| select.set_fdcansel(Fdcansel::HSE));
    // A processor that has locked up breaks TIM1, too.
    SYSCFG.cfgr2().modify(|locks| locks.set_cll(true));
    // Under a debugger that has halted, the gates are off and the watchdog waits.
    DBGMCU.apb2fzr().modify(|freeze| freeze.set_tim1(true));
    DBGMCU.apb1lfzr().modify(|freeze| freeze.set_iwdg(true));
}
