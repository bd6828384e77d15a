//! The continuous plant: circuit and shaft, advanced from one switching event to the next.

use super::config::{PlantConfig, SupplyConfig};
use super::emf::{EmfShape, Linear3};
use super::event::Event;
use super::gates::Gate;
use super::ledger::Ledger;
use super::mechanics::Shaft;
use super::network::Network;
use super::segment::{Electric, Leg, Segment};

/// Longest interval, s: half a period at 10 kHz, a tenth of the shortest L / R of common motors.
const INTERVAL_MAX: f64 = 50e-6;
/// Largest electrical angle of an interval, rad: the back-EMF is linear in it to 1e-3.
const ANGLE_MAX: f64 = 0.15;
/// A current below this is none, A.
const CURRENT_ZERO: f64 = 1e-9;
/// A diode or the source turns on or off when its voltage is this far beyond, V. Keeps rounding from toggling it.
pub(crate) const VOLTAGE_EDGE: f64 = 1e-7;
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
    stored_at_start: f64,
    /// Charge through the current shunt since it was last read, A s.
    pub(crate) shunt_charge: f64,
    /// Torque impulse since it was last read, N m s.
    pub(crate) impulse: f64,
    /// Changes of diodes since the start.
    pub(crate) diode_events: u64,
    /// Terminal voltages at the end of the last interval.
    pub(crate) terminals: [f64; 3],
    pub(crate) neutral: f64,
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
            stored_at_start: 0.0,
            shunt_charge: 0.0,
            impulse: 0.0,
            diode_events: 0,
            terminals: [0.0; 3],
            neutral: 0.0,
        };
        stage.stored_at_start = stage.stored();
        stage
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
        let h = limit.min(self.longest());
        let speed = self.shaft.predict(h);
        let span = speed * self.shaft.turns_per_radian() * h;
        let shape = self.shape.over(self.shaft.angle + 0.5 * span, span, h);
        let emf = Linear3 { start: shape.start.map(|k| k * speed), slope: shape.slope.map(|k| k * speed) };
        let segment = self.settle(emf);
        let half = self.network.decay(segment.topology, segment.source_on, 0.5 * h);
        let full = self.network.squared(segment.topology, segment.source_on, &half);
        let middle = segment.at(0.5 * h, &half);
        let end = segment.at(h, &full);
        match self.first_event(&segment, h, &middle, &end) {
            None => {
                self.commit(&segment, &shape, h, &middle, &end);
                h
            }
            Some((event, t)) if t > INSTANT => {
                let half = self.network.decay(segment.topology, segment.source_on, 0.5 * t);
                let full = self.network.squared(segment.topology, segment.source_on, &half);
                let (middle, end) = (segment.at(0.5 * t, &half), segment.at(t, &full));
                self.commit(&segment, &shape, t, &middle, &end);
                self.apply(event, false);
                t
            }
            Some((event, _)) => {
                self.apply(event, true);
                0.0
            }
        }
    }

    /// Longest interval that the approximations allow.
    fn longest(&self) -> f64 {
        let mut h = INTERVAL_MAX;
        let turns_per_second = self.shaft.speed * self.shaft.turns_per_radian();
        if turns_per_second != 0.0 {
            let rate = turns_per_second.abs();
            h = h.min(ANGLE_MAX / (2.0 * core::f64::consts::PI) / rate);
            if let Some(turns) = self.shape.turns_to_corner(self.shaft.angle, turns_per_second.signum()) {
                h = h.min(turns / rate);
            }
        }
        // While the source charges an empty capacitor, its loss needs a closer look.
        if self.source_on && self.network.source_v - self.electric.v > 2.0 {
            h = h.min(0.5 * self.network.c / self.network.source_g);
        }
        h
    }

    /// Turns diodes and source on or off until they agree with the voltages, and returns the circuit.
    fn settle(&mut self, emf: Linear3) -> Segment {
        self.settle_source();
        let mut segment = Segment::new(&self.network, self.legs, self.source_on, &self.electric, emf);
        // Each pass changes one diode; six are more than three legs can need.
        for _ in 0..6 {
            if !self.settle_diode(&segment) {
                break;
            }
            self.diode_events += 1;
            segment = Segment::new(&self.network, self.legs, self.source_on, &self.electric, emf);
        }
        segment
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
        let mut first: Option<(Event, f64)> = None;
        let mut consider = |event: Event, edge: f64| {
            let at_middle = event.beyond(segment, &self.network, 0.5 * h, middle);
            let bracket = if at_middle > edge {
                Some((0.0, event.beyond(segment, &self.network, 0.0, &self.electric), 0.5 * h, at_middle))
            } else {
                let at_end = event.beyond(segment, &self.network, h, end);
                (at_end > edge).then_some((0.5 * h, at_middle, h, at_end))
            };
            if let Some(bracket) = bracket {
                let t = event.locate(segment, &self.network, bracket);
                if first.is_none_or(|(_, earliest)| t < earliest) {
                    first = Some((event, t));
                }
            }
        };
        for x in 0..3 {
            if self.legs[x].is_diode() {
                consider(Event::Stops(x), 0.0);
            }
        }
        for event in self.starts(segment).into_iter().flatten() {
            consider(event, VOLTAGE_EDGE);
        }
        if !self.may_sink {
            if self.source_on {
                consider(Event::SourceStops, VOLTAGE_EDGE);
            } else {
                consider(Event::SourceStarts, VOLTAGE_EDGE);
            }
        }
        first
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

    /// Takes over the state after `h` seconds and books the energies.
    fn commit(&mut self, segment: &Segment, shape: &Linear3, h: f64, middle: &Electric, end: &Electric) {
        let start = self.electric;
        let (link, volt_seconds) = segment.integrals(&self.network, h, &start, end);
        self.shunt_charge += link + self.network.leak_g * volt_seconds;
        let simpson = Simpson { h, points: [&start, middle, end] };
        let impulse = simpson.impulse(shape);
        self.impulse += impulse;
        self.book(segment, &simpson, volt_seconds);
        self.electric = *end;
        let before = self.shaft.angle;
        let moved = self.shaft.turn(impulse, h);
        let ledger = &mut self.ledger;
        ledger.shaft += impulse * (self.shaft.angle - before) / (self.shaft.turns_per_radian() * h);
        ledger.friction += moved.friction;
        ledger.load += moved.load;
        self.held = [false; 3];
        self.neutral = segment.neutral(h, end.v, self.network.drop);
        for x in 0..3 {
            self.terminals[x] = segment.terminal(&self.network, x, h, end);
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
            let charge = network.source_g * (network.source_v * simpson.h - volt_seconds);
            ledger.source += network.source_v * charge;
            ledger.source_loss += network.source_g
                * simpson.integral(|at| {
                    let fall = network.source_v - at.v;
                    fall * fall
                });
        }
        if network.leak_g > 0.0 {
            ledger.leak += network.leak_g * simpson.integral(|at| at.v * at.v);
        }
    }
}

/// Simpson's rule over an interval.
struct Simpson<'a> {
    h: f64,
    points: [&'a Electric; 3],
}

impl Simpson<'_> {
    fn integral(&self, value: impl Fn(&Electric) -> f64) -> f64 {
        let [start, middle, end] = self.points;
        self.h * (1.0 / 6.0) * (value(start) + 4.0 * value(middle) + value(end))
    }

    /// Torque impulse, N m s: each phase's back-EMF per speed times its current.
    fn impulse(&self, shape: &Linear3) -> f64 {
        let [start, middle, end] = self.points;
        let mut sum = 0.0;
        for x in 0..3 {
            let first = shape.start[x];
            let rise = shape.slope[x] * self.h;
            sum += first * start.i[x] + 4.0 * (first + 0.5 * rise) * middle.i[x] + (first + rise) * end.i[x];
        }
        self.h * (1.0 / 6.0) * sum
    }
}
