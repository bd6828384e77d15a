//! The shaft's way over a period of the plant or two: predicted, so that the circuit can be solved along it,
//! and then settled with the torque that came of it.

use super::INSTANT;
use super::angle::{Rotation, Sweep, Track};
use super::emf::{Chord, EmfShape};
use super::mechanics::{Motion, Push, Shaft, Turn};
use super::segment::Shape;
use super::stage::Stage;
use super::wiring::Wiring;

/// Longest course, s: two periods at 10 kHz.
const LENGTH_MAX: f64 = 200e-6;
/// Part of the shaft's and the circuit's common swing, rad, that a course may be long: a rotor that is light
/// for its torque swings against the winding's inductance within a period or two.
const SWING_MAX: f64 = 0.11;
/// Part of the rotor's swing about the angle where currents hold it, rad, that a course may be long: without
/// friction the energy of the swing has to last for many periods.
const HOLD_MAX: f64 = 0.07;
/// Courses are not made shorter than this because of a wrong prediction, s.
const LENGTH_MIN: f64 = 5e-6;
/// Less is no course, s: rounding may leave the shaft a hair before a corner.
const PROGRESS: f64 = 1e-10;
/// Largest electrical angle of a course, rad: the back-EMF is linear in it to 1e-3.
const ANGLE_MAX: f64 = 0.27;
/// Largest error of a phase's back-EMF because the speed was predicted wrongly: V, and part of the back-EMF.
/// Beyond it the next courses are shorter.
const EMF_ERROR: (f64, f64) = (1e-3, 1e-3);

/// A course, and what adds up along it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Course {
    /// s.
    length: f64,
    /// Time since its start, s.
    pub(crate) elapsed: f64,
    /// Longest one that the shaft can be predicted for, s.
    length_max: f64,
    /// Upper bound of `length_max`, s.
    ceiling: f64,
    motion: Motion,
    /// Value for `lean` of [`super::segment::Pace`]: effect of the electrical torque's slope on the
    /// acceleration.
    pub(crate) lean: f64,
    /// Electrical angular speed at its start as predicted, rad/s, and half of what it gains, rad/s2.
    rate: f64,
    half_gain: f64,
    sweep: Sweep,
    track: Track,
    /// By so much the shaft is ahead of that prediction, electrical rad; `track` knows.
    ahead: f64,
    /// Torque impulse so far, N m s, and its moment about the start, N m s2.
    pub(crate) impulse: f64,
    pub(crate) moment: f64,
    /// Way travelled so far as the circuit was told, rad.
    pub(crate) path: f64,
}

impl Course {
    /// One of no length.
    pub(crate) fn new() -> Self {
        Self {
            length: 0.0,
            elapsed: 0.0,
            length_max: LENGTH_MAX,
            ceiling: LENGTH_MAX,
            motion: Motion { speed: 0.0, drift: 0.0, per_inertia: 0.0 },
            lean: 0.0,
            rate: 0.0,
            half_gain: 0.0,
            sweep: Sweep::new(&Rotation::of(0.0), 0.0),
            track: Track::new(&Rotation::of(0.0), 0.0, 0.0),
            ahead: 0.0,
            impulse: 0.0,
            moment: 0.0,
            path: 0.0,
        }
    }

    /// Speed now, rad/s.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn speed(&self) -> f64 {
        let Motion { speed, drift, per_inertia } = self.motion;
        speed + drift * self.elapsed + per_inertia * self.impulse
    }

    /// Acceleration under an electrical torque in N m, rad/s2.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn acceleration(&self, torque: f64) -> f64 {
        self.motion.drift + self.motion.per_inertia * torque
    }

    /// Nothing is left of it.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn is_done(&self) -> bool {
        self.rest() < 2.0 * INSTANT
    }

    /// Returns the time that is left of it, s.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn rest(&self) -> f64 {
        self.length - self.elapsed
    }

    /// Back-EMF per speed along the coordinates of `wiring` for the next `h` seconds; `three` says that all
    /// its legs conduct.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn shape(&self, emf: &EmfShape, shaft: &Shaft, wiring: &Wiring, three: bool, h: f64) -> Shape {
        let t = self.elapsed + 0.5 * h;
        let rate = self.rate + 2.0 * self.half_gain * t;
        if emf.is_sine() {
            emf.along(wiring, three, &self.rotation(t), rate, h)
        } else {
            emf.trapezoids_along(wiring, self.turns(shaft, t), rate)
        }
    }

    /// Back-EMF per speed of every leg for the next `h` seconds.
    pub(crate) fn legs(&self, emf: &EmfShape, shaft: &Shaft, h: f64) -> [Chord; 3] {
        let t = self.elapsed + 0.5 * h;
        let rate = self.rate + 2.0 * self.half_gain * t;
        emf.legs(self.turns(shaft, t), &self.rotation(t), rate, h)
    }

    /// Electrical angle after `t` seconds of the course, turns.
    pub(crate) fn turns(&self, shaft: &Shaft, t: f64) -> f64 {
        let way = self.ahead + t * (self.rate + self.half_gain * t);
        shaft.angle + way * (0.5 / core::f64::consts::PI)
    }

    /// Its sine and cosine.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn rotation(&self, t: f64) -> Rotation {
        self.track.at(t - 0.5 * self.length)
    }
}

impl Stage {
    /// Begins a course that ends with the present period, which has `rest` seconds left, with the next one,
    /// or before both.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn set_out(&mut self, rest: f64, period: f64) {
        let longest = self.longest(rest + period).max(PROGRESS);
        let length = if longest < rest + period && longest > rest { rest } else { longest };
        let motion = self.shaft.predict(self.torque, length);
        let acceleration = motion.drift + motion.per_inertia * self.torque;
        let (rate, half_gain) =
            (motion.speed * self.shaft.pole_pairs(), 0.5 * acceleration * self.shaft.pole_pairs());
        let course = &mut self.course;
        (course.length, course.elapsed) = (length, 0.0);
        (course.motion, course.rate, course.half_gain) = (motion, rate, half_gain);
        // Its mean is weighted as it acts on the way travelled: a third, not a half.
        course.lean = self.network.per_l * motion.per_inertia * (1.0 / 3.0);
        if self.shape.is_sine() {
            course.sweep = Sweep::little(&self.rotation, (rate + half_gain * length) * length);
            // Half way in time, the angle lies a little before half of the span.
            let gain = 2.0 * half_gain;
            let late = 0.25 * half_gain * length * length;
            let Rotation { sin, cos } = course.sweep.middle;
            let middle = Rotation { sin: sin - late * cos, cos: cos + late * sin };
            course.track = Track::new(&middle, rate + half_gain * length, gain);
        }
        (course.impulse, course.moment, course.path, course.ahead) = (0.0, 0.0, 0.0, 0.0);
    }

    /// The rotor's inertia, or the winding's inductance, is what it is from now on.
    pub(crate) fn limit_courses(&mut self) {
        let peak = self.shape.peak();
        let swing = libm::sqrt(2.0 * peak * peak * self.network.per_l * self.shaft.per_inertia());
        let course = &mut self.course;
        course.ceiling = (SWING_MAX / swing.max(SWING_MAX / LENGTH_MAX)).max(LENGTH_MIN);
        course.length_max = course.length_max.min(course.ceiling);
    }

    /// Longest course up to `limit` that the approximations allow.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn longest(&self, limit: f64) -> f64 {
        let most = self.course.length_max;
        let mut length = if limit < most { limit } else { most };
        let rate = (self.shaft.speed * self.shaft.pole_pairs()).abs();
        if rate * length > ANGLE_MAX {
            length = ANGLE_MAX / rate;
        }
        length = self.to_stop(length);
        let hold = self.hold();
        if hold * length * length > HOLD_MAX * HOLD_MAX {
            length = (HOLD_MAX / libm::sqrt(hold)).max(LENGTH_MIN);
        }
        if self.shape.is_sine() { length } else { self.to_corner(length) }
    }

    /// `length`, or less if the shaft comes to rest before: it may turn back from there.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn to_stop(&self, length: f64) -> f64 {
        let speed = self.shaft.speed;
        let loss = -self.shaft.acceleration(self.torque);
        if speed * (speed - loss * length) < 0.0 {
            (speed / loss).max(LENGTH_MIN).min(length)
        } else {
            length
        }
    }

    /// Square of the rate at which the rotor swings about where the present currents hold it, (rad/s)2, at
    /// most.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn hold(&self) -> f64 {
        let [a, b, c] = self.electric.i;
        0.5 * (a.abs() + b.abs() + c.abs())
            * self.shape.peak()
            * self.shaft.pole_pairs()
            * self.shaft.per_inertia()
    }

    /// `length`, or less if the back-EMF has a corner before.
    #[inline(never)]
    fn to_corner(&self, length: f64) -> f64 {
        let turns_per_second = self.shaft.speed * self.shaft.turns_per_radian();
        match self.shape.turns_to_corner(self.shaft.angle, turns_per_second.signum()) {
            Some(turns) if turns_per_second.abs() * length > turns => turns / turns_per_second.abs(),
            _ => length,
        }
    }

    /// At a stop on the way: the course goes on from where the shaft is, which the torque has told since it
    /// began.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn go_on(&mut self) {
        let course = &mut self.course;
        let expected = (course.rate + course.half_gain * course.elapsed) * course.elapsed;
        let ahead = course.path * self.shaft.pole_pairs() - expected;
        course.track.turn(ahead - course.ahead);
        course.ahead = ahead;
    }

    /// Electrical angle now, turns.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn angle(&self) -> f64 {
        self.shaft.angle + self.course.path * self.shaft.turns_per_radian()
    }

    /// Turn of the shaft since the course began.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn turn_so_far(&self) -> Turn {
        let Course { elapsed: h, impulse, moment, path, .. } = self.course;
        self.shaft.turn(&Push {
            h,
            per_h: 1.0 / h,
            impulse,
            lead: 0.5 * impulse * h - moment,
            speed: path / h,
        })
    }

    /// Speed, rad/s, and electrical angle, turns, of the shaft now, as its course would end here.
    pub(crate) fn shaft_now(&self) -> (f64, f64) {
        if self.course.elapsed == 0.0 {
            return (self.shaft.speed, self.shaft.angle);
        }
        self.shaft.after(&self.turn_so_far())
    }

    /// Ends a course where it is: moves the shaft and books what added up.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn arrive(&mut self) {
        let course = &self.course;
        let Course { elapsed: h, impulse, path, .. } = *course;
        if h == 0.0 {
            return;
        }
        let expected = path / h;
        let turn = self.turn_so_far();
        let more = turn.path - path;
        let error = more.abs() / h * self.shape.peak();
        let allowed = EMF_ERROR.0 + EMF_ERROR.1 * self.shape.peak() * expected.abs();
        if error > allowed {
            self.course.length_max = (0.5 * h).max(LENGTH_MIN);
        } else if error < 0.25 * allowed && course.length_max < course.ceiling {
            self.course.length_max = (2.0 * course.length_max).min(course.ceiling);
        }
        if self.shape.is_sine() {
            self.rotation = self.course.sweep.end(turn.path * self.shaft.pole_pairs());
        }
        self.shaft.apply(&turn);
        self.course.elapsed = 0.0;
        self.course.length = 0.0;
        self.course.path = 0.0;
        self.course.impulse = 0.0;
        self.impulse += impulse;
        self.ledger.shaft += impulse * turn.mean;
        self.ledger.friction += turn.friction;
        self.ledger.load += turn.load;
    }
}
