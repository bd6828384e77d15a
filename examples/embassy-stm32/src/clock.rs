//! 150 MHz from the NUCLEO's crystal of 24 MHz, which is also the clock of the CAN controller.
//!
//! Above 150 MHz the core needs its higher voltage (R1MODE of PWR_CR5, bit 8: RM0440, section 6.4.5).
//! embassy-stm32 0.6 clears bit 0 instead, which changes nothing.

use embassy_stm32::rcc::mux::Fdcansel;
use embassy_stm32::rcc::{Config, Hse, HseMode, Pll, PllMul, PllPreDiv, PllRDiv, PllSource, Sysclk};
use embassy_stm32::time::Hertz;

/// Sets the clocks in embassy's configuration.
pub fn set(rcc: &mut Config) {
    rcc.hse = Some(Hse { freq: Hertz(24_000_000), mode: HseMode::Oscillator });
    rcc.pll = Some(Pll {
        source: PllSource::HSE,
        prediv: PllPreDiv::DIV6,
        mul: PllMul::MUL75,
        divp: None,
        divq: None,
        divr: Some(PllRDiv::DIV2),
    });
    rcc.sys = Sysclk::PLL1_R;
    rcc.mux.fdcansel = Fdcansel::HSE;
}
