//! 170 MHz from the NUCLEO's crystal of 24 MHz, which is also the clock of the CAN controller.

use embassy_stm32::rcc::mux::Fdcansel;
use embassy_stm32::rcc::{Config, Hse, HseMode, Pll, PllMul, PllPreDiv, PllRDiv, PllSource, Sysclk};
use embassy_stm32::time::Hertz;

/// Sets the clocks in embassy's configuration.
pub fn set(rcc: &mut Config) {
    rcc.hse = Some(Hse { freq: Hertz(24_000_000), mode: HseMode::Oscillator });
    rcc.pll = Some(Pll {
        source: PllSource::HSE,
        prediv: PllPreDiv::DIV6,
        mul: PllMul::MUL85,
        divp: None,
        divq: None,
        divr: Some(PllRDiv::DIV2),
    });
    rcc.sys = Sysclk::PLL1_R;
    // Above 150 MHz.
    rcc.boost = true;
    rcc.mux.fdcansel = Fdcansel::HSE;
}
