//! The exact solution between two switching events: which legs conduct is fixed, the back-EMF is linear in time.

use super::circuit::{Circuit, Reduced};
use super::emf::Line;
use super::network::{Loop, Modes, Network};

/// How the shaft is expected to move over an interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion {
    /// Mechanical speed at the start, rad/s.
    pub(crate) speed: f64,
    /// Acceleration at the start, rad/s2.
    pub(crate) acceleration: f64,
    /// 1 / (kg m2) to let the acceleration follow the currents, 0 to keep it.
    pub(crate) per_inertia: f64,
    /// Length of the interval, s.
    pub(crate) h: f64,
}

/// Back-EMF per speed along the coordinates of a circuit, V s/rad; `idle` is that of the one idle leg beside two that conduct,
/// less the mean of theirs.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Shape {
    pub(crate) s: Line,
    pub(crate) d: Line,
    pub(crate) idle: Line,
}

/// One interval's circuit and its solution.
///
/// ```text
///   L ds/dt = -R s + [v k] + u(t)        [ ]: only where some legs are tied to the bus and some to ground
///   L dd/dt = -R d + f(t)
///   C dv/dt = [-s] - g v + j
/// ```
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segment {
    topology: Loop,
    source_on: bool,
    pub(crate) start: Reduced,
    pub(crate) shape: Shape,
    /// Mean acceleration that the back-EMF was taken with, rad/s2.
    pub(crate) acceleration: f64,
    /// Terminal of the one idle leg beside two that conduct, less its share of the bus voltage, V.
    pub(crate) idle: Line,
    u: Line,
    f: Line,
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
    /// Of the bus voltage, V s.
    pub(crate) v: f64,
}

impl Segment {
    /// The circuit from `start` on; `shape` is the back-EMF per speed.
    #[inline(always)]
    pub(crate) fn new(
        network: &Network,
        circuit: &Circuit,
        source_on: bool,
        start: Reduced,
        shape: Shape,
        motion: &Motion,
    ) -> Self {
        let topology = circuit.wiring.topology;
        let k = circuit.wiring.k;
        // What drives the coordinates: diode drops less back-EMF.
        let rest_s = circuit.drop_s - shape.s.start * motion.speed;
        let rest_d = circuit.drop_d - shape.d.start * motion.speed;
        let bus = if topology == Loop::Open { 0.0 } else { start.v };
        // The torque's own slope gives the acceleration's, else a light rotor would outrun its prediction within one interval.
        let s_slope = k * (bus + rest_s) - network.r * start.s;
        let d_slope = 0.5 * rest_d - network.r * start.d;
        let jerk = (shape.s.start * s_slope + shape.d.start * d_slope) * network.per_l * motion.per_inertia;
        // Mean over the interval of alpha + jerk t, weighted as it acts on the way travelled: a third, not a half.
        let acceleration = motion.acceleration + jerk * motion.h * (1.0 / 3.0);
        let half = 0.5 * motion.h;
        let middle = motion.speed + acceleration * half;
        let slope = |line: &Line| line.slope * middle + (line.start + half * line.slope) * acceleration;
        let u = Line { start: k * rest_s, slope: -k * slope(&shape.s) };
        let mut segment = Self {
            topology,
            source_on,
            start,
            shape,
            acceleration,
            idle: Line::default(),
            u,
            f: Line::default(),
            p: Reduced::default(),
            q: Reduced::default(),
            fading: Reduced::default(),
        };
        if circuit.wiring.conducting == 3 {
            segment.f = Line { start: 0.5 * rest_d, slope: -0.5 * slope(&shape.d) };
            segment.q.d = segment.f.slope * network.per_r;
            segment.p.d = segment.f.start * network.per_r - network.time_constant * segment.q.d;
            segment.fading.d = start.d - segment.p.d;
        } else {
            let start = circuit.drop_idle + shape.idle.start * motion.speed;
            segment.idle = Line { start, slope: slope(&shape.idle) };
        }
        segment.find_particular(network);
        segment
    }

    /// The particular solution of `s` and `v`.
    #[inline(always)]
    fn find_particular(&mut self, network: &Network) {
        let modes = self.modes(network);
        let Self { u, start, .. } = self;
        if self.topology == Loop::Open {
            self.q.s = u.slope * network.per_r;
            self.p.s = u.start * network.per_r - network.time_constant * self.q.s;
            self.p.v = if modes.g > 0.0 { modes.j * modes.per_g } else { start.v };
        } else {
            // A q = -b1, A p = q - b0 with b0 = (u.start / L, j / C), b1 = (u.slope / L, 0).
            let Modes { g, j, k, per_det, .. } = *modes;
            (self.q.s, self.q.v) = (u.slope * g * per_det, -u.slope * per_det);
            let (rest_s, rest_v) = (network.l * self.q.s - u.start, network.c * self.q.v - j);
            self.p.s = -(g * rest_s + k * rest_v) * per_det;
            self.p.v = (rest_s - network.r * rest_v) * per_det;
        }
        (self.fading.s, self.fading.v) = (start.s - self.p.s, start.v - self.p.v);
    }

    /// State `t` seconds after the start.
    #[inline(always)]
    pub(crate) fn at(&self, network: &Network, t: f64) -> Reduced {
        let Reduced { s, d, v } = self.fading;
        let (p, q, a) = (&self.p, &self.q, self.modes(network));
        if self.topology == Loop::Open {
            let [leg, bus] = network.separate_decay(a, t);
            return Reduced { s: p.s + q.s * t + leg * s, d: p.d + q.d * t + leg * d, v: p.v + bus * v };
        }
        let (alpha, beta) = a.transition(t);
        let d = if self.topology == Loop::ThreeLegs {
            p.d + q.d * t + network.leg_decay(t) * d
        } else {
            0.0
        };
        Reduced {
            s: p.s + q.s * t + alpha * s + beta * (a.a_ss * s + a.a_sv * v),
            d,
            v: p.v + q.v * t + alpha * v + beta * (a.a_vs * s + a.a_vv * v),
        }
    }

    /// Integrals over `h` seconds, exact from the circuit's equations.
    #[inline(always)]
    pub(crate) fn sums(&self, network: &Network, h: f64, to: &Reduced) -> Sums {
        let modes = self.modes(network);
        let Self { u, f, start, .. } = self;
        let charge = modes.j * h - network.c * (to.v - start.v);
        let flux = (u.start + 0.5 * u.slope * h) * h - network.l * (to.s - start.s);
        let d = ((f.start + 0.5 * f.slope * h) * h - network.l * (to.d - start.d)) * network.per_r;
        if self.topology == Loop::Open {
            let v = if modes.g > 0.0 { charge * modes.per_g } else { start.v * h };
            return Sums { s: flux * network.per_r, d, v };
        }
        let s = (modes.g * flux + modes.k * charge) * modes.per_det;
        Sums { s, d, v: (network.r * charge - flux) * modes.per_det }
    }

    /// Lowest and highest bus voltage on the way to `end` `h` seconds later: the bus follows the voltage at which the source
    /// gives what the motor takes, and never passes it.
    #[inline(always)]
    pub(crate) fn bus_range(
        &self,
        network: &Network,
        per_h: f64,
        end: &Reduced,
        sums: &Sums,
    ) -> (f64, f64) {
        let (from, to) = (self.start.v, end.v);
        if self.topology == Loop::Open {
            return (from.min(to), from.max(to));
        }
        // The link current is a parabola, as high above its chord as the mean tells.
        let Modes { j, per_g, .. } = *self.modes(network);
        let bend = 1.5 * (sums.s * per_h - 0.5 * (self.start.s + end.s)).abs();
        let most = self.start.s.max(end.s) + bend;
        let least = self.start.s.min(end.s) - bend;
        (from.min((j - most) * per_g), from.max((j - least) * per_g))
    }

    #[inline(always)]
    fn modes<'a>(&self, network: &'a Network) -> &'a Modes {
        network.modes(self.topology, self.source_on)
    }

    /// What the bus sees.
    #[inline]
    pub(crate) fn topology(&self) -> Loop {
        self.topology
    }
}
