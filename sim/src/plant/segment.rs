//! The exact solution between two switching events: which legs conduct is fixed, the back-EMF is linear in time.

use super::circuit::{Circuit, Reduced};
use super::emf::Line;
use super::network::{Loop, Modes, Network};

/// Back-EMF per speed along the coordinates of a circuit, V s/rad; `idle` is that of the one idle leg beside two that conduct,
/// less the mean of theirs.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Shape {
    pub(crate) s: Line,
    pub(crate) d: Line,
    pub(crate) idle: Line,
}

/// What tells circuits apart.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kind {
    /// What the bus sees of the motor.
    pub(crate) topology: Loop,
    /// All three legs conduct.
    pub(crate) three: bool,
    pub(crate) source_on: bool,
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
    kind: Kind,
    /// Mechanical speed at the start, rad/s, and acceleration, rad/s2.
    pub(crate) speed: f64,
    pub(crate) acceleration: f64,
    pub(crate) start: Reduced,
    pub(crate) shape: Shape,
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
    /// The circuit from `start` on for `h` seconds; `shape` is the back-EMF per speed, `motion` speed (rad/s), acceleration
    /// (rad/s2) and 1 / inertia (1 / (kg m2)).
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn new(
        network: &Network,
        circuit: &Circuit,
        kind: Kind,
        start: Reduced,
        shape: Shape,
        (speed, acceleration, per_inertia): (f64, f64, f64),
        h: f64,
    ) -> Self {
        let k = circuit.wiring.k;
        // The torque's own slope gives the acceleration's, else a light rotor would outrun its prediction within one interval. Its
        // mean is weighted as it acts on the way travelled: a third, not a half.
        let bus = if kind.topology == Loop::Open { 0.0 } else { start.v };
        let s_slope = k * (bus + circuit.drop_s - shape.s.start * speed) - network.r * start.s;
        let mut torque_slope = shape.s.start * s_slope;
        if kind.three {
            let d_slope = 0.5 * (circuit.drop_d - shape.d.start * speed) - network.r * start.d;
            torque_slope += shape.d.start * d_slope;
        }
        let acceleration = acceleration + torque_slope * network.per_l * per_inertia * h * (1.0 / 3.0);
        let half = 0.5 * h;
        let middle = speed + acceleration * half;
        let slope = |line: &Line| line.slope * middle + (line.start + half * line.slope) * acceleration;
        // What drives the coordinates: diode drops less back-EMF.
        let u = Line { start: k * (circuit.drop_s - shape.s.start * speed), slope: -k * slope(&shape.s) };
        let Kind { topology, three, source_on } = kind;
        let (mut f, mut idle) = (Line::default(), Line::default());
        let (mut p_d, mut q_d) = (0.0, 0.0);
        if three {
            f = Line { start: 0.5 * (circuit.drop_d - shape.d.start * speed), slope: -0.5 * slope(&shape.d) };
            q_d = f.slope * network.per_r;
            p_d = f.start * network.per_r - network.time_constant * q_d;
        } else {
            idle = Line { start: circuit.drop_idle + shape.idle.start * speed, slope: slope(&shape.idle) };
        }
        let modes = network.modes(topology, source_on);
        let ((p_s, q_s), (p_v, q_v)) = if topology == Loop::Open {
            let q_s = u.slope * network.per_r;
            let p_v = if modes.g > 0.0 { modes.j * modes.per_g } else { start.v };
            ((u.start * network.per_r - network.time_constant * q_s, q_s), (p_v, 0.0))
        } else {
            particular(network, modes, &u)
        };
        let (p, q) = (Reduced { s: p_s, d: p_d, v: p_v }, Reduced { s: q_s, d: q_d, v: q_v });
        let fading = Reduced { s: start.s - p_s, d: start.d - p_d, v: start.v - p_v };
        Self { kind, speed, acceleration, start, shape, idle, u, f, p, q, fading }
    }

    /// State `t` seconds after the start.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn at(&self, network: &Network, t: f64) -> Reduced {
        let Reduced { s, d, v } = self.fading;
        let (p, q, a) = (&self.p, &self.q, self.modes(network));
        if self.kind.topology == Loop::Open {
            let [leg, bus] = network.separate_decay(a, t);
            let d = if self.kind.three { p.d + q.d * t + leg * d } else { 0.0 };
            return Reduced { s: p.s + q.s * t + leg * s, d, v: p.v + bus * v };
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
        let charge = modes.j * h - network.c * (to.v - start.v);
        let flux = (u.start + 0.5 * u.slope * h) * h - network.l * (to.s - start.s);
        let d = if self.kind.three {
            ((f.start + 0.5 * f.slope * h) * h - network.l * (to.d - start.d)) * network.per_r
        } else {
            0.0
        };
        if self.kind.topology == Loop::Open {
            let v = if modes.g > 0.0 { charge * modes.per_g } else { start.v * h };
            return Sums { s: flux * network.per_r, d, v };
        }
        let s = (modes.g * flux + modes.k * charge) * modes.per_det;
        Sums { s, d, v: (network.r * charge - flux) * modes.per_det }
    }

    /// Slope of the state at `t`, A/s and V/s.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn slopes(&self, network: &Network, t: f64, at: &Reduced) -> Reduced {
        let modes = self.modes(network);
        let link = if self.kind.topology == Loop::Open { 0.0 } else { at.s };
        Reduced {
            s: (self.u.at(t) + modes.k * at.v - network.r * at.s) * network.per_l,
            d: (self.f.at(t) - network.r * at.d) * network.per_l,
            v: (modes.j - modes.g * at.v - link) / network.c,
        }
    }

    /// Lowest and highest bus voltage on the way to `end` `h` seconds later: the bus follows the voltage at which the source
    /// gives what the motor takes, and never passes it.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn bus_range(&self, network: &Network, per_h: f64, end: &Reduced, sums: &Sums) -> (f64, f64) {
        let (from, to) = (self.start.v, end.v);
        if self.kind.topology == Loop::Open {
            return (from.min(to), from.max(to));
        }
        // The link current is a parabola, as high above its chord as the mean tells.
        let Modes { g, j, per_g, .. } = *self.modes(network);
        let bend = 1.5 * (sums.s * per_h - 0.5 * (self.start.s + end.s)).abs();
        let most = self.start.s.max(end.s) + bend;
        let least = self.start.s.min(end.s) - bend;
        if !self.kind.source_on && (least > 0.0 || most + g * from.max(to) < 0.0) {
            // Nothing but the motor at the bus: a current that does not turn round moves it one way.
            return (from.min(to), from.max(to));
        }
        (from.min((j - most) * per_g), from.max((j - least) * per_g))
    }

    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn modes<'a>(&self, network: &'a Network) -> &'a Modes {
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

    /// What the bus sees.
    #[inline]
    pub(crate) fn topology(&self) -> Loop {
        self.kind.topology
    }
}

/// p and q of s and of v where the motor draws from the bus: A q = -b1, A p = q - b0 with b0 = (u.start / L, j / C),
/// b1 = (u.slope / L, 0).
#[cfg_attr(not(target_arch = "wasm32"), inline(always))]
fn particular(network: &Network, modes: &Modes, u: &Line) -> ((f64, f64), (f64, f64)) {
    let Modes { g, j, k, per_det, .. } = *modes;
    let (q_s, q_v) = (u.slope * g * per_det, -u.slope * per_det);
    let (rest_s, rest_v) = (network.l * q_s - u.start, network.c * q_v - j);
    let p_s = -(g * rest_s + k * rest_v) * per_det;
    let p_v = (rest_s - network.r * rest_v) * per_det;
    ((p_s, q_s), (p_v, q_v))
}
