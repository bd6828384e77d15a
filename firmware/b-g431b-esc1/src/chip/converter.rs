//! Both converters: four and three channels at the sampling instant, simultaneously, and between two instants
//! one slow channel.
//!
//! ```text
//!  trigger  | 47.5 + 12.5 clocks | 25      | 25      |
//!  ADC1     | bus voltage        | shunt A | shunt C |            2.6 us: the control interrupt
//!  ADC2     | shunt B | term. A  | term. B | term. C |            a clock is 1 / 42.5 MHz
//! ```
//!
//! A slow conversion begins after the others have ended and lasts 6 us, so that none of the two ever meets
//! the other.

use super::clock::PER_US;
use super::wait_for;
use core::sync::atomic::{AtomicU16, Ordering};
use stm32_metapac::adc::Adc;
use stm32_metapac::adc::regs::{Isr, Jsqr, Smpr, Smpr2, Sqr1};
use stm32_metapac::adc::vals::Ovrmod;
use stm32_metapac::adccommon::vals::Ckmode;
use stm32_metapac::opamp::vals::{PgaGain, VmSel, VpSel};
use stm32_metapac::{ADC1, ADC2, ADC12_COMMON, OPAMP1, OPAMP2, OPAMP3};

/// Codes of one instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Codes {
    pub(super) bus: u16,
    pub(super) terminals: [u16; 3],
    pub(super) shunts: [u16; 3],
}

/// The slow channels of ADC1: thermistor, potentiometer, internal reference.
const SLOW: [u32; 3] = [5, 11, 18];
static SLOW_CODES: [AtomicU16; 3] = [AtomicU16::new(0), AtomicU16::new(0), AtomicU16::new(0)];

/// JSQR: TIM1's second trigger, rising, and up to four channels.
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

/// SMPR1 and SMPR2: the sampling times of channels 0 to 18, 12.5 clocks but for those listed.
const fn sampling<const N: usize>(slower: [(u32, u32); N]) -> (Smpr, Smpr2) {
    const CLOCKS_12: u32 = 2;
    let mut times = 0_u64;
    let mut channel = 0;
    while channel < 19 {
        times |= (CLOCKS_12 as u64) << (3 * channel);
        channel += 1;
    }
    let mut index = 0;
    while index < N {
        let (channel, time) = slower[index];
        times ^= ((time ^ CLOCKS_12) as u64) << (3 * channel);
        index += 1;
    }
    const TEN_CHANNELS: u32 = 30;
    (Smpr((times & ((1 << TEN_CHANNELS) - 1)) as u32), Smpr2((times >> TEN_CHANNELS) as u32))
}

const CLOCKS_47: u32 = 4;
const CLOCKS_247: u32 = 6;

pub(super) fn start() {
    for amplifier in [OPAMP1, OPAMP2, OPAMP3] {
        amplifier.csr().modify(|control| {
            control.set_vp_sel(VpSel::VINP0);
            control.set_vm_sel(VmSel::PGA);
            control.set_pga_gain(PgaGain::GAIN16_INPUT_VINM0);
            control.set_opahsm(true);
            control.set_opampen(true);
        });
    }
    ADC12_COMMON.ccr().modify(|common| {
        common.set_ckmode(Ckmode::SYNC_DIV4);
        common.set_vrefen(true);
    });
    // The divider of the bus voltage has 16 kohm.
    begin(
        ADC1,
        sequence([1, 3, 12]),
        sampling([(1, CLOCKS_47), (5, CLOCKS_247), (11, CLOCKS_247), (18, CLOCKS_247)]),
    );
    begin(ADC2, sequence([3, 17, 5, 14]), sampling([]));
    ADC1.ier().modify(|enable| enable.set_jeosie(true));
}

fn begin(adc: Adc, sequence: Jsqr, (first, second): (Smpr, Smpr2)) {
    adc.cr().modify(|control| control.set_deeppwd(false));
    adc.cr().modify(|control| control.set_advregen(true));
    // The regulator takes 20 us.
    cortex_m::asm::delay(20 * PER_US);
    adc.cr().modify(|control| control.set_adcal(true));
    wait_for(|| !adc.cr().read().adcal());
    // Four clocks of the converter between calibration and enabling.
    cortex_m::asm::delay(PER_US);
    adc.isr().write_value(Isr(1));
    adc.cr().modify(|control| control.set_aden(true));
    wait_for(|| adc.isr().read().adrdy());
    adc.cfgr().modify(|settings| {
        settings.set_jqdis(true);
        settings.set_ovrmod(Ovrmod::OVERWRITE);
    });
    adc.smpr().write_value(first);
    adc.smpr2().write_value(second);
    adc.jsqr().write_value(sequence);
    adc.cr().modify(|control| control.set_jadstart(true));
}

/// The codes of the instant that has just been sampled; nothing if none has.
pub(super) fn take() -> Option<Codes> {
    const ALL: u32 = 1 << 5 | 1 << 6;
    if !ADC1.isr().read().jeos() {
        return None;
    }
    ADC1.isr().write_value(Isr(ALL));
    ADC2.isr().write_value(Isr(ALL));
    let code = |adc: Adc, rank| adc.jdr(rank).read().jdata();
    Some(Codes {
        bus: code(ADC1, 0),
        shunts: [code(ADC1, 1), code(ADC2, 0), code(ADC1, 2)],
        terminals: [code(ADC2, 1), code(ADC2, 2), code(ADC2, 3)],
    })
}

/// Takes the slow conversion that was begun in the tick before, and begins that of the next channel in turn.
pub(super) fn go_on(turn: &mut u8) {
    if let Some(place) = SLOW_CODES.get(usize::from(*turn))
        && ADC1.isr().read().eoc()
    {
        place.store(ADC1.dr().read().rdata(), Ordering::Relaxed);
        *turn = (*turn + 1) % SLOW.len() as u8;
    }
    if !ADC1.cr().read().adstart()
        && let Some(channel) = SLOW.get(usize::from(*turn))
    {
        ADC1.sqr1().write_value(Sqr1(channel << 6));
        ADC1.cr().modify(|control| control.set_adstart(true));
    }
}

/// The last codes of thermistor, potentiometer and internal reference.
pub(super) fn slow() -> [u16; 3] {
    SLOW_CODES.each_ref().map(|code| code.load(Ordering::Relaxed))
}
