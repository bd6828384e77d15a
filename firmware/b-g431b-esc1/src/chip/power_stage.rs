//! The bridge: TIM1 with its break inputs, the comparators that break it, and the commutations inside a
//! period.

use super::capture;
use crate::analog::trip_code;
use crate::timing::{DEAD_TIME, TOP, compare, has_come, part, position, sample_compare};
use narx_board::owned::Owned;
use narx_board::stm32::{Gates, dead_time_code, gates, pause, registers};
use narx_core::motor::{PwmCommand, Rectification, Step};
use stm32_metapac::comp::vals::Inm;
use stm32_metapac::dac::vals::Mode;
use stm32_metapac::timer::regs::{
    Af1Adv, BdtrAdv, CcerAdv, Ccmr3Adv, CcmrOutputGp16, Cr1Gp16, Cr2Adv, EgrAdv, RcrAdv, SrAdv,
};
use stm32_metapac::timer::vals::Mms2;
use stm32_metapac::{COMP1, COMP2, COMP4, DAC3, TIM1};

/// The comparators break at this phase current: above the 12 A that the drive may carry (Table 1) and below
/// the 40 A of the board, with room for an offset of the comparator of 9 mV, which is 5 A.
pub const TRIP_AMPERES: u16 = 25;
/// After a break the outputs come back when the drive has asked for Coast this long, ticks: 100 ms.
const REARM_TICKS: u16 = 1000;

/// The control interrupt's and the commutations'.
pub static BRIDGE: Owned<Bridge> = Owned::nothing();

const DEAD_TIME_CODE: u8 = match dead_time_code(DEAD_TIME) {
    Some(code) => code,
    None => panic!("no such dead time"),
};

/// TIM1_BDTR: dead time, lock level 1, off states driven, break by a high level that lasts 8 clocks.
const BREAK: u32 = DEAD_TIME_CODE as u32 | 0b01 << 8 | 1 << 10 | 1 << 11 | 1 << 12 | 1 << 13 | 3 << 16;
const MAIN_OUTPUT: u32 = 1 << 15;
/// TIM1_SR: break, system break.
const BROKEN: u32 = 1 << 7 | 1 << 13;

pub(super) fn start() {
    trip_start();
    // Break by comparators 1, 2 and 4, not by a pin.
    TIM1.af1().write_value(Af1Adv(1 << 1 | 1 << 2 | 1 << 4));
    TIM1.arr().modify(|reload| reload.set_arr(TOP));
    // An update in every second turn: at 0, because the counter starts there.
    TIM1.rcr().write_value(RcrAdv(1));
    // Channel 6 triggers the converter: inactive below its compare value. Latched at the boundary.
    TIM1.ccmr3().write_value(Ccmr3Adv(0b111 << 12 | 1 << 11));
    TIM1.ccr6().modify(|compare| compare.set_ccr(1));
    let mut control = Cr2Adv(0);
    control.set_mms2(Mms2::COMPARE_OC6);
    TIM1.cr2().write_value(control);
    write(gates(Step::Coast, Rectification::Diode));
    TIM1.bdtr().write_value(BdtrAdv(BREAK));
    // Latches what was preloaded.
    TIM1.egr().write_value(EgrAdv(1));
    TIM1.sr().write_value(SrAdv(0));
}

/// Shunt currents against [`TRIP_AMPERES`].
fn trip_start() {
    let code = trip_code(TRIP_AMPERES);
    DAC3.mcr().modify(|mode| {
        // The interface's timing above 160 MHz.
        mode.set_hfsel(0b10);
        mode.set_mode(0, Mode::NORMAL_INT_BUFDIS);
        mode.set_mode(1, Mode::NORMAL_INT_BUFDIS);
    });
    for channel in [0, 1] {
        DAC3.cr().modify(|control| control.set_en(channel, true));
        DAC3.dhr12r(channel).modify(|value| value.set_dhr(code));
    }
    // DAC3 channel 1 for comparator 1, channel 2 for 2 and 4; PA1, PA7, PB0.
    for comparator in [COMP1, COMP2, COMP4] {
        comparator.csr().modify(|control| {
            control.set_inmsel(Inm::DACA);
            control.set_en(true);
        });
    }
}

/// Starts the periods.
pub(super) fn run() {
    // Counting up and down, reload preloaded.
    TIM1.cr1().write_value(Cr1Gp16(1 << 0 | 0b01 << 5 | 1 << 7));
}

/// All six switches off, at once, whatever anybody else is about to do.
pub fn off() {
    TIM1.bdtr().write_value(BdtrAdv(BREAK));
}

/// Counts since the boundary of the period.
pub(super) fn since_boundary() -> u16 {
    let down = TIM1.cr1().read().dir() != stm32_metapac::timer::vals::Dir::UP;
    position(TIM1.cnt().read().cnt(), down)
}

fn write(gates: [Gates; 3]) {
    let words = registers(gates);
    // The modes first: a leg that goes from switched to off has its high side off before its enables change,
    // and the low side is still held back by the dead time.
    TIM1.ccmr_output(0).write_value(CcmrOutputGp16(words.ccmr1));
    TIM1.ccmr_output(1).write_value(CcmrOutputGp16(words.ccmr2));
    TIM1.ccer().write_value(CcerAdv(words.ccer));
}

/// The gates, and what is to become of them in this period.
#[derive(Debug, Default)]
pub struct Bridge {
    gates: [Gates; 3],
    rectification: Rectification,
    /// Count of TIM4 at the last change.
    changed_at: u16,
    /// Commutations to come: count of TIM4 and step, in order.
    pending: [Option<(u16, Step)>; 2],
    /// Outputs may be on: the shunts' zeros are known.
    armed: bool,
    /// Ticks of Coast since a break.
    rested: u16,
}

impl Bridge {
    /// Returns the commands to the legs' gates that are in force now.
    pub const fn gates(&self) -> [Gates; 3] {
        self.gates
    }

    /// From now on the outputs may be on.
    pub fn arm(&mut self) {
        self.armed = true;
        self.rested = REARM_TICKS;
    }

    /// Returns whether a break has turned the outputs off.
    pub fn is_broken(&self) -> bool {
        self.armed && !TIM1.bdtr().read().moe()
    }

    /// Puts a command on the timers, in the period that began at `start` (count of TIM4).
    pub fn apply(&mut self, command: &PwmCommand, start: u16) {
        self.pending = [None; 2];
        self.change(command.step);
        // Latched by the timer at the next boundary; how current freewheels there is taken into account by
        // the next tick's pattern.
        self.rectification = command.rectification;
        let duty = compare(command.duty);
        for leg in 0..3 {
            TIM1.ccr(leg).modify(|value| value.set_ccr(duty));
        }
        TIM1.ccr6().modify(|value| value.set_ccr(sample_compare(command.sample_at)));
        for (place, commutation) in self.pending.iter_mut().zip(command.commutations.iter()) {
            *place = Some((start.wrapping_add(part(commutation.instant)), commutation.step));
        }
        self.rearm(command.step);
        self.commutate();
    }

    /// Applies the commutations whose instant has come, and asks for the next one.
    pub fn commutate(&mut self) {
        while let [Some((at, step)), next] = self.pending {
            if !has_come(at, capture::now()) {
                capture::alarm(at);
                // It may have come while it was asked for.
                if !has_come(at, capture::now()) {
                    return;
                }
            }
            self.pending = [next, None];
            self.change(step);
        }
        capture::silence();
    }

    fn change(&mut self, step: Step) {
        let next = gates(step, self.rectification);
        if next == self.gates {
            return;
        }
        self.keep_dead_time();
        if let Some(paused) = pause(self.gates, next) {
            write(paused);
            self.changed_at = capture::now();
            self.keep_dead_time();
        }
        write(next);
        self.gates = next;
        self.changed_at = capture::now();
    }

    /// A leg that was just turned off stays so for a dead time, whoever turns it on again.
    fn keep_dead_time(&self) {
        while capture::now().wrapping_sub(self.changed_at) < DEAD_TIME {}
    }

    /// Outputs come on when the bridge is asked for nothing, for long enough after a break, and the cause is
    /// gone.
    fn rearm(&mut self, step: Step) {
        if TIM1.bdtr().read().moe() || !self.armed {
            return;
        }
        self.rested = if step == Step::Coast { self.rested.saturating_add(1) } else { 0 };
        let tripped = [COMP1, COMP2, COMP4].iter().any(|comparator| comparator.csr().read().value());
        if self.rested >= REARM_TICKS && !tripped {
            self.rested = 0;
            TIM1.sr().write_value(SrAdv(!BROKEN));
            TIM1.bdtr().write_value(BdtrAdv(BREAK | MAIN_OUTPUT));
        }
    }
}
