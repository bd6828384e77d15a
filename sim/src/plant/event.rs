//! Events that may end an interval: a diode or the source starts or stops conducting.

use super::circuit::{Circuit, Reduced};
use super::emf::Line;
use super::network::Network;
use super::phase::Phase;
use super::segment::Segment;
use super::stage::VOLTAGE_EDGE;

/// A change of state inside an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Event {
    /// The current of a leg's diode reaches zero.
    Stops(Phase),
    /// The terminal of an idle leg rises above the bus.
    HighStarts(Phase),
    /// The terminal of an idle leg falls below ground.
    LowStarts(Phase),
    /// With all legs idle: back-EMF from the second to the first exceeds the bus.
    PairStarts(Phase, Phase),
    /// The bus rises above the source.
    SourceStops,
    /// The bus falls below the source.
    SourceStarts,
}

/// Scene in which events are looked for: an interval, its circuit, and the other values that decide.
pub(crate) struct Scene<'a> {
    pub(crate) segment: &'a Segment,
    pub(crate) circuit: &'a Circuit,
    pub(crate) network: &'a Network,
    /// Back-EMF of every leg, V.
    pub(crate) emf: [Line; 3],
}

impl Scene<'_> {
    /// Terminal voltage of the idle leg `x`.
    fn idle_terminal(&self, x: Phase, t: f64, v: f64) -> f64 {
        if self.circuit.wiring.conducting == 2 {
            return self.segment.idle.at(t) + self.circuit.wiring.high_share * v;
        }
        let emf = self.emf.map(|emf| emf.at(t));
        self.circuit.neutral(&emf, v, self.network.drop) + emf[x]
    }
}

impl Event {
    /// Returns the distance of the circuit beyond the event at `t`: negative before it, A or V.
    pub(crate) fn beyond(self, scene: &Scene, t: f64, at: &Reduced) -> f64 {
        match self {
            Self::Stops(x) => {
                let Circuit { wiring, diodes, .. } = scene.circuit;
                diodes[x] * (wiring.along[x] * at.s + wiring.across[x] * at.d)
            }
            Self::HighStarts(x) => scene.idle_terminal(x, t, at.v) - at.v - scene.network.drop,
            Self::LowStarts(x) => -scene.network.drop - scene.idle_terminal(x, t, at.v),
            Self::PairStarts(x, y) => {
                scene.emf[x].at(t) - scene.emf[y].at(t) - at.v - 2.0 * scene.network.drop
            }
            Self::SourceStops => at.v - scene.network.source_v,
            Self::SourceStarts => scene.network.source_v - at.v,
        }
    }

    /// Returns the distance beyond the event from which it counts, A or V: a current stops at zero, a voltage
    /// has to pass its edge.
    pub(crate) fn edge(self) -> f64 {
        if matches!(self, Self::Stops(_)) { 0.0 } else { VOLTAGE_EDGE }
    }

    /// The instant of the event inside of `bracket`: of a voltage's on the far side of it. 0 if it has been
    /// reached at the start already.
    fn locate(self, scene: &Scene, bracket: &Bracket) -> f64 {
        let evaluate = |t: f64| self.beyond(scene, t, &scene.segment.at(scene.network, t));
        // The place to hit is `close` wide. A voltage's begins at the edge; a current ends there exactly
        // (`end_current`), from whichever side.
        let (edge, close) = match self {
            Self::Stops(_) => (-5e-7, 1e-6),
            _ => (self.edge(), 1e-5),
        };
        let goal = edge + 0.5 * close;
        let Bracket { mut lower, mut upper, mut f_upper, .. } = *bracket;
        if bracket.f_lower >= self.edge() {
            // It starts on the edge: is there a way off it before the way back?
            lower = 0.125 * upper;
            if evaluate(lower) >= self.edge() {
                return 0.0;
            }
        }
        // Newton's method on the parabola through three known points gives the first guess, its slope the
        // next ones.
        let mut t = bracket.guess(goal);
        for attempt in 0..60 {
            if f_upper - edge < close || upper - lower < 1e-11 {
                break;
            }
            // Halves where the parabola leads astray.
            if !(t > lower && t < upper) || (attempt > 5 && attempt % 2 == 0) {
                t = 0.5 * (lower + upper);
            }
            let f = evaluate(t);
            if f >= edge {
                (upper, f_upper) = (t, f);
            } else {
                lower = t;
            }
            t -= (f - goal) / bracket.slope(t);
        }
        upper
    }
}

/// Bracket of an event: it lies between `lower` and `upper`, with a third point `other` beside them.
struct Bracket {
    lower: f64,
    f_lower: f64,
    upper: f64,
    f_upper: f64,
    /// The parabola through all three: f_lower + (t - lower) (first + (t - upper) second).
    first: f64,
    second: f64,
}

impl Bracket {
    fn new((lower, f_lower): (f64, f64), (upper, f_upper): (f64, f64), (other, f_other): (f64, f64)) -> Self {
        let first = (f_upper - f_lower) / (upper - lower);
        let aside = (f_other - f_lower) / (other - lower);
        Self { lower, f_lower, upper, f_upper, first, second: (aside - first) / (other - upper) }
    }

    fn slope(&self, t: f64) -> f64 {
        self.first + self.second * (2.0 * t - self.lower - self.upper)
    }

    fn guess(&self, goal: f64) -> f64 {
        let mut t = self.lower + (goal - self.f_lower) / self.first;
        for _ in 0..3 {
            let f = self.f_lower + (t - self.lower) * (self.first + (t - self.upper) * self.second);
            t -= (f - goal) / self.slope(t);
        }
        t
    }
}

/// The search for the first event of an interval.
pub(crate) struct First<'a> {
    pub(crate) scene: &'a Scene<'a>,
    pub(crate) h: f64,
    pub(crate) middle: &'a Reduced,
    pub(crate) end: &'a Reduced,
    pub(crate) found: Option<(Event, f64)>,
}

impl First<'_> {
    pub(crate) fn consider(&mut self, event: Event) {
        let (scene, h) = (self.scene, self.h);
        let edge = event.edge();
        let look = |t: f64, at: &Reduced| (t, event.beyond(scene, t, at));
        let middle = look(0.5 * h, self.middle);
        let end = look(h, self.end);
        if middle.1 <= edge && end.1 <= edge {
            return;
        }
        let start = look(0.0, &scene.segment.start);
        let bracket =
            if middle.1 > edge { Bracket::new(start, middle, end) } else { Bracket::new(middle, end, start) };
        let t = event.locate(scene, &bracket);
        if self.found.is_none_or(|(_, earliest)| t < earliest) {
            self.found = Some((event, t));
        }
    }
}
