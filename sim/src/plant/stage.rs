//! The continuous plant: circuit and shaft, advanced from one switching event to the next.

use super::angle::Rotation;
use super::booking::Book;
use super::circuit::{Circuit, Electric, Leg};
use super::config::{PlantConfig, SupplyConfig};
use super::course::Course;
use super::emf::EmfShape;
use super::gates::Gate;
use super::ledger::Ledger;
use super::mechanics::Shaft;
use super::network::Network;
use super::phase::Phase;

/// A current below this is none, A.
const CURRENT_ZERO: f64 = 1e-9;
/// A diode or the source turns on or off when its voltage is this far beyond, V. Keeps rounding from toggling
/// it.
pub(crate) const VOLTAGE_EDGE: f64 = 1e-7;

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
    pub(crate) held: [bool; 3],
    /// The last change was that a diode began to conduct.
    pub(crate) just_started: bool,
    pub(crate) source_on: bool,
    pub(crate) may_sink: bool,
    /// `circuit` is no longer that of `legs`.
    changed: bool,
    pub(crate) circuit: Circuit,
    pub(crate) ledger: Ledger,
    /// Largest magnitude of a phase current since it was last set to 0, A.
    pub(crate) peak: f64,
    stored_at_start: f64,
    /// Charge through the current shunt up to the last entry in the ledger, A s.
    pub(crate) shunt_charge: f64,
    pub(crate) book: Book,
    /// Torque impulse since it was last read, N m s.
    pub(crate) impulse: f64,
    /// Changes of diodes since the start.
    pub(crate) diode_events: u64,
    /// Intervals solved since the start, corrections included.
    pub(crate) intervals: u64,
    /// The rotor's electrical angle again, followed in small steps; only of a sinusoidal motor.
    pub(crate) rotation: Rotation,
    pub(crate) course: Course,
    /// Electrical torque at the end of the last interval, N m.
    pub(crate) torque: f64,
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
            just_started: false,
            source_on: true,
            may_sink: config.supply.may_sink,
            changed: true,
            circuit: Circuit::new(&[Leg::Idle; 3], inverter.diode_drop),
            ledger: Ledger::default(),
            peak: 0.0,
            stored_at_start: 0.0,
            shunt_charge: 0.0,
            book: Book::default(),
            impulse: 0.0,
            diode_events: 0,
            intervals: 0,
            rotation: Rotation::of(config.angle_deg / 360.0),
            course: Course::new(),
            torque: 0.0,
            against_mean: [[0.0; 3]; 2],
            watched: config.comparator.is_some(),
        };
        stage.stored_at_start = stage.stored();
        stage.limit_courses();
        stage
    }

    /// Star point, V.
    pub(crate) fn neutral(&self) -> f64 {
        Circuit::new(&self.legs, self.network.drop).neutral(
            &self.legs_emf(),
            self.electric.v,
            self.network.drop,
        )
    }

    /// Back-EMF of every leg now, V.
    pub(crate) fn legs_emf(&self) -> [f64; 3] {
        let (speed, course) = (self.speed(), &self.course);
        if course.elapsed == 0.0 {
            return self.shape.now(self.shaft.angle, &self.rotation).map(|shape| shape * speed);
        }
        let (turns, rotation) = (course.turns(&self.shaft, course.elapsed), course.rotation(course.elapsed));
        self.shape.now(turns, &rotation).map(|shape| shape * speed)
    }

    /// Mechanical speed now, rad/s.
    pub(crate) fn speed(&self) -> f64 {
        if self.course.elapsed == 0.0 { self.shaft.speed } else { self.course.speed() }
    }

    /// Sine and cosine of the electrical angle now.
    fn rotation_now(&self) -> Rotation {
        if self.course.elapsed == 0.0 { self.rotation } else { self.course.rotation(self.course.elapsed) }
    }

    /// A copy whose course ends now.
    pub(crate) fn arrived(&self) -> Self {
        let mut stage = self.clone();
        stage.arrive();
        stage
    }

    /// Brings `circuit` up to date.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn refresh(&mut self) {
        if self.changed {
            self.circuit.follow(&self.legs, self.network.drop);
            self.changed = false;
        }
    }

    #[inline]
    pub(crate) fn set_leg(&mut self, x: Phase, leg: Leg) {
        self.legs[x] = leg;
        self.changed = true;
    }

    /// Terminals less their mean now, V.
    #[inline(never)]
    pub(crate) fn less_mean(&self) -> [f64; 3] {
        let terminals = self.terminals();
        let mean = (terminals[0] + terminals[1] + terminals[2]) * (1.0 / 3.0);
        terminals.map(|terminal| terminal - mean)
    }

    /// Keeps rounding from adding up in what is followed in small steps; to be called now and then.
    pub(crate) fn straighten(&mut self) {
        self.arrive();
        self.rotation = Rotation::of(self.shaft.angle);
    }

    /// Terminal voltages now, V. A broken cable leaves the motor's side to the divider: it reads 0.
    pub(crate) fn terminals(&self) -> [f64; 3] {
        let (v, drop) = (self.electric.v, self.network.drop);
        let mut terminals = [0, 1, 2].map(|x| {
            let fall = self.network.switch * self.electric.i[x];
            match self.legs[x] {
                Leg::Idle => 0.0,
                Leg::HighSwitch => v - fall,
                Leg::LowSwitch => -fall,
                Leg::HighDiode => v + drop - fall,
                Leg::LowDiode => -drop - fall,
            }
        });
        if self.legs.contains(&Leg::Idle) {
            self.add_idle(&mut terminals);
        }
        terminals
    }

    #[inline(never)]
    fn add_idle(&self, terminals: &mut [f64; 3]) {
        let (v, drop) = (self.electric.v, self.network.drop);
        let wiring = self.circuit.wiring;
        if !self.changed && wiring.conducting == 2 && self.shape.is_sine() {
            let emf = self.shape.aside(wiring, &self.rotation_now()) * self.speed();
            let terminal = (wiring.high_share * v + self.circuit.drop_idle + emf).max(-drop).min(v + drop);
            for x in 0..3 {
                if self.legs[x] == Leg::Idle && !self.open[x] {
                    terminals[x] = terminal;
                }
            }
            return;
        }
        let emf = self.legs_emf();
        let neutral = if self.changed {
            Circuit::new(&self.legs, drop).neutral(&emf, v, drop)
        } else {
            self.circuit.neutral(&emf, v, drop)
        };
        for x in 0..3 {
            if self.legs[x] == Leg::Idle && !self.open[x] {
                terminals[x] = (neutral + emf[x]).max(-drop).min(v + drop);
            }
        }
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
        self.arrive();
        let before = self.shaft.energy();
        self.shaft.set_load(load);
        self.stored_at_start += self.shaft.energy() - before;
        self.limit_courses();
    }

    /// Gate signals from now on.
    pub(crate) fn set_gates(&mut self, gates: &[Gate; 3]) {
        for x in Phase::ALL {
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
                self.set_leg(x, leg);
                self.held[x] = false;
                if leg == Leg::Idle {
                    self.end_current(x);
                }
            }
        }
    }

    /// Turns the switch `gate` of `leg` on.
    #[inline]
    pub(crate) fn turn_on(&mut self, leg: Phase, gate: Gate) {
        if !self.open[leg] {
            self.set_leg(leg, if gate == Gate::High { Leg::HighSwitch } else { Leg::LowSwitch });
            self.held[leg] = false;
        }
    }

    /// True if the current of `leg` would certainly go on through the diode beside the switch `gate` for the
    /// next `h` seconds, whether that switch is on or off.
    pub(crate) fn stays(&self, leg: Phase, gate: Gate, h: f64) -> bool {
        let Network { drop, rate, per_l, .. } = self.network;
        let i = match gate {
            Gate::Low => self.electric.i[leg],
            Gate::High => -self.electric.i[leg],
            Gate::Off => return false,
        };
        if self.watched || self.open[leg] || i < CURRENT_ZERO {
            return false;
        }
        // All that may drive it towards zero: the largest line-to-line back-EMF, two drops, and the bus
        // unless all that conduct stay on the low side.
        let own = self.shape.line_peak() * self.shaft.speed.abs() + 2.0 * drop;
        let left = i * (1.0 - rate * h) - own * per_l * h;
        let bus = self.electric.v * per_l * h;
        left > bus || (left > 0.0 && gate == Gate::Low && !self.legs.iter().any(|leg| leg.side() == 1))
    }

    /// Adds the effect that the drop of a diode in `leg`, beside the switch `gate`, has on the currents in a
    /// dead time of `h` seconds: it is much shorter than L / R, so that it acts as a whole.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn drop_of_dead_time(&mut self, leg: Phase, gate: Gate, h: f64) {
        self.refresh();
        let wiring = self.circuit.wiring;
        if wiring.conducting < 2 {
            return;
        }
        let flux = if gate == Gate::High { self.network.drop * h } else { -self.network.drop * h };
        let step = flux * self.network.per_l;
        let i = &mut self.electric.i;
        let before = i[leg];
        // Of a unit step in one leg the mean is taken off all that conduct, because currents sum to zero.
        for x in 0..3 {
            i[x] -= step * wiring.mean[x];
        }
        i[leg] += step;
        self.ledger.diodes -= flux * 0.5 * (before + i[leg]);
        self.changed = true;
    }

    /// Breaks or mends cables.
    pub(crate) fn set_open(&mut self, open: [bool; 3]) {
        for x in Phase::ALL {
            if open[x] && !self.open[x] {
                let before = self.stored();
                self.set_leg(x, Leg::Idle);
                self.end_current(x);
                self.turn_diodes();
                self.ledger.arc += before - self.stored();
            }
        }
        self.open = open;
    }

    /// A current that has turned round at once goes through the other diode of its leg.
    fn turn_diodes(&mut self) {
        for x in Phase::ALL {
            if self.legs[x].is_diode() {
                self.set_leg(x, if self.electric.i[x] > 0.0 { Leg::LowDiode } else { Leg::HighDiode });
            }
        }
    }

    /// Leg `x` carries no current any more; the others still sum to zero.
    pub(crate) fn end_current(&mut self, x: Phase) {
        self.changed = true;
        let [y, z] = x.others();
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
                self.set_leg(other, Leg::Idle);
            }
        }
    }
}
