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

use super::angle::Rotation;
use super::circuit::Reduced;
use super::config::SupplyConfig;
use super::exponential::{falling, falling_little};
use super::segment::{Segment, Sums};

/// Longest interval in time constants: losses are good to 1e-4 then.
const TIME_CONSTANTS_MAX: f64 = 0.35;
/// Eigenvalues are close together if half their distance is less than this part of their mean.
const CLOSE: f64 = 0.1;
/// Largest argument of the series for those: they are good to 1e-7.
const SERIES_MAX: f64 = 0.25;

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
    /// `1 / r`, `1 / l`, `l / r`.
    pub(crate) per_r: f64,
    pub(crate) per_l: f64,
    pub(crate) time_constant: f64,
    /// Longest interval, s.
    pub(crate) longest: f64,
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
    /// By source off or on, then by [`Loop`].
    modes: [[Modes; 3]; 2],
}

/// A second-order system: eigenvalues `middle +- distance` or a complex pair, and what its solution needs.
/// The bus is told from `rest`, the voltage that it has without the motor.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Modes {
    middle: f64,
    distance: f64,
    /// Half their distance squared: negative if they are complex.
    square: f64,
    /// They are complex or close together: their exponentials' difference would lose digits.
    close: bool,
    /// The real eigenvalues, 1/s, and 1 / (slow - fast).
    slow: f64,
    fast: f64,
    per_distance: f64,
    /// A's rows.
    pub(crate) a_ss: f64,
    pub(crate) a_sv: f64,
    pub(crate) a_vs: f64,
    pub(crate) a_vv: f64,
    pub(crate) k: f64,
    /// Conductance at the bus, and its open-circuit voltage.
    pub(crate) g: f64,
    pub(crate) rest: f64,
    /// 1 / g, or 0 if nothing hangs there.
    pub(crate) per_g: f64,
    /// The inverse of the steady circuit: 1 / (r g + k), and g, k and r times that.
    pub(crate) per_det: f64,
    pub(crate) g_det: f64,
    pub(crate) k_det: f64,
    pub(crate) r_det: f64,
    /// Parts of the particular solution, of `s` and of the bus, per slope of the driving voltage.
    pub(crate) lag_s: f64,
    pub(crate) lag_v: f64,
}

/// Which second-order system applies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Loop {
    /// No current between bus and motor.
    #[default]
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
            rate: 0.0,
            per_r: 0.0,
            per_l: 1.0 / l,
            time_constant: 0.0,
            longest: 0.0,
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
        self.per_r = 1.0 / self.r;
        self.time_constant = self.l / self.r;
        let mut fastest = self.rate;
        for source_on in [false, true] {
            for topology in [Loop::Open, Loop::TwoLegs, Loop::ThreeLegs] {
                let modes = self.solve(topology, source_on);
                if !modes.close && topology != Loop::Open {
                    fastest = fastest.max(-modes.slow);
                }
                self.modes[usize::from(source_on)][topology as usize] = modes;
            }
        }
        self.longest = TIME_CONSTANTS_MAX / fastest;
    }

    fn solve(&self, topology: Loop, source_on: bool) -> Modes {
        let (r, l, c, k) = (self.r, self.l, self.c, topology.k());
        let g = if source_on { self.source_g + self.leak_g } else { self.leak_g };
        let trace = -r / l - g / c;
        let det = (r * g + k) / (l * c);
        let middle = 0.5 * trace;
        let square = middle * middle - det;
        let distance = libm::sqrt(square.abs());
        let fast = middle - distance;
        let per_det = 1.0 / (r * g + k).max(f64::MIN_POSITIVE);
        Modes {
            middle,
            distance,
            square,
            close: square < 0.0 || distance < CLOSE * middle.abs(),
            // From the product of both, because their sum cancels.
            slow: det / fast,
            fast,
            per_distance: 0.5 / distance.max(1e-9),
            a_ss: -r / l,
            a_sv: k / l,
            a_vs: -1.0 / c,
            a_vv: -g / c,
            k,
            g,
            rest: if source_on { self.source_g * self.source_v / g } else { 0.0 },
            per_g: if g > 0.0 { 1.0 / g } else { 0.0 },
            per_det,
            g_det: g * per_det,
            k_det: k * per_det,
            r_det: r * per_det,
            // A q = -b1 and A p = q - b0 with b0 = (u / L, 0), b1 = (u' / L, 0).
            lag_s: (k * c - g * g * l) * per_det * per_det,
            lag_v: (g * l + r * c) * per_det * per_det,
        }
    }

    /// Integral of S w over an interval with the source on and the motor at the bus, V A s: S, the link
    /// current, is smooth and taken as a straight line; w, the bus voltage from its rest, has a fast part
    /// (source resistance times bus capacitance) which a quadrature would miss. The moment of w that the line
    /// needs is exact, from the bus equation C dw/dt = -S - g w times the time. The same equation times w
    /// gives the integral of g w^2 from that of S w.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn link_power(
        &self,
        (h, per_h): (f64, f64),
        segment: &Segment,
        end: &Reduced,
        sums: &Sums,
    ) -> f64 {
        let rise = end.s - segment.start.s;
        let link_moment = h * (0.5 * sums.s + h * (1.0 / 12.0) * rise);
        let moment = (self.c * (sums.w - h * (end.v - self.rest())) - link_moment) * self.per_source_g();
        segment.start.s * sums.w + rise * per_h * moment
    }

    /// Bus voltage without the motor, with the source on, V.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn rest(&self) -> f64 {
        self.modes(Loop::Open, true).rest
    }

    /// 1 / (all conductance at the bus), with the source on, ohm.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn per_source_g(&self) -> f64 {
        self.modes(Loop::Open, true).per_g
    }

    /// Returns the system for this path of the motor's current at the bus, with the source on or off.
    #[inline]
    pub(crate) fn modes(&self, topology: Loop, source_on: bool) -> &Modes {
        &self.modes[usize::from(source_on)][topology as usize]
    }

    /// Returns the share that is left after `t` seconds of a current that decays on its own.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn leg_decay(&self, t: f64) -> f64 {
        falling_little(-self.rate * t)
    }
}

impl Modes {
    /// Returns the share that is left after `t` seconds of the distance from `rest` of a bus without the
    /// motor.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn bus_decay(&self, t: f64) -> f64 {
        falling(self.a_vv * t)
    }

    /// exp(A t) = `alpha` + `beta` A.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn transition(&self, t: f64) -> (f64, f64) {
        if !self.close {
            let (e_slow, e_fast) = (falling_little(self.slow * t), falling(self.fast * t));
            let beta = (e_slow - e_fast) * self.per_distance;
            return (e_slow - beta * self.slow, beta);
        }
        if self.is_long(t) {
            return self.long_transition(t);
        }
        // Hyperbolic cosine and sine of a square that may be negative.
        let (envelope, y) = (falling(self.middle * t), self.square * t * t);
        let cosh = 1.0 + y * (1.0 / 2.0 + y * (1.0 / 24.0 + y * (1.0 / 720.0)));
        let sinh = 1.0 + y * (1.0 / 6.0 + y * (1.0 / 120.0 + y * (1.0 / 5040.0)));
        let beta = envelope * t * sinh;
        (envelope * cosh - self.middle * beta, beta)
    }

    /// True if the series for complex or close eigenvalues would not do for `t` seconds.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn is_long(&self, t: f64) -> bool {
        self.close && self.square.abs() * t * t > SERIES_MAX
    }

    /// Complex or close eigenvalues, and a time in which they go far.
    #[cold]
    #[inline(never)]
    fn long_transition(&self, t: f64) -> (f64, f64) {
        if self.square > 0.0 {
            let (e_slow, e_fast) = (falling(self.slow * t), falling(self.fast * t));
            let beta = (e_slow - e_fast) * self.per_distance;
            return (e_slow - beta * self.slow, beta);
        }
        let envelope = falling(self.middle * t);
        let Rotation { sin, cos } = Rotation::by(self.distance * t);
        let beta = 2.0 * self.per_distance * envelope * sin;
        (envelope * cos - self.middle * beta, beta)
    }
}
