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
    #[inline(always)]
    pub(crate) fn new(
        network: &Network,
        legs: [Leg; 3],
        source_on: bool,
        electric: &Electric,
        shape: &Linear3,
        motion: &Motion,
    ) -> Self {
        let wiring = Wiring::of(&legs);
        let modes = network.modes(wiring.topology, source_on);
        let diodes = [legs[0].diode_sign(), legs[1].diode_sign(), legs[2].diode_sign()];
        let drop_s = network.drop * dot(&wiring.along, &diodes);
        let drop_d = network.drop * dot(&wiring.across, &diodes);
        let start = Reduced { s: wiring.s_of(&electric.i), d: wiring.d_of(&electric.i), v: electric.v };
        let reduced = Linear2 {
            s: dot(&wiring.along, &shape.start),
            d: dot(&wiring.across, &shape.start),
            s_slope: dot(&wiring.along, &shape.slope),
            d_slope: dot(&wiring.across, &shape.slope),
        };
        // What drives the coordinates: diode drops less back-EMF.
        let (rest_s, rest_d) = (drop_s - reduced.s * motion.speed, drop_d - reduced.d * motion.speed);
        let acceleration = motion.mean_acceleration(network, wiring, &start, &reduced, (rest_s, rest_d));
        let middle = motion.speed + 0.5 * acceleration * motion.h;
        let (gain, half) = (acceleration, 0.5 * motion.h);
        let slope = |start: f64, slope: f64| slope * middle + (start + half * slope) * gain;
        let emf = Linear3 {
            start: [0, 1, 2].map(|x| shape.start[x] * motion.speed),
            slope: [0, 1, 2].map(|x| slope(shape.start[x], shape.slope[x])),
        };
        let (u0, u1) = (wiring.k * rest_s, -wiring.k * slope(reduced.s, reduced.s_slope));
        let (f0, f1) = (0.5 * rest_d, -0.5 * slope(reduced.d, reduced.d_slope));
        let (p, q) = particular(network, modes, wiring.topology, (u0, u1), (f0, f1), start.v);
        let fading = Reduced { s: start.s - p.s, d: start.d - p.d, v: start.v - p.v };
        let idle = idle_terminal(wiring, network.drop, &diodes, &emf);
        Self {
            legs,
            wiring,
            source_on,
            has_diodes: diodes != [0.0; 3],
            diodes,
            emf,
            shape: reduced,
            acceleration,
            start,
            drop_s,
            drop_d,
            idle,
            u0,
            u1,
            p,
            q,
            fading,
        }
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

impl Motion {
    /// The torque's own slope gives the acceleration's, else a light rotor would outrun its prediction within one
    /// interval.
    #[inline(always)]
    fn mean_acceleration(
        &self,
        network: &Network,
        wiring: &Wiring,
        start: &Reduced,
        shape: &Linear2,
        (rest_s, rest_d): (f64, f64),
    ) -> f64 {
        let bus = if wiring.topology == Loop::Open { 0.0 } else { start.v };
        let s_slope = wiring.k * (bus + rest_s) - network.r * start.s;
        let d_slope = 0.5 * rest_d - network.r * start.d;
        let jerk = (shape.s * s_slope + shape.d * d_slope) * network.per_l * self.per_inertia;
        // Mean over the interval of alpha + jerk t, weighted as it acts on the way travelled: a third, not a half.
        self.acceleration + jerk * self.h * (1.0 / 3.0)
    }
}

/// The particular solution p + q t.
#[inline(always)]
fn particular(
    network: &Network,
    modes: &Modes,
    topology: Loop,
    (u0, u1): (f64, f64),
    (f0, f1): (f64, f64),
    v: f64,
) -> (Reduced, Reduced) {
    let (per_r, lag) = (network.per_r, network.time_constant);
    let q_d = f1 * per_r;
    let p_d = f0 * per_r - lag * q_d;
    if topology == Loop::Open {
        let q_s = u1 * per_r;
        let p_v = if modes.g > 0.0 { modes.j * modes.per_g } else { v };
        let p = Reduced { s: u0 * per_r - lag * q_s, d: p_d, v: p_v };
        return (p, Reduced { s: q_s, d: q_d, v: 0.0 });
    }
    // A q = -b1, A p = q - b0 with b0 = (u0 / L, j / C), b1 = (u1 / L, 0).
    let Modes { g, j, k, per_det, .. } = *modes;
    let (q_s, q_v) = (u1 * g * per_det, -u1 * per_det);
    let (rest_s, rest_v) = (network.l * q_s - u0, network.c * q_v - j);
    let p_s = -(g * rest_s + k * rest_v) * per_det;
    let p_v = (rest_s - network.r * rest_v) * per_det;
    (Reduced { s: p_s, d: p_d, v: p_v }, Reduced { s: q_s, d: q_d, v: q_v })
}

/// Terminal of the one idle leg beside two that conduct, less its share of the bus voltage: at the start, V, and its slope, V/s.
#[inline(always)]
fn idle_terminal(wiring: &Wiring, drop: f64, diodes: &[f64; 3], emf: &Linear3) -> (f64, f64) {
    if wiring.conducting != 2 {
        return (0.0, 0.0);
    }
    let (mean, z) = (&wiring.mean, wiring.idle);
    let start = emf.start[z] + drop * dot(mean, diodes) - dot(mean, &emf.start);
    (start, emf.slope[z] - dot(mean, &emf.slope))
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
