//! The bridge: TIM1 with its break input, and commutations inside a period by TIM2.
//!
//! TIM1 counts up and down, so that every on-time is centred on the count 0, the boundary of the period. TIM2
//! runs freely from the same clock: a boundary is known in its counts whenever TIM1 is read beside it.

use crate::board::{DEAD_TIME, PERIOD, TICK_RATE, TOP, compare, has_come, part, sample_compare};
use embassy_stm32::pac::timer::regs::{
    Af1Adv, BdtrAdv, CcerAdv, Ccmr3Adv, CcmrOutputGp16, Cr1Gp16, Cr2Adv, EgrAdv, RcrAdv, SrAdv,
};
use embassy_stm32::pac::timer::vals::{Dir, Mms2};
use embassy_stm32::pac::{RCC, TIM1, TIM2};
use narx_board::owned::Owned;
use narx_board::stm32::{Gates, dead_time_code, gates, pause, registers};
use narx_core::motor::{PwmCommand, Rectification, Step};

/// The control interrupt's, and TIM2's.
pub static BRIDGE: Owned<Bridge> = Owned::nothing();

/// After a break the outputs come back when the drive has asked for Coast this long, ticks: 100 ms.
const REARM_TICKS: u16 = (TICK_RATE / 10) as u16;

const DEAD_TIME_CODE: u8 = match dead_time_code(DEAD_TIME) {
    Some(code) => code,
    None => panic!("no such dead time"),
};
/// TIM1_BDTR: dead time, lock level 1, off states driven, break by a low level that lasts 8 clocks.
const BREAK: u32 = DEAD_TIME_CODE as u32 | 0b01 << 8 | 1 << 10 | 1 << 11 | 1 << 12 | 3 << 16;
const MAIN_OUTPUT: u32 = 1 << 15;
/// TIM1_CCER: the inputs of the L6398 for the low sides are active low.
const LOW_SIDES_ACTIVE_LOW: u32 = 1 << 3 | 1 << 7 | 1 << 11;
/// TIM1_CR2: their level without main output is high.
const LOW_SIDES_IDLE_HIGH: u32 = 1 << 9 | 1 << 11 | 1 << 13;
/// TIM1_SR: break.
const BROKEN: u32 = 1 << 7;
/// TIM2_DIER and TIM2_SR: compare 1.
const ALARM: u32 = 1 << 1;

/// Starts the clocks and sets the timers up, all six switches off. The periods begin with [`run`].
pub fn start() {
    RCC.apb2enr().modify(|clocks| clocks.set_tim1en(true));
    RCC.apb1enr1().modify(|clocks| clocks.set_tim2en(true));
    TIM1.af1().write_value(Af1Adv(1));
    TIM1.arr().modify(|reload| reload.set_arr(TOP));
    // An update in every second turn: at 0, because the counter starts there.
    TIM1.rcr().write_value(RcrAdv(1));
    // Channel 6 triggers the converters: inactive below its compare value. Latched at the boundary.
    TIM1.ccmr3().write_value(Ccmr3Adv(0b111 << 12 | 1 << 11));
    TIM1.ccr6().modify(|compare| compare.set_ccr(1));
    let mut control = Cr2Adv(LOW_SIDES_IDLE_HIGH);
    control.set_mms2(Mms2::COMPARE_OC6);
    TIM1.cr2().write_value(control);
    write(gates(Step::Coast, Rectification::Diode));
    TIM1.bdtr().write_value(BdtrAdv(BREAK));
    // Latches what was preloaded.
    TIM1.egr().write_value(EgrAdv(1));
    TIM1.sr().write_value(SrAdv(0));
    TIM2.arr().write_value(u32::MAX);
    TIM2.cr1().write_value(Cr1Gp16(1));
}

/// Starts the periods: counting up and down, reload preloaded.
pub fn run() {
    TIM1.cr1().write_value(Cr1Gp16(1 | 0b01 << 5 | 1 << 7));
}

/// Turns all six switches off, at once.
pub fn off() {
    TIM1.bdtr().write_value(BdtrAdv(BREAK));
}

/// Returns the count of TIM2.
pub fn now() -> u32 {
    TIM2.cnt().read()
}

/// Returns the count of TIM2 at the boundary of this period.
pub fn boundary() -> u32 {
    let down = TIM1.cr1().read().dir() != Dir::UP;
    let count = TIM1.cnt().read().cnt();
    now().wrapping_sub(if down { PERIOD.wrapping_sub(count) } else { count }.into())
}

fn write(gates: [Gates; 3]) {
    let words = registers(gates);
    // The modes first: a leg that goes from switched to off has its high side off before its enables change.
    TIM1.ccmr_output(0).write_value(CcmrOutputGp16(words.ccmr1));
    TIM1.ccmr_output(1).write_value(CcmrOutputGp16(words.ccmr2));
    TIM1.ccer().write_value(CcerAdv(words.ccer | LOW_SIDES_ACTIVE_LOW));
}

/// The gates, and the changes that are to come in this period.
#[derive(Debug, Default)]
pub struct Bridge {
    gates: [Gates; 3],
    rectification: Rectification,
    /// Count of TIM2 at the last change.
    changed_at: u32,
    /// Commutations to come: count of TIM2 and step, in order.
    pending: [Option<(u32, Step)>; 2],
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

    /// Puts a command on the timers, in the period that began at `start`, a count of TIM2.
    pub fn apply(&mut self, command: &PwmCommand, start: u32) {
        self.pending = [None; 2];
        self.change(command.step);
        self.rectification = command.rectification;
        for leg in 0..3 {
            TIM1.ccr(leg).modify(|value| value.set_ccr(compare(command.duty)));
        }
        TIM1.ccr6().modify(|value| value.set_ccr(sample_compare(command.sample_at)));
        for (place, commutation) in self.pending.iter_mut().zip(command.commutations.iter()) {
            *place = Some((start.wrapping_add(part(commutation.instant).into()), commutation.step));
        }
        self.rearm(command.step);
        self.commutate();
    }

    /// The body of TIM2's interrupt: applies the commutations whose instant has come, and sets the alarm for
    /// the next one.
    pub fn commutate(&mut self) {
        TIM2.dier().modify(|enable| enable.0 &= !ALARM);
        while let [Some((at, step)), next] = self.pending {
            if !has_come(at, now()) {
                TIM2.ccr(0).write_value(at);
                TIM2.sr().modify(|flags| flags.0 = !ALARM);
                TIM2.dier().modify(|enable| enable.0 |= ALARM);
                // It may have come while the alarm was set.
                if !has_come(at, now()) {
                    return;
                }
                TIM2.dier().modify(|enable| enable.0 &= !ALARM);
            }
            self.pending = [next, None];
            self.change(step);
        }
    }

    fn change(&mut self, step: Step) {
        let next = gates(step, self.rectification);
        if next == self.gates {
            return;
        }
        self.keep_dead_time();
        if let Some(paused) = pause(self.gates, next) {
            write(paused);
            self.changed_at = now();
            self.keep_dead_time();
        }
        write(next);
        self.gates = next;
        self.changed_at = now();
    }

    /// A leg that was just turned off stays so for a dead time, whichever command turns it on again.
    fn keep_dead_time(&self) {
        while now().wrapping_sub(self.changed_at) < u32::from(DEAD_TIME) {}
    }

    /// The outputs come on when the drive has asked for Coast long enough after a break, and its cause is
    /// gone.
    fn rearm(&mut self, step: Step) {
        if TIM1.bdtr().read().moe() || !self.armed {
            return;
        }
        self.rested = if step == Step::Coast { self.rested.saturating_add(1) } else { 0 };
        if self.rested >= REARM_TICKS {
            self.rested = 0;
            TIM1.sr().write_value(SrAdv(!BROKEN));
            TIM1.bdtr().write_value(BdtrAdv(BREAK | MAIN_OUTPUT));
        }
    }
}
