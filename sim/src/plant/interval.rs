//! One interval between two switching events: the circuit along the shaft's course.

use super::circuit::Reduced;
use super::event::Event;
use super::network::{Loop, Network};
use super::segment::{Segment, Sums};
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
    /// What ended it early.
    event: Option<Event>,
}

impl Stage {
    /// Advances by `limit` seconds or less on the present course, to the next event at most. Returns by how much.
    pub(crate) fn interval(&mut self, limit: f64) -> f64 {
        self.intervals += 1;
        self.settle_source();
        let rest = self.course.rest();
        let most = TIME_CONSTANTS_MAX * self.network.time_constant;
        let h = if limit < rest { limit } else { rest };
        let h = if h < most { h } else { most };
        let mut passes = 0;
        let segment = loop {
            self.refresh();
            let segment = self.segment(h);
            // Diodes turn on or off until they agree with the voltages.
            if passes == PASSES_MAX || !self.is_unsettled(segment.idle.start) || !self.change_diode() {
                break segment;
            }
            self.diode_events += 1;
            passes += 1;
        };
        let mut solved = Solved::of(&self.network, &segment, h, segment.at(&self.network, h), None);
        if !self.keeps_diodes(&segment, &solved) {
            match self.diode_stop(segment, h, solved.end) {
                Some((event, t, end)) => {
                    solved = Solved::of(&self.network, &segment, t, end, Some(event));
                }
                None => return self.search_and_commit(segment, h, solved.end),
            }
        }
        if !self.keeps_within_rails(&segment, &solved) {
            let end = segment.at(&self.network, h);
            return self.search_and_commit(segment, h, end);
        }
        self.commit(&segment, &solved);
        solved.h
    }

    #[inline(always)]
    fn segment(&self, h: f64) -> Segment {
        let Self { network, circuit, course, .. } = self;
        let shape = course.shape(&self.shape, &self.shaft, circuit.wiring, h);
        let motion = (course.speed(), course.acceleration(self.torque));
        Segment::new(network, circuit, self.source_on, self.reduced, shape, motion, h)
    }

    /// Where something may happen that is not the plain end of a diode's current.
    #[inline(never)]
    fn search_and_commit(&mut self, segment: Segment, h: f64, end: Reduced) -> f64 {
        match self.search(segment, h, end) {
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
            0 => self.shape.line_peak() * self.course.speed().abs() > v + edge,
            _ => true,
        }
    }

    /// True if no diode's current ends before the end.
    #[inline(always)]
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

    /// True if certainly no idle leg's terminal leaves the rails before the end, and the source goes on as it is.
    #[inline(always)]
    fn keeps_within_rails(&self, segment: &Segment, solved: &Solved) -> bool {
        let Solved { h, per_h, end, sums, .. } = solved;
        let circuit = &self.circuit;
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
                let (least, most) = if a < b { (a, b) } else { (b, a) };
                let share = circuit.wiring.high_share;
                least + share * low > -edge && most < (1.0 - share) * low + edge
            }
            // An idle bridge drives nothing: the speed hardly changes.
            0 => self.shape.line_peak() * self.course.speed().abs() < 0.99 * low,
            _ => false,
        }
    }

    /// Adds up what the interval moved.
    #[inline(always)]
    fn book(&mut self, segment: &Segment, solved: &Solved) {
        let Solved { h, per_h, end, sums, .. } = solved;
        let (network, course, start) = (&self.network, &mut self.course, &segment.start);
        // Of a parabola between a and b with mean m: mean square m^2 + (b - a)^2 / 12 and less than 1e-4 beside.
        let square = |sum: f64, a: f64, b: f64| sum * sum * per_h + h * (1.0 / 12.0) * (b - a) * (b - a);
        // along . along = 1 / k, across . across = 2.
        if self.circuit.wiring.conducting == 3 {
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
        if self.source_on {
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
    #[inline(always)]
    fn commit(&mut self, segment: &Segment, solved: &Solved) {
        self.book(segment, solved);
        let Solved { h, end, .. } = solved;
        if self.watched {
            self.against_mean[0] = self.less_mean();
        }
        let shape = &segment.shape;
        self.shape_at_end = (shape.s.at(*h), shape.d.at(*h));
        self.torque = self.shape_at_end.0 * end.s + self.shape_at_end.1 * end.d;
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
    #[inline(always)]
    fn of(network: &Network, segment: &Segment, h: f64, end: Reduced, event: Option<Event>) -> Self {
        Self { h, per_h: 1.0 / h, end, sums: segment.sums(network, h, &end), event }
    }

    /// Torque impulse, N m s: back-EMF per speed times current along each coordinate, the current being a parabola of known
    /// mean.
    #[inline(always)]
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
