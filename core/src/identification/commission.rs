//! The drive commissioned for the motor as far as it is known.

use super::script::Action;
use super::{CONTINUOUS, Identification, IdentificationError};
use crate::commissioning::{self, Commissioning, CommissioningError, Mode, Motor, Nameplate};
use crate::dictionary::{engineering, number};
use crate::motor::Board;
use libm::{fmax, fmin, round, sqrt};

/// Lowest supply of the drive (Table 2), V.
const LEAST: f64 = *commissioning::SUPPLY.start();
/// A set-point may be this many times slower than what commissioning allows.
const SLOWER: f64 = 3.0;
/// An acceleration takes this share of the current that the winding may carry: what is measured on the way
/// lags less behind it.
const ACCELERATION_SHARE: f64 = 0.7;
/// A start takes this share of the largest current: a rotor that is held swings, and its back-EMF adds to it.
const START_SHARE: f64 = 0.6;
/// Largest duty before the torque constant is known, and afterwards, 0.01 %: half of the supply drives a
/// rotor to half of its nominal speed, whatever that is. An acceleration needs a little more.
const LARGEST_DUTY: [i32; 2] = [5_000, 6_000];
/// Most guesses of a faster motor.
const GUESSES: usize = 12;
/// Guesses for a motor of 20 to 200 W before anything is known: `k / sqrt(R)`, N m per root watt, and
/// `J R / k^2`, s. Both are on the safe side: a light rotor gets low gains.
const MOTOR_CONSTANT: f64 = 0.05;
pub(super) const MECHANICAL_TIME: [f64; 4] = [8e-3, 24e-3, 4e-3, 60e-3];

impl Identification {
    /// The motor as it is known, with a guess for what is not.
    fn motor(&self) -> Motor {
        let total = self.found.winding.map_or(1.0, |winding| winding.resistance);
        let (k, _) = self.found.torque_constant;
        let k = if k > 0.0 { k } else { MOTOR_CONSTANT * sqrt(total) };
        let guess = MECHANICAL_TIME[self.guess % MECHANICAL_TIME.len()] * k * k / total;
        let inertia = self.found.driven.map_or(guess, |driven| driven.inertia.0);
        let poles = f64::from(self.found.pole_pairs);
        let coasted = self.found.coast.map_or((0.0, 0.0), |coast| coast.friction);
        let coasted = (coasted.0 / poles * inertia, coasted.1 * inertia);
        let (static_friction, viscous_friction) = self.found.driven.map_or(coasted, |driven| driven.friction);
        Motor {
            pole_pairs: self.found.pole_pairs,
            resistance: total - self.asked.bridge,
            inductance: self.found.winding.map_or(1e-3, |winding| winding.inductance),
            torque_constant: k,
            inertia,
            static_friction,
            viscous_friction,
        }
    }

    /// Commissions the drive for the motor as it is known, and writes its parameters.
    pub(super) fn commission(&mut self, mode: Mode) -> Result<Commissioning, IdentificationError> {
        let rate = round(1.0 / self.found.period) as u32;
        let board = Board::BENCH.at_rate(rate).ok_or(IdentificationError::Rate(rate))?;
        let unknown = self.found.torque_constant.0 <= 0.0;
        let mut plate = Nameplate {
            motor: self.motor(),
            rated_current: Some(ACCELERATION_SHARE * self.found.current),
            // A supply of 18 V may read a little less.
            supply: if self.found.supply > 0.99 * LEAST {
                fmax(self.found.supply, LEAST)
            } else {
                self.found.supply
            },
            open_loop_speed: None,
        };
        let most = START_SHARE * self.asked.current.unwrap_or(CONTINUOUS);
        let mut commissioning = plate.commission_within(&board, mode, None, most);
        for _ in 0..GUESSES {
            if matches!(commissioning, Err(CommissioningError::TooSlow { .. })) {
                if unknown {
                    // It was guessed too slow.
                    plate.motor.torque_constant *= 0.7;
                } else {
                    // It turns faster with less torque.
                    plate.rated_current = plate.rated_current.map(|current| current / 2.0);
                }
                commissioning = plate.commission_within(&board, mode, None, most);
            }
        }
        let mut commissioning = commissioning.map_err(IdentificationError::Commissioning)?;
        // The identification turns as slowly as the motor needs. It knows no fastest speed before that is
        // measured, and the drive gets none: a light rotor leaps when its start ends.
        let fastest = fmin(f64::from(rate) * 60.0 / (6.0 * 4.0 * f64::from(self.found.pole_pairs)), 30_000.0);
        commissioning.speed_min /= SLOWER;
        if unknown {
            commissioning.speed_max = fastest;
        }
        let parameters = &mut commissioning.parameters;
        let limits = [(number::SPEED_MIN_SL, commissioning.speed_min), (number::SPEED_MAX_SL, fastest)];
        for (number, value) in limits {
            engineering::set(parameters, number, value).map_err(IdentificationError::Value)?;
        }
        for number in commissioning::WRITTEN {
            let raw = commissioning.parameters.raw(number);
            let raw = match number {
                // Before it is measured the drive must not rely on it.
                number::BACK_EMF_CONSTANT if unknown => 0,
                number::LOCK_DUTY | number::OPEN_LOOP_DUTY | number::DUTY_MAX_SL => {
                    raw.min(LARGEST_DUTY[usize::from(!unknown)])
                }
                _ => raw,
            };
            self.script.add(&[Action::Write(number, raw)]);
        }
        Ok(commissioning)
    }
}
