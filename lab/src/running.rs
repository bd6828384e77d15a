//! The demonstration's motor in steady running: recordings whose ticks are counted, made on the bench when
//! they are needed.

use narx_core::commissioning::Mode;
use narx_core::motor::State;
use narx_report::{figures, steps};
use narx_sim::plant::{Injection, Phase};
use narx_sim::session::{Session, SessionConfig};
use narx_terminal::demo;
use serde::Serialize;
use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Simulated time from power-up to the end, s.
const SECONDS: f64 = 3.0;
/// Largest difference from the set-point at the end, as a share of it.
const TOLERANCE: f64 = 0.02;

/// File beside the recordings that describes them.
const FILE: &str = "running.json";

/// One motor at one set-point in hall mode, and without sensors.
#[derive(Clone, Debug, Serialize)]
pub struct Running {
    /// Paths of the recordings.
    pub paths: Vec<PathBuf>,
    /// Descriptions of the runs to print: a line for each.
    pub labels: Vec<String>,
    /// The motor's electrical speed, mHz.
    pub millihertz: u32,
}

/// Records both runs in `directory`, and describes them in `running.json`.
pub fn command(directory: &Path) -> ExitCode {
    steps::finish(Running::record(directory).and_then(|running| {
        figures::write(&directory.join(FILE), &running)?;
        Ok(running.labels)
    }))
}

impl Running {
    /// Runs both and writes their recordings into `directory`.
    ///
    /// # Errors
    /// Fails if a motor is not at its set-point at the end, or a file cannot be written.
    pub fn record(directory: &Path) -> Result<Self, String> {
        // The manual's rate (Table 2): what a tick costs stays comparable.
        let rate = ["--pwm-rate", "10000"];
        let (sensorless, rpm) = demo::session(&[&["--mode", "sensorless"], &rate[..]].concat())?;
        let (hall, _) = demo::session(&[&["--mode", "hall", "--rpm", &rpm.to_string()], &rate[..]].concat())?;
        let hertz = f64::from(rpm) / 60.0 * f64::from(hall.motor.pole_pairs);
        let millihertz = (hertz * 1e3).round() as u32;
        fs::create_dir_all(directory).map_err(|error| format!("{}: {error}", directory.display()))?;
        let mut running = Self { paths: Vec::new(), labels: Vec::new(), millihertz };
        for (name, config) in [("hall", hall), ("sensorless", sensorless)] {
            let path = directory.join(name).with_extension("narxrec");
            let recording =
                run(config.clone(), rpm).map_err(|reason| format!("{}: {reason}", config.label))?;
            fs::write(&path, recording).map_err(|error| format!("{}: {error}", path.display()))?;
            running.paths.push(path);
            running.labels.push(format!("{}, {SECONDS} s", config.label));
        }
        Ok(running)
    }
}

/// Powers up, starts and runs; returns the recording.
fn run(config: SessionConfig, rpm: i32) -> Result<Vec<u8>, String> {
    let mut session =
        Session::new(&SessionConfig { trace: false, ..config }).map_err(|error| error.to_string())?;
    let state = match config.mode {
        Mode::Hall => State::HallClosedLoop,
        Mode::Sensorless | Mode::OpenLoop => {
            // A motor for sensorless control has no sensors: its hall lines are dead.
            for line in [Phase::A, Phase::B, Phase::C] {
                session.bench_mut().plant_mut().inject(Injection::HallStuck { line, high: false });
            }
            State::SensorlessClosedLoop
        }
    };
    session.start(rpm);
    while session.bench().time() < SECONDS {
        session.step();
        // The frames on the bus are not used.
        while session.bench_mut().receive().is_some() {}
        while session.bench_mut().monitor().is_some() {}
    }
    let reached = session.bench().plant().observe().speed * 60.0 / TAU;
    let now = session.bench().status().state;
    if now != state || (reached / f64::from(rpm) - 1.0).abs() > TOLERANCE {
        return Err(format!("{} at {reached:.0} rpm after {SECONDS} s", now.name()));
    }
    Ok(session.bench().recording())
}
