//! The continuous plant: circuit and shaft, advanced from one switching event to the next.

use super::angle::{Rotation, Sweep};
use super::config::{PlantConfig, SupplyConfig};
use super::emf::{EmfShape, Linear3};
use super::event::{Event, First};
use super::gates::Gate;
use super::ledger::Ledger;
use super::mechanics::{Shaft, Turn};
use super::network::Network;
use super::segment::{Electric, Leg, Motion, Reduced, Segment, neutral};
use super::simpson::Simpson;
use super::wiring::Wiring;

/// Longest interval, s: a period at 10 kHz.
const INTERVAL_MAX: f64 = 100e-6;
/// Longest interval in time constants L / R: Simpson's rule gives losses to 1e-4 then.
const TIME_CONSTANTS_MAX: f64 = 0.35;
/// Largest electrical angle of an interval, turns (0.25 rad): the back-EMF is linear in it to 1e-3.
const ANGLE_MAX: f64 = 0.25 / (2.0 * core::f64::consts::PI);
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
    /// The rotor's electrical angle again, followed in small steps.
    rotation: Rotation,
    /// Of the last interval: which legs conducted, through which diodes; back-EMF (V) and bus voltage at its end.
    wiring: &'static Wiring,
    diodes: [f64; 3],
    emf: [f64; 3],
    v: f64,
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
            rotation: Rotation::of(config.angle_deg / 360.0),
            wiring: Wiring::of(&[Leg::Idle; 3]),
            diodes: [0.0; 3],
            emf: [0.0; 3],
            v: config.supply.voltage,
            against_mean: [[0.0; 3]; 2],
            watched: config.comparator.is_some(),
        };
        stage.stored_at_start = stage.stored();
        stage
    }

    /// Star point, V.
    pub(crate) fn neutral(&self) -> f64 {
        neutral(self.wiring, &self.diodes, &self.emf, self.v, self.network.drop)
    }

    /// Keeps rounding from adding up in what is followed in small steps; to be called now and then.
    pub(crate) fn straighten(&mut self) {
        self.rotation = Rotation::of(self.shaft.angle);
        self.shaft.straighten();
    }

    /// Terminal voltages now, V. A broken cable leaves the motor's side to the divider: it reads 0.
    pub(crate) fn terminals(&self) -> [f64; 3] {
        let (v, drop) = (self.electric.v, self.network.drop);
        let neutral = self.neutral();
        [0, 1, 2].map(|x| {
            let fall = self.network.switch * self.electric.i[x];
            match self.legs[x] {
                Leg::Idle if self.open[x] => 0.0,
                Leg::Idle => (neutral + self.emf[x]).clamp(-drop, v + drop),
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

    /// True if the current of `leg` would certainly go on through the diode beside the switch `gate` for the next `h`
    /// seconds, whether that switch is on or off.
    pub(crate) fn stays(&self, leg: usize, gate: Gate, h: f64) -> bool {
        let Network { drop, rate, per_l, .. } = self.network;
        let i = match gate {
            Gate::Low => self.electric.i[leg],
            Gate::High => -self.electric.i[leg],
            Gate::Off => return false,
        };
        if self.watched || self.open[leg] || i < CURRENT_ZERO {
            return false;
        }
        // All that may drive it towards zero: the largest line-to-line back-EMF, two drops, and the bus unless all that
        // conduct stay on the low side.
        let [a, b, c] = self.emf;
        let emf = a.max(b).max(c) - a.min(b).min(c);
        let all_low = gate == Gate::Low && Wiring::of(&self.legs).high_share == 0.0;
        let bus = if all_low { 0.0 } else { self.electric.v };
        let against = bus + emf + 2.0 * drop;
        i * (1.0 - rate * h) > against * per_l * h
    }

    /// What the drop of a diode in `leg`, beside the switch `gate`, does to the currents in a dead time of `h` seconds: it
    /// is much shorter than L / R, so that it acts as a whole.
    pub(crate) fn drop_of_dead_time(&mut self, leg: usize, gate: Gate, h: f64) {
        let sign = if gate == Gate::High { 1.0 } else { -1.0 };
        let wiring = Wiring::of(&self.legs);
        if wiring.conducting < 2 {
            return;
        }
        let step = sign * self.network.drop * h * self.network.per_l;
        let before = self.electric.i[leg];
        for x in 0..3 {
            self.electric.i[x] -= step * wiring.mean[x];
        }
        self.electric.i[leg] += step;
        self.ledger.diodes -= sign * self.network.drop * h * 0.5 * (before + self.electric.i[leg]);
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
        let mut motion = self.shaft.predict(self.longest(limit));
        for corrections in 0.. {
            self.intervals += 1;
            let rate = (motion.speed + 0.5 * motion.h * motion.acceleration) * self.shaft.turns_per_radian();
            let sweep = Sweep::new(&self.rotation, rate * motion.h);
            let shape = self.shape.over(self.shaft.angle, &sweep, rate, motion.h);
            self.settle_source();
            let mut segment = self.circuit(&shape, &motion);
            // Diodes turn on or off until they agree with the voltages: each pass changes one, six are more than three legs can
            // need.
            let mut passes = 6;
            while passes > 0 && self.settle_diode(&segment) {
                segment = self.circuit(&shape, &motion);
                self.diode_events += 1;
                passes -= 1;
            }
            let solved = self.solve(&segment, motion.h);
            if solved.h <= INSTANT {
                if let Some(event) = solved.event {
                    self.apply(event, true);
                }
                return 0.0;
            }
            let per_h = 1.0 / solved.h;
            let simpson = solved.simpson();
            let impulse = simpson.impulse(&solved.segment.shape);
            let expected = motion.speed + 0.5 * solved.segment.acceleration * solved.h;
            let turn = self.shaft.turn(impulse, (solved.h, per_h), expected);
            let mean = turn.path * per_h;
            if corrections == CORRECTIONS_MAX || (mean - expected).abs() * self.shape.peak() < EMF_ERROR {
                self.commit(&solved, per_h, impulse, &turn, &sweep);
                return solved.h;
            }
            // The shaft went faster or slower than the circuit was told: once more with what it did.
            motion.acceleration = 2.0 * (mean - motion.speed) * per_h;
            motion.per_inertia = 0.0;
            motion.h = motion.h.min(1.001 * solved.h);
        }
        0.0
    }

    #[inline(always)]
    fn circuit(&self, shape: &Linear3, motion: &Motion) -> Segment {
        Segment::new(&self.network, self.legs, self.source_on, &self.electric, shape, motion)
    }

    /// Solves the circuit over `h` seconds or to its first event.
    #[inline]
    fn solve<'a>(&self, segment: &'a Segment, h: f64) -> Solved<'a> {
        let (middle, end) = self.ends(segment, h);
        match self.first_event(segment, h, &middle, &end) {
            None => Solved { segment, h, middle, end, event: None },
            Some((event, t)) => {
                let (middle, end) = self.ends(segment, t);
                Solved { segment, h: t, middle, end, event: Some(event) }
            }
        }
    }

    /// State after half of `h` and after `h` seconds.
    #[inline]
    fn ends(&self, segment: &Segment, h: f64) -> (Reduced, Reduced) {
        let (topology, source_on) = (segment.topology(), segment.source_on);
        let half = self.network.decay(topology, source_on, 0.5 * h);
        let full = self.network.squared(topology, source_on, &half);
        (segment.at(&self.network, 0.5 * h, &half), segment.at(&self.network, h, &full))
    }

    /// Longest interval up to `limit` that the approximations allow.
    #[inline]
    fn longest(&self, limit: f64) -> f64 {
        let mut h = limit.min(INTERVAL_MAX).min(TIME_CONSTANTS_MAX * self.network.time_constant);
        let turns_per_second = self.shaft.speed * self.shaft.turns_per_radian();
        let rate = turns_per_second.abs();
        if rate * h > ANGLE_MAX {
            h = ANGLE_MAX / rate;
        }
        if !self.shape.is_sine()
            && rate > 0.0
            && let Some(turns) = self.shape.turns_to_corner(self.shaft.angle, turns_per_second.signum())
            && rate * h > turns
        {
            h = turns / rate;
        }
        h
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
    #[inline]
    fn settle_diode(&mut self, segment: &Segment) -> bool {
        let idle =
            segment.has_diodes && (0..3).any(|x| segment.diodes[x] != 0.0 && self.electric.i[x] == 0.0);
        (idle || self.outside(segment, 0.0, self.electric.v)) && self.change_diode(segment)
    }

    fn change_diode(&mut self, segment: &Segment) -> bool {
        for x in 0..3 {
            if segment.diodes[x] != 0.0 && self.electric.i[x] == 0.0 {
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
        if !self.outside(segment, 0.0, self.electric.v) {
            return false;
        }
        let mut most = (VOLTAGE_EDGE, None);
        for event in self.starts(segment).into_iter().flatten() {
            let excess = event.beyond(segment, &self.network, 0.0, &segment.start);
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
    #[inline]
    fn first_event(
        &self,
        segment: &Segment,
        h: f64,
        middle: &Reduced,
        end: &Reduced,
    ) -> Option<(Event, f64)> {
        let stops =
            segment.has_diodes && (segment.is_against_a_diode(middle) || segment.is_against_a_diode(end));
        let starts = segment.wiring.conducting < 3
            && (self.outside(segment, 0.5 * h, middle.v) || self.outside(segment, h, end.v));
        let source_v = self.network.source_v;
        let source = if self.source_on {
            !self.may_sink && middle.v.max(end.v) > source_v + VOLTAGE_EDGE
        } else {
            middle.v.min(end.v) < source_v - VOLTAGE_EDGE
        };
        if !(stops || starts || source) {
            return None;
        }
        let mut first = First { network: &self.network, segment, h, middle, end, found: None };
        if stops {
            (0..3).filter(|x| segment.diodes[*x] != 0.0).for_each(|x| first.consider(Event::Stops(x)));
        }
        if starts {
            self.starts(segment).into_iter().flatten().for_each(|event| first.consider(event));
        }
        if source {
            first.consider(if self.source_on { Event::SourceStops } else { Event::SourceStarts });
        }
        first.found
    }

    /// True if the terminal of any idle leg is outside the rails: a quick look before a close one.
    #[inline]
    fn outside(&self, segment: &Segment, t: f64, v: f64) -> bool {
        let edge = self.network.drop + VOLTAGE_EDGE;
        match segment.wiring.conducting {
            3 => return false,
            2 => {
                let terminal = segment.idle.0 + segment.idle.1 * t + segment.wiring.high_share * v;
                return terminal < -edge || terminal > v + edge;
            }
            _ => {}
        }
        let emf = [0, 1, 2].map(|x| segment.emf_at(x, t));
        if segment.is_tied() {
            let neutral = neutral(segment.wiring, &segment.diodes, &emf, v, self.network.drop);
            return (0..3).any(|x| {
                self.legs[x] == Leg::Idle && {
                    let terminal = neutral + emf[x];
                    terminal < -edge || terminal > v + edge
                }
            });
        }
        let [a, b, c] = emf;
        a.max(b).max(c) - a.min(b).min(c) > v + self.network.drop + edge
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
    #[inline]
    fn commit(&mut self, solved: &Solved, per_h: f64, impulse: f64, turn: &Turn, sweep: &Sweep) {
        let Solved { segment, h, end, event, .. } = solved;
        let before = self.electric;
        let (link, volt_seconds) = segment.integrals(&self.network, *h, end);
        self.shunt_charge += link + self.network.shunt_g * volt_seconds;
        self.impulse += impulse;
        self.book(segment, &solved.simpson(), per_h, volt_seconds);
        self.ledger.shaft += impulse * turn.path * per_h;
        self.ledger.friction += turn.friction;
        self.ledger.load += turn.load;
        let shape = &segment.shape;
        let torque = (shape.s + shape.s_slope * h) * end.s + (shape.d + shape.d_slope * h) * end.d;
        if self.shape.is_sine() {
            self.rotation = sweep.end(&self.rotation, self.shaft.electrical(turn));
        }
        self.shaft.apply(turn, torque);
        let i = segment.wiring.currents(end.s, end.d);
        // Between two switching events currents hardly bend: their extremes are at the events.
        self.peak = self.peak.max(i[0].abs()).max(i[1].abs()).max(i[2].abs());
        self.electric = Electric { i, v: end.v };
        self.held = [false; 3];
        (self.wiring, self.diodes, self.v) = (segment.wiring, segment.diodes, end.v);
        self.emf = [0, 1, 2].map(|x| segment.emf_at(x, *h));
        if self.watched {
            let less_mean = |t: f64, at: &Electric| {
                let terminals = [0, 1, 2].map(|x| segment.terminal(&self.network, x, t, at));
                let mean = (terminals[0] + terminals[1] + terminals[2]) * (1.0 / 3.0);
                terminals.map(|terminal| terminal - mean)
            };
            self.against_mean = [less_mean(0.0, &before), less_mean(*h, &self.electric)];
        }
        if let Some(event) = *event {
            self.apply(event, false);
        }
    }

    #[inline]
    fn book(&mut self, segment: &Segment, simpson: &Simpson, per_h: f64, volt_seconds: f64) {
        let network = &self.network;
        let ledger = &mut self.ledger;
        let wiring = segment.wiring;
        // along . along = 1 / k, across . across = 2.
        let along = if wiring.conducting == 3 { 1.5 } else { 2.0 };
        let squares = simpson.integral(|at| along * at.s * at.s + 2.0 * at.d * at.d);
        ledger.copper += network.copper * squares;
        ledger.switches += network.switch * squares;
        if segment.has_diodes {
            // A diode's drop is against its current.
            ledger.diodes -=
                segment.drop_s * simpson.integral(|at| at.s) + segment.drop_d * simpson.integral(|at| at.d);
        }
        if segment.source_on {
            let fall = network.source_v * simpson.h - volt_seconds;
            ledger.source += network.source_v * network.source_g * fall;
            let links = simpson.points.map(|at| segment.link(at));
            let [start, _, end] = simpson.points;
            ledger.source_loss += network.source_loss((simpson.h, per_h), (start.v, end.v), fall, links);
        }
        if network.leak_g > 0.0 {
            ledger.leak += network.leak_g * simpson.integral(|at| at.v * at.v);
        }
    }
}

/// One interval, solved.
struct Solved<'a> {
    segment: &'a Segment,
    h: f64,
    middle: Reduced,
    end: Reduced,
    /// What ended it early.
    event: Option<Event>,
}

impl Solved<'_> {
    #[inline]
    fn simpson(&self) -> Simpson<'_> {
        Simpson { h: self.h, points: [&self.segment.start, &self.middle, &self.end] }
    }
}
