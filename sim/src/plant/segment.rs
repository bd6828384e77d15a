//! The exact solution between two switching events: which legs conduct is fixed, the back-EMF is linear in time.

use super::emf::Linear3;
use super::network::{Decay, Loop, Modes, Network};
use super::wiring::{Wiring, dot};

/// What a leg of the bridge does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Leg {
    /// No current.
    #[default]
    Idle,
    /// High-side switch on.
    HighSwitch,
    /// Low-side switch on.
    LowSwitch,
    /// Current from the motor through the high-side diode into the bus.
    HighDiode,
    /// Current from ground through the low-side diode into the motor.
    LowDiode,
}

impl Leg {
    pub(crate) const fn is_diode(self) -> bool {
        matches!(self, Self::HighDiode | Self::LowDiode)
    }
    /// 0 idle, 1 tied to the bus, 2 tied to ground.
    #[inline]
    pub(crate) const fn side(self) -> usize {
        match self {
            Self::Idle => 0,
            Self::HighSwitch | Self::HighDiode => 1,
            Self::LowSwitch | Self::LowDiode => 2,
        }
    }
    /// Sign of the diode's drop at the terminal: +1 above the bus, -1 below ground, 0 without a diode. Also the sign of the
    /// current that it does not let through.
    #[inline]
    pub(crate) const fn diode_sign(self) -> f64 {
        match self {
            Self::HighDiode => 1.0,
            Self::LowDiode => -1.0,
            _ => 0.0,
        }
    }
}

/// Currents into the motor and the bus voltage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Electric {
    pub(crate) i: [f64; 3],
    pub(crate) v: f64,
}

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

/// The circuit's state in the coordinates of its [`Wiring`].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Reduced {
    pub(crate) s: f64,
    pub(crate) d: f64,
    pub(crate) v: f64,
}

/// A quantity along `s` and `d` that runs linearly over an interval: `start + slope t`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Linear2 {
    pub(crate) s: f64,
    pub(crate) d: f64,
    pub(crate) s_slope: f64,
    pub(crate) d_slope: f64,
}

/// One interval's circuit and its solution.
///
/// ```text
///   L ds/dt = -R s + [v k] + u(t)        [ ]: only where some legs are tied to the bus and some to ground
///   L dd/dt = -R d + f(t)
///   C dv/dt = [-s] - g v + j
/// ```
#[derive(Clone, Debug)]
pub(crate) struct Segment {
    pub(crate) legs: [Leg; 3],
    pub(crate) wiring: &'static Wiring,
    pub(crate) source_on: bool,
    /// Any leg conducts through a diode.
    pub(crate) has_diodes: bool,
    /// Where, and in which direction.
    pub(crate) diodes: [f64; 3],
    pub(crate) emf: Linear3,
    /// Back-EMF per speed along the coordinates.
    pub(crate) shape: Linear2,
    /// Mean acceleration that the back-EMF was taken with, rad/s2.
    pub(crate) acceleration: f64,
    pub(crate) start: Reduced,
    /// Diode drops along the coordinates, V.
    pub(crate) drop_s: f64,
    pub(crate) drop_d: f64,
    /// Terminal of the one idle leg beside two that conduct, less its share of the bus voltage: at the start, V, and its
    /// slope, V/s.
    pub(crate) idle: (f64, f64),
    u0: f64,
    u1: f64,
    /// Particular solution p + q t, and what decays: start - p.
    p: Reduced,
    q: Reduced,
    fading: Reduced,
}

impl Segment {
    /// The circuit of `legs` from `electric` on; `shape` is the back-EMF per speed.
    #[inline]
    pub(crate) fn new(
        network: &Network,
        legs: [Leg; 3],
        source_on: bool,
        electric: &Electric,
        shape: &Linear3,
        motion: &Motion,
    ) -> Self {
        let wiring = Wiring::of(&legs);
        let diodes = [legs[0].diode_sign(), legs[1].diode_sign(), legs[2].diode_sign()];
        let mut segment = Self {
            legs,
            wiring,
            source_on,
            has_diodes: diodes != [0.0; 3],
            diodes,
            emf: Linear3::default(),
            shape: Linear2 {
                s: dot(&wiring.along, &shape.start),
                d: dot(&wiring.across, &shape.start),
                s_slope: dot(&wiring.along, &shape.slope),
                d_slope: dot(&wiring.across, &shape.slope),
            },
            acceleration: 0.0,
            start: Reduced { s: wiring.s_of(&electric.i), d: wiring.d_of(&electric.i), v: electric.v },
            drop_s: network.drop * dot(&wiring.along, &diodes),
            drop_d: network.drop * dot(&wiring.across, &diodes),
            idle: (0.0, 0.0),
            u0: 0.0,
            u1: 0.0,
            p: Reduced::default(),
            q: Reduced::default(),
            fading: Reduced::default(),
        };
        let forcing = segment.move_on(network, shape, motion);
        segment.solve(network, &forcing);
        if wiring.conducting == 2 {
            let (mean, emf, z) = (&wiring.mean, &segment.emf, wiring.idle);
            let drops = network.drop * dot(mean, &diodes);
            segment.idle =
                (drops + emf.start[z] - dot(mean, &emf.start), emf.slope[z] - dot(mean, &emf.slope));
        }
        segment
    }

    /// Back-EMF over the interval: the shape times a speed that changes with the mean acceleration. The torque's own
    /// slope gives the acceleration's, else a light rotor would outrun its prediction within one interval. Returns
    /// what drives the coordinates: diode drops less back-EMF, V.
    #[inline]
    fn move_on(&mut self, network: &Network, shape: &Linear3, motion: &Motion) -> Linear2 {
        let Motion { speed, acceleration, per_inertia, h } = *motion;
        let along = &self.shape;
        let k = self.wiring.k;
        let (rest_s, rest_d) = (self.drop_s - along.s * speed, self.drop_d - along.d * speed);
        let bus = if self.wiring.topology == Loop::Open { 0.0 } else { k * self.start.v };
        let s_slope = bus + k * rest_s - network.r * self.start.s;
        let d_slope = 0.5 * rest_d - network.r * self.start.d;
        let jerk = (along.s * s_slope + along.d * d_slope) * network.per_l * per_inertia;
        // Mean over the interval of alpha + jerk t, weighted as it acts on the way travelled: a third, not a half.
        self.acceleration = acceleration + jerk * h * (1.0 / 3.0);
        let middle = speed + 0.5 * self.acceleration * h;
        let gain = self.acceleration;
        let slope = |start: f64, slope: f64| slope * middle + (start + 0.5 * h * slope) * gain;
        for x in 0..3 {
            self.emf.start[x] = shape.start[x] * speed;
            self.emf.slope[x] = slope(shape.start[x], shape.slope[x]);
        }
        Linear2 {
            s: rest_s,
            d: rest_d,
            s_slope: -slope(along.s, along.s_slope),
            d_slope: -slope(along.d, along.d_slope),
        }
    }

    /// The particular solution and what decays towards it.
    #[inline]
    fn solve(&mut self, network: &Network, forcing: &Linear2) {
        let modes = network.modes(self.wiring.topology, self.source_on);
        let (l, per_r, lag) = (network.l, network.per_r, network.time_constant);
        let k = self.wiring.k;
        (self.u0, self.u1) = (k * forcing.s, k * forcing.s_slope);
        self.q.d = 0.5 * forcing.d_slope * per_r;
        self.p.d = 0.5 * forcing.d * per_r - lag * self.q.d;
        if self.wiring.topology == Loop::Open {
            self.q.s = self.u1 * per_r;
            self.p.s = self.u0 * per_r - lag * self.q.s;
            self.p.v = if modes.g > 0.0 { modes.j * modes.per_g } else { self.start.v };
        } else {
            // A q = -b1, A p = q - b0 with b0 = (u0 / L, j / C), b1 = (u1 / L, 0).
            let Modes { g, j, per_det, .. } = *modes;
            (self.q.s, self.q.v) = (self.u1 * g * per_det, -self.u1 * per_det);
            let (rest_s, rest_v) = (l * self.q.s - self.u0, network.c * self.q.v - j);
            self.p.s = -(g * rest_s + k * rest_v) * per_det;
            self.p.v = (rest_s - network.r * rest_v) * per_det;
        }
        self.fading = Reduced {
            s: self.start.s - self.p.s,
            d: self.start.d - self.p.d,
            v: self.start.v - self.p.v,
        };
    }

    /// State `t` seconds after the start; `decay` is the transition over `t`.
    #[inline]
    pub(crate) fn at(&self, network: &Network, t: f64, decay: &Decay) -> Reduced {
        let Reduced { s, d, v } = self.fading;
        let (p, q) = (&self.p, &self.q);
        if self.wiring.topology == Loop::Open {
            return Reduced {
                s: p.s + q.s * t + decay.leg * s,
                d: p.d + q.d * t + decay.leg * d,
                v: p.v + decay.alpha * v,
            };
        }
        let a = network.modes(self.wiring.topology, self.source_on);
        Reduced {
            s: p.s + q.s * t + decay.alpha * s + decay.beta * (a.a_ss * s + a.a_sv * v),
            d: p.d + q.d * t + decay.leg * d,
            v: p.v + q.v * t + decay.alpha * v + decay.beta * (a.a_vs * s + a.a_vv * v),
        }
    }

    /// What the bus sees.
    #[inline]
    pub(crate) fn topology(&self) -> Loop {
        self.wiring.topology
    }

    /// Integrals over `h` seconds of the link current and of the bus voltage, from the circuit's two equations.
    #[inline]
    pub(crate) fn integrals(&self, network: &Network, h: f64, to: &Reduced) -> (f64, f64) {
        let modes = network.modes(self.wiring.topology, self.source_on);
        let charge = modes.j * h - network.c * (to.v - self.start.v);
        if self.wiring.topology == Loop::Open {
            return (0.0, if modes.g > 0.0 { charge * modes.per_g } else { self.start.v * h });
        }
        let flux = self.u0 * h + 0.5 * self.u1 * h * h - network.l * (to.s - self.start.s);
        let (g, k) = (modes.g, modes.k);
        ((g * flux + k * charge) * modes.per_det, (network.r * charge - flux) * modes.per_det)
    }

    /// True if a diode's current has turned round.
    #[inline]
    pub(crate) fn is_against_a_diode(&self, at: &Reduced) -> bool {
        let i = self.wiring.currents(at.s, at.d);
        self.diodes[0] * i[0] > 0.0 || self.diodes[1] * i[1] > 0.0 || self.diodes[2] * i[2] > 0.0
    }

    /// Current through the DC link.
    #[inline]
    pub(crate) fn link(&self, at: &Reduced) -> f64 {
        if self.wiring.topology == Loop::Open { 0.0 } else { at.s }
    }

    /// Voltage of the star point, `t` seconds after the start.
    pub(crate) fn neutral(&self, t: f64, v: f64, drop: f64) -> f64 {
        neutral(self.wiring, &self.diodes, &[0, 1, 2].map(|x| self.emf_at(x, t)), v, drop)
    }

    /// True while any leg is tied to bus or ground.
    #[inline]
    pub(crate) const fn is_tied(&self) -> bool {
        self.wiring.conducting > 0
    }

    /// Back-EMF of leg `x`, V.
    #[inline]
    pub(crate) fn emf_at(&self, x: usize, t: f64) -> f64 {
        self.emf.start[x] + self.emf.slope[x] * t
    }

    /// Terminal voltage of leg `x`.
    pub(crate) fn terminal(&self, network: &Network, x: usize, t: f64, electric: &Electric) -> f64 {
        let fall = network.switch * electric.i[x];
        match self.legs[x] {
            Leg::Idle => self.neutral(t, electric.v, network.drop) + self.emf_at(x, t),
            Leg::HighSwitch => electric.v - fall,
            Leg::LowSwitch => -fall,
            Leg::HighDiode => electric.v + network.drop - fall,
            Leg::LowDiode => -network.drop - fall,
        }
    }

    /// di/dt of leg `x` at the start, for a leg that carries no current yet.
    pub(crate) fn slope_from_rest(&self, network: &Network, x: usize, v: f64) -> f64 {
        let resting = Electric { i: [0.0; 3], v };
        let terminal = self.terminal(network, x, 0.0, &resting);
        (terminal - self.neutral(0.0, v, network.drop) - self.emf_at(x, 0.0)) * network.per_l
    }
}

/// Voltage of the star point: the conducting legs' terminal voltages less back-EMF average to it, because their currents sum
/// to zero. With all legs idle the divider pulls the terminals to ground, and the low-side diodes hold the lowest one.
#[inline]
pub(crate) fn neutral(wiring: &Wiring, diodes: &[f64; 3], emf: &[f64; 3], v: f64, drop: f64) -> f64 {
    if wiring.conducting > 0 {
        return wiring.high_share * v + drop * dot(&wiring.mean, diodes) - dot(&wiring.mean, emf);
    }
    (-drop - emf[0].min(emf[1]).min(emf[2])).max(0.0)
}
