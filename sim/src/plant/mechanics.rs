//! The shaft: inertia, Coulomb friction with stiction, viscous and quadratic drag, cogging.

use super::angle::sine;
use super::config::{LoadConfig, MotorConfig};

/// The shaft's state and constants.
#[derive(Clone, Debug)]
pub(crate) struct Shaft {
    inertia: f64,
    /// Motor's share of the Coulomb torque and of the viscous drag.
    static_friction: f64,
    viscous_friction: f64,
    cogging_torque: f64,
    cogging_periods: f64,
    /// Electrical turns per mechanical radian, and electrical radians.
    turns_per_radian: f64,
    pole_pairs: f64,
    /// Cogging periods per electrical turn.
    cogging_ratio: f64,
    load: LoadConfig,
    /// 1 / (rotor and load), 1 / (kg m2).
    per_inertia: f64,
    /// Electrical angle, turns, unwrapped.
    pub(crate) angle: f64,
    /// Mechanical speed, rad/s.
    pub(crate) speed: f64,
    /// Torque of cogging less machine and all friction at the end of the last turn, N m.
    opposing: f64,
    pub(crate) blocked: bool,
}

/// Effect of one interval on the shaft.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turn {
    /// Speed at the end, rad/s, and its mean.
    speed: f64,
    pub(crate) mean: f64,
    /// Mechanical angle turned, rad.
    pub(crate) path: f64,
    /// Energy lost in the motor's friction (and the block), J.
    pub(crate) friction: f64,
    /// Energy taken by the load, J.
    pub(crate) load: f64,
    /// Torque of cogging less machine and all friction at the end, N m.
    opposing: f64,
}

/// Expected motion of the shaft: by its drag, and by the electrical impulse as it comes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion {
    /// At the start, rad/s.
    pub(crate) speed: f64,
    /// Acceleration without electrical torque, rad/s2.
    pub(crate) drift: f64,
    /// 1 / (kg m2), or 0 if the electrical torque moves nothing.
    pub(crate) per_inertia: f64,
}

/// Electrical drive of the shaft over an interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Push {
    /// Length, s, and 1 / length.
    pub(crate) h: f64,
    pub(crate) per_h: f64,
    /// Electrical angular impulse, N m s.
    pub(crate) impulse: f64,
    /// Moment of the impulse about the middle of the interval, N m s2: positive if it acts before the middle
    /// on the whole.
    pub(crate) lead: f64,
    /// Mean speed that the circuit was solved with, rad/s.
    pub(crate) speed: f64,
}

const TAU: f64 = 2.0 * core::f64::consts::PI;

impl Shaft {
    pub(crate) fn new(motor: &MotorConfig, load: LoadConfig, angle: f64, speed: f64) -> Self {
        let cogging_ratio = f64::from(motor.cogging_periods) / f64::from(motor.pole_pairs.max(1));
        Self {
            inertia: motor.inertia,
            static_friction: motor.static_friction,
            viscous_friction: motor.viscous_friction,
            cogging_torque: motor.cogging_torque,
            cogging_periods: f64::from(motor.cogging_periods),
            turns_per_radian: f64::from(motor.pole_pairs.max(1)) / TAU,
            pole_pairs: f64::from(motor.pole_pairs.max(1)),
            cogging_ratio,
            load,
            per_inertia: 1.0 / (motor.inertia + load.inertia),
            angle,
            speed,
            opposing: 0.0,
            blocked: false,
        }
    }

    pub(crate) fn load(&self) -> LoadConfig {
        self.load
    }

    pub(crate) fn set_load(&mut self, load: LoadConfig) {
        self.load = load;
        self.per_inertia = 1.0 / (self.inertia + load.inertia);
    }

    /// 1 / (rotor and load), 1 / (kg m2).
    pub(crate) fn per_inertia(&self) -> f64 {
        self.per_inertia
    }

    /// Electrical turns per mechanical radian.
    pub(crate) fn turns_per_radian(&self) -> f64 {
        self.turns_per_radian
    }

    /// Electrical radians per mechanical radian.
    pub(crate) fn pole_pairs(&self) -> f64 {
        self.pole_pairs
    }

    /// Mechanical angle, rad.
    pub(crate) fn mechanical_angle(&self) -> f64 {
        self.angle / self.turns_per_radian()
    }

    /// Acceleration of a shaft that turns, under an electrical torque in N m, rad/s2.
    pub(crate) fn acceleration(&self, torque: f64) -> f64 {
        (self.opposing + torque) * self.per_inertia
    }

    /// Predicts the motion of the shaft for `h` seconds if the electrical torque is `torque` at first, N m.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn predict(&self, torque: f64, h: f64) -> Motion {
        let (speed, per_inertia) = (self.speed, self.per_inertia);
        if self.blocked || speed == 0.0 {
            return self.predict_from_rest(torque);
        }
        let drift = self.opposing * per_inertia;
        if (speed + (drift + torque * per_inertia) * h) * speed <= 0.0 {
            // About to stop: on average half way there.
            return Motion { speed, drift: -speed / h, per_inertia: 0.0 };
        }
        Motion { speed, drift, per_inertia }
    }

    /// Predicts the motion of a shaft that is held or at rest if the electrical torque is `torque` at first,
    /// N m.
    fn predict_from_rest(&self, torque: f64) -> Motion {
        let coulomb = self.static_friction + self.load.constant;
        let drive = torque + self.cogging_torque * sine(self.cogging_ratio * self.angle) - self.load.machine;
        if self.blocked || drive.abs() < coulomb {
            return Motion { speed: 0.0, drift: 0.0, per_inertia: 0.0 };
        }
        let friction = if drive > 0.0 { coulomb } else { -coulomb };
        Motion {
            speed: 0.0,
            drift: (drive - torque - friction) * self.per_inertia,
            per_inertia: self.per_inertia,
        }
    }

    /// Kinetic and cogging energy, J.
    pub(crate) fn energy(&self) -> f64 {
        let kinetic = self.kinetic(self.speed);
        if self.cogging_torque == 0.0 {
            return kinetic;
        }
        // T = -dU/dangle with T = amplitude sin(n angle)
        let cos = sine(self.cogging_ratio * self.angle + 0.25);
        kinetic + self.cogging_torque / self.cogging_periods * cos
    }

    fn kinetic(&self, speed: f64) -> f64 {
        0.5 * (self.inertia + self.load.inertia) * speed * speed
    }

    /// Mean cogging torque over an interval in which the shaft turns by `span` (mechanical rad) from here.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn cogging(&self, span: f64) -> f64 {
        if self.cogging_torque == 0.0 {
            return 0.0;
        }
        let middle = self.angle + 0.5 * span * self.turns_per_radian;
        // Mean of a sine over x: its value in the middle times sin(x/2) / (x/2).
        let half = 0.5 * self.cogging_periods * span;
        let y = half * half;
        self.cogging_torque * sine(self.cogging_ratio * middle) * (1.0 - y * (1.0 / 6.0 - y * (1.0 / 120.0)))
    }

    /// Computes the effect of an interval; the shaft does not move yet.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn turn(&self, push: &Push) -> Turn {
        // Torques that do not depend on the direction of motion.
        let along = self.cogging(push.speed * push.h) - self.load.machine;
        let Push { h, per_h, impulse, lead, speed: predicted } = *push;
        let coulomb = self.static_friction + self.load.constant;
        let viscous = self.viscous_friction + self.load.viscous + self.load.quadratic * predicted.abs();
        let inertia = self.inertia + self.load.inertia;
        // The drag is taken at the mean of old and new speed, which is stable whatever the inertia and
        // conserves energy exactly.
        let drag = 0.5 * viscous * h;
        let mut sign = if self.speed > 0.0 { 1.0 } else { -1.0 };
        let mut speed =
            (self.speed * (inertia - drag) + impulse + (along - sign * coulomb) * h) / (inertia + drag);
        let mut mean = 0.5 * (self.speed + speed);
        let mut path = mean * h;
        let mut slid = path.abs();
        path += lead * self.per_inertia;
        if speed * self.speed <= 0.0 || self.blocked {
            if self.blocked {
                return self.block();
            }
            (speed, path, slid) = self.slide(impulse * per_h + along, coulomb, viscous, h);
            sign = if speed > 0.0 { 1.0 } else { -1.0 };
            mean = path * per_h;
        }
        // Coulomb friction works along the way, drag with the mean speed; both with the mean of old and new
        // speed, as the shaft gets its energy.
        let dragged = slid * mean.abs();
        Turn {
            speed,
            mean,
            path,
            friction: self.static_friction * slid + self.viscous_friction * dragged,
            load: self.load.constant * slid
                + (viscous - self.viscous_friction) * dragged
                + self.load.machine * mean * h,
            opposing: along - sign * coulomb - viscous * speed,
        }
    }

    /// A block takes all kinetic energy.
    #[cold]
    fn block(&self) -> Turn {
        Turn {
            speed: 0.0,
            mean: 0.0,
            path: 0.0,
            friction: self.kinetic(self.speed),
            load: 0.0,
            opposing: 0.0,
        }
    }

    /// Takes over a turn.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn apply(&mut self, turn: &Turn) {
        (self.speed, self.angle) = self.after(turn);
        self.opposing = turn.opposing;
    }

    /// Speed, rad/s, and electrical angle, turns, after a turn.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn after(&self, turn: &Turn) -> (f64, f64) {
        (turn.speed, self.angle + turn.path * self.turns_per_radian)
    }

    /// Speed after `h` seconds, way travelled and distance slid (both rad), under `drive` N m, where the
    /// shaft may stop.
    #[cold]
    #[inline(never)]
    fn slide(&self, drive: f64, coulomb: f64, viscous: f64, h: f64) -> (f64, f64, f64) {
        let inertia = self.inertia + self.load.inertia;
        let before = self.speed;
        let after = |from: f64, sign: f64, time: f64| {
            let drag = 0.5 * viscous * time;
            (from * (inertia - drag) + (drive - sign * coulomb) * time) / (inertia + drag)
        };
        let (mut rest, mut path) = (h, 0.0);
        if before != 0.0 {
            let sign = if before > 0.0 { 1.0 } else { -1.0 };
            let end = after(before, sign, h);
            if end * sign > 0.0 {
                path = 0.5 * (before + end) * h;
                return (end, path, path.abs());
            }
            // It comes to rest inside: inertia (0 - before) = (drive - friction - viscous before / 2) time.
            let push = drive - sign * coulomb - 0.5 * viscous * before;
            let time = if push * sign < 0.0 { (-inertia * before / push).max(0.0).min(h) } else { h };
            path = 0.5 * before * time;
            rest = h - time;
        }
        let slid = path.abs();
        // At rest: friction holds it, or what exceeds friction moves it.
        if drive.abs() <= coulomb || rest <= 0.0 {
            return (0.0, path, slid);
        }
        let end = after(0.0, if drive > 0.0 { 1.0 } else { -1.0 }, rest);
        let more = 0.5 * end * rest;
        (end, path + more, slid + more.abs())
    }
}
