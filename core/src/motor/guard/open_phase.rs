//! Open phase: voltage is applied and no current flows where it should.
//!
//! Phase X takes part in four of the six steps. With X open these four carry nothing and the other two do;
//! with the motor at rest a step that includes X carries nothing at a voltage that must drive a current.

use crate::motor::commutate::commutation::Step;
use crate::units::{Amps, Duty};
use serde::{Deserialize, Serialize};

/// Mean bus current below this is none: 60 mA, above converter offset and noise.
const NONE: i32 = 65_536 * 60 / 1000;
/// Duty from which a healthy winding at rest must carry current: 20 %.
const DUTY_AT_REST: u16 = 32_768 / 5;

/// State of the detector.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct OpenPhase {
    step: Step,
    /// Ticks in this step.
    ticks: u32,
    /// Ticks with current, wrapping; as of the beginning of this step, and of the last millisecond.
    carrying: u32,
    carried_before: u32,
    carried_at_rest: u32,
    /// Per phase: consecutive steps that fit "this phase is open".
    evidence: [u8; 3],
    /// Milliseconds at rest under voltage without any current.
    resting: u8,
    /// The evidence of a phase has reached [`EVIDENCE`].
    found: bool,
}

/// Milliseconds at rest without current until it counts.
const AT_REST: u8 = 100;
/// Consecutive steps, three electrical revolutions.
const EVIDENCE: u8 = 18;
/// Fewer counted ticks in a step prove nothing. The current dips at every commutation, and in steps of 2 1/3
/// ticks a single sample falls into the dip of the same phase's steps revolution after revolution: a motor
/// without load, whose current is near [`NONE`], then looks like one with an open phase.
const COUNTED_MIN: u32 = 2;

impl OpenPhase {
    /// One tick of a step: is there current? The mean of the first one is still in part that of the step
    /// before.
    #[inline]
    pub const fn count(&mut self, current: Amps) {
        // Wraps after days in one step.
        self.ticks = self.ticks.wrapping_add(1);
        if current.to_bits() > NONE && self.ticks > 1 {
            self.carrying = self.carrying.wrapping_add(1);
        }
    }

    /// Once a millisecond: the rotor is at rest (`stopped`), or not known to turn: a voltage must drive a
    /// current. True if a phase is open.
    pub fn rest(&mut self, applied: Step, duty: Duty, stopped: bool) -> bool {
        let silent = self.carrying == core::mem::replace(&mut self.carried_at_rest, self.carrying);
        let pressing = stopped && silent && duty.to_bits() >= DUTY_AT_REST && applied != Step::Coast;
        self.resting = if pressing { self.resting.saturating_add(1) } else { 0 };
        self.is_found()
    }

    /// From the next tick on `step` is applied: what has been seen of the one before is judged. True if a
    /// phase is open.
    #[inline]
    pub fn change(&mut self, step: Step) -> bool {
        if step != self.step {
            self.judge();
            (self.step, self.ticks, self.carried_before) = (step, 0, self.carrying);
        }
        self.found
    }

    /// A phase is open.
    #[inline]
    pub const fn is_found(&self) -> bool {
        self.found || self.resting >= AT_REST
    }

    /// Forgets everything: the bridge is off.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// At the end of a step: a phase is suspect while every step with it was dead and every step without it
    /// alive. The freewheeling rest of the step before may still show in a dead one; what is neither proves
    /// nothing.
    fn judge(&mut self) {
        let Some(floating) = self.step.floating() else { return };
        let counted = self.ticks.saturating_sub(1);
        let carrying = self.carrying.wrapping_sub(self.carried_before);
        let (quarter, without) = (counted / 4, 1_u8 << floating);
        // Bit by bit the phases that may be open.
        let suspects = if counted < COUNTED_MIN {
            0
        } else if carrying >= counted - quarter {
            without
        } else if carrying <= quarter {
            !without
        } else {
            0
        };
        self.found = false;
        for (phase, evidence) in self.evidence.iter_mut().enumerate() {
            let suspect = (suspects >> phase) & 1 == 1;
            *evidence = if suspect { evidence.saturating_add(1) } else { 0 };
            self.found |= *evidence >= EVIDENCE;
        }
    }
}
