//! Both converters: four and three channels at the sampling instant, side by side, and the temperature
//! between two instants.
//!
//! ```text
//!  trigger  | 47.5 + 12.5 clocks | 25      | 25      |
//!  ADC1     | bus voltage        | shunt A | shunt C |            2.9 us: the control interrupt
//!  ADC2     | shunt B | term. A  | term. B | term. C |            a clock is 1 / 37.5 MHz
//! ```

use crate::board::CLOCK_HZ;
use core::sync::atomic::{AtomicU16, Ordering};
use embassy_stm32::pac::adc::Adc;
use embassy_stm32::pac::adc::regs::{Isr, Jsqr, Smpr, Smpr2, Sqr1};
use embassy_stm32::pac::adccommon::vals::Ckmode;
use embassy_stm32::pac::{ADC1, ADC2, ADC12_COMMON, RCC};

/// Codes of one instant.
#[derive(Clone, Copy, Debug)]
pub struct Codes {
    /// Bus voltage.
    pub bus: u16,
    /// Terminals A, B, C.
    pub terminals: [u16; 3],
    /// Shunts A, B, C.
    pub shunts: [u16; 3],
}

/// The temperature's channel of ADC1, and its last code.
const TEMPERATURE: u32 = 8;
static TEMPERATURE_CODE: AtomicU16 = AtomicU16::new(0);

/// ADC_SMPR1: 12.5 clocks for every channel but IN2, the bus voltage, whose divider has 8.8 kohm: 47.5; and
/// IN8, the temperature: 247.5.
const SAMPLING: u32 = 0o2_2222_2222 ^ (2 ^ 4) << 6 ^ (2 ^ 6) << 24 | 2 << 27;

/// ADC_SMPR2: 12.5 clocks for IN11, a terminal.
const SAMPLING_FROM_10: u32 = 2 << 3;

/// ADC_JSQR: TIM1's second trigger, rising, and up to four channels.
const fn sequence<const N: usize>(channels: [u32; N]) -> Jsqr {
    const TIM1_TRGO2: u32 = 8 << 2;
    const RISING: u32 = 1 << 7;
    let mut word = (N as u32 - 1) | TIM1_TRGO2 | RISING;
    let mut rank = 0;
    while rank < N {
        word |= channels[rank] << (9 + 6 * rank);
        rank += 1;
    }
    Jsqr(word)
}

/// Starts both converters; ADC1 interrupts when the last channel is converted.
pub fn start() {
    RCC.ahb2enr().modify(|clocks| clocks.set_adc12en(true));
    ADC12_COMMON.ccr().modify(|common| common.set_ckmode(Ckmode::SYNC_DIV4));
    begin(ADC1, sequence([2, 1, 6]));
    begin(ADC2, sequence([7, 9, 5, 11]));
    ADC1.ier().modify(|enable| enable.set_jeosie(true));
}

fn begin(adc: Adc, channels: Jsqr) {
    adc.cr().modify(|control| control.set_deeppwd(false));
    adc.cr().modify(|control| control.set_advregen(true));
    // The regulator takes 20 us.
    cortex_m::asm::delay(20 * (CLOCK_HZ / 1_000_000));
    adc.cr().modify(|control| control.set_adcal(true));
    while adc.cr().read().adcal() {}
    // Four clocks of the converter between calibration and enabling.
    cortex_m::asm::delay(CLOCK_HZ / 1_000_000);
    adc.isr().write_value(Isr(1));
    adc.cr().modify(|control| control.set_aden(true));
    while !adc.isr().read().adrdy() {}
    adc.cfgr().modify(|settings| settings.set_jqdis(true));
    adc.smpr().write_value(Smpr(SAMPLING));
    adc.smpr2().write_value(Smpr2(SAMPLING_FROM_10));
    adc.jsqr().write_value(channels);
    adc.cr().modify(|control| control.set_jadstart(true));
}

/// Returns the codes of the instant that has just been sampled; `None` if none has.
pub fn take() -> Option<Codes> {
    const ALL: u32 = 1 << 5 | 1 << 6;
    if !ADC1.isr().read().jeos() {
        return None;
    }
    ADC1.isr().write_value(Isr(ALL));
    ADC2.isr().write_value(Isr(ALL));
    let code = |adc: Adc, rank| adc.jdr(rank).read().jdata();
    convert_temperature();
    Some(Codes {
        bus: code(ADC1, 0),
        shunts: [code(ADC1, 1), code(ADC2, 0), code(ADC1, 2)],
        terminals: [code(ADC2, 1), code(ADC2, 2), code(ADC2, 3)],
    })
}

/// Keeps the temperature's conversion that has ended, and begins the next one: it is over before the next
/// instant.
fn convert_temperature() {
    if ADC1.isr().read().eoc() {
        TEMPERATURE_CODE.store(ADC1.dr().read().rdata(), Ordering::Relaxed);
    }
    if !ADC1.cr().read().adstart() {
        ADC1.sqr1().write_value(Sqr1(TEMPERATURE << 6));
        ADC1.cr().modify(|control| control.set_adstart(true));
    }
}

/// Returns the thermistor's last code.
pub fn temperature() -> u16 {
    TEMPERATURE_CODE.load(Ordering::Relaxed)
}
