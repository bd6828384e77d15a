//! One interval between two switching events: the circuit along the shaft's course.

use super::circuit::Reduced;
use super::event::Event;
use super::network::{Loop, Network};
use super::segment::{Kind, Segment, Sums};
use super::stage::{Stage, VOLTAGE_EDGE};

/// Longest interval in time constants L / R: losses are good to 1e-4 then.
const TIME_CONSTANTS_MAX: f64 = 0.35;
/// Each pass changes one diode: six are more than three legs can need.
const PASSES_MAX: u32 = 6;
/// Shorter intervals are none, s.
const INSTANT: f64 = 1e-13;

/// What an interval comes to.
#[derive(Clone, Copy)]
pub(crate) struct Solved {
    h: f64,
    per_h: f64,
    pub(crate) end: Reduced,
    sums: Sums,
    /// Lowest and highest bus voltage on the way, V.
    bus: (f64, f64),
    /// What ended it early.
    event: Option<Event>,
}

impl Stage {
    /// Advances by `limit` seconds or less on the present course, to the next event at most. Returns by how much.
    #[inline(never)]
    pub(crate) fn interval(&mut self, limit: f64) -> f64 {
        self.intervals += 1;
        self.settle_source();
        let rest = self.course.rest();
        let most = TIME_CONSTANTS_MAX * self.network.time_constant;
        let h = if limit < rest { limit } else { rest };
        let h = if h < most { h } else { most };
        let mut passes = 0;
        loop {
            self.refresh();
            // One by one, so that the compiler makes code for each that does nothing which it does not need.
            let done = match (self.circuit.wiring.topology, self.circuit.wiring.conducting) {
                (Loop::Open, 3) => self.solve(h, Loop::Open, true, passes),
                (Loop::Open, _) => self.solve(h, Loop::Open, false, passes),
                (Loop::TwoLegs, _) => self.solve(h, Loop::TwoLegs, false, passes),
                (Loop::ThreeLegs, _) => self.solve(h, Loop::ThreeLegs, true, passes),
            };
            if let Some(h) = done {
                return h;
            }
            self.diode_events += 1;
            passes += 1;
        }
    }

    /// Solves the circuit for `h` seconds or up to an event; `three` says that all legs conduct. None if a diode had to change
    /// first.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn solve(&mut self, h: f64, topology: Loop, three: bool, passes: u32) -> Option<f64> {
        let segment = self.segment_of(h, topology, three);
        // Diodes turn on or off until they agree with the voltages.
        if passes < PASSES_MAX && self.is_unsettled(&segment) && self.change_diode() {
            return None;
        }
        let end = segment.at(&self.network, h);
        let mut solved = Solved::of(&self.network, &segment, h, end, None);
        let (diodes, source) = (self.keeps_diodes(&segment, &solved), self.keeps_source(&segment, &solved));
        if !(diodes && source) {
            let Some((event, t, end)) = self.plain_event(h, !diodes) else {
                return Some(self.search_and_commit(h));
            };
            solved = Solved::of(&self.network, &segment, t, end, Some(event));
            let plain = if diodes {
                self.keeps_diodes(&segment, &solved)
            } else {
                self.keeps_source(&segment, &solved)
            };
            if !plain {
                return Some(self.search_and_commit(h));
            }
        }
        if !self.keeps_idle_legs(&segment, &solved) {
            return Some(self.search_and_commit(h));
        }
        self.commit(&segment, &solved);
        Some(solved.h)
    }

    /// The circuit for the next `h` seconds.
    pub(crate) fn segment(&self, h: f64) -> Segment {
        let wiring = self.circuit.wiring;
        self.segment_of(h, wiring.topology, wiring.conducting == 3)
    }

    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn segment_of(&self, h: f64, topology: Loop, three: bool) -> Segment {
        let Self { network, circuit, course, .. } = self;
        let shape = course.shape(&self.shape, &self.shaft, circuit.wiring, three, h);
        let motion = (course.speed(), course.acceleration(self.torque), course.motion.per_inertia);
        let kind = Kind { topology, three, source_on: self.source_on };
        Segment::new(network, circuit, kind, self.reduced, shape, motion, h)
    }

    /// Where something may happen that is not the plain end of a diode's current.
    #[inline(never)]
    fn search_and_commit(&mut self, h: f64) -> f64 {
        let segment = self.segment(h);
        let end = segment.at(&self.network, h);
        match self.search(&segment, h, end) {
            None => {
                let solved = Solved::of(&self.network, &segment, h, end, None);
                self.commit(&segment, &solved);
                h
            }
            Some((event, t)) if t <= INSTANT => {
                self.apply(event, true);
                0.0
            }
            Some((event, t)) => {
                let end = segment.at(&self.network, t);
                let solved = Solved::of(&self.network, &segment, t, end, Some(event));
                self.commit(&segment, &solved);
                t
            }
        }
    }

    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn settle_source(&mut self) {
        let excess = self.electric.v - self.network.source_v;
        if self.may_sink || excess < -VOLTAGE_EDGE {
            self.source_on = true;
        } else if excess > VOLTAGE_EDGE {
            self.source_on = false;
        }
    }

    /// True if some diode may have to turn on or off at the start of the interval.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn is_unsettled(&self, segment: &Segment) -> bool {
        let circuit = &self.circuit;
        if circuit.has_diodes && (0..3).any(|x| circuit.diodes[x] != 0.0 && self.electric.i[x] == 0.0) {
            return true;
        }
        let (v, edge) = (self.electric.v, self.network.drop + VOLTAGE_EDGE);
        match circuit.wiring.conducting {
            _ if segment.has_difference() => false,
            2 => {
                let terminal = segment.idle.start + circuit.wiring.high_share * v;
                terminal < -edge || terminal > v + edge
            }
            0 => self.shape.line_peak() * self.course.speed().abs() > v + edge,
            _ => true,
        }
    }

    /// True if no diode's current ends before the end.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn keeps_diodes(&self, segment: &Segment, solved: &Solved) -> bool {
        let Solved { per_h, end, sums, .. } = solved;
        let circuit = &self.circuit;
        if !circuit.has_diodes {
            return true;
        }
        // Half way the parabola through both ends with the known mean is 3/2 of the mean less a quarter of both ends.
        let middle = |sum: f64, a: f64, b: f64| 1.5 * sum * per_h - 0.25 * (a + b);
        let (s, d) = (middle(sums.s, segment.start.s, end.s), middle(sums.d, segment.start.d, end.d));
        !(circuit.is_against_a_diode(end.s, end.d) || circuit.is_against_a_diode(s, d))
    }

    /// True if the source certainly goes on as it is until the end.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn keeps_source(&self, segment: &Segment, solved: &Solved) -> bool {
        let (low, high) = solved.bus;
        let source_v = self.network.source_v;
        if segment.source_on() {
            self.may_sink || high <= source_v + VOLTAGE_EDGE
        } else {
            low >= source_v - VOLTAGE_EDGE
        }
    }

    /// True if certainly no idle leg's terminal leaves the rails before the end.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn keeps_idle_legs(&self, segment: &Segment, solved: &Solved) -> bool {
        let ((low, _), edge) = (solved.bus, self.network.drop);
        match self.circuit.wiring.conducting {
            _ if segment.has_difference() => true,
            2 => {
                let (a, b) = (segment.idle.start, segment.idle.at(solved.h));
                let (least, most) = if a < b { (a, b) } else { (b, a) };
                let share = self.circuit.wiring.high_share;
                least + share * low > -edge && most < (1.0 - share) * low + edge
            }
            // An idle bridge drives nothing: the speed hardly changes.
            0 => self.shape.line_peak() * self.course.speed().abs() < 0.99 * low,
            _ => false,
        }
    }

    /// Adds up what the interval moved.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn book(&mut self, segment: &Segment, solved: &Solved) {
        let Solved { h, per_h, end, sums, .. } = solved;
        let (network, course, start) = (&self.network, &mut self.course, &segment.start);
        // Of a parabola between a and b with mean m: mean square m^2 + (b - a)^2 / 12 and less than 1e-4 beside.
        let square = |sum: f64, a: f64, b: f64| sum * sum * per_h + h * (1.0 / 12.0) * (b - a) * (b - a);
        // along . along = 1 / k, across . across = 2.
        if segment.has_difference() {
            course.squares += 1.5 * square(sums.s, start.s, end.s) + 2.0 * square(sums.d, start.d, end.d);
        } else {
            course.squares += 2.0 * square(sums.s, start.s, end.s);
        }
        if self.circuit.has_diodes {
            // A diode's drop is against its current.
            self.ledger.diodes -= self.circuit.drop_s * sums.s + self.circuit.drop_d * sums.d;
        }
        let is_open = segment.topology() == Loop::Open;
        self.shunt_charge += network.shunt_g * sums.v;
        if !is_open {
            self.shunt_charge += sums.s;
        }
        if segment.source_on() {
            let fall = network.source_v * h - sums.v;
            let link = if is_open { None } else { Some(([start.s, end.s], sums.s)) };
            let fall_squared = network.fall_squared((*h, *per_h), (start.v, end.v), fall, link);
            course.fall += fall;
            course.fall_squared += fall_squared;
            course.volts_squared += network.source_v * (network.source_v * h - 2.0 * fall) + fall_squared;
        } else {
            course.volts_squared += square(sums.v, start.v, end.v);
        }
        let impulse = solved.impulse(segment);
        course.impulse += impulse;
        course.path += (segment.speed + 0.5 * segment.acceleration * h) * h;
        course.moment += impulse * (course.elapsed + 0.5 * h);
    }

    /// Takes over what was solved, and lets the event happen.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn commit(&mut self, segment: &Segment, solved: &Solved) {
        self.book(segment, solved);
        let Solved { h, end, .. } = solved;
        if self.watched {
            self.against_mean[0] = self.less_mean();
        }
        let shape = &segment.shape;
        self.torque = shape.s.at(*h) * end.s + shape.d.at(*h) * end.d;
        self.course.elapsed += h;
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
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn of(network: &Network, segment: &Segment, h: f64, end: Reduced, event: Option<Event>) -> Self {
        let (per_h, sums) = (1.0 / h, segment.sums(network, h, &end));
        Self { h, per_h, end, sums, bus: segment.bus_range(network, per_h, &end, &sums), event }
    }

    /// Torque impulse, N m s: back-EMF per speed times current along each coordinate, the current being a parabola of known
    /// mean.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn impulse(&self, segment: &Segment) -> f64 {
        let Self { h, end, sums, .. } = self;
        let (shape, start) = (&segment.shape, &segment.start);
        let twelfth = h * h * (1.0 / 12.0);
        let s = shape.s.at(0.5 * h) * sums.s + shape.s.slope * twelfth * (end.s - start.s);
        if segment.has_difference() {
            s + shape.d.at(0.5 * h) * sums.d + shape.d.slope * twelfth * (end.d - start.d)
        } else {
            s
        }
    }
}
