//! Pins of the power board, as they are connected to the NUCLEO-G474RE. Pins of the converters stay analogue,
//! as after a reset. PB14 and PB15 share nets with gates and the break input: they stay unconnected.
//!
//! | signal | pin | function |
//! |---|---|---|
//! | high sides A, B, C | PA8, PA9, PA10 | TIM1_CH1 to 3 |
//! | low sides A, B, C, active low | PA7, PB0, PB1 | TIM1_CH1N to 3N |
//! | over-current, active low | PA6 | TIM1_BKIN |
//! | hall sensors A, B, C | PA15, PB3, PB10 | inputs |
//! | currents A, B, C | PA0, PC1, PC0 | ADC12_IN1, IN7, IN6 |
//! | bus voltage | PA1 | ADC12_IN2 |
//! | terminals A, B, C | PC3, PC4, PC5 | ADC12_IN9, ADC2_IN5, IN11 |
//! | dividers of the terminals connected | PC9, low | output |
//! | temperature | PC2 | ADC12_IN8 |

use embassy_stm32::pac::gpio::Gpio;
use embassy_stm32::pac::gpio::vals::{Moder, Ospeedr, Pupdr};
use embassy_stm32::pac::{GPIOA, GPIOB, GPIOC};

/// Function number of TIM1 on all of its pins here.
const TIM1: u8 = 6;

/// Gives the pins their functions. The gates' levels are TIM1's from here on: start it before.
pub fn start() {
    for (port, pin) in [(GPIOA, 8), (GPIOA, 9), (GPIOA, 10), (GPIOA, 7), (GPIOB, 0), (GPIOB, 1)] {
        port.ospeedr().modify(|speed| speed.set_ospeedr(pin, Ospeedr::VERY_HIGH_SPEED));
        alternate(port, pin, TIM1);
    }
    GPIOA.pupdr().modify(|pull| pull.set_pupdr(6, Pupdr::PULL_UP));
    alternate(GPIOA, 6, TIM1);
    for (port, pin) in HALLS {
        port.pupdr().modify(|pull| pull.set_pupdr(pin, Pupdr::PULL_UP));
        port.moder().modify(|mode| mode.set_moder(pin, Moder::INPUT));
    }
    GPIOC.bsrr().write(|set| set.set_br(9, true));
    GPIOC.moder().modify(|mode| mode.set_moder(9, Moder::OUTPUT));
}

const HALLS: [(Gpio, usize); 3] = [(GPIOA, 15), (GPIOB, 3), (GPIOB, 10)];

/// Returns the hall lines, bit 0 is A.
pub fn halls() -> u8 {
    let line = |(port, pin): (Gpio, usize)| (port.idr().read().0 >> pin & 1) as u8;
    line(HALLS[0]) | line(HALLS[1]) << 1 | line(HALLS[2]) << 2
}

fn alternate(port: Gpio, pin: usize, function: u8) {
    port.afr(pin / 8).modify(|functions| functions.set_afr(pin % 8, function));
    port.moder().modify(|mode| mode.set_moder(pin, Moder::ALTERNATE));
}
