//! Physical limits of sensorless control by a motor's data: conditions under which the rotor's signals are
//! too weak or too late for any drive without sensors.
//!
//! It also follows why a load that grows with the square of the speed takes long at low speed: with `B = 2 T
//! / w` its slope makes the motor `(1 / k) / (tau s + 1 + q)`, `q = R B / k^2`, while the controller's zero
//! stays at `1 / tau`. The loop then closes at about `wc / (1 + q)` instead of `wc`: q is 14 for a motor of
//! 30 % loss at 4 % of its no-load speed, and the last per cent takes seconds.

use crate::pwm_rate;
use narx_core::motor::Board;
use narx_sim::plant::MotorConfig;
use std::f64::consts::TAU;

/// Bandwidth that commissioning gives the speed loop, rad/s: 0.7 of 2000 electrical revolutions per minute.
const BANDWIDTH: f64 = 0.7 * 2_000.0 / 60.0;
/// Share of the speed that a load step may take away before the speed loop responds.
const DEEP: f64 = 0.5;

/// Time for which a phase still conducts after it was switched off: during it the terminal shows a diode, not
/// the back-EMF.
pub(super) struct Hidden {
    /// Electrical degrees, out of the 60 of a step; the crossing is at 30.
    pub(super) degrees: f64,
    /// Electrical degrees of two ticks: one before the crossing, one after it.
    samples: f64,
}

impl Hidden {
    /// Computes it for a torque, N m, and a speed, rpm. The current falls by `(D V + 2 e) / 3 L` of a phase,
    /// with `D V = R I + k w` and `2 e = k w`.
    pub(super) fn new(board: &Board, motor: &MotorConfig, torque: f64, rpm: f64) -> Self {
        let speed = rpm * TAU / 60.0;
        let current =
            (torque + motor.static_friction + motor.viscous_friction * speed) / motor.torque_constant;
        let emf = motor.torque_constant * speed;
        let seconds = 1.5 * motor.inductance * current / (motor.resistance * current + 2.0 * emf);
        let degrees_per_second = 360.0 * rpm / 60.0 * f64::from(motor.pole_pairs);
        Self {
            degrees: seconds * degrees_per_second,
            samples: 2.0 * pwm_rate::tick(board) * degrees_per_second,
        }
    }

    /// Returns whether it hides the crossing itself, or the last sample before it.
    pub(super) fn is_crossing(&self) -> bool {
        self.degrees + self.samples > 30.0
    }
}

/// Loss of speed in a load step before the speed loop brings it back.
pub(super) struct Plunge {
    /// Share of the speed.
    pub(super) share: f64,
}

impl Plunge {
    /// Computes it for a torque, N m, and a speed, rpm. From load to speed the closed loop is `(R / k^2) s /
    /// ((tau s + 1) (s + wc))`, whose response to a step is deepest by `T R / k^2 (wc tau)^(wc tau / (1 - wc
    /// tau))`.
    pub(super) fn new(motor: &MotorConfig, torque: f64, rpm: f64) -> Self {
        let square = motor.torque_constant * motor.torque_constant;
        let x = BANDWIDTH * motor.inertia * motor.resistance / square;
        // At x = 1 the power is 1 / e.
        let depth = if (x - 1.0).abs() < 1e-6 { (-1.0_f64).exp() } else { x.powf(x / (1.0 - x)) };
        Self { share: torque * motor.resistance / square * depth / (rpm * TAU / 60.0) }
    }

    /// Returns whether the crossings come so late that they cannot be distinguished from missing ones.
    pub(super) fn is_deep(&self) -> bool {
        self.share > DEEP
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The equation matches a numerical integration of its system: a motor without inductance, and a PI
    /// controller whose zero cancels the motor's pole.
    #[test]
    fn a_plunge_is_as_deep_as_the_loop_lets_it() {
        for (inertia, resistance, constant) in [(5e-7, 14.0, 0.036), (6e-5, 1.7, 0.048), (1.1e-3, 0.8, 0.18)]
        {
            let motor =
                MotorConfig { inertia, resistance, torque_constant: constant, ..MotorConfig::default() };
            let (torque, speed, h) = (0.01, 100.0, 1e-6);
            let (mut w, mut integral, mut deepest) = (0.0_f64, 0.0, 0.0_f64);
            for _ in 0..300_000 {
                integral -= BANDWIDTH * constant * w * h;
                let volts = integral - BANDWIDTH * inertia * resistance / constant * w;
                w += (constant * (volts - constant * w) / resistance - torque) / inertia * h;
                deepest = deepest.min(w);
            }
            let share = Plunge::new(&motor, torque, speed * 60.0 / TAU).share;
            assert!((share * speed / -deepest - 1.0).abs() < 0.01, "{share} {deepest}");
        }
    }

    #[test]
    fn a_phase_conducts_for_longer_the_more_current_and_the_faster() {
        let motor = MotorConfig::default();
        let degrees = |torque, rpm| Hidden::new(&Board::BENCH, &motor, torque, rpm).degrees;
        assert!(
            degrees(0.2, 3_000.0) > 1.5 * degrees(0.1, 3_000.0)
                && degrees(0.1, 3_000.0) > degrees(0.1, 1_500.0)
        );
        // 1.5 x 0.2 mH x 5.56 A / (2 V + 22.6 V) = 68 us of the 833 us of a step.
        assert!((degrees(0.2, 3_000.0) - 60.0 * 68.0 / 833.0).abs() < 0.2);
        assert!(!Hidden::new(&Board::BENCH, &motor, 0.2, 3_000.0).is_crossing());
    }
}
