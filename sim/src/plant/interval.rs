//! One interval between two switching events: the circuit along the shaft's course.

use super::circuit::{Leg, Reduced};
use super::diodes::Change;
use super::event::Event;
use super::network::{Loop, Network};
use super::phase::Phase;
use super::segment::{Kind, Pace, Segment, Sums};
use super::stage::{Stage, VOLTAGE_EDGE};

/// Each pass changes one diode: six are more than three legs can need.
const PASSES_MAX: u32 = 6;
/// Shorter intervals are none, s.
const INSTANT: f64 = 1e-13;
/// A diode's current below this has ended, A.
const STOPPED: f64 = 1e-6;

/// Solution of an interval.
#[derive(Clone, Copy)]
pub(crate) struct Solved {
    pub(crate) h: f64,
    pub(crate) per_h: f64,
    pub(crate) end: Reduced,
    pub(crate) sums: Sums,
    /// Event that ended it early.
    event: Option<Event>,
}

/// Outcome of an attempt at an interval.
enum Attempt {
    /// It is done, and took so many seconds.
    Done(f64),
    /// The terminal of the one idle leg beside two that conduct is beyond its diode: +1 above the bus, -1
    /// below ground.
    Starts(f64),
    /// It needs a closer look.
    Unclear,
}

impl Stage {
    /// Advances by `limit` seconds or less on the present course, to the next event at most. Returns by how
    /// much.
    #[inline(never)]
    pub(crate) fn interval(&mut self, limit: f64) -> f64 {
        self.settle_source();
        let h = self.longest_interval(limit);
        self.refresh();
        // One by one, so that the compiler makes code for each that does nothing which it does not need.
        let attempt = match (self.circuit.wiring.topology, self.circuit.wiring.conducting) {
            (Loop::Open, 3) => self.attempt(h, Loop::Open, true),
            (Loop::Open, _) => self.attempt(h, Loop::Open, false),
            (Loop::TwoLegs, _) => self.attempt(h, Loop::TwoLegs, false),
            (Loop::ThreeLegs, _) => self.attempt(h, Loop::ThreeLegs, true),
        };
        match attempt {
            Attempt::Done(h) => h,
            Attempt::Starts(sign) => self.start_idle_leg(sign, limit),
            Attempt::Unclear => self.interval_closely(h),
        }
    }

    /// Solves the circuit for `h` seconds or up to the end of the only diode's current, where nothing else
    /// can happen; `three` says that all legs conduct. Calls nothing before all is told, so that it can keep
    /// its many numbers in registers.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn attempt(&mut self, h: f64, topology: Loop, three: bool) -> Attempt {
        let circuit = &self.circuit;
        let several = circuit.has_diodes && circuit.lone.is_none();
        let modes = self.network.modes(topology, self.source_on);
        if modes.is_long(h)
            || several
            || (circuit.lone.is_some_and(|x| self.electric.i[x] == 0.0) && !self.just_started)
        {
            return Attempt::Unclear;
        }
        let mut segment = self.segment_of(h, topology, three);
        if !three {
            let (v, edge) = (self.electric.v, self.network.drop + VOLTAGE_EDGE);
            let terminal = segment.idle.start + circuit.wiring.high_share * v;
            if circuit.wiring.conducting < 2 {
                return Attempt::Unclear;
            } else if terminal < -edge {
                return Attempt::Starts(-1.0);
            } else if terminal > v + edge {
                return Attempt::Starts(1.0);
            }
        }
        let (h, end, event) = match self.stop(&segment, h) {
            Some((t, end, event)) => {
                segment.end_at(t);
                (t, end, Some(event))
            }
            None => (h, segment.at(&self.network, h), None),
        };
        let solved = Solved::of(&self.network, &segment, h, end, event);
        let (source, low) = self.keeps_source(&segment, &solved);
        if !source || !self.keeps_diodes(&segment, &solved) || !self.keeps_idle_legs(&segment, h, low) {
            let (segment, solved) = (segment, solved);
            return Attempt::Done(self.end_early(&segment, &solved, source, low));
        }
        self.commit(&segment, &solved);
        Attempt::Done(h)
    }

    /// Ends the interval early where an event may happen before the end of the solution. `source` says that
    /// the source certainly goes on as it is, with the bus at `low` or above.
    #[inline(never)]
    fn end_early(&mut self, segment: &Segment, solved: &Solved, source: bool, low: f64) -> f64 {
        let changed = if source { None } else { self.change_source(segment, solved, low) };
        changed.unwrap_or_else(|| self.search_and_commit(segment, segment.length()))
    }

    /// Ends what was solved where the source stops or starts, if it does. Returns when; nothing if something
    /// else may happen before.
    fn change_source(&mut self, segment: &Segment, solved: &Solved, low: f64) -> Option<f64> {
        let (mut segment, mut solved) = (*segment, *solved);
        match self.source_changes(&segment, solved.h, &solved.end) {
            Change::Never => {}
            Change::Unclear => return None,
            Change::At(t, end) => {
                let event = if self.source_on { Event::SourceStops } else { Event::SourceStarts };
                solved = Solved::of(&self.network, &segment, t, end, Some(event));
            }
        }
        let h = solved.h;
        if !self.keeps_diodes(&segment, &solved) || !self.keeps_idle_legs(&segment, h, low) {
            return None;
        }
        segment.end_at(h);
        self.commit(&segment, &solved);
        Some(h)
    }

    /// `limit` seconds, or less if the course ends before or the approximations would not hold.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn longest_interval(&self, limit: f64) -> f64 {
        let (rest, most) = (self.course.rest(), self.network.longest);
        let h = if limit < rest { limit } else { rest };
        if h < most { h } else { most }
    }

    /// Solves up to `limit` seconds of any circuit, whatever happens in them, and returns how many, s.
    #[inline(never)]
    fn interval_closely(&mut self, limit: f64) -> f64 {
        let h = self.longest_interval(limit);
        let mut segment = self.segment(h);
        for _ in 0..PASSES_MAX {
            // Diodes turn on or off until they agree with the voltages.
            if !(self.is_unsettled(&segment) && self.change_diode()) {
                break;
            }
            self.diode_events += 1;
            segment = self.segment(h);
        }
        let (t, end, event) = match self.stop(&segment, h) {
            Some((t, end, event)) => (t, end, Some(event)),
            None => (h, segment.at(&self.network, h), None),
        };
        let solved = Solved::of(&self.network, &segment, t, end, event);
        let (source, low) = self.keeps_source(&segment, &solved);
        if !source || !self.keeps_diodes(&segment, &solved) || !self.keeps_idle_legs(&segment, t, low) {
            return self.end_early(&segment, &solved, source, low);
        }
        segment.end_at(t);
        self.commit(&segment, &solved);
        t
    }

    /// Lets the idle leg beside two that conduct begin to, if it can: through the high-side diode for +1, the
    /// low-side one for -1. Then the interval begins anew; not in a loop there, before which the compiler
    /// would load all constants.
    #[inline(never)]
    fn start_idle_leg(&mut self, sign: f64, limit: f64) -> f64 {
        let Some(x) =
            Phase::ALL.into_iter().find(|x| self.legs[*x] == Leg::Idle && !self.open[*x] && !self.held[*x])
        else {
            return self.interval_closely(limit);
        };
        self.set_leg(x, if sign > 0.0 { Leg::HighDiode } else { Leg::LowDiode });
        self.diode_events += 1;
        self.just_started = true;
        self.interval(limit)
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
        let (speed, acceleration) = (course.speed(), course.acceleration(self.torque));
        let kind = Kind { topology, three, source_on: self.source_on };
        let pace = Pace { speed, acceleration, lean: course.lean };
        Segment::new(network, circuit, kind, circuit.reduce(&self.electric), shape, pace, h)
    }

    /// Searches for events that are neither the plain end of a diode's current nor of the source's, and
    /// commits the time up to the first.
    #[inline(never)]
    fn search_and_commit(&mut self, segment: &Segment, h: f64) -> f64 {
        let end = segment.at(&self.network, h);
        match self.search(segment, h, end) {
            None => {
                let solved = Solved::of(&self.network, segment, h, end, None);
                self.commit(segment, &solved);
                h
            }
            Some((event, t)) if t <= INSTANT => {
                self.apply(event, true);
                0.0
            }
            Some((event, t)) => {
                let end = segment.at(&self.network, t);
                let solved = Solved::of(&self.network, segment, t, end, Some(event));
                let mut segment = *segment;
                segment.end_at(t);
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

    /// True if some diode may have to turn on or off now, at the start of `segment`.
    fn is_unsettled(&self, segment: &Segment) -> bool {
        let circuit = &self.circuit;
        if Phase::ALL.into_iter().any(|x| circuit.diodes[x] != 0.0 && self.electric.i[x] == 0.0) {
            return true;
        }
        let (v, edge) = (self.electric.v, self.network.drop + VOLTAGE_EDGE);
        match circuit.wiring.conducting {
            3 => false,
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
        let Solved { per_h, end, sums, event, .. } = solved;
        let circuit = &self.circuit;
        if !circuit.has_diodes {
            return true;
        }
        // Half way the parabola through both ends with the known mean is 3/2 of the mean less a quarter of
        // both ends.
        let middle = |sum: f64, a: f64, b: f64| 1.5 * sum * per_h - 0.25 * (a + b);
        let (s, d) = (middle(sums.s, segment.start.s, end.s), middle(sums.d, segment.start.d, end.d));
        if circuit.lone.is_some() {
            let against = |s: f64, d: f64| circuit.against[0] * s + circuit.against[1] * d > 0.0;
            let ends = matches!(event, Some(Event::Stops(_)));
            return !(against(s, d) || (!ends && against(end.s, end.d)));
        }
        !(circuit.is_against_a_diode(end.s, end.d) || circuit.is_against_a_diode(s, d))
    }

    /// True if the source certainly goes on as it is until the end, and the lowest bus voltage on the way:
    /// the bus follows the voltage at which the source gives what the motor takes, and never passes it.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn keeps_source(&self, segment: &Segment, solved: &Solved) -> (bool, f64) {
        let Solved { h, per_h, end, sums, .. } = solved;
        let (start, from, to) = (&segment.start, segment.start.v, end.v);
        let below = if from < to { from } else { to };
        let source_v = self.network.source_v;
        let stays_below = self.may_sink || from <= source_v + VOLTAGE_EDGE;
        if segment.topology() == Loop::Open {
            let keeps = if segment.source_on() { stays_below } else { below >= source_v - VOLTAGE_EDGE };
            return (keeps, below);
        }
        // The link current is a parabola, as high above its chord as the mean tells.
        let bend = (1.5 * sums.s * per_h - 0.75 * (start.s + end.s)).abs();
        let (least, most) = if start.s < end.s { (start.s, end.s) } else { (end.s, start.s) };
        let (least, most) = (least - bend, most + bend);
        let modes = segment.modes(&self.network);
        let lowest = modes.rest - most * modes.per_g;
        let low = if from < lowest { from } else { lowest };
        if segment.source_on() {
            let top = source_v + VOLTAGE_EDGE;
            let may_rise = least < 0.0 && modes.rest - least * modes.per_g > top;
            // The bound tells little where the bus is still low: then the way tells, half way and at the end.
            let rises = may_rise && (to > top || segment.at(&self.network, 0.5 * h).v > top);
            return (self.may_sink || (stays_below && !rises), low);
        }
        // Nothing but the motor at the bus: a current that does not turn round moves it one way.
        let above = if from < to { to } else { from };
        let one_way = least > 0.0 || most + modes.g * above < 0.0;
        let low = if one_way { below } else { low };
        (low >= source_v - VOLTAGE_EDGE, low)
    }

    /// True if certainly no idle leg's terminal leaves the rails in the next `h` seconds, with the bus at
    /// `low` or above.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn keeps_idle_legs(&self, segment: &Segment, h: f64, low: f64) -> bool {
        let edge = self.network.drop;
        match self.circuit.wiring.conducting {
            _ if segment.has_difference() => true,
            2 => {
                let (a, b) = (segment.idle.start, segment.idle.at(h));
                let (least, most) = if a < b { (a, b) } else { (b, a) };
                let share = self.circuit.wiring.high_share;
                least + share * low > -edge && most < (1.0 - share) * low + edge
            }
            // An idle bridge drives nothing: the speed hardly changes.
            0 => self.shape.line_peak() * self.course.speed().abs() < 0.99 * low,
            _ => false,
        }
    }

    /// Returns the time at which the current of the only diode ends, if there is one and that is within the
    /// next `h` seconds, the state then, and the event.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn stop(&self, segment: &Segment, h: f64) -> Option<(f64, Reduced, Event)> {
        let event = Event::Stops(self.circuit.lone?);
        let mut t = segment.expected_zero(&self.network, &self.circuit.against);
        // Where it does not converge, the end of the interval tells.
        for _ in 0..4 {
            if !(t > INSTANT && t < h) {
                return None;
            }
            let at = segment.at(&self.network, t);
            let [s, d] = self.circuit.against;
            let value = s * at.s + d * at.d;
            if value.abs() < STOPPED {
                return Some((t, at, event));
            }
            let slope = segment.slopes(&self.network, t, &at);
            t -= value / (s * slope.s + d * slope.d);
        }
        None
    }

    /// Takes over what was solved, and lets the event happen.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn commit(&mut self, segment: &Segment, solved: &Solved) {
        self.book(segment, solved);
        let Solved { h, end, .. } = solved;
        if self.watched {
            self.against_mean[0] = self.less_mean();
        }
        let (shape, half) = (&segment.shape, 0.5 * h);
        self.torque = (shape.s.middle + half * shape.s.slope) * end.s;
        if segment.has_difference() {
            self.torque += (shape.d.middle + half * shape.d.slope) * end.d;
        }
        self.course.elapsed += h;
        self.electric.v = end.v;
        let wiring = self.circuit.wiring;
        // Between two switching events currents hardly bend: their extremes are at the events. Where three
        // legs conduct, two share `s` and differ by `d`.
        let peak = if segment.has_difference() {
            self.electric.i = wiring.currents(end.s, end.d);
            let shared = 0.5 * end.s.abs() + end.d.abs();
            if shared > end.s.abs() { shared } else { end.s.abs() }
        } else {
            self.electric.i = wiring.along.map(|part| part * end.s);
            end.s.abs()
        };
        self.peak = if peak > self.peak { peak } else { self.peak };
        self.intervals += 1;
        (self.held, self.just_started) = ([false; 3], false);
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
        Self { h, per_h: 1.0 / h, end, sums: segment.sums(network, h, &end), event }
    }
}
