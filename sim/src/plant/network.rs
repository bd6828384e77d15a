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
    /// `r / l`, 1/s.
    pub(crate) rate: f64,
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
    /// All that hangs across the bus, S: the drive's own electronics and an injected leak.
    pub(crate) leak_g: f64,
    /// The part of it behind the current shunt: the injected leak, S.
    pub(crate) shunt_g: f64,
    /// By source off or on, then by k = 1/2 or 2/3.
    modes: [[Modes; 2]; 2],
}

/// Eigenvalues of the second-order system: `middle +- distance`, or a complex pair.
#[derive(Clone, Copy, Debug, Default)]
struct Modes {
    middle: f64,
    distance: f64,
    complex: bool,
    /// The real eigenvalues, 1/s, and 1 / (slow - fast).
    slow: f64,
    fast: f64,
    per_distance: f64,
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
            rate: (copper + switch) / l,
            l,
            c,
            drop,
            source_v: supply.voltage,
            source_g: 1.0 / supply.resistance.max(SupplyConfig::RESISTANCE_MIN),
            leak_g: 0.0,
            shunt_g: 0.0,
            modes: Default::default(),
        };
        network.update();
        network
    }

    /// To be called after a change of any element.
    pub(crate) fn update(&mut self) {
        self.r = self.copper + self.switch;
        self.rate = self.r / self.l;
        for source_on in [false, true] {
            for topology in [Loop::TwoLegs, Loop::ThreeLegs] {
                let g = self.g(source_on);
                let trace = -self.r / self.l - g / self.c;
                let det = (self.r * g + topology.k()) / (self.l * self.c);
                let middle = 0.5 * trace;
                let square = middle * middle - det;
                let distance = libm::sqrt(square.abs());
                let fast = middle - distance;
                self.modes[usize::from(source_on)][usize::from(topology == Loop::ThreeLegs)] = Modes {
                    middle,
                    distance,
                    complex: square < 0.0,
                    // From the product of both, because their sum cancels.
                    slow: det / fast,
                    fast,
                    per_distance: 0.5 / distance.max(1e-9),
                    trace,
                    det,
                };
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

    /// Energy lost in the source resistance over `h` seconds in which the bus goes from `v0` to `v1`, J. `fall` is the
    /// integral of y = source voltage - v, `links` the link current S at start, middle and end.
    ///
    /// y has a fast part (source resistance times bus capacitance), which a quadrature would miss. The bus equation
    /// C dv/dt = G y - S - g v, multiplied by y, gives the integral of y^2 from that of S y, and S is smooth: it is
    /// taken as a straight line, and the moment of y that it needs is exact, again from the bus equation.
    pub(crate) fn source_loss(&self, h: f64, v0: f64, v1: f64, fall: f64, links: [f64; 3]) -> f64 {
        let (y0, y1) = (self.source_v - v0, self.source_v - v1);
        let per_g = 1.0 / (self.source_g + self.leak_g);
        let link_moment = h * h * (1.0 / 6.0) * (2.0 * links[1] + links[2]);
        let volt_seconds = self.source_v * h - fall;
        let leak = self.leak_g * self.source_v;
        let moment = (self.c * (h * v1 - volt_seconds) + link_moment + 0.5 * leak * h * h) * per_g;
        let product = links[0] * fall + (links[2] - links[0]) / h * moment;
        self.source_g * per_g * (0.5 * self.c * (y0 * y0 - y1 * y1) + product + leak * fall)
    }

    fn modes(&self, topology: Loop, source_on: bool) -> &Modes {
        &self.modes[usize::from(source_on)][usize::from(topology == Loop::ThreeLegs)]
    }

    /// Transition over `t` seconds.
    pub(crate) fn decay(&self, topology: Loop, source_on: bool, t: f64) -> Decay {
        // Two legs share one current: nothing decays apart from the loop.
        let leg = if topology == Loop::TwoLegs { 0.0 } else { exp_small(-self.rate * t) };
        let (alpha, beta) = match topology {
            Loop::Open => (exp_negative(-self.g(source_on) / self.c * t), 0.0),
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
            let envelope = exp_small(self.middle * t);
            let angle = self.distance * t;
            let beta = envelope * libm::sin(angle) / self.distance;
            return (envelope * libm::cos(angle) - self.middle * beta, beta);
        }
        if self.distance * t < 1e-6 {
            let beta = exp_small(self.middle * t) * t;
            return (beta / t - self.middle * beta, beta);
        }
        let (e_slow, e_fast) = (exp_small(self.slow * t), exp_negative(self.fast * t));
        let beta = (e_slow - e_fast) * self.per_distance;
        (e_slow - beta * self.slow, beta)
    }
}

/// exp(x) by its series where that is short; exact to 1e-13.
fn exp_small(x: f64) -> f64 {
    if x.abs() > 0.25 {
        return exp_negative(x);
    }
    let tail = 1.0 + x * (1.0 / 7.0) * (1.0 + x * (1.0 / 8.0) * (1.0 + x * (1.0 / 9.0)));
    1.0 + x
        * (1.0
            + x * (1.0 / 2.0)
                * (1.0
                    + x * (1.0 / 3.0)
                        * (1.0 + x * (1.0 / 4.0) * (1.0 + x * (1.0 / 5.0) * (1.0 + x * (1.0 / 6.0) * tail)))))
}

/// exp(x), 0 where that cannot be told from it.
fn exp_negative(x: f64) -> f64 {
    if x < -80.0 { 0.0 } else { libm::exp(x) }
}
