//! A commissioned drive on a bench with an operator at its master's place: what a notebook or a page plays with.

use crate::bench::{Bench, BenchConfig};
use crate::commissioning::{Commissioning, CommissioningError, Mode, Nameplate};
use crate::engineering::{self, ValueError};
use crate::operator::Operator;
use crate::plant::{LoadConfig, MotorConfig, PlantConfig, SupplyConfig};
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt;

/// What is on the bench, and how the drive is set up.
#[derive(Clone, Debug)]
pub struct SessionConfig {
    /// The motor.
    pub motor: MotorConfig,
    /// Its rated DC current, A; without it the drive's own 6 A are assumed.
    pub rated_current: Option<f64>,
    /// What it drives.
    pub load: LoadConfig,
    /// Supply voltage, V.
    pub supply: f64,
    /// Control mode.
    pub mode: Mode,
    /// Mechanical speed of open loop, rpm; without it the slowest closed-loop speed.
    pub open_loop_speed: Option<f64>,
    /// Parameters by number, in their units, that win over those of commissioning.
    pub parameters: Vec<(u16, f64)>,
    /// Ambient temperature, degrees Celsius.
    pub ambient: f64,
    /// Seed of all noise.
    pub seed: u64,
    /// Goes into recordings.
    pub label: String,
    /// Keep a row per tick.
    pub trace: bool,
}

impl SessionConfig {
    /// `motor` without load on a supply of `supply` volts, at 25 degrees Celsius, with a trace.
    pub const fn new(motor: MotorConfig, supply: f64, mode: Mode) -> Self {
        Self {
            motor,
            rated_current: None,
            load: LoadConfig { constant: 0.0, viscous: 0.0, quadratic: 0.0, inertia: 0.0 },
            supply,
            mode,
            open_loop_speed: None,
            parameters: Vec::new(),
            ambient: 25.0,
            seed: 1,
            label: String::new(),
            trace: true,
        }
    }

    /// The parameter set that the drive will have, and what limits it.
    ///
    /// # Errors
    /// A motor or supply that the drive cannot run, or a parameter that cannot have its value.
    pub fn commission(&self) -> Result<Commissioning, SessionError> {
        let motor = MotorConfig { inertia: self.motor.inertia + self.load.inertia, ..self.motor };
        let plate = Nameplate {
            motor,
            rated_current: self.rated_current,
            supply: self.supply,
            open_loop_speed: self.open_loop_speed,
        };
        let mut commissioning = plate.commission(self.mode)?;
        for (number, value) in &self.parameters {
            engineering::set(&mut commissioning.parameters, *number, *value)?;
        }
        Ok(commissioning)
    }
}

/// Why a session cannot be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SessionError {
    /// The motor cannot be commissioned.
    Commissioning(CommissioningError),
    /// A parameter cannot have its value.
    Parameter(ValueError),
}

impl From<CommissioningError> for SessionError {
    fn from(error: CommissioningError) -> Self {
        Self::Commissioning(error)
    }
}

impl From<ValueError> for SessionError {
    fn from(error: ValueError) -> Self {
        Self::Parameter(error)
    }
}

impl fmt::Display for SessionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Commissioning(error) => error.fmt(f),
            Self::Parameter(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for SessionError {}

/// A bench and its operator. Frames that the host receives are left for whoever looks at the bench.
#[derive(Debug)]
pub struct Session {
    bench: Bench,
    operator: Operator,
    commissioning: Commissioning,
}

impl Session {
    /// Powers up a commissioned drive. The operator asks for Standby.
    ///
    /// # Errors
    /// As [`SessionConfig::commission`].
    pub fn new(config: &SessionConfig) -> Result<Self, SessionError> {
        let commissioning = config.commission()?;
        let mut plant = PlantConfig::new(config.motor, config.supply);
        plant.load = config.load;
        plant.supply = SupplyConfig { voltage: config.supply, ..plant.supply };
        plant.ambient = config.ambient;
        plant.seed = config.seed;
        // No position is special; this one is not on a sector's edge.
        plant.angle_deg = 77.0;
        let bench = Bench::new(&BenchConfig {
            plant,
            parameters: commissioning.parameters.clone(),
            label: config.label.clone(),
            trace: config.trace,
        });
        let operator = Operator::new(bench.node().addresses());
        Ok(Self { bench, operator, commissioning })
    }

    /// One control tick; the operator's frames go out when they are due.
    pub fn step(&mut self) {
        while let Some(frame) = self.operator.poll(self.bench.now_ns()) {
            // Two frames every 50 ms do not fill a queue of 64.
            let _ = self.bench.send(frame);
        }
        self.bench.step();
    }

    /// As many ticks as `seconds` have, to the nearest; none for a negative number.
    pub fn run(&mut self, seconds: f64) {
        let ticks = libm::round(seconds * 1e9 / self.bench.period_ns() as f64) as u64;
        (0..ticks).for_each(|_| self.step());
    }

    /// The bench.
    pub const fn bench(&self) -> &Bench {
        &self.bench
    }

    /// The bench, to receive its frames, inject faults and change the load.
    pub const fn bench_mut(&mut self) -> &mut Bench {
        &mut self.bench
    }

    /// The operator: what the drive is asked for.
    pub const fn operator(&mut self) -> &mut Operator {
        &mut self.operator
    }

    /// The parameter set that the drive powered up with, and what limits it.
    pub const fn commissioning(&self) -> &Commissioning {
        &self.commissioning
    }
}
