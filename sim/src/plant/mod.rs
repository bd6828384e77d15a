//! The plant: motor, load, bridge, bus, supply and sensors, in the time of the PWM period.
//!
//! Every interval between two switching events is a linear circuit and is solved exactly (`interval`,
//! `segment`, `network`); diodes and the source change state at located instants (`diodes`, `event`); the
//! shaft is predicted and then settled over a period or two (`course`, `mechanics`). Per period:
//!
//! ```text
//!  period k   0 |========= sample() ========| finish_period() =====================| 1
//!               on-time ends                sample, step acts, commutations   on-time starts
//! ```
//!
//! Runs with the same seed and the same commands give the same bits on every platform: plain f64 arithmetic
//! and `libm`.
#![forbid(unsafe_code)]
#![allow(clippy::needless_range_loop, reason = "several arrays run in parallel over the three legs")]

mod angle;
mod booking;
mod changes;
mod circuit;
mod comparator;
mod config;
mod converter;
mod course;
mod diodes;
mod emf;
mod event;
mod exponential;
mod gated;
mod gates;
mod hall;
mod injection;
mod inputs;
mod interval;
mod ledger;
mod mechanics;
mod network;
mod phase;
mod segment;
mod stage;
mod way;
mod wiring;

pub use config::{
    BackEmf, ComparatorConfig, ConverterConfig, HallConfig, InverterConfig, LoadConfig, MotorConfig,
    PlantConfig, SupplyConfig,
};
pub use gated::{GatedPlant, HallEdge};
pub use gates::Gate;
pub use injection::{Injection, InjectionError, InjectionKind, InjectionOptions, InjectionValue};
pub use inputs::{Input, InputError};
pub use ledger::Ledger;
pub use phase::Phase;

use crate::random::Random;
use comparator::Comparators;
use converter::Converter;
use gates::Gates;
use hall::{Capture, Halls};
use injection::Injected;
use inputs::Inputs;
use narx_core::motor::{CurrentMode, Lines, PwmCommand, Samples};
use stage::Stage;

/// Less than this is no time, s.
const INSTANT: f64 = 1e-12;
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
    /// The rotor's angle, turns, up to which the sensors have followed it, and when that was, s.
    followed: (f64, f64),
    capture: Capture,
    captured: Capture,
    comparators: Option<Comparators>,
    converter: Converter,
    random: Random,
    injected: Injected,
    inputs: Inputs,
    winding_temperature: f64,
    copper_loss_seen: f64,
    last_sample: f64,
    last_charge: f64,
    /// At the start of this period, and of the one before.
    marks: [Marks; 2],
    peak_current: f64,
}

/// Sums at the start of a period.
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

/// Speed and angle of the shaft, as in [`Observation`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShaftState {
    /// Mechanical speed, rad/s.
    pub speed: f64,
    /// Electrical angle, turns, unwrapped.
    pub electrical_turns: f64,
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
            followed: (config.angle_deg / 360.0, 0.0),
            capture: Capture::default(),
            captured: Capture::default(),
            comparators: config.comparator.map(Comparators::new),
            converter: Converter::new(config.converter, &config.board.front_end),
            random: Random::new(config.seed),
            injected: Injected::default(),
            inputs: Inputs::new(),
            winding_temperature: config.ambient,
            copper_loss_seen: 0.0,
            last_sample: 0.0,
            last_charge: 0.0,
            marks: [Marks::default(); 2],
            peak_current: 0.0,
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
        let mut phases = self.stage.terminals();
        let skew = self.converter.skew();
        if skew > 0 {
            self.advance((self.t + self.instant(skew)).min(self.period));
            let last = self.stage.terminals();
            for x in 0..3 {
                phases[x] += (x + 1) as f64 * (1.0 / 3.0) * (last[x] - phases[x]);
            }
        }
        let now = self.tick as f64 * self.period + self.t;
        let charge = self.stage.charge();
        // The DC-link current is averaged by the amplifier's filter since the last reading.
        let elapsed = now - self.last_sample;
        let current = if elapsed > 0.0 { (charge - self.last_charge) / elapsed } else { 0.0 };
        (self.last_sample, self.last_charge) = (now, charge);
        let codes = self.converter.convert(bus, &phases, current, &mut self.random);
        Samples {
            tick: self.tick,
            phase_voltage: codes.phase_voltage,
            bus_voltage: codes.bus_voltage,
            bus_current: codes.bus_current,
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

    fn start_next_period(&mut self, command: &PwmCommand) {
        self.peak_current = core::mem::replace(&mut self.stage.peak, 0.0);
        self.marks = [
            Marks { charge: self.stage.charge(), impulse: self.stage.impulse + self.stage.course.impulse },
            self.marks[0],
        ];
        self.tick += 1;
        self.t = 0.0;
        self.followed.1 = 0.0;
        self.gates_until = self.gates.latch(command);
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
        let arrived;
        let stage = if self.stage.course.elapsed == 0.0 {
            &self.stage
        } else {
            arrived = self.stage.arrived();
            &arrived
        };
        Observation {
            time: self.time(),
            speed: stage.shaft.speed,
            angle: stage.shaft.mechanical_angle(),
            electrical_turns: stage.shaft.angle,
            current: self.current(),
            terminal: stage.terminals(),
            neutral: stage.neutral(),
            bus_voltage: self.bus_voltage(),
            bus_current: self.bus_current(),
            peak_current: self.peak_current(),
            torque: self.torque(),
            winding_temperature: self.winding_temperature(),
            ledger: Ledger { stored: stage.stored(), ..stage.ledger_now() },
            diode_events: stage.diode_events,
            intervals: stage.intervals,
        }
    }

    /// Time since the start, s.
    pub fn time(&self) -> f64 {
        self.tick as f64 * self.period + self.t
    }

    /// Phase currents into the motor, A.
    pub fn current(&self) -> [f64; 3] {
        self.stage.electric.i
    }

    /// Bus voltage, V.
    pub fn bus_voltage(&self) -> f64 {
        self.stage.electric.v
    }

    /// Current through the DC-link shunt, mean of the last full period, A.
    pub fn bus_current(&self) -> f64 {
        let [start, before] = self.marks;
        (start.charge - before.charge) / self.period
    }

    /// Largest magnitude of a phase current during the last full period, ripple included, A.
    pub fn peak_current(&self) -> f64 {
        self.peak_current
    }

    /// Electromagnetic torque without cogging, mean of the last full period, N m.
    pub fn torque(&self) -> f64 {
        let [start, before] = self.marks;
        (start.impulse - before.impulse) / self.period
    }

    /// Winding temperature, degrees Celsius.
    pub fn winding_temperature(&self) -> f64 {
        self.winding_temperature
    }

    /// Speed and angle of the shaft: a part of [`Plant::observe`] at a fraction of its cost.
    pub fn shaft(&self) -> ShaftState {
        let (speed, electrical_turns) = self.stage.shaft_now();
        ShaftState { speed, electrical_turns }
    }

    /// Back-EMF of the phases against the star point, V.
    pub fn back_emf(&self) -> [f64; 3] {
        self.stage.legs_emf()
    }

    /// Returns the switches that the gate signals of legs A, B and C call for now.
    pub fn gates(&self) -> [Gate; 3] {
        self.gates.asked()
    }

    /// Hall lines as they are wired: bit 0 = A, bit 1 = B, bit 2 = C.
    pub fn hall(&self) -> u8 {
        self.halls.code()
    }

    /// Number of the period.
    pub fn tick(&self) -> u64 {
        self.tick
    }

    /// Returns the configuration that it was built from, with every change since.
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

    /// Digital inputs as they stand.
    pub fn lines(&self) -> Lines {
        let mut injected = Lines::empty();
        injected.set(Lines::DRIVER_FAULT, self.injected.driver.contains(&true));
        injected.set(Lines::EMERGENCY, self.injected.emergency);
        injected.set(Lines::DSI1, self.injected.dsi1);
        injected.set(Lines::DSI2, self.injected.dsi2);
        injected | self.inputs.digital()
    }
}
