//! One interval between two switching events: circuit and shaft solved together, energies booked.

use super::angle::Sweep;
use super::circuit::Reduced;
use super::event::Event;
use super::mechanics::{Push, Turn};
use super::network::{Loop, Network};
use super::segment::{Segment, Sums};
use super::stage::{Stage, VOLTAGE_EDGE};

/// Longest interval, s: a period at 10 kHz.
const INTERVAL_MAX: f64 = 100e-6;
/// Longest interval in time constants L / R: losses are good to 1e-4 then.
const TIME_CONSTANTS_MAX: f64 = 0.35;
/// Largest electrical angle of an interval, rad: the back-EMF is linear in it to 1e-3.
const ANGLE_MAX: f64 = 0.25;
/// Largest error of a phase's back-EMF because the speed was predicted wrongly, V.
const EMF_ERROR: f64 = 1e-3;
/// Attempts to get below it.
const CORRECTIONS_MAX: u32 = 3;
/// Each pass changes one diode: six are more than three legs can need.
const PASSES_MAX: u32 = 6;
/// Shorter intervals are none, s.
const INSTANT: f64 = 1e-13;

/// What an interval comes to.
#[derive(Clone, Copy)]
struct Solved {
    h: f64,
    per_h: f64,
    end: Reduced,
    sums: Sums,
    /// What ended it early.
    event: Option<Event>,
}

impl Stage {
    /// Advances by `limit` seconds or less, to the next event at most. Returns by how much.
    pub(crate) fn interval(&mut self, limit: f64) -> f64 {
        let mut motion = self.shaft.predict(self.longest(limit));
        self.settle_source();
        let mut passes = 0;
        for corrections in 0.. {
            self.intervals += 1;
            self.refresh();
            let rate = (motion.speed + 0.5 * motion.h * motion.acceleration) * self.shaft.pole_pairs();
            let sweep = Sweep::new(&self.rotation, rate * motion.h);
            let segment = loop {
                let shape =
                    self.shape.along(self.circuit.wiring, self.shaft.angle, &sweep, rate, motion.h);
                let segment =
                    Segment::new(&self.network, &self.circuit, self.source_on, self.reduced, shape, &motion);
                // Diodes turn on or off until they agree with the voltages.
                if passes == PASSES_MAX || !self.is_unsettled(segment.idle.start) || !self.change_diode() {
                    break segment;
                }
                self.diode_events += 1;
                passes += 1;
            };
            let mut solved = Solved::of(&self.network, &segment, motion.h, segment.at(&self.network, motion.h), None);
            if !self.is_quiet(&segment, &solved)
                && let Some((event, h)) = self.search(segment, motion.h, solved.end, &sweep, rate)
            {
                if h <= INSTANT {
                    self.apply(event, true);
                    return 0.0;
                }
                solved = Solved::of(&self.network, &segment, h, segment.at(&self.network, h), Some(event));
            }
            let Solved { h, per_h, .. } = solved;
            let impulse = solved.impulse(&segment);
            let expected = motion.speed + 0.5 * segment.acceleration * h;
            let turn = self.shaft.turn(&Push { h, per_h, impulse, speed: expected });
            if (turn.mean - expected).abs() * self.shape.peak() < EMF_ERROR || corrections == CORRECTIONS_MAX {
                self.book(&segment, &solved, impulse, &turn);
                self.commit(&segment, &solved, &turn, &sweep);
                return h;
            }
            // The shaft went faster or slower than the circuit was told: once more with what it did.
            motion.acceleration = 2.0 * (turn.mean - motion.speed) * per_h;
            motion.per_inertia = 0.0;
            motion.h = motion.h.min(1.001 * h);
        }
        0.0
    }

    /// Longest interval up to `limit` that the approximations allow.
    #[inline(always)]
    fn longest(&self, limit: f64) -> f64 {
        let mut h = limit.min(INTERVAL_MAX).min(TIME_CONSTANTS_MAX * self.network.time_constant);
        let rate = (self.shaft.speed * self.shaft.pole_pairs()).abs();
        if rate * h > ANGLE_MAX {
            h = ANGLE_MAX / rate;
        }
        if !self.shape.is_sine() {
            h = self.to_corner(h);
        }
        h
    }

    /// `h`, or less if the back-EMF has a corner before.
    fn to_corner(&self, h: f64) -> f64 {
        let turns_per_second = self.shaft.speed * self.shaft.turns_per_radian();
        match self.shape.turns_to_corner(self.shaft.angle, turns_per_second.signum()) {
            Some(turns) if turns_per_second.abs() * h > turns => turns / turns_per_second.abs(),
            _ => h,
        }
    }

    #[inline(always)]
    fn settle_source(&mut self) {
        let excess = self.electric.v - self.network.source_v;
        if self.may_sink || excess < -VOLTAGE_EDGE {
            self.source_on = true;
        } else if excess > VOLTAGE_EDGE {
            self.source_on = false;
        }
    }

    /// True if some diode may have to turn on or off at the start of the interval.
    #[inline(always)]
    fn is_unsettled(&self, idle: f64) -> bool {
        let circuit = &self.circuit;
        if circuit.has_diodes && (0..3).any(|x| circuit.diodes[x] != 0.0 && self.electric.i[x] == 0.0) {
            return true;
        }
        let (v, edge) = (self.electric.v, self.network.drop + VOLTAGE_EDGE);
        match circuit.wiring.conducting {
            3 => false,
            2 => {
                let terminal = idle + circuit.wiring.high_share * v;
                terminal < -edge || terminal > v + edge
            }
            0 => self.shape.line_peak() * self.shaft.speed.abs() > v + edge,
            _ => true,
        }
    }

    /// True if certainly nothing happens before the end: no diode's current ends, no idle leg's terminal leaves the rails, the
    /// source goes on as it is.
    #[inline(always)]
    fn is_quiet(&self, segment: &Segment, solved: &Solved) -> bool {
        let Solved { h, per_h, end, sums, .. } = solved;
        let circuit = &self.circuit;
        if circuit.has_diodes {
            // Half way the parabola through both ends with the known mean is 3/2 of the mean less a quarter of both ends.
            let middle = |mean: f64, a: f64, b: f64| 1.5 * mean * per_h - 0.25 * (a + b);
            let (s, d) = (middle(sums.s, segment.start.s, end.s), middle(sums.d, segment.start.d, end.d));
            if circuit.is_against_a_diode(end.s, end.d) || circuit.is_against_a_diode(s, d) {
                return false;
            }
        }
        let (low, high) = segment.bus_range(&self.network, *per_h, end, sums);
        let source_v = self.network.source_v;
        if self.source_on {
            if !self.may_sink && high > source_v + VOLTAGE_EDGE {
                return false;
            }
        } else if low < source_v - VOLTAGE_EDGE {
            return false;
        }
        let edge = self.network.drop;
        match circuit.wiring.conducting {
            3 => true,
            2 => {
                let (a, b) = (segment.idle.start, segment.idle.at(*h));
                let share = circuit.wiring.high_share;
                a.min(b) + share * low > -edge && a.max(b) < (1.0 - share) * low + edge
            }
            0 => {
                let speed = self.shaft.speed.abs() + segment.acceleration.abs() * h;
                self.shape.line_peak() * speed < low + edge
            }
            _ => false,
        }
    }

    /// Books the energies.
    #[inline(always)]
    fn book(&mut self, segment: &Segment, solved: &Solved, impulse: f64, turn: &Turn) {
        let Solved { h, per_h, end, sums, .. } = solved;
        let network = &self.network;
        let ledger = &mut self.ledger;
        let start = &segment.start;
        // Of a parabola between a and b with mean m: mean square m^2 + (b - a)^2 / 12 and less than 1e-4 beside.
        let square = |sum: f64, a: f64, b: f64| sum * sum * per_h + h * (1.0 / 12.0) * (b - a) * (b - a);
        // along . along = 1 / k, across . across = 2.
        let squares = if self.circuit.wiring.conducting == 3 {
            1.5 * square(sums.s, start.s, end.s) + 2.0 * square(sums.d, start.d, end.d)
        } else {
            2.0 * square(sums.s, start.s, end.s)
        };
        ledger.copper += network.copper * squares;
        ledger.switches += network.switch * squares;
        if self.circuit.has_diodes {
            // A diode's drop is against its current.
            ledger.diodes -= self.circuit.drop_s * sums.s + self.circuit.drop_d * sums.d;
        }
        let is_open = segment.topology() == Loop::Open;
        let (link, links) = if is_open { (0.0, [0.0; 2]) } else { (sums.s, [start.s, end.s]) };
        let volts_squared = if self.source_on {
            let fall = network.source_v * h - sums.v;
            let fall_squared =
                network.fall_squared((*h, *per_h), (start.v, end.v), fall, links, link);
            ledger.source += network.source_v * network.source_g * fall;
            ledger.source_loss += network.source_g * fall_squared;
            network.source_v * (network.source_v * h - 2.0 * fall) + fall_squared
        } else {
            square(sums.v, start.v, end.v)
        };
        ledger.leak += network.leak_g * volts_squared;
        ledger.shaft += impulse * turn.mean;
        ledger.friction += turn.friction;
        ledger.load += turn.load;
        self.shunt_charge += link + network.shunt_g * sums.v;
        self.impulse += impulse;
    }

    /// Takes over what was solved, and lets the event happen.
    #[inline(always)]
    fn commit(&mut self, segment: &Segment, solved: &Solved, turn: &Turn, sweep: &Sweep) {
        let Solved { h, end, .. } = solved;
        if self.watched {
            self.against_mean[0] = self.less_mean();
        }
        let shape = &segment.shape;
        let torque = shape.s.at(*h) * end.s + shape.d.at(*h) * end.d;
        if self.shape.is_sine() {
            self.rotation = sweep.end(turn.path * self.shaft.pole_pairs());
        }
        self.shaft.apply(turn, torque);
        self.reduced = *end;
        self.electric.i = self.circuit.wiring.currents(end.s, end.d);
        self.electric.v = end.v;
        // Between two switching events currents hardly bend: their extremes are at the events.
        self.see_peak();
        self.held = [false; 3];
        if self.watched {
            self.against_mean[1] = self.less_mean();
        }
        if let Some(event) = solved.event {
            self.apply(event, false);
        }
    }
}

impl Solved {
    #[inline(always)]
    fn of(network: &Network, segment: &Segment, h: f64, end: Reduced, event: Option<Event>) -> Self {
        let sums = segment.sums(network, h, &end);
        Self { h, per_h: 1.0 / h, end, sums, event }
    }

    /// Torque impulse, N m s: back-EMF per speed times current along each coordinate, the current being a parabola of known
    /// mean.
    #[inline(always)]
    fn impulse(&self, segment: &Segment) -> f64 {
        let Self { h, end, sums, .. } = self;
        let (shape, start) = (&segment.shape, &segment.start);
        let twelfth = h * h * (1.0 / 12.0);
        shape.s.at(0.5 * h) * sums.s
            + shape.s.slope * twelfth * (end.s - start.s)
            + shape.d.at(0.5 * h) * sums.d
            + shape.d.slope * twelfth * (end.d - start.d)
    }
}
