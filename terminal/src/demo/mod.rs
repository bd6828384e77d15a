//! The demonstration: a real data-sheet motor on the virtual drive, commanded over CAN from power-up to its
//! speed.

mod displacement;
mod figures;
mod settings;

pub use settings::Arguments;

use crate::plot::{self, Caption};
use displacement::Displacement;
use figures::Figures;
use narx_core::bus::candump;
use narx_core::motor::{Drive, State};
use narx_core::recording::{Recording, replay};
use narx_host::csv;
use narx_sim::commutations::Commutations;
use narx_sim::session::{Session, SessionConfig};
use narx_sim::trace::Trace;
use settings::Settings;
use std::error::Error;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write as _};
use std::path::Path;
use std::process::ExitCode;

/// Runs the demonstration; invalid arguments give exit code 2 and one line.
pub fn run(arguments: &Arguments) -> ExitCode {
    let settings = match Settings::new(arguments) {
        Ok(settings) => settings,
        Err(refused) => {
            eprintln!("{refused}");
            return ExitCode::from(2);
        }
    };
    match demonstrate(&settings) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("{}: {error}", settings.out.display());
            ExitCode::FAILURE
        }
    }
}

/// Session and speed, rpm, that `cargo xtask demo` runs with these arguments.
///
/// # Errors
/// Fails with one line about invalid arguments.
pub fn session(arguments: &[&str]) -> Result<(SessionConfig, i32), String> {
    let arguments = Arguments::read(arguments).map_err(|error| error.to_string())?;
    let settings = Settings::new(&arguments).map_err(|refused| refused.to_string())?;
    Ok((settings.session, settings.rpm))
}

/// The picture of the demonstration with these arguments, as `run.svg` has it.
///
/// # Errors
/// Arguments that cannot be, or a run that cannot be drawn, in one line.
pub fn picture(arguments: &[&str]) -> Result<String, String> {
    let arguments = Arguments::read(arguments).map_err(|error| error.to_string())?;
    let settings = Settings::new(&arguments).map_err(|refused| refused.to_string())?;
    let mut session = Session::new(&settings.session).map_err(|error| error.to_string())?;
    while session.bench().time() < settings.seconds {
        start_when_due(&mut session, settings.rpm);
        session.step();
    }
    let caption = Caption { title: settings.title(), subtitle: &settings.subtitle() };
    plot::svg(&session.bench().trace(), None, &caption).map_err(|error| error.to_string())
}

/// Time at which the master requests Drive, s: after boot (0.5 s) and two of its periods of Standby.
const START: f64 = 0.6;

/// Requests Drive at [`START`].
fn start_when_due(session: &mut Session, rpm: i32) {
    if session.bench().time() >= START && session.master().setpoint() == 0 {
        session.master().start(rpm);
    }
}

/// Runs the demonstration; returns true if the motor still ran at the end and the recording replays.
fn demonstrate(settings: &Settings) -> io::Result<bool> {
    println!("{}", settings.headline());
    for note in &settings.commissioning.notes {
        println!("  note: {note}");
    }
    let mut run = Run::new(settings).map_err(io::Error::other)?;
    println!("\n{:>9}  state", "time");
    while run.session.bench().time() < settings.seconds {
        run.step();
    }
    let mark = run.steady_from.take();
    let figures = Figures::new(settings, run.session.bench(), mark, run.closed, &run.commutations);
    println!("\n{figures}");
    if let Some(displacement) = &run.displacement {
        println!("{}", displacement.figures(settings.steady_start(), settings.seconds));
    }
    write_files(settings, &run)?;
    let identical = replays(&run.session.bench().recording());
    println!("\nwritten to {}: run.svg run.csv run.log run.narxrec", settings.out.display());
    println!("replayed {} ticks from run.narxrec: {}", run.session.bench().plant().tick(), identical.1);
    Ok(figures.running() && identical.0)
}

/// A session with its log and the observations of the run.
struct Run<'a> {
    settings: &'a Settings,
    session: Session,
    state: Option<State>,
    faults: u32,
    log: String,
    /// Energies at the beginning of the last quarter.
    steady_from: Option<figures::Mark>,
    /// Time at which closed loop began, s.
    closed: Option<f64>,
    commutations: Commutations,
    displacement: Option<Displacement>,
}

impl<'a> Run<'a> {
    fn new(settings: &'a Settings) -> Result<Self, Box<dyn Error + Send + Sync>> {
        let mut session = Session::new(&settings.session)?;
        let displacement = match settings.tx_drivers {
            0 => None,
            count => Some(Displacement::new(session.bench_mut(), count)?),
        };
        Ok(Self {
            settings,
            session,
            state: None,
            faults: 0,
            log: String::new(),
            steady_from: None,
            closed: None,
            commutations: Commutations::default(),
            displacement,
        })
    }

    fn step(&mut self) {
        start_when_due(&mut self.session, self.settings.rpm);
        if let Some(displacement) = &mut self.displacement {
            displacement.send(self.session.bench_mut());
        }
        self.session.step();
        while let Some(received) = self.session.bench_mut().monitor() {
            let _ = writeln!(self.log, "{}", candump::line(received.time_ns, "can0", &received.frame));
            if let Some(displacement) = &mut self.displacement {
                displacement.receive(&received.frame, received.time_ns, self.session.bench());
            }
        }
        if let Some(displacement) = &mut self.displacement {
            displacement.keep();
        }
        if self.steady_from.is_none() && self.session.bench().time() >= self.settings.steady_start() {
            self.steady_from = Some(figures::Mark::new(self.session.bench()));
            self.commutations.clear();
        }
        self.commutations.watch(self.session.bench());
        self.tell();
    }

    /// Prints a line for every change of state and every new fault.
    fn tell(&mut self) {
        let bench = self.session.bench();
        let status = bench.status();
        let (state, faults) = (status.state, status.faults.bits());
        if self.state != Some(state) || faults & !self.faults != 0 {
            let speed = bench.plant().observe().speed * 60.0 / std::f64::consts::TAU;
            print!("{:>7.3} s  {} {:<31} {speed:>8.0} rpm", bench.time(), state as u8, state.name());
            println!(
                "{}",
                if faults == 0 {
                    String::new()
                } else {
                    format!("  faults {faults:#010x}, code {:#06x}", status.extended_code)
                }
            );
            if matches!(state, State::SensorlessClosedLoop | State::HallClosedLoop) {
                self.closed.get_or_insert(bench.time());
            }
            self.state = Some(state);
        }
        self.faults = faults;
    }
}

fn write_files(settings: &Settings, run: &Run<'_>) -> io::Result<()> {
    fs::create_dir_all(&settings.out)?;
    let file = |name: &str| settings.out.join(name);
    let trace = run.session.bench().trace();
    let caption = Caption { title: settings.title(), subtitle: &settings.subtitle() };
    let displacements = run.displacement.as_ref().map(Displacement::trace);
    let picture = plot::svg(&trace, displacements, &caption).map_err(io::Error::other)?;
    fs::write(file("run.svg"), picture)?;
    fs::write(file("run.log"), &run.log)?;
    fs::write(file("run.narxrec"), run.session.bench().recording())?;
    let traces: Vec<&Trace> = [&trace].into_iter().chain(displacements).collect();
    write_csv(&file("run.csv"), &traces)
}

fn write_csv(path: &Path, traces: &[&Trace]) -> io::Result<()> {
    let mut out = BufWriter::new(File::create(path)?);
    csv::write(traces, &mut out)?;
    out.flush()
}

/// Returns whether the recording replays to the digest in it, and a line with the result.
fn replays(bytes: &[u8]) -> (bool, String) {
    let outcome = Recording::open(bytes)
        .map_err(|error| error.to_string())
        .and_then(|recording| replay::<Drive>(&recording).map_err(|error| error.to_string()));
    match outcome {
        Ok(outcome) if outcome.is_identical() => (true, format!("identical, digest {:016x}", outcome.digest)),
        Ok(outcome) => {
            (false, format!("digest {:016x}, recorded {:016x}", outcome.digest, outcome.recorded_digest))
        }
        Err(error) => (false, error),
    }
}
