//! The exact solution between two switching events: which legs conduct is fixed, the back-EMF is linear in
//! time.

use super::circuit::{Circuit, Reduced};
use super::emf::{Chord, Line};
use super::network::{Loop, Modes, Network};

/// Back-EMF per speed along the coordinates of a circuit, V s/rad; `idle` is that of the one idle leg beside
/// two that conduct, less the mean of theirs.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Shape {
    pub(crate) s: Chord,
    pub(crate) d: Chord,
    pub(crate) idle: Chord,
}

/// Properties in which circuits differ.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kind {
    /// Path of the motor's current at the bus: none, two legs or three.
    pub(crate) topology: Loop,
    /// All three legs conduct.
    pub(crate) three: bool,
    pub(crate) source_on: bool,
}

/// Motion of the shaft at the start of an interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pace {
    /// Mechanical speed, rad/s.
    pub(crate) speed: f64,
    /// rad/s2.
    pub(crate) acceleration: f64,
    /// Change of the acceleration per second of interval and per unit of the torque's slope, which is
    /// computed with L times the slopes of the currents.
    pub(crate) lean: f64,
}

/// One interval's circuit and its solution.
///
/// ```text
///   L ds/dt = -R s + [w k] + u(t)        [ ]: only where some legs are tied to the bus and some to ground
///   L dd/dt = -R d + f(t)
///   C dw/dt = [-s] - g w                 w: bus voltage from where it rests without the motor
/// ```
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segment {
    kind: Kind,
    /// Length, s: `shape` and `middle_speed` are told from its middle.
    h: f64,
    /// Mechanical speed at the start and half way, rad/s, and acceleration, rad/s2.
    pub(crate) speed: f64,
    pub(crate) middle_speed: f64,
    pub(crate) acceleration: f64,
    pub(crate) start: Reduced,
    pub(crate) shape: Shape,
    /// Terminal of the one idle leg beside two that conduct, less its share of the bus voltage, V.
    pub(crate) idle: Line,
    u: Line,
    f: Line,
    /// Slopes of `s` and `d` at the start times L, V.
    s_slope: f64,
    d_slope: f64,
    /// Particular solution p + q t, and what decays: start - p.
    p: Reduced,
    q: Reduced,
    fading: Reduced,
}

/// Integrals over an interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sums {
    /// Of `s` and `d`, A s.
    pub(crate) s: f64,
    pub(crate) d: f64,
    /// Of the bus voltage from where it rests, V s.
    pub(crate) w: f64,
}

impl Segment {
    /// The circuit from `start` on for `h` seconds; `shape` is the back-EMF per speed.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn new(
        network: &Network,
        circuit: &Circuit,
        kind: Kind,
        start: Reduced,
        shape: Shape,
        pace: Pace,
        h: f64,
    ) -> Self {
        let Kind { topology, three, source_on } = kind;
        let modes = network.modes(topology, source_on);
        let (speed, half) = (pace.speed, 0.5 * h);
        // 1 / (along . along); without a current it does not matter.
        let k = if three { 2.0 / 3.0 } else { 0.5 };
        // What drives the coordinates: the bus at rest and diode drops less back-EMF.
        let s_shape = shape.s.middle - half * shape.s.slope;
        let tied = topology != Loop::Open;
        let rest = if tied { modes.rest } else { 0.0 };
        let u_start = k * (rest + circuit.drop_s - s_shape * speed);
        let s_slope = if tied { u_start + k * (start.v - rest) } else { u_start } - network.r * start.s;
        let mut torque_slope = s_shape * s_slope;
        let (mut f_start, mut d_slope) = (0.0, 0.0);
        if three {
            let d_shape = shape.d.middle - half * shape.d.slope;
            f_start = 0.5 * (circuit.drop_d - d_shape * speed);
            d_slope = f_start - network.r * start.d;
            torque_slope += d_shape * d_slope;
        }
        // The torque's own slope gives the acceleration's, else a light rotor would outrun its prediction
        // within one interval.
        let acceleration = pace.acceleration + torque_slope * pace.lean * h;
        let middle_speed = speed + acceleration * half;
        let slope = |chord: &Chord| chord.slope * middle_speed + chord.middle * acceleration;
        let u = Line { start: u_start, slope: -k * slope(&shape.s) };
        let (mut f, mut idle) = (Line::default(), Line::default());
        let (mut p_d, mut q_d) = (0.0, 0.0);
        if three {
            f = Line { start: f_start, slope: -0.5 * slope(&shape.d) };
            q_d = f.slope * network.per_r;
            p_d = f.start * network.per_r - network.time_constant * q_d;
        } else {
            let start = (shape.idle.middle - half * shape.idle.slope) * speed;
            idle = Line { start: circuit.drop_idle + start, slope: slope(&shape.idle) };
        }
        let (p_s, p_v, q_s, q_v) = if tied {
            (
                u.start * modes.g_det + u.slope * modes.lag_s,
                modes.rest - u.start * modes.per_det + u.slope * modes.lag_v,
                u.slope * modes.g_det,
                -u.slope * modes.per_det,
            )
        } else {
            let q_s = u.slope * network.per_r;
            let p_v = if modes.g > 0.0 { modes.rest } else { start.v };
            (u.start * network.per_r - network.time_constant * q_s, p_v, q_s, 0.0)
        };
        let (p, q) = (Reduced { s: p_s, d: p_d, v: p_v }, Reduced { s: q_s, d: q_d, v: q_v });
        let fading = Reduced { s: start.s - p_s, d: start.d - p_d, v: start.v - p_v };
        Self {
            kind,
            h,
            speed,
            middle_speed,
            acceleration,
            start,
            shape,
            idle,
            u,
            f,
            s_slope,
            d_slope,
            p,
            q,
            fading,
        }
    }

    /// Ends it earlier, `h` seconds after the start.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn end_at(&mut self, h: f64) {
        let later = 0.5 * (h - self.h);
        for chord in [&mut self.shape.s, &mut self.shape.d] {
            chord.middle += later * chord.slope;
        }
        self.middle_speed += later * self.acceleration;
        self.h = h;
    }

    /// Length, s.
    #[inline]
    pub(crate) fn length(&self) -> f64 {
        self.h
    }

    /// State `t` seconds after the start.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn at(&self, network: &Network, t: f64) -> Reduced {
        let Reduced { s, d, v } = self.fading;
        let (p, q, a) = (&self.p, &self.q, self.modes(network));
        if self.kind.topology == Loop::Open {
            let leg = network.leg_decay(t);
            let d = if self.kind.three { p.d + q.d * t + leg * d } else { 0.0 };
            return Reduced { s: p.s + q.s * t + leg * s, d, v: p.v + a.bus_decay(t) * v };
        }
        let (alpha, beta) = a.transition(t);
        let d = if self.kind.three { p.d + q.d * t + network.leg_decay(t) * d } else { 0.0 };
        Reduced {
            s: p.s + q.s * t + alpha * s + beta * (a.a_ss * s + a.a_sv * v),
            d,
            v: p.v + q.v * t + alpha * v + beta * (a.a_vs * s + a.a_vv * v),
        }
    }

    /// Integrals over `h` seconds, exact from the circuit's equations.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn sums(&self, network: &Network, h: f64, to: &Reduced) -> Sums {
        let modes = self.modes(network);
        let Self { u, f, start, .. } = self;
        let fall = network.c * (start.v - to.v);
        let flux = (u.start + 0.5 * h * u.slope) * h - network.l * (to.s - start.s);
        let d = if self.kind.three {
            ((f.start + 0.5 * h * f.slope) * h - network.l * (to.d - start.d)) * network.per_r
        } else {
            0.0
        };
        if self.kind.topology == Loop::Open {
            let w = if modes.g > 0.0 { fall * modes.per_g } else { start.v * h };
            return Sums { s: flux * network.per_r, d, w };
        }
        let s = modes.g_det * flux + modes.k_det * fall;
        Sums { s, d, w: modes.r_det * fall - modes.per_det * flux }
    }

    /// Slope of the state at `t`, A/s and V/s.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn slopes(&self, network: &Network, t: f64, at: &Reduced) -> Reduced {
        let modes = self.modes(network);
        let link = if self.kind.topology == Loop::Open { 0.0 } else { at.s };
        let w = at.v - modes.rest;
        Reduced {
            s: (self.u.at(t) + modes.k * w - network.r * at.s) * network.per_l,
            d: (self.f.at(t) - network.r * at.d) * network.per_l,
            v: (-modes.g * w - link) / network.c,
        }
    }

    /// Time at which a negative combination of `s` and `d` reaches zero according to the present slopes, s;
    /// infinity if it does not.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn expected_zero(&self, network: &Network, parts: &[f64; 2]) -> f64 {
        let (mut value, mut slope) = (parts[0] * self.start.s, parts[0] * self.s_slope);
        if self.kind.three {
            value += parts[1] * self.start.d;
            slope += parts[1] * self.d_slope;
        }
        if slope <= 0.0 {
            return f64::INFINITY;
        }
        // The currents decay as they go: value + slope (1 - exp(-rate t)) / rate.
        let t = -value * network.l / slope;
        t * (1.0 + 0.5 * network.rate * t)
    }

    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn modes<'a>(&self, network: &'a Network) -> &'a Modes {
        network.modes(self.kind.topology, self.kind.source_on)
    }

    /// True if `d` is a current, with three legs that conduct.
    #[inline]
    pub(crate) fn has_difference(&self) -> bool {
        self.kind.three
    }

    /// True if the source feeds the bus.
    #[inline]
    pub(crate) fn source_on(&self) -> bool {
        self.kind.source_on
    }

    /// Returns the path of the motor's current at the bus.
    #[inline]
    pub(crate) fn topology(&self) -> Loop {
        self.kind.topology
    }
}
