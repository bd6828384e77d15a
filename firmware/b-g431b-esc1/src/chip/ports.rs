//! The pins, as the table says.

use crate::pins::{Port, words};
use core::sync::atomic::{AtomicBool, Ordering};
use stm32_metapac::gpio::Gpio;
use stm32_metapac::gpio::regs::{Afr, Bsrr, Moder, Odr, Ospeedr, Pupdr};
use stm32_metapac::{GPIOA, GPIOB, GPIOC, RCC};

const LED: u32 = 6;
const BUTTON: u32 = 10;
const PWM_INPUT: u32 = 15;
const HALL_A: u32 = 6;

static LIT: AtomicBool = AtomicBool::new(false);

pub(super) fn start() {
    set(GPIOA, Port::A);
    set(GPIOB, Port::B);
    set(GPIOC, Port::C);
}

/// The LED alone, for the bootloader.
pub(super) fn start_led() {
    RCC.ahb2enr().modify(|enable| enable.set_gpiocen(true));
    GPIOC.moder().modify(|modes| modes.set_moder(LED as usize, stm32_metapac::gpio::vals::Moder::OUTPUT));
}

fn set(gpio: Gpio, port: Port) {
    let words = words(port);
    gpio.odr().write_value(Odr(words.output));
    gpio.ospeedr().write_value(Ospeedr(words.speed));
    gpio.pupdr().write_value(Pupdr(words.pull));
    gpio.afr(0).write_value(Afr(words.alternate[0]));
    gpio.afr(1).write_value(Afr(words.alternate[1]));
    gpio.moder().write_value(Moder(words.mode));
}

/// The hall lines: bit 0 = A.
pub(super) fn hall() -> u8 {
    (GPIOB.idr().read().0 >> HALL_A & 7) as u8
}

/// DSIO1: the PWM input of J3. DSIO2: the button.
pub(super) fn digital() -> [bool; 2] {
    [GPIOA.idr().read().0 >> PWM_INPUT & 1 != 0, GPIOC.idr().read().0 >> BUTTON & 1 == 0]
}

/// Turns the LED on or off, whichever it is not.
pub(super) fn toggle_led() {
    let lit = !LIT.load(Ordering::Relaxed);
    LIT.store(lit, Ordering::Relaxed);
    set_led(lit);
}

/// Turns the LED on or off.
pub(super) fn set_led(lit: bool) {
    GPIOC.bsrr().write_value(Bsrr(if lit { 1 << LED } else { 1 << (LED + 16) }));
}
