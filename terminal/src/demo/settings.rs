//! Settings of the demonstration, checked before anything runs or is written.

use crate::setup::{self, Refused, Setup, number};
use clap::{Args, Command, FromArgMatches};
use narx_core::commissioning::{Commissioning, Mode};
use narx_sim::session::SessionConfig;
use std::path::PathBuf;

/// Arguments of `demo`, as typed.
#[derive(Args, Debug)]
pub struct Arguments {
    /// Motor, mode, supply, PWM rate and load of the bench
    #[command(flatten)]
    pub bench: setup::Arguments,
    /// Mechanical speed, rpm; negative is Reverse [default: the middle of the motor's range]
    #[arg(long, allow_hyphen_values = true)]
    pub rpm: Option<String>,
    /// Number of TX-Drivers that measure the shaft on the drive's bus, 1 to 127, with the node-ids 1 to N;
    /// `drive` takes a list of node-ids instead
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    pub tx_drivers: Option<String>,
    /// Simulated time from power-up, s
    #[arg(long, allow_hyphen_values = true, default_value = "3")]
    pub seconds: String,
    /// Folder for run.svg, run.csv, run.log and run.narxrec
    #[arg(long, default_value = "target/demo")]
    pub out: PathBuf,
}

impl Arguments {
    /// Parses words as if typed after `demo`.
    pub(super) fn read(words: &[&str]) -> Result<Self, clap::Error> {
        let command = Self::augment_args(Command::new("demo").no_binary_name(true));
        Self::from_arg_matches(&command.try_get_matches_from(words)?)
    }
}

/// Checked settings.
#[derive(Debug)]
pub(super) struct Settings {
    setup: Setup,
    pub(super) mode: Mode,
    pub(super) rpm: i32,
    pub(super) seconds: f64,
    /// Number of TX-Drivers, with node-ids from 1.
    pub(super) tx_drivers: u8,
    pub(super) out: PathBuf,
    pub(super) commissioning: Commissioning,
    pub(super) session: SessionConfig,
}

/// Shortest and longest run, s: boot, start and a steady last quarter need about 1 s.
const SECONDS: (f64, f64) = (1.0, 60.0);

impl Settings {
    pub(super) fn new(arguments: &Arguments) -> Result<Self, Refused> {
        let setup = arguments.bench.check()?;
        let seconds = number("--seconds", &arguments.seconds, SECONDS.0, SECONDS.1, "s")?;
        let tx_drivers = arguments.tx_drivers.as_deref().map_or(Ok(0), tx_drivers)?;
        let (mode, mut session) = (setup.mode, setup.session.clone());
        let rpm = speed(arguments.rpm.as_deref(), mode, &setup.range)?;
        if mode == Mode::OpenLoop {
            session.open_loop_speed = Some(f64::from(rpm.abs()));
        }
        let commissioning = session.commission();
        let commissioning =
            commissioning.map_err(|error| Refused(format!("--motor {}: {error}", arguments.bench.motor)))?;
        let out = arguments.out.clone();
        let mut settings = Self { setup, mode, rpm, seconds, tx_drivers, out, commissioning, session };
        settings.session.label = settings.headline();
        Ok(settings)
    }

    /// Time at which the last quarter begins, over which steady figures are taken, s.
    pub(super) fn steady_start(&self) -> f64 {
        self.seconds * 0.75
    }

    pub(super) fn title(&self) -> &str {
        self.setup.title()
    }

    pub(super) fn subtitle(&self) -> String {
        format!("{}, {} rpm, {}", self.setup.mode_name(), self.rpm, self.setup.conditions())
    }

    pub(super) fn headline(&self) -> String {
        format!("{}: {}", self.title(), self.subtitle())
    }
}

fn tx_drivers(text: &str) -> Result<u8, Refused> {
    let count = text.parse().ok().filter(|count| (1..=127).contains(count));
    count.ok_or_else(|| {
        Refused(format!("--tx-drivers {text}: must be a whole number from 1 to 127, how many there are"))
    })
}

/// Checks the speed. Open loop turns a field: it may be as slow as 10 rpm, but no faster than twice the
/// slowest closed-loop speed.
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

    fn typed(words: &[&str]) -> Result<Settings, Refused> {
        Settings::new(&Arguments::read(&[&["--mode", "hall"], words].concat()).unwrap())
    }

    /// Every refusal names the argument, its value and the range, in one line.
    #[test]
    fn refusals() {
        let cases: [(&[&str], &str); 17] = [
            (
                &["--motor", "mn7005"],
                "--motor mn7005: unknown motor; a file of figures (.toml), or one of ec45",
            ),
            (&["--supply", "12"], "--supply 12: must be a number from 18 to 60 V"),
            (&["--supply", "nan"], "--supply nan: must be"),
            (&["--supply", "-18"], "--supply -18: must be"),
            (&["--seconds", "0.5"], "--seconds 0.5: must be a number from 1 to 60 s"),
            (&["--seconds", "inf"], "--seconds inf: must be"),
            (&["--load", "-1"], "--load -1: must be a number from 0 to"),
            (&["--load", "9"], "--load 9: must be"),
            (&["--tx-drivers", "0"], "--tx-drivers 0: must be a whole number from 1 to 127, how many"),
            (&["--tx-drivers", "128"], "--tx-drivers 128: must be"),
            (&["--tx-drivers", "2,5"], "--tx-drivers 2,5: must be"),
            (&["--rpm", "0"], "--rpm 0: must be a whole number from 250 to"),
            (&["--rpm", "-99999"], "--rpm -99999: must be"),
            (&["--rpm", "fast"], "--rpm fast: must be"),
            (&["--pwm-rate", "7999"], "--pwm-rate 7999: must be a whole number from 8000 to 50000 Hz"),
            (&["--pwm-rate", "-10000"], "--pwm-rate -10000: must be"),
            (&["--pwm-rate", "20e3"], "--pwm-rate 20e3: must be"),
        ];
        let unknown_mode = Settings::new(&Arguments::read(&["--mode", "foc"]).unwrap()).unwrap_err();
        assert_eq!(unknown_mode.to_string(), "--mode foc: unknown mode; one of sensorless, hall, open-loop");
        for (words, expected) in cases {
            let refused = typed(words).unwrap_err().to_string();
            assert!(refused.starts_with(expected), "{refused}");
            assert!(!refused.contains('\n'));
        }
    }

    /// The first line of the output, the picture and the recording name the PWM rate.
    #[test]
    fn the_pwm_rate_is_in_the_headline() {
        for (words, expected) in [
            (vec!["--rpm", "2000"], "hall closed loop, 2000 rpm, 18 V supply, 0 N m load, 20 kHz PWM"),
            (
                vec!["--rpm", "-900", "--load", "0.02", "--pwm-rate", "12500"],
                "hall closed loop, -900 rpm, 18 V supply, 0.02 N m load, 12.5 kHz PWM",
            ),
        ] {
            let settings = typed(&words).unwrap();
            assert_eq!(settings.subtitle(), expected);
            assert_eq!(settings.session.label, format!("{}: {expected}", settings.title()));
        }
    }

    #[test]
    fn reverse_is_a_negative_speed() {
        let settings = typed(&["--rpm", "-2000"]).unwrap();
        assert_eq!(settings.rpm, -2000);
        assert_eq!(settings.session.supply, 18.0);
    }
}
