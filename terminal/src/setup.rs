//! Set-up of the bench: motor, mode, supply, PWM rate and load, as typed and checked before anything runs.

use crate::motor::NamedMotor;
use clap::Args;
use narx_core::commissioning::{Commissioning, Mode};
use narx_core::motor::Board;
use narx_sim::session::{SessionConfig, parse_board};
use std::fmt;

/// Arguments of every command with a bench. Numbers are checked here, so that every refusal is one line.
// The structs that contain it already have a group of this name.
#[derive(Args, Clone, Debug)]
#[group(skip)]
pub struct Arguments {
    /// Name of a preset, or a file of figures (.toml), as the identification of a motor saves it
    #[arg(long, default_value = "ec45-flat-50w-18v")]
    pub motor: String,
    /// Control mode: sensorless, hall or open-loop
    #[arg(long, default_value = "sensorless")]
    pub mode: String,
    /// Supply voltage, V [default: the preset's nominal voltage; 48 for a file]
    #[arg(long, allow_hyphen_values = true)]
    pub supply: Option<String>,
    /// PWM frequency, Hz; every period has one control tick
    #[arg(long, allow_hyphen_values = true, default_value = "20000")]
    pub pwm_rate: String,
    /// Load torque on the shaft, N m
    #[arg(long, allow_hyphen_values = true, default_value = "0")]
    pub load: String,
}

/// A checked set-up of a bench.
#[derive(Debug)]
pub(crate) struct Setup {
    title: String,
    pub(crate) mode: Mode,
    pub(crate) supply: f64,
    pub(crate) load: f64,
    /// Range of the motor within the drive's limits.
    pub(crate) range: Commissioning,
    pub(crate) session: SessionConfig,
}

/// Reason for a refusal in one line: the argument, its value and the allowed values.
#[derive(Debug, PartialEq)]
pub(crate) struct Refused(pub(crate) String);

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Refused {}

impl Arguments {
    pub(crate) fn check(&self) -> Result<Setup, Refused> {
        let named = NamedMotor::find(&self.motor)?;
        let mode = mode(&self.mode)?;
        let supply = match &self.supply {
            Some(text) => number("--supply", text, 18.0, 60.0, "V")?,
            None => named.nominal_voltage.clamp(18.0, 60.0),
        };
        let mut session = SessionConfig::new(named.motor, supply, mode);
        session.rated_current = named.rated_current;
        session.speed_max = named.speed_max;
        session.hall_offset_deg = named.hall_offset_deg;
        session.board = board(&self.pwm_rate)?;
        let range = session.commission();
        let range = range.map_err(|error| Refused(format!("--motor {}: {error}", self.motor)))?;
        let torque = range.phase_current * named.motor.torque_constant;
        let load = number("--load", &self.load, 0.0, (torque * 1e4).floor() / 1e4, "N m")?;
        session.load.constant = load;
        Ok(Setup { title: named.title, mode, supply, load, range, session })
    }
}

impl Setup {
    pub(crate) fn title(&self) -> &str {
        &self.title
    }

    pub(crate) fn mode_name(&self) -> &'static str {
        match self.mode {
            Mode::Hall => "hall closed loop",
            Mode::Sensorless => "sensorless closed loop",
            Mode::OpenLoop => "open loop",
        }
    }

    /// Returns supply, load and PWM frequency, for titles.
    pub(crate) fn conditions(&self) -> String {
        let pwm_rate = f64::from(self.session.board.tick_rate) / 1e3;
        format!("{} V supply, {} N m load, {pwm_rate} kHz PWM", self.supply, self.load)
    }
}

/// Returns the board with this PWM rate.
fn board(pwm_rate: &str) -> Result<Board, Refused> {
    parse_board(pwm_rate).map_err(|error| Refused(format!("--pwm-rate {pwm_rate}: {error}")))
}

fn mode(name: &str) -> Result<Mode, Refused> {
    match name {
        "hall" => Ok(Mode::Hall),
        "open-loop" => Ok(Mode::OpenLoop),
        "sensorless" => Ok(Mode::Sensorless),
        _ => Err(Refused(format!("--mode {name}: unknown mode; one of sensorless, hall, open-loop"))),
    }
}

/// Parses a finite number within `min..=max`.
pub(crate) fn number(argument: &str, text: &str, min: f64, max: f64, unit: &str) -> Result<f64, Refused> {
    let value = text.parse::<f64>().ok().filter(|value| (min..=max).contains(value));
    value.ok_or_else(|| Refused(format!("{argument} {text}: must be a number from {min} to {max} {unit}")))
}
