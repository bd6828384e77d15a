//! The exact solution between two switching events: which legs conduct is fixed, the back-EMF is linear in time.

use super::emf::Linear3;
use super::network::{Decay, Loop, Network};

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
    pub(crate) const fn is_high(self) -> bool {
        matches!(self, Self::HighSwitch | Self::HighDiode)
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

/// One interval's circuit and its solution.
#[derive(Clone, Debug)]
pub(crate) struct Segment {
    pub(crate) legs: [Leg; 3],
    pub(crate) topology: Loop,
    pub(crate) source_on: bool,
    pub(crate) emf: Linear3,
    /// Mean acceleration that the back-EMF was taken with, rad/s2.
    pub(crate) acceleration: f64,
    /// Legs that conduct.
    conducting: u8,
    /// Neutral voltage = `neutral_v` v + `neutral_0` + `neutral_1` t, while any leg conducts.
    neutral_v: f64,
    neutral_0: f64,
    neutral_1: f64,
    /// Forcing of the DC-link loop: u = `u0` + `u1` t.
    u0: f64,
    u1: f64,
    /// (S, v) = p + q t + exp(A t) (start - p): particular solution, then what decays.
    p: [f64; 2],
    q: [f64; 2],
    start: [f64; 2],
    /// Part of S that a leg carries.
    share: [f64; 3],
    /// A leg's difference from its share = dp + dq t + exp(-R t / L) d.
    dp: [f64; 3],
    dq: [f64; 3],
    d: [f64; 3],
    /// A's rows.
    a_ss: f64,
    a_sv: f64,
    a_vs: f64,
    a_vv: f64,
}

impl Segment {
    /// The circuit of `legs` from `electric` on; `shape` is the back-EMF per speed.
    pub(crate) fn new(
        network: &Network,
        legs: [Leg; 3],
        source_on: bool,
        electric: &Electric,
        shape: &Linear3,
        motion: &Motion,
    ) -> Self {
        let mut segment = Self::idle(legs, source_on, electric);
        let mut offsets = [0.0; 3];
        for x in 0..3 {
            // Terminal = h v + offset - Ron i.
            match legs[x] {
                Leg::Idle => continue,
                Leg::HighSwitch | Leg::LowSwitch => {}
                Leg::HighDiode => offsets[x] = network.drop,
                Leg::LowDiode => offsets[x] = -network.drop,
            }
            segment.conducting += 1;
        }
        segment.move_on(network, &offsets, electric, shape, motion);
        if segment.conducting > 0 {
            let mut high = Group::default();
            let mut low = Group::default();
            let mut driving = [(0.0, 0.0); 3];
            for x in 0..3 {
                // What drives a phase is its terminal less its back-EMF.
                driving[x] = (offsets[x] - segment.emf.start[x], -segment.emf.slope[x]);
                match legs[x] {
                    Leg::Idle => {}
                    leg if leg.is_high() => high.add(driving[x], electric.i[x]),
                    _ => low.add(driving[x], electric.i[x]),
                }
            }
            segment.tie_neutral(&high, &low);
            if segment.topology != Loop::TwoLegs {
                segment.spread(network, &high, &low, &driving, electric);
            } else {
                segment.share_two();
            }
            segment.solve_link(network, &high, electric);
        } else {
            segment.solve_link(network, &Group::default(), electric);
        }
        segment
    }

    /// Back-EMF over the interval: the shape times a speed that changes with the mean acceleration. The torque's own
    /// slope gives the acceleration's, else a light rotor would outrun its prediction within one interval.
    fn move_on(
        &mut self,
        network: &Network,
        offsets: &[f64; 3],
        electric: &Electric,
        shape: &Linear3,
        motion: &Motion,
    ) {
        if motion.speed == 0.0 && motion.acceleration == 0.0 {
            return;
        }
        let mut jerk = 0.0;
        if motion.per_inertia > 0.0 && self.conducting > 1 {
            let mut rest = [0.0; 3];
            let mut sum = 0.0;
            for x in 0..3 {
                if self.legs[x] != Leg::Idle {
                    let bus = if self.legs[x].is_high() { electric.v } else { 0.0 };
                    rest[x] = bus + offsets[x] - shape.start[x] * motion.speed;
                    sum += rest[x];
                }
            }
            let neutral = sum / f64::from(self.conducting);
            let mut torque_slope = 0.0;
            for x in 0..3 {
                if self.legs[x] != Leg::Idle {
                    let i_slope = rest[x] - neutral - network.r * electric.i[x];
                    torque_slope += shape.start[x] * i_slope;
                }
            }
            jerk = torque_slope / network.l * motion.per_inertia;
        }
        // Mean over the interval of alpha + jerk t, weighted as it acts on the way travelled: a third, not a half.
        self.acceleration = motion.acceleration + jerk * motion.h * (1.0 / 3.0);
        let middle = motion.speed + 0.5 * self.acceleration * motion.h;
        for x in 0..3 {
            let k = shape.start[x] + 0.5 * motion.h * shape.slope[x];
            self.emf.start[x] = shape.start[x] * motion.speed;
            self.emf.slope[x] = shape.slope[x] * middle + k * self.acceleration;
        }
    }

    /// One leg high, one low: both carry the link current and nothing else.
    fn share_two(&mut self) {
        for x in 0..3 {
            self.share[x] = match self.legs[x] {
                Leg::Idle => 0.0,
                leg if leg.is_high() => 1.0,
                _ => -1.0,
            };
        }
    }

    fn idle(legs: [Leg; 3], source_on: bool, electric: &Electric) -> Self {
        Self {
            legs,
            topology: Loop::Open,
            source_on,
            emf: Linear3::default(),
            acceleration: 0.0,
            conducting: 0,
            neutral_v: 0.0,
            neutral_0: 0.0,
            neutral_1: 0.0,
            u0: 0.0,
            u1: 0.0,
            p: [0.0, electric.v],
            q: [0.0; 2],
            start: [0.0; 2],
            share: [0.0; 3],
            dp: [0.0; 3],
            dq: [0.0; 3],
            d: [0.0; 3],
            a_ss: 0.0,
            a_sv: 0.0,
            a_vs: 0.0,
            a_vv: 0.0,
        }
    }

    /// The currents of the conducting legs sum to zero: their terminal voltages less back-EMF average to the neutral.
    fn tie_neutral(&mut self, high: &Group, low: &Group) {
        let each = 1.0 / f64::from(self.conducting);
        self.neutral_v = f64::from(high.count) * each;
        self.neutral_0 = (high.driving.0 + low.driving.0) * each;
        self.neutral_1 = (high.driving.1 + low.driving.1) * each;
        self.u0 = high.driving.0 - f64::from(high.count) * self.neutral_0;
        self.u1 = high.driving.1 - f64::from(high.count) * self.neutral_1;
        self.topology = match (high.count, low.count) {
            (0, _) | (_, 0) => Loop::Open,
            (1, 1) => Loop::TwoLegs,
            _ => Loop::ThreeLegs,
        };
    }

    /// Legs on the same side share the link current and differ by what decays with L / R.
    fn spread(
        &mut self,
        network: &Network,
        high: &Group,
        low: &Group,
        driving: &[(f64, f64); 3],
        electric: &Electric,
    ) {
        for x in 0..3 {
            let (group, sign) = match self.legs[x] {
                Leg::Idle => continue,
                leg if leg.is_high() => (high, 1.0),
                _ => (low, -1.0),
            };
            let each = 1.0 / f64::from(group.count);
            self.share[x] = sign * each;
            if group.count > 1 {
                let f0 = driving[x].0 - group.driving.0 * each;
                let f1 = driving[x].1 - group.driving.1 * each;
                self.dq[x] = f1 / network.r;
                self.dp[x] = (f0 - network.l * self.dq[x]) / network.r;
                self.d[x] = electric.i[x] - group.current * each - self.dp[x];
            }
        }
    }

    fn solve_link(&mut self, network: &Network, high: &Group, electric: &Electric) {
        let (g, j) = (network.g(self.source_on), network.j(self.source_on));
        if self.topology == Loop::Open {
            self.p[1] = if g > 0.0 { j / g } else { electric.v };
            self.start[1] = electric.v - self.p[1];
            return;
        }
        let (r, l, c, k) = (network.r, network.l, network.c, self.topology.k());
        let per_det = 1.0 / (r * g + k);
        // A q = -b1, A p = q - b0 with b0 = (u0 / L, j / C), b1 = (u1 / L, 0).
        self.q = [self.u1 * g * per_det, -self.u1 * per_det];
        let rest = [l * self.q[0] - self.u0, c * self.q[1] - j];
        self.p = [-(g * rest[0] + k * rest[1]) * per_det, (rest[0] - r * rest[1]) * per_det];
        self.start = [high.current - self.p[0], electric.v - self.p[1]];
        self.a_ss = -r / l;
        self.a_sv = k / l;
        self.a_vs = -1.0 / c;
        self.a_vv = -g / c;
    }

    /// State `t` seconds after the start; `decay` is the transition over `t`.
    pub(crate) fn at(&self, t: f64, decay: &Decay) -> Electric {
        let [ds, dv] = self.start;
        let link =
            self.p[0] + self.q[0] * t + decay.alpha * ds + decay.beta * (self.a_ss * ds + self.a_sv * dv);
        let v = self.p[1] + self.q[1] * t + decay.alpha * dv + decay.beta * (self.a_vs * ds + self.a_vv * dv);
        let mut i = self.share.map(|share| share * link);
        if self.topology != Loop::TwoLegs {
            for x in 0..3 {
                i[x] += self.dp[x] + self.dq[x] * t + decay.leg * self.d[x];
            }
        }
        Electric { i, v }
    }

    /// Integrals over `h` seconds of the link current and of the bus voltage, from the circuit's two equations.
    pub(crate) fn integrals(&self, network: &Network, h: f64, from: &Electric, to: &Electric) -> (f64, f64) {
        let (g, j) = (network.g(self.source_on), network.j(self.source_on));
        let charge = j * h - network.c * (to.v - from.v);
        if self.topology == Loop::Open {
            return (0.0, if g > 0.0 { charge / g } else { from.v * h });
        }
        let flux = self.u0 * h + 0.5 * self.u1 * h * h - network.l * (self.link(to) - self.link(from));
        let k = self.topology.k();
        let per_det = 1.0 / (network.r * g + k);
        ((g * flux + k * charge) * per_det, (network.r * charge - flux) * per_det)
    }

    /// Sum of the currents of the legs tied to the bus.
    pub(crate) fn link(&self, electric: &Electric) -> f64 {
        let mut sum = 0.0;
        for x in 0..3 {
            if self.legs[x].is_high() {
                sum += electric.i[x];
            }
        }
        sum
    }

    /// Voltage of the star point, `t` seconds after the start.
    pub(crate) fn neutral(&self, t: f64, v: f64, drop: f64) -> f64 {
        if self.conducting > 0 {
            return self.neutral_v * v + self.neutral_0 + self.neutral_1 * t;
        }
        // All idle: the divider pulls the terminals to ground, the low-side diodes hold the lowest one.
        let mut lowest = self.emf_at(0, t);
        for x in 1..3 {
            lowest = lowest.min(self.emf_at(x, t));
        }
        (-drop - lowest).max(0.0)
    }

    /// True while any leg is tied to bus or ground.
    pub(crate) const fn is_tied(&self) -> bool {
        self.conducting > 0
    }

    /// Back-EMF of leg `x`, V.
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
        (terminal - self.neutral(0.0, v, network.drop) - self.emf_at(x, 0.0)) / network.l
    }
}

/// The legs on one side of the bus.
#[derive(Clone, Copy, Debug, Default)]
struct Group {
    count: u8,
    current: f64,
    driving: (f64, f64),
}

impl Group {
    fn add(&mut self, driving: (f64, f64), current: f64) {
        self.count += 1;
        self.current += current;
        self.driving.0 += driving.0;
        self.driving.1 += driving.1;
    }
}
