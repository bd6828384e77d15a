//! What may end an interval: a diode or the source starts or stops conducting.

use super::network::Network;
use super::segment::{Electric, Leg, Segment};
use super::stage::VOLTAGE_EDGE;

/// A change of state inside an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Event {
    /// The current of a leg's diode reaches zero.
    Stops(usize),
    /// The terminal of an idle leg rises above the bus.
    HighStarts(usize),
    /// The terminal of an idle leg falls below ground.
    LowStarts(usize),
    /// With all legs idle: back-EMF from the second to the first exceeds the bus.
    PairStarts(usize, usize),
    /// The bus rises above the source.
    SourceStops,
    /// The bus falls below the source.
    SourceStarts,
}

impl Event {
    /// How far beyond the event the circuit is at `t`: negative before it, A or V.
    pub(crate) fn beyond(self, segment: &Segment, network: &Network, t: f64, at: &Electric) -> f64 {
        match self {
            Self::Stops(x) if segment.legs[x] == Leg::HighDiode => at.i[x],
            Self::Stops(x) => -at.i[x],
            Self::HighStarts(x) => {
                segment.neutral(t, at.v, network.drop) + segment.emf_at(x, t) - at.v - network.drop
            }
            Self::LowStarts(x) => {
                -network.drop - segment.neutral(t, at.v, network.drop) - segment.emf_at(x, t)
            }
            Self::PairStarts(x, y) => segment.emf_at(x, t) - segment.emf_at(y, t) - at.v - 2.0 * network.drop,
            Self::SourceStops => at.v - network.source_v,
            Self::SourceStarts => network.source_v - at.v,
        }
    }

    /// How far beyond counts, A or V: a current stops at zero, a voltage has to pass its edge.
    pub(crate) fn edge(self) -> f64 {
        if matches!(self, Self::Stops(_)) { 0.0 } else { VOLTAGE_EDGE }
    }

    /// The instant of the event inside `(lower, beyond there, upper, beyond there)`, on the far side of it. 0 if it has
    /// been reached at the start already.
    pub(crate) fn locate(self, segment: &Segment, network: &Network, bracket: (f64, f64, f64, f64)) -> f64 {
        let evaluate = |t: f64| {
            let decay = network.decay(segment.topology, segment.source_on, t);
            self.beyond(segment, network, t, &segment.at(t, &decay))
        };
        let edge = self.edge();
        let close = if edge == 0.0 { 1e-8 } else { 1e-5 };
        let (mut lower, mut f_lower, mut upper, mut f_upper) = bracket;
        f_lower -= edge;
        f_upper -= edge;
        if f_lower >= 0.0 {
            // It starts on the edge: is there a way off it before the way back?
            lower = 0.125 * upper;
            f_lower = evaluate(lower) - edge;
            if f_lower >= 0.0 {
                return 0.0;
            }
        }
        // False position; an end that stays when the other moves twice weighs half (the Illinois rule).
        let (mut weight_lower, mut weight_upper) = (f_lower, f_upper);
        for _ in 0..40 {
            if f_upper < close || upper - lower < 1e-11 {
                break;
            }
            let t = (lower * weight_upper - upper * weight_lower) / (weight_upper - weight_lower);
            let t = if t > lower && t < upper { t } else { 0.5 * (lower + upper) };
            let f = evaluate(t) - edge;
            if f >= 0.0 {
                weight_lower = if weight_upper == f_upper { weight_lower } else { 0.5 * weight_lower };
                (upper, f_upper, weight_upper) = (t, f, f);
            } else {
                weight_upper *= 0.5;
                (lower, weight_lower) = (t, f);
            }
        }
        upper
    }
}

/// The search for the first event of an interval.
pub(crate) struct First<'a> {
    pub(crate) network: &'a Network,
    pub(crate) segment: &'a Segment,
    pub(crate) h: f64,
    pub(crate) start: &'a Electric,
    pub(crate) middle: &'a Electric,
    pub(crate) end: &'a Electric,
    pub(crate) found: Option<(Event, f64)>,
}

impl First<'_> {
    pub(crate) fn consider(&mut self, event: Event) {
        let (network, h) = (self.network, self.h);
        let edge = event.edge();
        let at_middle = event.beyond(self.segment, network, 0.5 * h, self.middle);
        let bracket = if at_middle > edge {
            (0.0, event.beyond(self.segment, network, 0.0, self.start), 0.5 * h, at_middle)
        } else {
            let at_end = event.beyond(self.segment, network, h, self.end);
            if at_end <= edge {
                return;
            }
            (0.5 * h, at_middle, h, at_end)
        };
        let t = event.locate(self.segment, network, bracket);
        if self.found.is_none_or(|(_, earliest)| t < earliest) {
            self.found = Some((event, t));
        }
    }
}
