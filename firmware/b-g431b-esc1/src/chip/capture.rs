//! TIM4: the free-running clock of the period, captures of the hall lines, and the alarm for commutations.

use crate::edges::{Capture, Edges};
use stm32_metapac::TIM4;
use stm32_metapac::timer::regs::{CcerGp16, CcmrInput2ch, Cr1Gp16, SrGp16};

/// The alarm's channel.
const ALARM: usize = 3;

pub(super) fn start() {
    TIM4.arr().modify(|reload| reload.set_arr(u16::MAX));
    // Channels 1 to 3 capture their own inputs, both edges, which must stand for 1.5 us; channel 4 compares.
    const INPUT: u32 = 0b01 | 0b1111 << 4;
    TIM4.ccmr_input(0).write_value(CcmrInput2ch(INPUT | INPUT << 8));
    TIM4.ccmr_input(1).write_value(CcmrInput2ch(INPUT));
    const BOTH_EDGES: u32 = 0b1011;
    TIM4.ccer().write_value(CcerGp16(BOTH_EDGES | BOTH_EDGES << 4 | BOTH_EDGES << 8));
    TIM4.cr1().write_value(Cr1Gp16(1));
}

/// The count now.
pub(super) fn now() -> u16 {
    TIM4.cnt().read().cnt()
}

/// Interrupts at the count `at`.
pub(super) fn alarm(at: u16) {
    TIM4.ccr(ALARM).modify(|value| value.set_ccr(at));
    clear(1 << (ALARM + 1));
    TIM4.dier().modify(|enable| enable.set_ccie(ALARM, true));
}

/// No alarm any more.
pub(super) fn silence() {
    TIM4.dier().modify(|enable| enable.set_ccie(ALARM, false));
    clear(1 << (ALARM + 1));
}

/// Flags are cleared by writing 0; a 1 changes nothing.
fn clear(flags: u32) {
    TIM4.sr().write_value(SrGp16(!flags));
}

/// Adds the captures since the last call to `edges`; answers how many are certainly lost.
pub(super) fn take(edges: &mut Edges) -> u8 {
    let flags = TIM4.sr().read();
    let mut lost = 0;
    for line in 0..crate::edges::LINES {
        if flags.ccof(line) {
            lost += 1;
            clear(1 << (line + 9));
        }
        if flags.ccif(line) {
            // Reading the capture clears its flag.
            let at = TIM4.ccr(line).read().ccr();
            lost += u8::from(edges.push(Capture { line: line as u8, at }));
        }
    }
    lost
}
