//! The speed loop: its gains for a bandwidth, and the bandwidth for a phase margin.
//!
//! From voltage to speed the motor is `(1 / k) / (tau s + 1)`, `tau = J R / k^2`. The controller
//! `wc k (tau s + 1) / s` leaves the open loop `wc / s`, which crosses a gain of 1 at the bandwidth `wc`:
//! `Kp = wc k tau = wc J R / k`, `Ki = wc k`. Delays take phase from its 90 degrees: the measured speed is
//! the mean of an electrical revolution of T, and stays the same for a sector of T / 6, half of both late;
//! and the winding's current follows its voltage L / R late. Every commutation costs the volt-seconds that
//! turn the current over, as if R were larger by `3 L p w / 2 pi`.

use super::{CommissioningError, Motor, TWO_PI, not_positive, write};
use crate::dictionary::{Parameters, number};
use crate::shown::Shown;
use core::f64::consts::{FRAC_PI_2, FRAC_PI_6};
use core::fmt;

/// Largest lag of phase at the bandwidth, rad: 60 degrees of margin are left.
const LAG_MAX: f64 = FRAC_PI_6;
/// Largest bandwidth, rad/s: a fifth of that of the current limiter, which then looks like none.
const FASTEST: f64 = super::CURRENT_BANDWIDTH / 5.0;

/// A speed loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedLoop {
    /// Frequency at which the open loop has a gain of 1, Hz.
    pub bandwidth: f64,
    /// Slowest set-point, mechanical rpm.
    pub speed_min: f64,
    /// Phase margin at the slowest set-point, degrees; it is larger at every other.
    pub phase_margin: f64,
    /// Proportional gain, V s/rad.
    pub kp: f64,
    /// Integral gain, V/rad.
    pub ki: f64,
}

/// A speed loop that cannot be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TuningError {
    /// A figure of the motor is not a positive number.
    Motor {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// The slowest set-point is no positive number.
    Speed(f64),
    /// The bandwidth is no positive number, or leaves less than 60 degrees of phase margin.
    Bandwidth {
        /// Hz.
        value: f64,
        /// Largest bandwidth at this slowest set-point, Hz.
        most: f64,
        /// That set-point, mechanical rpm.
        speed_min: f64,
    },
}

impl fmt::Display for TuningError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Motor { name, value } => {
                write!(f, "motor {name} {} must be greater than 0", Shown::Plain(value))
            }
            Self::Speed(value) => {
                write!(f, "slowest set-point {} rpm: must be greater than 0", Shown::Plain(value))
            }
            Self::Bandwidth { value, most, speed_min } => write!(
                f,
                "bandwidth {} Hz: must be greater than 0, and at most {} Hz where set-points begin \
                 at {} rpm; more leaves less than 60 degrees of phase margin, or meets the current limiter",
                Shown::Plain(value),
                Shown::Rounded(most, 2),
                Shown::Plain(speed_min)
            ),
        }
    }
}

impl Motor {
    /// The speed loop with this bandwidth, Hz; without it the fastest one that leaves 60 degrees of phase
    /// margin. speed_min: slowest set-point, mechanical rpm, where the margin is smallest.
    ///
    /// # Errors
    /// A figure of the motor or a speed that is no positive number; a bandwidth that leaves less margin, with
    /// the largest one that does not.
    pub fn speed_loop(&self, speed_min: f64, bandwidth: Option<f64>) -> Result<SpeedLoop, TuningError> {
        if let Some((name, value)) = not_positive(self.positive().into_iter()) {
            return Err(TuningError::Motor { name, value });
        }
        if !(speed_min > 0.0 && speed_min.is_finite()) {
            return Err(TuningError::Speed(speed_min));
        }
        let revolution = 60.0 / (speed_min * f64::from(self.pole_pairs));
        let resistance = self.resistance + 3.0 * self.inductance / revolution;
        let delay = (revolution + revolution / 6.0) / 2.0 + self.inductance / resistance;
        let fastest = libm::fmin(LAG_MAX / delay, FASTEST);
        let chosen = bandwidth.map_or(fastest, |hertz| hertz * TWO_PI);
        if !(chosen > 0.0 && chosen <= fastest * (1.0 + 1e-9)) {
            let (value, most) = (bandwidth.unwrap_or(f64::NAN), fastest / TWO_PI);
            return Err(TuningError::Bandwidth { value, most, speed_min });
        }
        let (kp, ki) = self.speed_gains(chosen, resistance);
        let phase_margin = (FRAC_PI_2 - chosen * delay).to_degrees();
        Ok(SpeedLoop { bandwidth: bandwidth.unwrap_or(chosen / TWO_PI), speed_min, phase_margin, kp, ki })
    }

    /// Kp, V s/rad, and Ki, V/rad, for a bandwidth, rad/s, and a resistance, ohm.
    pub(super) fn speed_gains(&self, bandwidth: f64, resistance: f64) -> (f64, f64) {
        (bandwidth * self.inertia * resistance / self.torque_constant, bandwidth * self.torque_constant)
    }
}

impl SpeedLoop {
    /// Numbers of the parameters that [`write`](Self::write) writes.
    pub const WRITTEN: [u16; 6] = [
        number::SPEED_KP_SL,
        number::SPEED_KI_SL,
        number::SPEED_KP_HES,
        number::SPEED_KI_HES,
        number::SPEED_MIN_SL,
        number::SPEED_MIN_HES,
    ];

    /// Writes the gains and the slowest set-point of both modes: nothing else changes.
    ///
    /// # Errors
    /// A value outside its parameter's range.
    pub fn write(&self, parameters: &mut Parameters) -> Result<(), CommissioningError> {
        write_gains(parameters, (self.kp, self.ki))?;
        write(parameters, number::SPEED_MIN_SL, self.speed_min)?;
        write(parameters, number::SPEED_MIN_HES, self.speed_min)
    }
}

/// Writes Kp, V s/rad, and Ki, V/rad, for both modes; with hall sensors the drive's unit is rpm.
pub(super) fn write_gains(p: &mut Parameters, (kp, ki): (f64, f64)) -> Result<(), CommissioningError> {
    write(p, number::SPEED_KP_SL, kp)?;
    write(p, number::SPEED_KI_SL, ki)?;
    write(p, number::SPEED_KP_HES, kp * TWO_PI / 60.0)?;
    write(p, number::SPEED_KI_HES, ki * TWO_PI / 60.0)
}
