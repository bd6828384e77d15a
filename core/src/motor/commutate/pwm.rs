//! Answer of the control tick: the pattern now, commutations inside this period, duty and sampling of the
//! next.

use super::commutation::Step;
use crate::motor::sense::samples::SampleMode;
use crate::units::Duty;
use serde::{Deserialize, Serialize};

/// The answer to the samples of period k. `step` and `commutations` act in period k, the rest from period
/// k + 1.
// Copied in every tick: by words.
#[repr(align(4))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PwmCommand {
    /// Duty of the switched legs in period k + 1. The on-time is centred on the period's boundary.
    pub duty: Duty,
    /// Freewheeling in period k + 1.
    pub rectification: Rectification,
    /// Sampling instant in period k + 1, in 1/65 536 of it.
    pub sample_at: u16,
    /// The part of the period in which that sample is taken.
    pub sample_mode: SampleMode,
    /// The pattern to apply at once, when `step` returns. [`Step::Coast`] turns all six switches off.
    pub step: Step,
    /// Pattern changes later in period k, in order of time, none before the tick's `earliest` instant.
    pub commutations: Commutations,
}

/// Up to two pattern changes inside one period.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Commutations([Option<Commutation>; 2]);

/// One pattern change.
// Moved by words.
#[repr(align(4))]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Commutation {
    /// Instant of the change, in 1/65 536 of the period.
    pub instant: u16,
    /// The pattern from then on.
    pub step: Step,
}

impl Commutations {
    /// No change in this period.
    pub const NONE: Self = Self([None, None]);

    /// One change.
    #[inline]
    pub const fn one(commutation: Commutation) -> Self {
        Self([Some(commutation), None])
    }

    /// Adds a change; one that finds no room is dropped: the next tick sees the rotor past the boundary and
    /// commutates at once.
    pub fn push(&mut self, commutation: Commutation) {
        match self.0 {
            [None, _] => self.0[0] = Some(commutation),
            [_, None] => self.0[1] = Some(commutation),
            _ => {}
        }
    }

    /// None at all.
    #[inline]
    pub const fn is_empty(&self) -> bool {
        self.0[0].is_none()
    }

    /// The last of them.
    pub const fn last(&self) -> Option<Commutation> {
        match self.0 {
            [_, Some(last)] | [Some(last), None] => Some(last),
            [None, None] => None,
        }
    }

    /// The first and the second change.
    pub const fn both(&self) -> [Option<Commutation>; 2] {
        self.0
    }

    /// The changes in order of time.
    pub fn iter(&self) -> impl Iterator<Item = Commutation> + '_ {
        self.0.iter().flatten().copied()
    }
}

/// Freewheeling of a switched leg's current while its high side is off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum Rectification {
    /// Through the low side's body diode. Current cannot reverse, so the motor cannot feed the bus.
    #[default]
    Diode,
    /// Through the low-side switch (complementary PWM with dead time): less loss, current may reverse.
    Synchronous,
}
