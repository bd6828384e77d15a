//! Which diodes conduct, and when that changes: the rare part of an interval.

use super::circuit::{Leg, Reduced};
use super::emf::Line;
use super::event::{Event, First, Scene};
use super::phase::Phase;
use super::segment::Segment;
use super::stage::{Stage, VOLTAGE_EDGE};

/// The source stops or starts between its edge and this far beyond, V.
const PASSED: f64 = 1e-5;
/// Shorter times are none, s.
const INSTANT: f64 = 1e-13;

/// Change of the source within an interval.
pub(crate) enum Change {
    Never,
    /// After so many seconds, in this state.
    At(f64, Reduced),
    /// It may.
    Unclear,
}

impl Stage {
    /// Turns the diode on that is most in need of it, or a currentless one off. False if all agree.
    #[inline(never)]
    pub(crate) fn change_diode(&mut self) -> bool {
        self.refresh();
        let (v, drop) = (self.electric.v, self.network.drop);
        let emf = self.legs_emf();
        let neutral = self.circuit.neutral(&emf, v, drop);
        for x in Phase::ALL {
            let sign = self.circuit.diodes[x];
            if sign != 0.0 && self.electric.i[x] == 0.0 {
                // L di/dt of a leg without current. The diode at the bus lets current out of the motor only.
                let terminal = if sign > 0.0 { v + drop } else { -drop };
                if sign * (terminal - neutral - emf[x]) >= 0.0 {
                    self.set_leg(x, Leg::Idle);
                    self.held[x] = true;
                    self.end_current(x);
                    self.refresh();
                    return true;
                }
            }
        }
        let mut most = (VOLTAGE_EDGE, None);
        for event in self.starts().into_iter().flatten() {
            let excess = match event {
                Event::HighStarts(x) => neutral + emf[x] - v - drop,
                Event::LowStarts(x) => -drop - neutral - emf[x],
                Event::PairStarts(x, y) => emf[x] - emf[y] - v - 2.0 * drop,
                _ => continue,
            };
            if excess > most.0 {
                most = (excess, Some(event));
            }
        }
        let Some(event) = most.1 else { return false };
        self.start_diodes(event);
        self.refresh();
        true
    }

    /// Diodes that could start to conduct.
    fn starts(&self) -> [Option<Event>; 6] {
        let mut events = [None; 6];
        let may_start = |x: Phase| self.legs[x] == Leg::Idle && !self.open[x] && !self.held[x];
        if self.circuit.is_tied() {
            for x in Phase::ALL {
                if may_start(x) {
                    events[2 * x.index()] = Some(Event::HighStarts(x));
                    events[2 * x.index() + 1] = Some(Event::LowStarts(x));
                }
            }
        } else {
            let pairs = Phase::ALL.into_iter().flat_map(|x| Phase::ALL.map(|y| (x, y)));
            let able = pairs.filter(|(x, y)| x != y && may_start(*x) && may_start(*y));
            for (event, (x, y)) in events.iter_mut().zip(able) {
                *event = Some(Event::PairStarts(x, y));
            }
        }
        events
    }

    fn start_diodes(&mut self, event: Event) {
        match event {
            Event::HighStarts(x) => self.set_leg(x, Leg::HighDiode),
            Event::LowStarts(x) => self.set_leg(x, Leg::LowDiode),
            Event::PairStarts(x, y) => {
                self.set_leg(x, Leg::HighDiode);
                self.set_leg(y, Leg::LowDiode);
            }
            _ => {}
        }
    }

    /// Returns the time at which the source stops or starts in the next `h` seconds, which lead to `end`.
    #[inline(never)]
    pub(crate) fn source_changes(&self, segment: &Segment, h: f64, end: &Reduced) -> Change {
        let network = &self.network;
        // The bus is to come to a little beyond its edge.
        let sign = if self.source_on { 1.0 } else { -1.0 };
        let beyond = |at: &Reduced| sign * (at.v - network.source_v) - 0.5 * PASSED;
        let slope = |t: f64, at: &Reduced| sign * segment.slopes(network, t, at).v;
        let start = &segment.start;
        let (f0, f1, first) = (beyond(start), beyond(end), slope(0.0, start));
        if f1 <= 0.0 && beyond(&segment.at(network, 0.5 * h)) <= 0.0 {
            return Change::Never;
        }
        let second = (f1 - f0 - first * h) / (h * h);
        let root = first * first - 4.0 * second * f0;
        if f0 >= 0.0 || f1 <= 0.0 || root <= 0.0 {
            return Change::Unclear;
        }
        // Where the parabola with the slope at the start rises through zero, then Newton's method on the
        // solution.
        let mut t = if first > 0.0 {
            -2.0 * f0 / (first + libm::sqrt(root))
        } else {
            (libm::sqrt(root) - first) / (2.0 * second)
        };
        for _ in 0..8 {
            if !(t > INSTANT && t < h) {
                break;
            }
            let at = segment.at(network, t);
            let f = beyond(&at);
            if f.abs() < 0.4 * PASSED {
                return Change::At(t, at);
            }
            t -= f / slope(t, &at);
        }
        Change::Unclear
    }

    /// Looks closely at an interval in which something may happen: what happens first, and when.
    #[inline(never)]
    pub(crate) fn search(&self, segment: &Segment, h: f64, end: Reduced) -> Option<(Event, f64)> {
        let (circuit, network) = (&self.circuit, &self.network);
        let mut emf = [Line::default(); 3];
        if circuit.wiring.conducting < 2 {
            let Segment { speed, middle_speed, acceleration, .. } = *segment;
            emf = self.course.legs(&self.shape, &self.shaft, h).map(|shape| Line {
                start: (shape.middle - 0.5 * h * shape.slope) * speed,
                slope: shape.slope * middle_speed + shape.middle * acceleration,
            });
        }
        let scene = Scene { segment, circuit, network, emf };
        let middle = segment.at(network, 0.5 * h);
        let mut first = First { scene: &scene, h, middle: &middle, end: &end, found: None };
        if circuit.has_diodes {
            let diodes = Phase::ALL.into_iter().filter(|x| circuit.diodes[*x] != 0.0);
            diodes.for_each(|x| first.consider(Event::Stops(x)));
        }
        if circuit.wiring.conducting < 3 {
            self.starts().into_iter().flatten().for_each(|event| first.consider(event));
        }
        if !self.source_on {
            first.consider(Event::SourceStarts);
        } else if !self.may_sink {
            first.consider(Event::SourceStops);
        }
        first.found
    }

    /// Makes `event` happen. One that comes without any delay holds its leg for an interval.
    pub(crate) fn apply(&mut self, event: Event, at_once: bool) {
        match event {
            Event::Stops(x) => {
                self.set_leg(x, Leg::Idle);
                self.held[x] = at_once;
                self.end_current(x);
                self.diode_events += 1;
            }
            Event::SourceStops => self.source_on = false,
            Event::SourceStarts => self.source_on = true,
            _ => {
                self.start_diodes(event);
                self.diode_events += 1;
            }
        }
    }
}
