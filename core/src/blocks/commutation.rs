//! Six-step commutation from a rotor position.
//!
//! The table alone (which step gives torque in which sector, which leg it switches, which floats) is
//! [`Step`].

use super::error::{SettingError, within};
use super::{Position, turn_of_centidegrees};
use crate::motor::commutate::commutation::{Direction, Step};
use crate::motor::commutate::commutator::{Commutator, CommutatorCoefficients};
use crate::motor::commutate::pwm::Commutations;

/// Settings of a [`Commutation`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CommutationSettings {
    /// Timing advance, electrical, 0 to 3000 in 0.01 degree (parameter 273).
    pub advance_cdeg: u16,
    /// First instant of a period at which a new step can act, 1/65 536 of it: when the caller has its answer.
    pub earliest: u16,
}

/// Computes the step of a period, and the changes within it, from position and torque direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Commutation {
    ready: CommutatorCoefficients,
    station: Commutator,
}

impl Commutation {
    /// Builds a commutation that knows no rotor position yet.
    ///
    /// # Errors
    /// The setting that is out of range.
    pub fn build(settings: &CommutationSettings) -> Result<Self, SettingError> {
        coefficients(settings).map(Self::new)
    }

    /// A commutation that knows no rotor position yet, with ready-made coefficients, which are not checked.
    pub fn new(ready: CommutatorCoefficients) -> Self {
        Self { ready, station: Commutator::default() }
    }

    /// Its coefficients, for [`new`](Self::new) elsewhere.
    pub const fn ready(&self) -> &CommutatorCoefficients {
        &self.ready
    }

    /// Returns the step at the earliest instant of this period, and up to two changes later in it, for a
    /// rotor at `position` with torque in direction `torque`. A rotor that seems to have fallen back by less
    /// than 15 degrees is not commutated back.
    pub fn step(&mut self, position: Position, torque: Direction) -> (Step, Commutations) {
        self.station.step(&self.ready, position.angle, position.speed, torque)
    }

    /// Forgets the sector: the bridge was off.
    pub fn reset(&mut self) {
        self.station.reset();
    }
}

pub(super) fn coefficients(settings: &CommutationSettings) -> Result<CommutatorCoefficients, SettingError> {
    within("advance_cdeg", settings.advance_cdeg.into(), 0, 3000, "0.01 degree")?;
    let advance = turn_of_centidegrees(settings.advance_cdeg.into());
    Ok(CommutatorCoefficients { earliest: settings.earliest, advance })
}
