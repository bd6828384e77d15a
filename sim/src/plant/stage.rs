//! The continuous plant: circuit and shaft, advanced from one switching event to the next.

use super::config::{PlantConfig, SupplyConfig};
use super::emf::{EmfShape, Linear3};
use super::event::{Event, First};
use super::gates::Gate;
use super::ledger::Ledger;
use super::mechanics::{Shaft, Turn};
use super::network::Network;
use super::segment::{Electric, Leg, Motion, Segment};
use super::simpson::Simpson;

/// Longest interval, s: a period at 10 kHz.
const INTERVAL_MAX: f64 = 100e-6;
/// Longest interval in time constants L / R: Simpson's rule gives losses to 1e-4 then.
const TIME_CONSTANTS_MAX: f64 = 0.35;
/// Largest electrical angle of an interval, rad: the back-EMF is linear in it to 1e-3.
const ANGLE_MAX: f64 = 0.25;
/// A current below this is none, A.
const CURRENT_ZERO: f64 = 1e-9;
/// A diode or the source turns on or off when its voltage is this far beyond, V. Keeps rounding from toggling it.
pub(crate) const VOLTAGE_EDGE: f64 = 1e-7;
/// Largest error of a phase's back-EMF because the speed was predicted wrongly, V.
const EMF_ERROR: f64 = 1e-3;
/// Attempts to get below it.
const CORRECTIONS_MAX: u32 = 3;
/// Shorter intervals are none, s.
const INSTANT: f64 = 1e-13;

/// Circuit and shaft.
#[derive(Clone, Debug)]
pub(crate) struct Stage {
    pub(crate) network: Network,
    pub(crate) shape: EmfShape,
    pub(crate) shaft: Shaft,
    pub(crate) electric: Electric,
    pub(crate) legs: [Leg; 3],
    pub(crate) open: [bool; 3],
    /// A diode that would not conduct although it was let: idle until the next interval has passed.
    held: [bool; 3],
    source_on: bool,
    may_sink: bool,
    pub(crate) ledger: Ledger,
    /// Largest magnitude of a phase current since it was last set to 0, A.
    pub(crate) peak: f64,
    stored_at_start: f64,
    /// Charge through the current shunt since it was last read, A s.
    pub(crate) shunt_charge: f64,
    /// Torque impulse since it was last read, N m s.
    pub(crate) impulse: f64,
    /// Changes of diodes since the start.
    pub(crate) diode_events: u64,
    /// Intervals solved since the start, corrections included.
    pub(crate) intervals: u64,
    /// Star point and back-EMF at the end of the last interval, V.
    pub(crate) neutral: f64,
    emf: [f64; 3],
    /// Terminals less their mean at start and end of the last interval, V; kept up only while `watched`.
    pub(crate) against_mean: [[f64; 3]; 2],
    pub(crate) watched: bool,
}

impl Stage {
    pub(crate) fn new(config: &PlantConfig) -> Self {
        let motor = &config.motor;
        let inverter = &config.inverter;
        let network = Network::new(
            0.5 * motor.resistance,
            0.5 * motor.inductance,
            inverter.on_resistance,
            inverter.diode_drop,
            inverter.capacitance,
            &config.supply,
        );
        let shaft = Shaft::new(motor, config.load, config.angle_deg / 360.0, config.speed);
        let mut stage = Self {
            network,
            shape: EmfShape::new(motor),
            shaft,
            electric: Electric { i: [0.0; 3], v: config.supply.voltage },
            legs: [Leg::Idle; 3],
            open: [false; 3],
            held: [false; 3],
            source_on: true,
            may_sink: config.supply.may_sink,
            ledger: Ledger::default(),
            peak: 0.0,
            stored_at_start: 0.0,
            shunt_charge: 0.0,
            impulse: 0.0,
            diode_events: 0,
            intervals: 0,
            neutral: 0.0,
            emf: [0.0; 3],
            against_mean: [[0.0; 3]; 2],
            watched: config.comparator.is_some(),
        };
        stage.stored_at_start = stage.stored();
        stage
    }

    /// Terminal voltages now, V. A broken cable leaves the motor's side to the divider: it reads 0.
    pub(crate) fn terminals(&self) -> [f64; 3] {
        let (v, drop) = (self.electric.v, self.network.drop);
        [0, 1, 2].map(|x| {
            let fall = self.network.switch * self.electric.i[x];
            match self.legs[x] {
                Leg::Idle if self.open[x] => 0.0,
                Leg::Idle => (self.neutral + self.emf[x]).clamp(-drop, v + drop),
                Leg::HighSwitch => v - fall,
                Leg::LowSwitch => -fall,
                Leg::HighDiode => v + drop - fall,
                Leg::LowDiode => -drop - fall,
            }
        })
    }

    /// Energy in capacitor, inductances and shaft, J.
    pub(crate) fn stored(&self) -> f64 {
        let Electric { i, v } = self.electric;
        let squares = i[0] * i[0] + i[1] * i[1] + i[2] * i[2];
        0.5 * self.network.c * v * v + 0.5 * self.network.l * squares + self.shaft.energy()
            - self.stored_at_start
    }

    /// Changes the supply; its capacitor stays.
    pub(crate) fn set_supply(&mut self, supply: &SupplyConfig) {
        self.network.source_v = supply.voltage;
        self.network.source_g = 1.0 / supply.resistance.max(SupplyConfig::RESISTANCE_MIN);
        self.may_sink = supply.may_sink;
        self.network.update();
    }

    /// Changes the load; energy that a new inertia brings along is not created by the plant.
    pub(crate) fn set_load(&mut self, load: super::LoadConfig) {
        let before = self.shaft.energy();
        self.shaft.set_load(load);
        self.stored_at_start += self.shaft.energy() - before;
    }

    /// Gate signals from now on.
    pub(crate) fn set_gates(&mut self, gates: &[Gate; 3]) {
        for x in 0..3 {
            let leg = match gates[x] {
                _ if self.open[x] => Leg::Idle,
                Gate::High => Leg::HighSwitch,
                Gate::Low => Leg::LowSwitch,
                // The current goes on through the diode that leads it.
                Gate::Off if self.legs[x] == Leg::Idle || self.legs[x].is_diode() => continue,
                Gate::Off if self.electric.i[x] > CURRENT_ZERO => Leg::LowDiode,
                Gate::Off if self.electric.i[x] < -CURRENT_ZERO => Leg::HighDiode,
                Gate::Off => Leg::Idle,
            };
            if leg != self.legs[x] {
                self.legs[x] = leg;
                self.held[x] = false;
                if leg == Leg::Idle {
                    self.end_current(x);
                }
            }
        }
    }

    /// Breaks or mends cables.
    pub(crate) fn set_open(&mut self, open: [bool; 3]) {
        for x in 0..3 {
            if open[x] && !self.open[x] {
                let before = self.stored();
                self.legs[x] = Leg::Idle;
                self.end_current(x);
                self.ledger.arc += before - self.stored();
            }
        }
        self.open = open;
    }

    /// Leg `x` carries no current any more; the others still sum to zero.
    fn end_current(&mut self, x: usize) {
        let (y, z) = ((x + 1) % 3, (x + 2) % 3);
        let i = &mut self.electric.i;
        let left = 0.5 * (i[y] - i[z]);
        *i = [0.0; 3];
        if self.legs[y] != Leg::Idle && self.legs[z] != Leg::Idle {
            i[y] = left;
            i[z] = -left;
            return;
        }
        // One leg alone has no return path.
        for other in [y, z] {
            if self.legs[other].is_diode() {
                self.legs[other] = Leg::Idle;
            }
        }
    }

    /// Advances by `limit` seconds or less, to the next event at most. Returns by how much.
    pub(crate) fn interval(&mut self, limit: f64) -> f64 {
        let mut motion = self.shaft.predict(limit.min(self.longest()));
        for corrections in 0.. {
            let solved = self.solve(&motion);
            if solved.h <= INSTANT {
                if let Some(event) = solved.event {
                    self.apply(event, true);
                }
                return 0.0;
            }
            let simpson = Simpson { h: solved.h, points: [&self.electric, &solved.middle, &solved.end] };
            let impulse = simpson.impulse(&solved.shape);
            let expected = motion.speed + 0.5 * solved.segment.acceleration * solved.h;
            let turn = self.shaft.turn(impulse, solved.h, expected);
            let mean = turn.path / solved.h;
            if corrections == CORRECTIONS_MAX || (mean - expected).abs() * self.shape.peak() < EMF_ERROR {
                self.commit(&solved, impulse, &turn);
                return solved.h;
            }
            // The shaft went faster or slower than the circuit was told: once more with what it did.
            motion.acceleration = 2.0 * (mean - motion.speed) / solved.h;
            motion.per_inertia = 0.0;
            motion.h = motion.h.min(1.001 * solved.h);
        }
        0.0
    }

    /// Solves the circuit over `motion`'s interval or to its first event.
    #[inline]
    fn solve(&mut self, motion: &Motion) -> Solved {
        self.intervals += 1;
        let h = motion.h;
        let span = (motion.speed + 0.5 * h * motion.acceleration) * self.shaft.turns_per_radian() * h;
        let shape = self.shape.over(self.shaft.angle + 0.5 * span, span, h);
        let segment = self.settle(&shape, motion);
        let (middle, end) = self.ends(&segment, h);
        match self.first_event(&segment, h, &middle, &end) {
            None => Solved { segment, shape, h, middle, end, event: None },
            Some((event, t)) => {
                let (middle, end) = self.ends(&segment, t);
                Solved { segment, shape, h: t, middle, end, event: Some(event) }
            }
        }
    }

    /// State after half of `h` and after `h` seconds.
    fn ends(&self, segment: &Segment, h: f64) -> (Electric, Electric) {
        let half = self.network.decay(segment.topology, segment.source_on, 0.5 * h);
        let full = self.network.squared(segment.topology, segment.source_on, &half);
        (segment.at(0.5 * h, &half), segment.at(h, &full))
    }

    /// Longest interval that the approximations allow.
    fn longest(&self) -> f64 {
        let mut h = INTERVAL_MAX.min(TIME_CONSTANTS_MAX * self.network.l / self.network.r);
        let turns_per_second = self.shaft.speed * self.shaft.turns_per_radian();
        if turns_per_second != 0.0 {
            let rate = turns_per_second.abs();
            h = h.min(ANGLE_MAX / (2.0 * core::f64::consts::PI) / rate);
            if let Some(turns) = self.shape.turns_to_corner(self.shaft.angle, turns_per_second.signum()) {
                h = h.min(turns / rate);
            }
        }
        h
    }

    /// Turns diodes and source on or off until they agree with the voltages, and returns the circuit.
    fn settle(&mut self, shape: &Linear3, motion: &Motion) -> Segment {
        self.settle_source();
        // Each pass changes one diode; six are more than three legs can need.
        let mut passes = 6;
        loop {
            let segment =
                Segment::new(&self.network, self.legs, self.source_on, &self.electric, shape, motion);
            if passes == 0 || !self.settle_diode(&segment) {
                return segment;
            }
            self.diode_events += 1;
            passes -= 1;
        }
    }

    fn settle_source(&mut self) {
        let excess = self.electric.v - self.network.source_v;
        if self.may_sink || excess < -VOLTAGE_EDGE {
            self.source_on = true;
        } else if excess > VOLTAGE_EDGE {
            self.source_on = false;
        }
    }

    /// Turns the diode on that is most in need of it, or a currentless one off. False if all agree.
    fn settle_diode(&mut self, segment: &Segment) -> bool {
        for x in 0..3 {
            if self.legs[x].is_diode() && self.electric.i[x] == 0.0 {
                let slope = segment.slope_from_rest(&self.network, x, self.electric.v);
                let conducts = if self.legs[x] == Leg::HighDiode { slope < 0.0 } else { slope > 0.0 };
                if !conducts {
                    self.legs[x] = Leg::Idle;
                    self.held[x] = true;
                    self.end_current(x);
                    return true;
                }
            }
        }
        if !self.outside(segment, 0.0, &self.electric) {
            return false;
        }
        let mut most = (VOLTAGE_EDGE, None);
        for event in self.starts(segment).into_iter().flatten() {
            let excess = event.beyond(segment, &self.network, 0.0, &self.electric);
            if excess > most.0 {
                most = (excess, Some(event));
            }
        }
        match most.1 {
            Some(event) => {
                self.start_diodes(event);
                true
            }
            None => false,
        }
    }

    /// Diodes that could start to conduct.
    fn starts(&self, segment: &Segment) -> [Option<Event>; 6] {
        let mut events = [None; 6];
        if segment.is_tied() {
            for x in 0..3 {
                if self.legs[x] == Leg::Idle && !self.open[x] && !self.held[x] {
                    events[2 * x] = Some(Event::HighStarts(x));
                    events[2 * x + 1] = Some(Event::LowStarts(x));
                }
            }
        } else {
            let mut next = 0;
            for x in 0..3 {
                for y in 0..3 {
                    if x != y && !(self.open[x] || self.open[y] || self.held[x] || self.held[y]) {
                        events[next] = Some(Event::PairStarts(x, y));
                        next += 1;
                    }
                }
            }
        }
        events
    }

    fn start_diodes(&mut self, event: Event) {
        match event {
            Event::HighStarts(x) => self.legs[x] = Leg::HighDiode,
            Event::LowStarts(x) => self.legs[x] = Leg::LowDiode,
            Event::PairStarts(x, y) => {
                self.legs[x] = Leg::HighDiode;
                self.legs[y] = Leg::LowDiode;
            }
            _ => {}
        }
    }

    /// What happens first within `h` seconds, and when.
    fn first_event(
        &self,
        segment: &Segment,
        h: f64,
        middle: &Electric,
        end: &Electric,
    ) -> Option<(Event, f64)> {
        let mut first =
            First { network: &self.network, segment, h, start: &self.electric, middle, end, found: None };
        for x in 0..3 {
            match self.legs[x] {
                Leg::HighDiode if middle.i[x] > 0.0 || end.i[x] > 0.0 => first.consider(Event::Stops(x)),
                Leg::LowDiode if middle.i[x] < 0.0 || end.i[x] < 0.0 => first.consider(Event::Stops(x)),
                _ => {}
            }
        }
        let may_start = self.outside(segment, 0.5 * h, middle) || self.outside(segment, h, end);
        if may_start {
            for event in self.starts(segment).into_iter().flatten() {
                first.consider(event);
            }
        }
        let source_v = self.network.source_v;
        if self.source_on && !self.may_sink && middle.v.max(end.v) > source_v + VOLTAGE_EDGE {
            first.consider(Event::SourceStops);
        }
        if !self.source_on && middle.v.min(end.v) < source_v - VOLTAGE_EDGE {
            first.consider(Event::SourceStarts);
        }
        first.found
    }

    /// True if the terminal of any idle leg is outside the rails: a quick look before a close one.
    fn outside(&self, segment: &Segment, t: f64, at: &Electric) -> bool {
        let edge = self.network.drop + VOLTAGE_EDGE;
        if segment.is_tied() {
            let neutral = segment.neutral(t, at.v, self.network.drop);
            return (0..3).any(|x| {
                self.legs[x] == Leg::Idle && {
                    let terminal = neutral + segment.emf_at(x, t);
                    terminal < -edge || terminal > at.v + edge
                }
            });
        }
        let [a, b, c] = [0, 1, 2].map(|x| segment.emf_at(x, t));
        a.max(b).max(c) - a.min(b).min(c) > at.v + self.network.drop + edge
    }

    /// Makes `event` happen. One that comes without any delay holds its leg for an interval.
    fn apply(&mut self, event: Event, at_once: bool) {
        match event {
            Event::Stops(x) => {
                self.legs[x] = Leg::Idle;
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

    /// Takes over what was solved, books the energies and lets the event happen.
    fn commit(&mut self, solved: &Solved, impulse: f64, turn: &Turn) {
        let Solved { segment, shape, h, middle, end, event } = solved;
        let start = self.electric;
        let (link, volt_seconds) = segment.integrals(&self.network, *h, &start, end);
        self.shunt_charge += link + self.network.shunt_g * volt_seconds;
        self.impulse += impulse;
        self.book(segment, &Simpson { h: *h, points: [&start, middle, end] }, volt_seconds);
        // Between two switching events currents hardly bend: their extremes are at the events.
        self.peak = end.i.iter().fold(self.peak, |peak, i| peak.max(i.abs()));
        self.ledger.shaft += impulse * turn.path / h;
        self.ledger.friction += turn.friction;
        self.ledger.load += turn.load;
        let torque_at = |x: usize| (shape.start[x] + shape.slope[x] * h) * end.i[x];
        self.shaft.apply(turn, torque_at(0) + torque_at(1) + torque_at(2));
        self.electric = *end;
        self.held = [false; 3];
        self.neutral = segment.neutral(*h, end.v, self.network.drop);
        self.emf = [0, 1, 2].map(|x| segment.emf_at(x, *h));
        if self.watched {
            let less_mean = |t: f64, at: &Electric| {
                let terminals = [0, 1, 2].map(|x| segment.terminal(&self.network, x, t, at));
                let mean = (terminals[0] + terminals[1] + terminals[2]) * (1.0 / 3.0);
                terminals.map(|terminal| terminal - mean)
            };
            self.against_mean = [less_mean(0.0, &start), less_mean(*h, end)];
        }
        if let Some(event) = *event {
            self.apply(event, false);
        }
    }

    fn book(&mut self, segment: &Segment, simpson: &Simpson, volt_seconds: f64) {
        let network = &self.network;
        let ledger = &mut self.ledger;
        let squares = simpson.integral(|at| at.i[0] * at.i[0] + at.i[1] * at.i[1] + at.i[2] * at.i[2]);
        ledger.copper += network.copper * squares;
        ledger.switches += network.switch * squares;
        for x in 0..3 {
            if segment.legs[x].is_diode() {
                ledger.diodes += network.drop * simpson.integral(|at| at.i[x]).abs();
            }
        }
        if segment.source_on {
            let fall = network.source_v * simpson.h - volt_seconds;
            ledger.source += network.source_v * network.source_g * fall;
            let links = simpson.points.map(|at| segment.link(at));
            ledger.source_loss +=
                network.source_loss(simpson.h, simpson.points[0].v, simpson.points[2].v, fall, links);
        }
        if network.leak_g > 0.0 {
            ledger.leak += network.leak_g * simpson.integral(|at| at.v * at.v);
        }
    }
}

/// One interval, solved.
struct Solved {
    segment: Segment,
    /// Back-EMF per speed.
    shape: Linear3,
    h: f64,
    middle: Electric,
    end: Electric,
    /// What ended it early.
    event: Option<Event>,
}
