//! The plant: motor, load, bridge, bus, supply and sensors, in the time of the PWM period.
//!
//! Every interval between two switching events is a linear circuit and is solved exactly (`interval`, `segment`, `network`);
//! diodes and the source change state at located instants (`diodes`, `event`); the shaft is predicted and then settled
//! from stop to stop (`course`, `mechanics`). Per period:
//!
//! ```text
//!  period k   0 |========= sample() ========| finish_period() =====================| 1
//!               on-time ends                sample, step acts, commutations   on-time starts
//! ```
//!
//! The same seed and the same commands give the same bits on every platform: plain f64 arithmetic and `libm`.
#![forbid(unsafe_code)]
#![allow(clippy::needless_range_loop, reason = "several arrays run in parallel over the three legs")]

mod angle;
mod booking;
mod circuit;
mod comparator;
mod config;
mod converter;
mod course;
mod diodes;
mod emf;
mod event;
mod exponential;
mod gates;
mod hall;
mod injection;
mod interval;
mod ledger;
mod mechanics;
mod network;
mod segment;
mod slow;
mod stage;
mod wiring;

pub use config::{
    BackEmf, ComparatorConfig, ConverterConfig, HallConfig, InverterConfig, LoadConfig, MotorConfig,
    PlantConfig, SupplyConfig,
};
pub use injection::{Injection, Phase};
pub use ledger::Ledger;

use crate::random::Random;
use comparator::Comparators;
use converter::Converter;
use gates::Gates;
use hall::{Capture, Halls};
use injection::Injected;
use narx_core::motor::{CurrentMode, Lines, PwmCommand, Samples, Step};
use stage::Stage;

/// Temperature of the motor's data, degrees Celsius.
const REFERENCE_TEMPERATURE: f64 = 25.0;
/// Less than this is no time, s.
const INSTANT: f64 = 1e-12;
/// A dead time goes without an interval of its own if the current would outlast so many: a small one stops, and lets other
/// diodes conduct beside it.
const DEAD_TIME_MARGIN: f64 = 8.0;
/// Periods between two updates of what drifts with temperature.
const DRIFT_PERIODS: u64 = 128;

/// The plant.
#[derive(Clone, Debug)]
pub struct Plant {
    config: PlantConfig,
    period: f64,
    /// 65 536 / `period`.
    parts_per_second: f64,
    tick: u64,
    /// Instant inside the period, s.
    t: f64,
    gates: Gates,
    /// No gate changes before this instant of the period, s.
    gates_until: f64,
    command: PwmCommand,
    stage: Stage,
    halls: Halls,
    capture: Capture,
    captured: Capture,
    comparators: Option<Comparators>,
    converter: Converter,
    random: Random,
    injected: Injected,
    winding_temperature: f64,
    copper_loss_seen: f64,
    last_sample: f64,
    last_charge: f64,
    period_start: Marks,
    bus_current: f64,
    peak_current: f64,
    torque: f64,
}

/// Sums at the start of the period.
#[derive(Clone, Copy, Debug, Default)]
struct Marks {
    charge: f64,
    impulse: f64,
}

/// True values, which no drive sees.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Observation {
    /// Since the start, s.
    pub time: f64,
    /// Mechanical speed, rad/s.
    pub speed: f64,
    /// Mechanical angle, rad, unwrapped.
    pub angle: f64,
    /// Electrical angle, turns, unwrapped; 0 is the rising zero crossing of phase A's back-EMF.
    pub electrical_turns: f64,
    /// Phase currents into the motor, A.
    pub current: [f64; 3],
    /// Terminal voltages against ground, V.
    pub terminal: [f64; 3],
    /// Star point against ground, V.
    pub neutral: f64,
    /// Bus voltage, V.
    pub bus_voltage: f64,
    /// Largest magnitude of a phase current during the last full period, ripple included, A.
    pub peak_current: f64,
    /// Current through the DC-link shunt, mean of the last full period, A.
    pub bus_current: f64,
    /// Electromagnetic torque without cogging, mean of the last full period, N m.
    pub torque: f64,
    /// Winding temperature, degrees Celsius.
    pub winding_temperature: f64,
    /// Energies.
    pub ledger: Ledger,
    /// Changes of diodes since the start.
    pub diode_events: u64,
    /// Intervals solved since the start.
    pub intervals: u64,
}

impl Plant {
    /// A plant at the start of period 0, all switches off.
    pub fn new(config: &PlantConfig) -> Self {
        let period = 1.0 / f64::from(config.board.tick_rate);
        let mut plant = Self {
            period,
            parts_per_second: 65_536.0 / period,
            tick: 0,
            t: 0.0,
            gates: Gates::new(period, f64::from(config.board.dead_time_ns) * 1e-9),
            gates_until: 0.0,
            command: PwmCommand::default(),
            stage: Stage::new(config),
            halls: Halls::new(&config.hall, config.angle_deg / 360.0),
            capture: Capture::default(),
            captured: Capture::default(),
            comparators: config.comparator.map(Comparators::new),
            converter: Converter::new(config.converter, &config.board.front_end),
            random: Random::new(config.seed),
            injected: Injected::default(),
            winding_temperature: config.ambient,
            copper_loss_seen: 0.0,
            last_sample: 0.0,
            last_charge: 0.0,
            period_start: Marks::default(),
            bus_current: 0.0,
            peak_current: 0.0,
            torque: 0.0,
            config: config.clone(),
        };
        plant.apply_drift();
        plant.apply_injections();
        plant
    }

    /// Advances from the start of the period to its sampling instant and reads all inputs.
    pub fn sample(&mut self) -> Samples {
        self.advance(self.instant(self.gates.sample_at()));
        let bus = self.stage.electric.v;
        let first = self.stage.terminals();
        let skew = self.converter.skew();
        if skew > 0 {
            self.advance((self.t + self.instant(skew)).min(self.period));
        }
        let last = if skew > 0 { self.stage.terminals() } else { first };
        let now = self.tick as f64 * self.period + self.t;
        let charge = self.stage.shunt_charge;
        // The DC-link current is averaged by the amplifier's filter since the last reading.
        let elapsed = now - self.last_sample;
        let current = if elapsed > 0.0 { (charge - self.last_charge) / elapsed } else { 0.0 };
        (self.last_sample, self.last_charge) = (now, charge);
        let random = &mut self.random;
        let bus_voltage = self.converter.bus_voltage(bus, random);
        let mut phase_voltage = [0; 3];
        for (x, code) in phase_voltage.iter_mut().enumerate() {
            let part = (x + 1) as f64 * (1.0 / 3.0);
            *code = self.converter.phase_voltage(x, first[x] + part * (last[x] - first[x]), random);
        }
        Samples {
            tick: self.tick,
            phase_voltage,
            bus_voltage,
            bus_current: self.converter.bus_current(current, random),
            sample_mode: self.gates.sample_mode(),
            current_mode: CurrentMode::Average,
            skew,
            hall: self.halls.code(),
            edges: self.captured.edges.clone(),
            edges_lost: self.captured.lost,
            lines: self.lines(),
        }
    }

    /// Applies the answer to this period's samples and advances to the start of the next period.
    pub fn finish_period(&mut self, command: &PwmCommand) {
        let earliest = self.instant(self.config.board.earliest);
        self.advance_and_set(earliest, command.step);
        for commutation in command.commutations.iter() {
            self.advance_and_set(self.instant(commutation.instant).max(earliest), commutation.step);
        }
        self.advance(self.period);
        self.start_next_period(command);
    }

    /// A change to the same step needs no stop.
    fn advance_and_set(&mut self, instant: f64, step: Step) {
        if step != self.gates.step() {
            self.advance(instant);
            self.gates.set_step(step);
            self.gates_until = 0.0;
        }
    }

    fn start_next_period(&mut self, command: &PwmCommand) {
        let charge = self.stage.shunt_charge;
        let impulse = self.stage.impulse;
        self.peak_current = core::mem::replace(&mut self.stage.peak, 0.0);
        self.bus_current = (charge - self.period_start.charge) / self.period;
        self.torque = (impulse - self.period_start.impulse) / self.period;
        self.period_start = Marks { charge, impulse };
        self.tick += 1;
        self.t = 0.0;
        self.gates.latch(command);
        self.gates_until = 0.0;
        self.command = *command;
        if !self.config.board.hall_capture {
            self.capture = Capture::default();
        }
        if let Some(comparators) = &mut self.comparators {
            comparators.end_period(self.period, &mut self.capture);
        }
        core::mem::swap(&mut self.capture, &mut self.captured);
        self.capture = Capture::default();
        self.halls.start_period(&self.injected, self.period, &mut self.random);
        if self.tick.is_multiple_of(DRIFT_PERIODS) {
            self.warm(DRIFT_PERIODS as f64 * self.period);
            self.stage.straighten();
        }
    }

    /// The true values now.
    pub fn observe(&self) -> Observation {
        let stage = &self.stage;
        Observation {
            time: self.tick as f64 * self.period + self.t,
            speed: stage.shaft.speed,
            angle: stage.shaft.mechanical_angle(),
            electrical_turns: stage.shaft.angle,
            current: stage.electric.i,
            terminal: stage.terminals(),
            neutral: stage.neutral(),
            bus_voltage: stage.electric.v,
            bus_current: self.bus_current,
            peak_current: self.peak_current,
            torque: self.torque,
            winding_temperature: self.winding_temperature,
            ledger: Ledger { stored: stage.stored(), ..stage.ledger },
            diode_events: stage.diode_events,
            intervals: stage.intervals,
        }
    }

    /// Number of the period.
    pub fn tick(&self) -> u64 {
        self.tick
    }

    /// What it was built from, with every change since.
    pub fn config(&self) -> &PlantConfig {
        &self.config
    }

    /// The last command.
    pub fn command(&self) -> &PwmCommand {
        &self.command
    }

    /// Ambient temperature at the power board, degrees Celsius.
    pub fn ambient(&self) -> f64 {
        self.injected.ambient.unwrap_or(self.config.ambient)
    }

    /// Output of the pressure bridge after its amplifier, V.
    pub fn pressure(&self) -> f64 {
        self.injected.pressure.unwrap_or(self.config.pressure)
    }

    /// Changes the supply: voltage, source resistance, whether it takes current back.
    pub fn set_supply(&mut self, supply: SupplyConfig) {
        self.config.supply = supply;
        self.apply_supply();
    }

    /// Changes the load.
    pub fn set_load(&mut self, load: LoadConfig) {
        self.config.load = load;
        self.stage.set_load(load);
    }

    /// The load now.
    pub fn load(&self) -> LoadConfig {
        self.stage.shaft.load()
    }

    /// Changes the ambient temperature, degrees Celsius. The winding follows with its time constant.
    pub fn set_ambient(&mut self, celsius: f64) {
        self.config.ambient = celsius;
    }

    /// Changes the output of the pressure bridge, V.
    pub fn set_pressure(&mut self, volts: f64) {
        self.config.pressure = volts;
    }

    /// Brings winding and magnets to this temperature at once, degrees Celsius.
    pub fn set_winding_temperature(&mut self, celsius: f64) {
        self.winding_temperature = celsius;
        self.apply_drift();
    }

    /// Breaks something.
    pub fn inject(&mut self, injection: Injection) {
        self.set_injection(injection, true);
    }

    /// Mends what `injection` names; its value does not matter.
    pub fn clear(&mut self, injection: Injection) {
        self.set_injection(injection, false);
    }

    /// Mends everything.
    pub fn clear_all(&mut self) {
        self.injected = Injected::default();
        self.apply_injections();
    }

    fn set_injection(&mut self, injection: Injection, active: bool) {
        self.injected.set(injection, active);
        self.apply_injections();
    }

    fn apply_injections(&mut self) {
        self.gates_until = 0.0;
        self.stage.set_open(self.injected.open);
        self.stage.shaft.blocked = self.injected.blocked;
        let leak = self.injected.leak.map_or(0.0, |ohm| 1.0 / ohm.max(1e-3));
        self.stage.network.shunt_g = leak;
        self.stage.network.leak_g = leak + self.config.inverter.own_conductance;
        self.halls.rewire(self.t / self.period * 65_536.0, &self.injected, &mut self.capture);
        self.apply_supply();
    }

    fn apply_supply(&mut self) {
        let mut supply = self.config.supply;
        if let Some(voltage) = self.injected.supply {
            supply.voltage = voltage;
        }
        self.stage.set_supply(&supply);
    }

    fn instant(&self, part: u16) -> f64 {
        f64::from(part) * (1.0 / 65_536.0) * self.period
    }

    /// Digital inputs as they stand.
    pub fn lines(&self) -> Lines {
        let mut lines = Lines::empty();
        lines.set(Lines::DRIVER_FAULT, self.injected.driver.contains(&true));
        lines.set(Lines::EMERGENCY, self.injected.emergency);
        lines.set(Lines::DSI1, self.injected.dsi1);
        lines.set(Lines::DSI2, self.injected.dsi2);
        lines
    }

    /// Runs to `target`, s from the start of the period; nothing if that has passed.
    fn advance(&mut self, target: f64) {
        while target - self.t > INSTANT {
            let (from, before) = (self.t, self.stage.shaft.angle);
            let goal = from + self.stage.set_out(target - from);
            let goal = if target - goal > INSTANT { goal } else { target };
            while goal - self.t > INSTANT {
                self.run(goal);
            }
            self.stage.arrive();
            self.follow_halls(before, from);
        }
    }

    /// One interval of the stage, to `goal` at most.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn run(&mut self, goal: f64) {
        if self.t >= self.gates_until {
            self.switch(goal);
        }
        let mut stretched = None;
        let mut change = goal;
        if self.gates_until <= goal {
            change = self.gates_until;
            if change - self.t <= INSTANT {
                // A dead time that ends with the period is a rounding error away from its end.
                self.t = change;
                return;
            }
            stretched = self.gates.changing_sides(change).filter(|&(leg, gate, over)| {
                over <= goal && !self.injected.driver[leg] && self.stage.stays(leg, gate, over - self.t)
            });
        }
        let until = stretched.map_or(change, |(.., over)| over);
        let h = self.stage.interval(until - self.t);
        let from = self.t;
        self.t = if h >= until - from { until } else { from + h };
        if let Some((leg, gate, _)) = stretched
            && self.t > change
        {
            self.gates.turned_off(leg, change);
            self.gates_until = 0.0;
            self.stage.drop_of_dead_time(leg, gate, self.t - change);
        }
        if let Some(comparators) = &mut self.comparators
            && self.t > from
        {
            let [start, end] = &self.stage.against_mean;
            comparators.follow(&self.gates.floating(), start, end, from, self.t);
        }
    }

    /// Sets the gates for the time from now on. During a dead time the current leads through the diode beside the switch
    /// that was on, or beside the one that will be on: the circuit is then the same as with that switch, but for the
    /// diode's drop, and where nothing else can happen until `target` the dead time needs no interval of its own.
    fn switch(&mut self, target: f64) {
        let mut gates = self.gates.at(self.t, &self.injected.driver);
        if let Some((leg, gate, over)) = self.gates.waiting(self.t)
            && over <= target
            && self.stage.stays(leg, gate, DEAD_TIME_MARGIN * (over - self.t))
        {
            self.gates.turn_on(leg, gate);
            gates[leg] = gate;
            self.stage.set_gates(&gates);
            self.stage.drop_of_dead_time(leg, gate, over - self.t);
        } else {
            self.stage.set_gates(&gates);
        }
        self.gates_until = self.gates.next_change(self.t, f64::INFINITY);
    }

    fn follow_halls(&mut self, angle_before: f64, from: f64) {
        let per_period = self.parts_per_second;
        self.halls.follow(
            (angle_before, self.stage.shaft.angle),
            (from * per_period, self.t * per_period),
            &self.injected,
            &mut self.random,
            &mut self.capture,
        );
    }

    /// The winding's temperature after `seconds` with the copper loss since the last call.
    fn warm(&mut self, seconds: f64) {
        let motor = &self.config.motor;
        let loss = self.stage.ledger.copper - self.copper_loss_seen;
        self.copper_loss_seen = self.stage.ledger.copper;
        let ambient = self.ambient();
        if motor.thermal_resistance <= 0.0 {
            if self.winding_temperature == ambient {
                return;
            }
            self.winding_temperature = ambient;
        } else {
            let target = ambient + motor.thermal_resistance * loss / seconds;
            let part = (seconds / motor.thermal_time.max(seconds)).min(1.0);
            self.winding_temperature += part * (target - self.winding_temperature);
        }
        self.apply_drift();
    }

    fn apply_drift(&mut self) {
        let motor = &self.config.motor;
        let rise = self.winding_temperature - REFERENCE_TEMPERATURE;
        self.stage.network.copper = 0.5 * motor.resistance * (1.0 + motor.copper_drift * rise).max(0.1);
        self.stage.network.update();
        self.stage.shape.set_drift((1.0 + motor.magnet_drift * rise).max(0.1));
    }
}
