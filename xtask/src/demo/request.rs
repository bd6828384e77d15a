//! What was asked for, checked before anything runs or is written.

use clap::{Args, Command, FromArgMatches};
use narx_sim::commissioning::{Commissioning, Mode};
use narx_sim::presets::{PRESETS, Preset, preset};
use narx_sim::session::SessionConfig;
use std::fmt;
use std::path::PathBuf;

/// Arguments of `demo`, as typed: numbers are checked here, so that every refusal is one line.
#[derive(Args, Debug)]
pub struct Arguments {
    /// Motor preset
    #[arg(long, default_value = "ec45-flat-50w-18v")]
    pub motor: String,
    /// Control mode: sensorless, hall or open-loop
    #[arg(long, default_value = "sensorless")]
    pub mode: String,
    /// Mechanical speed, rpm; negative is Reverse [default: the middle of the motor's range]
    #[arg(long, allow_hyphen_values = true)]
    pub rpm: Option<String>,
    /// Supply voltage, V [default: the motor's nominal voltage]
    #[arg(long, allow_hyphen_values = true)]
    pub supply: Option<String>,
    /// Load torque on the shaft, N m
    #[arg(long, allow_hyphen_values = true, default_value = "0")]
    pub load: String,
    /// Simulated time from power-up, s
    #[arg(long, allow_hyphen_values = true, default_value = "3")]
    pub seconds: String,
    /// Where run.svg, run.csv, run.log and run.narxrec go
    #[arg(long, default_value = "target/demo")]
    pub out: PathBuf,
}

impl Arguments {
    /// As if typed behind `demo`.
    pub(super) fn read(words: &[&str]) -> Result<Self, clap::Error> {
        let command = Self::augment_args(Command::new("demo").no_binary_name(true));
        Self::from_arg_matches(&command.try_get_matches_from(words)?)
    }
}

/// A run that can be.
#[derive(Debug)]
pub(super) struct Request {
    pub(super) preset: &'static Preset,
    pub(super) mode: Mode,
    pub(super) rpm: i32,
    pub(super) supply: f64,
    pub(super) load: f64,
    pub(super) seconds: f64,
    pub(super) out: PathBuf,
    pub(super) commissioning: Commissioning,
    pub(super) session: SessionConfig,
}

/// Why it cannot be: names the argument, its value and what is allowed, in one line.
#[derive(Debug, PartialEq)]
pub(super) struct Refused(String);

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Refused {}

/// Boot, start and a steady quarter need about this long, s.
const SECONDS: (f64, f64) = (1.0, 60.0);

impl Request {
    pub(super) fn new(arguments: &Arguments) -> Result<Self, Refused> {
        let preset = preset(&arguments.motor).ok_or_else(|| unknown_motor(&arguments.motor))?;
        let mode = mode(&arguments.mode)?;
        let nominal = preset.data.nominal_voltage.clamp(18.0, 60.0);
        let supply = match &arguments.supply {
            Some(text) => number("--supply", text, 18.0, 60.0, "V")?,
            None => nominal,
        };
        let seconds = number("--seconds", &arguments.seconds, SECONDS.0, SECONDS.1, "s")?;
        let mut session = SessionConfig::new(preset.motor, supply, mode);
        session.rated_current = preset.data.rated_current;
        let refuse = |error: &dyn fmt::Display| Refused(format!("--motor {}: {error}", preset.name));
        let range = session.commission().map_err(|error| refuse(&error))?;
        let rpm = speed(arguments.rpm.as_deref(), mode, &range)?;
        if mode == Mode::OpenLoop {
            session.open_loop_speed = Some(f64::from(rpm.abs()));
        }
        let commissioning = session.commission().map_err(|error| refuse(&error))?;
        let torque = commissioning.phase_current * preset.motor.torque_constant;
        let load = number("--load", &arguments.load, 0.0, (torque * 1e4).floor() / 1e4, "N m")?;
        session.load.constant = load;
        let out = arguments.out.clone();
        let mut request = Self { preset, mode, rpm, supply, load, seconds, out, commissioning, session };
        request.session.label = request.headline();
        Ok(request)
    }

    /// When the last quarter begins, over which steady figures are taken, s.
    pub(super) fn steady_start(&self) -> f64 {
        self.seconds * 0.75
    }

    pub(super) fn title(&self) -> String {
        format!("{} {}", self.preset.maker, self.preset.part)
    }

    pub(super) fn subtitle(&self) -> String {
        let mode = match self.mode {
            Mode::Hall => "hall closed loop",
            Mode::Sensorless => "sensorless closed loop",
            Mode::OpenLoop => "open loop",
        };
        format!("{mode}, {} rpm, {} V supply, {} N m load", self.rpm, self.supply, self.load)
    }

    pub(super) fn headline(&self) -> String {
        format!("{}: {}", self.title(), self.subtitle())
    }
}

fn unknown_motor(name: &str) -> Refused {
    let names: Vec<&str> = PRESETS.iter().map(|preset| preset.name).collect();
    Refused(format!("--motor {name}: unknown motor; one of {}", names.join(", ")))
}

fn mode(name: &str) -> Result<Mode, Refused> {
    match name {
        "hall" => Ok(Mode::Hall),
        "open-loop" => Ok(Mode::OpenLoop),
        "sensorless" => Ok(Mode::Sensorless),
        _ => Err(Refused(format!("--mode {name}: unknown mode; one of sensorless, hall, open-loop"))),
    }
}

/// A finite number within `min..=max`.
fn number(argument: &str, text: &str, min: f64, max: f64, unit: &str) -> Result<f64, Refused> {
    let value = text.parse::<f64>().ok().filter(|value| (min..=max).contains(value));
    value.ok_or_else(|| Refused(format!("{argument} {text}: must be a number from {min} to {max} {unit}")))
}

/// Open loop turns a field: as slow as one likes, and no faster than twice the slowest closed-loop speed.
fn speed(text: Option<&str>, mode: Mode, range: &Commissioning) -> Result<i32, Refused> {
    let (min, max) = match mode {
        Mode::OpenLoop => (10.0, (2.0 * range.speed_min).min(range.speed_max)),
        _ => (range.speed_min, range.speed_max),
    };
    let (min, max) = (min.ceil() as i32, max.floor() as i32);
    let Some(text) = text else { return Ok((min + max) / 2) };
    let value = text.parse::<i32>().ok().filter(|value| (min..=max).contains(&value.saturating_abs()));
    value.ok_or_else(|| {
        Refused(format!("--rpm {text}: must be a whole number from {min} to {max} rpm, or from -{max} to -{min} for Reverse"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arguments() -> Arguments {
        Arguments {
            motor: "ec45-flat-50w-18v".into(),
            mode: "hall".into(),
            rpm: None,
            supply: None,
            load: "0".into(),
            seconds: "3".into(),
            out: "out".into(),
        }
    }

    /// Every refusal names the argument, its value and the range, in one line.
    #[test]
    fn refusals() {
        let cases: [(Arguments, &str); 11] = [
            (
                Arguments { motor: "mn7005".into(), ..arguments() },
                "--motor mn7005: unknown motor; one of ec45",
            ),
            (
                Arguments { mode: "foc".into(), ..arguments() },
                "--mode foc: unknown mode; one of sensorless, hall",
            ),
            (
                Arguments { supply: Some("12".into()), ..arguments() },
                "--supply 12: must be a number from 18 to 60 V",
            ),
            (Arguments { supply: Some("nan".into()), ..arguments() }, "--supply nan: must be"),
            (
                Arguments { seconds: "0.5".into(), ..arguments() },
                "--seconds 0.5: must be a number from 1 to 60 s",
            ),
            (Arguments { seconds: "inf".into(), ..arguments() }, "--seconds inf: must be"),
            (Arguments { load: "-1".into(), ..arguments() }, "--load -1: must be a number from 0 to"),
            (Arguments { load: "9".into(), ..arguments() }, "--load 9: must be"),
            (
                Arguments { rpm: Some("0".into()), ..arguments() },
                "--rpm 0: must be a whole number from 250 to",
            ),
            (Arguments { rpm: Some("-99999".into()), ..arguments() }, "--rpm -99999: must be"),
            (Arguments { rpm: Some("fast".into()), ..arguments() }, "--rpm fast: must be"),
        ];
        for (arguments, expected) in cases {
            let refused = Request::new(&arguments).unwrap_err().to_string();
            assert!(refused.starts_with(expected), "{refused}");
            assert!(!refused.contains('\n'));
        }
    }

    #[test]
    fn reverse_is_a_negative_speed() {
        let request = Request::new(&Arguments { rpm: Some("-2000".into()), ..arguments() }).unwrap();
        assert_eq!(request.rpm, -2000);
        assert_eq!(request.supply, 18.0);
    }
}
