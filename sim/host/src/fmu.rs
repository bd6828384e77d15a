//! A drive with its motor as a model of FMI 2 and 3 (Functional Mock-up Interface), co-simulation: variables
//! by their value references, and steps of time. `python/fmu` exports it as C functions; `narx/fmu.py` packs
//! it.

use crc::{CRC_64_XZ, Crc};
use narx_core::dictionary::Parameters;
use narx_core::master::SpeedLimits;
use narx_sim::bench::SIGNALS;
use narx_sim::plant::{Injection, LoadConfig};
use narx_sim::session::{Session, SessionConfig};
use std::ops::RangeInclusive;

/// Role of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Causality {
    /// Time.
    Independent,
    /// Set by the importer.
    Input,
    /// Computed by the model.
    Output,
}

/// Type of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// 64-bit float.
    Real,
    /// 32-bit integer.
    Integer,
    /// Boolean.
    Boolean,
}

/// A variable of the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variable {
    /// Value reference.
    pub reference: u32,
    /// Name: an output's is that of the signal in a trace.
    pub name: &'static str,
    /// Unit; empty for plain numbers.
    pub unit: &'static str,
    /// Role.
    pub causality: Causality,
    /// Type.
    pub kind: Kind,
    /// Value of an input until it is set.
    pub start: f64,
}

/// Signals that are numbers of something.
const CODES: [&str; 7] = ["state", "sector", "hall", "step", "limiter", "faults", "crossing"];
// Value references of the inputs; an output's is its place among `SIGNALS`, of which the first is time.
const RUN: u32 = 100;
const SPEED_REQUEST: u32 = 101;
const LOAD_TORQUE: u32 = 102;
const MACHINE_TORQUE: u32 = 103;
const SUPPLY_VOLTAGE: u32 = 104;

/// Inputs, in the order of their value references.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Inputs {
    run: bool,
    speed_request: f64,
    load_torque: f64,
    machine_torque: f64,
    supply_voltage: f64,
}

impl Inputs {
    fn of(config: &SessionConfig) -> Self {
        Self {
            run: false,
            speed_request: 0.0,
            load_torque: config.load.constant,
            machine_torque: config.load.machine,
            supply_voltage: config.supply,
        }
    }
}

/// The variables of a model that was made with this configuration: outputs, then inputs.
pub fn variables(config: &SessionConfig) -> Vec<Variable> {
    let output = |(reference, signal): (u32, &narx_sim::trace::Signal)| Variable {
        reference,
        name: signal.name,
        unit: signal.unit,
        causality: if reference == 0 { Causality::Independent } else { Causality::Output },
        kind: if CODES.contains(&signal.name) { Kind::Integer } else { Kind::Real },
        start: 0.0,
    };
    let inputs = Inputs::of(config);
    let rows = [
        (RUN, "run", "", Kind::Boolean, 0.0),
        (SPEED_REQUEST, "speed_request", "rpm", Kind::Real, inputs.speed_request),
        (LOAD_TORQUE, "load_torque", "N m", Kind::Real, inputs.load_torque),
        (MACHINE_TORQUE, "machine_torque", "N m", Kind::Real, inputs.machine_torque),
        (SUPPLY_VOLTAGE, "supply_voltage", "V", Kind::Real, inputs.supply_voltage),
    ];
    let inputs = rows.into_iter().map(|(reference, name, unit, kind, start)| Variable {
        reference,
        name,
        unit,
        causality: Causality::Input,
        kind,
        start,
    });
    (0..).zip(&SIGNALS).map(output).chain(inputs).collect()
}

/// Writes a configuration as the file from which [`Model::new`] is made.
pub fn written(config: &SessionConfig) -> String {
    // Numbers, texts and lists of these: nothing that cannot be written.
    serde_json::to_string_pretty(config).unwrap_or_default()
}

/// Token that ties a model's description to its file.
pub fn token(file: &str) -> String {
    format!("{{{:016x}}}", Crc::<u64>::new(&CRC_64_XZ).checksum(file.as_bytes()))
}

/// A drive with its motor, from power-up on. A copy is the whole model as it stands.
#[derive(Clone)]
pub struct Model {
    config: SessionConfig,
    session: Session,
    inputs: Inputs,
    /// Inputs that the session has been told.
    applied: Inputs,
    /// Time of the importer at power-up, s.
    begin: f64,
    ticks: u64,
}

impl Model {
    /// Powers up the drive that a file describes.
    ///
    /// # Errors
    /// A file that is none, or a drive that cannot be commissioned.
    pub fn new(file: &str) -> Result<Self, String> {
        let config: SessionConfig =
            serde_json::from_str(file).map_err(|error| format!("the file of the drive: {error}"))?;
        Self::powered_up(config)
    }

    fn powered_up(config: SessionConfig) -> Result<Self, String> {
        let session = Session::new(&config).map_err(|error| error.to_string())?.without_recording();
        let inputs = Inputs::of(&config);
        Ok(Self { config, session, inputs, applied: inputs, begin: 0.0, ticks: 0 })
    }

    /// Powers the drive up anew; its inputs have their first values again.
    ///
    /// # Errors
    /// None after a first power-up with the same file.
    pub fn reset(&mut self) -> Result<(), String> {
        *self = Self::powered_up(self.config.clone())?;
        Ok(())
    }

    /// States the importer's time at power-up, s.
    ///
    /// # Errors
    /// A time that is not finite.
    pub fn begin(&mut self, time: f64) -> Result<(), String> {
        if !time.is_finite() {
            return Err(format!("start time {time} s: must be a finite number"));
        }
        self.begin = time;
        Ok(())
    }

    /// Returns the value of a variable by its value reference, a Boolean as 0 or 1; `None` for a reference
    /// that no variable has.
    pub fn value(&self, reference: u32) -> Option<f64> {
        let Inputs { run, speed_request, load_torque, machine_torque, supply_voltage } = self.inputs;
        match reference {
            0 => Some(self.time()),
            RUN => Some(f64::from(u8::from(run))),
            SPEED_REQUEST => Some(speed_request),
            LOAD_TORQUE => Some(load_torque),
            MACHINE_TORQUE => Some(machine_torque),
            SUPPLY_VOLTAGE => Some(supply_voltage),
            place => self.session.bench().values().get(place as usize).copied(),
        }
    }

    /// Sets an input, a Boolean as 0 or 1.
    ///
    /// # Errors
    /// A reference that no input has, or a value out of range.
    pub fn set(&mut self, reference: u32, value: f64) -> Result<(), String> {
        let load = LoadConfig::MAX;
        let inputs = &mut self.inputs;
        let (place, name, unit, range) = match reference {
            RUN => {
                inputs.run = value != 0.0;
                return Ok(());
            }
            SPEED_REQUEST => (&mut inputs.speed_request, "speed_request", "rpm", -RPM_MAX..=RPM_MAX),
            LOAD_TORQUE => (&mut inputs.load_torque, "load_torque", "N m", 0.0..=load),
            MACHINE_TORQUE => (&mut inputs.machine_torque, "machine_torque", "N m", -load..=load),
            SUPPLY_VOLTAGE => (&mut inputs.supply_voltage, "supply_voltage", "V", supply()),
            _ => return Err(format!("value reference {reference}: there is no such input")),
        };
        if !range.contains(&value) {
            let (min, max) = range.into_inner();
            return Err(format!("{name} {value} {unit}: must be a number from {min} to {max} {unit}"));
        }
        *place = value;
        Ok(())
    }

    /// Runs the control ticks up to `time + length`, to the nearest, with the inputs as they are now.
    ///
    /// # Errors
    /// A time that is not where the model stands, to a tick; a length that is no time; a set-point that the
    /// drive would clamp. Nothing has run then.
    pub fn step(&mut self, time: f64, length: f64) -> Result<(), String> {
        let rate = f64::from(self.config.board.tick_rate);
        let now = self.time();
        // Less than a tick from it; a time that is no number is not.
        if !(now - 1.0 / rate..=now + 1.0 / rate).contains(&time) {
            return Err(format!("communication point {time} s: the model stands at {now} s"));
        }
        if !(length.is_finite() && length >= 0.0) {
            return Err(format!("communication step size {length} s: must be a finite number, 0 or more"));
        }
        self.apply()?;
        let end = ((time + length - self.begin) * rate).round() as u64;
        while self.ticks < end {
            self.session.step();
            self.ticks += 1;
        }
        Ok(())
    }

    /// Time of the importer, s.
    fn time(&self) -> f64 {
        self.begin + self.session.bench().time()
    }

    /// Tells the session which inputs have changed.
    fn apply(&mut self) -> Result<(), String> {
        let (inputs, before) = (self.inputs, self.applied);
        if (inputs.run, inputs.speed_request) != (before.run, before.speed_request) {
            self.command(before)?;
        }
        let plant = self.session.bench_mut().plant_mut();
        if (inputs.load_torque, inputs.machine_torque) != (before.load_torque, before.machine_torque) {
            let Inputs { load_torque: constant, machine_torque: machine, .. } = inputs;
            plant.set_load(LoadConfig { constant, machine, ..self.config.load });
        }
        if inputs.supply_voltage != before.supply_voltage {
            let voltage = inputs.supply_voltage;
            plant.set_supply(narx_sim::plant::SupplyConfig { voltage, ..plant.config().supply });
        }
        self.applied = inputs;
        Ok(())
    }

    /// Starts or stops the motor, or changes its speed. The bus has whole rpm.
    fn command(&mut self, before: Inputs) -> Result<(), String> {
        let rpm = self.inputs.speed_request.round() as i32;
        if !self.inputs.run {
            self.session.stop();
            return Ok(());
        }
        let parameters: &Parameters = self.session.bench().node().parameters();
        let limits = SpeedLimits::of(|number| parameters.value(number)).unwrap_or(SpeedLimits::WIRE);
        match limits.check(rpm) {
            // Open loop has one speed, whatever is requested.
            Err(refused) if !refused.is_fixed() => return Err(format!("speed_request: {refused}")),
            _ => {}
        }
        let same_way = rpm.signum() == before.speed_request.signum() as i32;
        if before.run && same_way {
            self.session.set_speed(rpm.unsigned_abs().min(u32::from(u16::MAX)) as u16);
        } else {
            self.session.start(rpm);
        }
        Ok(())
    }
}

/// Largest set-point on the bus, rpm.
const RPM_MAX: f64 = u16::MAX as f64;

/// Supply voltages of a bench, V.
fn supply() -> RangeInclusive<f64> {
    let kind = Injection::KINDS.iter().find(|kind| kind.name == "supply");
    kind.and_then(|kind| kind.value).map_or(0.0..=f64::MAX, |value| value.min..=value.max)
}
