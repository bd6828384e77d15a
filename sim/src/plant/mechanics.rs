//! The shaft: inertia, Coulomb friction with stiction, viscous and quadratic drag, cogging.

use super::config::{LoadConfig, MotorConfig};
use super::emf::sin_cos;

/// The shaft's state and constants.
#[derive(Clone, Debug)]
pub(crate) struct Shaft {
    pole_pairs: f64,
    inertia: f64,
    /// Motor's share of the Coulomb torque and of the viscous drag.
    static_friction: f64,
    viscous_friction: f64,
    cogging_torque: f64,
    cogging_periods: f64,
    load: LoadConfig,
    /// Electrical angle, turns, unwrapped.
    pub(crate) angle: f64,
    /// Mechanical speed, rad/s.
    pub(crate) speed: f64,
    /// Acceleration over the last interval, rad/s2.
    acceleration: f64,
    pub(crate) blocked: bool,
}

/// What one interval did to the shaft.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Move {
    /// Energy lost in the motor's friction (and the block), J.
    pub(crate) friction: f64,
    /// Energy taken by the load, J.
    pub(crate) load: f64,
}

const TAU: f64 = 2.0 * core::f64::consts::PI;

impl Shaft {
    pub(crate) fn new(motor: &MotorConfig, load: LoadConfig, angle: f64, speed: f64) -> Self {
        Self {
            pole_pairs: f64::from(motor.pole_pairs.max(1)),
            inertia: motor.inertia,
            static_friction: motor.static_friction,
            viscous_friction: motor.viscous_friction,
            cogging_torque: motor.cogging_torque,
            cogging_periods: f64::from(motor.cogging_periods),
            load,
            angle,
            speed,
            acceleration: 0.0,
            blocked: false,
        }
    }

    pub(crate) fn load(&self) -> LoadConfig {
        self.load
    }

    pub(crate) fn set_load(&mut self, load: LoadConfig) {
        self.load = load;
    }

    /// Electrical turns per mechanical radian.
    pub(crate) fn turns_per_radian(&self) -> f64 {
        self.pole_pairs * (1.0 / TAU)
    }

    /// Mechanical angle, rad.
    pub(crate) fn mechanical_angle(&self) -> f64 {
        self.angle / self.turns_per_radian()
    }

    /// Speed to expect in the middle of an interval of `h` seconds, rad/s.
    pub(crate) fn predict(&self, h: f64) -> f64 {
        let middle = self.speed + 0.5 * h * self.acceleration;
        if middle * self.speed > 0.0 { middle } else { 0.0 }
    }

    /// Kinetic and cogging energy, J.
    pub(crate) fn energy(&self) -> f64 {
        let kinetic = 0.5 * (self.inertia + self.load.inertia) * self.speed * self.speed;
        if self.cogging_torque == 0.0 {
            return kinetic;
        }
        // T = -dU/dangle with T = amplitude sin(n angle)
        let (_, cos) = sin_cos(self.cogging_periods * self.mechanical_angle() * (1.0 / TAU));
        kinetic + self.cogging_torque / self.cogging_periods * cos
    }

    /// Mean cogging torque over an interval in which the shaft turns by `span` (mechanical rad) from here.
    fn cogging(&self, span: f64) -> f64 {
        if self.cogging_torque == 0.0 {
            return 0.0;
        }
        let middle = self.mechanical_angle() + 0.5 * span;
        let (sin, _) = sin_cos(self.cogging_periods * middle * (1.0 / TAU));
        // Mean of a sine over x = n span: its value in the middle times sin(x/2) / (x/2).
        let y = 0.25 * self.cogging_periods * self.cogging_periods * span * span;
        self.cogging_torque * sin * (1.0 - y * (1.0 / 6.0) * (1.0 - y * (1.0 / 20.0)))
    }

    /// Turns the shaft for `h` seconds under the electrical angular impulse `impulse` (N m s).
    pub(crate) fn turn(&mut self, impulse: f64, h: f64) -> Move {
        let before = self.speed;
        let inertia = self.inertia + self.load.inertia;
        if self.blocked {
            self.speed = 0.0;
            self.acceleration = 0.0;
            return Move { friction: 0.5 * inertia * before * before, load: 0.0 };
        }
        let predicted = self.predict(h);
        let drive = impulse / h + self.cogging(predicted * h);
        let coulomb = self.static_friction + self.load.constant;
        let viscous = self.viscous_friction + self.load.viscous + self.load.quadratic * predicted.abs();
        let (after, path, slid) = self.slide(drive, coulomb, viscous, inertia, h);
        self.speed = after;
        self.acceleration = (after - before) / h;
        self.angle += path * self.turns_per_radian();
        // Coulomb friction works along the path, drag with the mean speed.
        let drag = path * path / h;
        Move {
            friction: self.static_friction * slid + self.viscous_friction * drag,
            load: self.load.constant * slid + (viscous - self.viscous_friction) * drag,
        }
    }

    /// Speed after `h` seconds, way travelled and distance slid (both rad). The drag is taken at the mean of old and
    /// new speed, which is stable whatever the inertia and conserves energy exactly.
    fn slide(&self, drive: f64, coulomb: f64, viscous: f64, inertia: f64, h: f64) -> (f64, f64, f64) {
        let before = self.speed;
        let drag = 0.5 * viscous * h;
        let advance = |from: f64, sign: f64, time: f64| {
            let drag = 0.5 * viscous * time;
            (from * (inertia - drag) + (drive - sign * coulomb) * time) / (inertia + drag)
        };
        let mut rest = h;
        let mut path = 0.0;
        let mut slid = 0.0;
        if before != 0.0 {
            let sign = if before > 0.0 { 1.0 } else { -1.0 };
            let after = (before * (inertia - drag) + (drive - sign * coulomb) * h) / (inertia + drag);
            if after * sign > 0.0 {
                path = 0.5 * (before + after) * h;
                return (after, path, path.abs());
            }
            // It comes to rest inside the interval: inertia (0 - before) = (drive - friction - drag before / 2) time.
            let push = drive - sign * coulomb - 0.5 * viscous * before;
            let time = if push * sign < 0.0 { (-inertia * before / push).clamp(0.0, h) } else { h };
            path = 0.5 * before * time;
            slid = path.abs();
            rest = h - time;
        }
        // At rest: friction holds it, or what exceeds friction moves it.
        if drive.abs() <= coulomb || rest <= 0.0 {
            return (0.0, path, slid);
        }
        let sign = if drive > 0.0 { 1.0 } else { -1.0 };
        let after = advance(0.0, sign, rest);
        let more = 0.5 * after * rest;
        (after, path + more, slid + more.abs())
    }
}
