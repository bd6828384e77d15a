//! The linear circuit's constants and its exponentials.
//!
//! Phases are equal and the neutral is free, so whatever legs conduct, the DC-link current S (the sum of the
//! currents of the legs tied to the bus) and the bus voltage v form one second-order system, and every other
//! difference of currents decays on its own with L / R:
//!
//! ```text
//!   L dS/dt = -R S + k v + u(t)        k = n_high n_low / (n_high + n_low) = 1/2 or 2/3, or 0 without a loop
//!   C dv/dt = -S - g v + j             g, j: conductance and short-circuit current of what hangs at the bus
//! ```

use super::config::SupplyConfig;

/// Values of the elements, all in SI units.
#[derive(Clone, Debug)]
pub(crate) struct Network {
    /// Copper of one phase, ohm.
    pub(crate) copper: f64,
    /// Switch or diode slope, ohm.
    pub(crate) switch: f64,
    /// `copper + switch`.
    pub(crate) r: f64,
    /// One phase, H.
    pub(crate) l: f64,
    /// Bus, F.
    pub(crate) c: f64,
    /// Diode drop, V.
    pub(crate) drop: f64,
    /// Open-circuit voltage of the source, V.
    pub(crate) source_v: f64,
    /// Source conductance, S.
    pub(crate) source_g: f64,
    /// Leak across the bus, S.
    pub(crate) leak_g: f64,
    /// By source off or on, then by k = 1/2 or 2/3.
    modes: [[Modes; 2]; 2],
}

/// Eigenvalues of the second-order system: `middle +- distance`, or a complex pair.
#[derive(Clone, Copy, Debug, Default)]
struct Modes {
    middle: f64,
    distance: f64,
    complex: bool,
    trace: f64,
    det: f64,
}

/// The state transition over some time: exp(A t) = `alpha` + `beta` A for (S, v), `leg` for every difference.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Decay {
    pub(crate) leg: f64,
    pub(crate) alpha: f64,
    pub(crate) beta: f64,
}

/// Which second-order system applies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Loop {
    /// No current between bus and motor.
    Open,
    /// One leg high, one low: k = 1/2.
    TwoLegs,
    /// Three legs, not all on one side: k = 2/3.
    ThreeLegs,
}

impl Loop {
    pub(crate) const fn k(self) -> f64 {
        match self {
            Self::Open => 0.0,
            Self::TwoLegs => 0.5,
            Self::ThreeLegs => 2.0 / 3.0,
        }
    }
}

impl Network {
    pub(crate) fn new(copper: f64, l: f64, switch: f64, drop: f64, c: f64, supply: &SupplyConfig) -> Self {
        let mut network = Self {
            copper,
            switch,
            r: copper + switch,
            l,
            c,
            drop,
            source_v: supply.voltage,
            source_g: 1.0 / supply.resistance.max(SupplyConfig::RESISTANCE_MIN),
            leak_g: 0.0,
            modes: Default::default(),
        };
        network.update();
        network
    }

    /// To be called after a change of any element.
    pub(crate) fn update(&mut self) {
        self.r = self.copper + self.switch;
        for source_on in [false, true] {
            for topology in [Loop::TwoLegs, Loop::ThreeLegs] {
                let g = self.g(source_on);
                let trace = -self.r / self.l - g / self.c;
                let det = (self.r * g + topology.k()) / (self.l * self.c);
                let middle = 0.5 * trace;
                let square = middle * middle - det;
                let distance = libm::sqrt(square.abs());
                self.modes[usize::from(source_on)][usize::from(topology == Loop::ThreeLegs)] =
                    Modes { middle, distance, complex: square < 0.0, trace, det };
            }
        }
    }

    /// Conductance at the bus.
    pub(crate) fn g(&self, source_on: bool) -> f64 {
        if source_on { self.source_g + self.leak_g } else { self.leak_g }
    }

    /// Short-circuit current at the bus.
    pub(crate) fn j(&self, source_on: bool) -> f64 {
        if source_on { self.source_g * self.source_v } else { 0.0 }
    }

    fn modes(&self, topology: Loop, source_on: bool) -> &Modes {
        &self.modes[usize::from(source_on)][usize::from(topology == Loop::ThreeLegs)]
    }

    /// Transition over `t` seconds.
    pub(crate) fn decay(&self, topology: Loop, source_on: bool, t: f64) -> Decay {
        let leg = libm::exp(-self.r / self.l * t);
        let (alpha, beta) = match topology {
            Loop::Open => (libm::exp(-self.g(source_on) / self.c * t), 0.0),
            _ => self.modes(topology, source_on).transition(t),
        };
        Decay { leg, alpha, beta }
    }

    /// Transition over twice the time of `half`, by Cayley and Hamilton: A^2 = trace A - det.
    pub(crate) fn squared(&self, topology: Loop, source_on: bool, half: &Decay) -> Decay {
        let modes = self.modes(topology, source_on);
        let bb = half.beta * half.beta;
        Decay {
            leg: half.leg * half.leg,
            alpha: half.alpha * half.alpha - bb * modes.det,
            beta: 2.0 * half.alpha * half.beta + bb * modes.trace,
        }
    }
}

impl Modes {
    fn transition(&self, t: f64) -> (f64, f64) {
        if self.complex {
            let envelope = libm::exp(self.middle * t);
            let angle = self.distance * t;
            let beta = envelope * libm::sin(angle) / self.distance;
            return (envelope * libm::cos(angle) - self.middle * beta, beta);
        }
        if self.distance * t < 1e-6 {
            let beta = libm::exp(self.middle * t) * t;
            return (beta / t - self.middle * beta, beta);
        }
        let fast = self.middle - self.distance;
        // From the product, because the sum cancels.
        let slow = self.det / fast;
        let (e_slow, e_fast) = (libm::exp(slow * t), libm::exp(fast * t));
        let beta = (e_slow - e_fast) / (2.0 * self.distance);
        (e_slow - beta * slow, beta)
    }
}
