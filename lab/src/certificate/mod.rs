//! The start-up certificate: conditions under which the sensorless start succeeds, and conditions under which
//! it fails. Grids of inertia, load, friction, supply, temperature and angle over every motor of the market
//! go well beyond the promise, so that they show the limit, which can be compared with the physical one.

mod grid;
mod picture;

use crate::promises::{Ending, Start};
use crate::pwm_rate::{self, PwmRate};
use clap::Args;
use grid::{Cell, GRIDS};
use narx_core::motor::Board;
use narx_host::parallel::map;
use narx_report::figures::{self, Figure, Part};
use narx_sim::presets::{PRESETS, Preset};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Arguments of `certificate`.
#[derive(Args, Debug)]
pub struct Arguments {
    /// Motors of the market by name, separated by commas; without a name all of them
    #[arg(long, value_delimiter = ',')]
    pub motors: Vec<String>,
    #[command(flatten)]
    rate: PwmRate,
    /// Folder for starts.json and certificate.svg; at another PWM rate than 10 kHz their names have it:
    /// starts-20kHz.json
    #[arg(long, default_value = "docs/evidence")]
    pub out: PathBuf,
}

/// Share of the lock's torque that friction and load may take in a promised start.
pub const BREAKAWAY_MAX: f64 = 0.5;
/// Share of the promised starts that succeed, %.
const STARTED: f64 = 99.9;

/// Results of the measurement.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Certificate {
    /// PWM rate, Hz.
    #[serde(default = "pwm_rate::default")]
    pub pwm_rate: u32,
    /// Figures and failures within the promise.
    pub part: Part,
    /// Starts by the share of the lock's torque that friction and load take: upper bound of the share, number
    /// of starts, number of successes.
    pub breakaway: Vec<(f64, u64, u64)>,
    /// Ends of the starts that did not succeed, with their numbers within and beyond the promise.
    pub endings: BTreeMap<String, (u64, u64)>,
}

/// Measures, draws and writes; exit code 1 if a promised start failed more often than promised.
pub fn command(root: &Path, arguments: &Arguments) -> ExitCode {
    let chosen = |preset: &&Preset| {
        arguments.motors.is_empty() || arguments.motors.iter().any(|name| name == preset.name)
    };
    let presets: Vec<&'static Preset> = PRESETS.iter().filter(chosen).collect();
    if presets.is_empty() {
        eprintln!("no motor {}: {}", arguments.motors.join(","), PRESETS.map(|preset| preset.name).join(" "));
        return ExitCode::FAILURE;
    }
    let board = match arguments.rate.board() {
        Ok(board) => board,
        Err(reason) => {
            eprintln!("{reason}");
            return ExitCode::FAILURE;
        }
    };
    let begun = Instant::now();
    let (certificate, picture) = measure(&board, &presets, 1);
    let out = root.join(&arguments.out);
    let [starts, drawing] =
        ["starts.json", "certificate.svg"].map(|name| pwm_rate::file(Path::new(name), &board));
    let written = certificate.write(&out.join(&starts)).and_then(|()| {
        let path = out.join(&drawing);
        picture.and_then(|picture| {
            fs::write(&path, picture).map_err(|error| format!("{}: {error}", path.display()))
        })
    });
    if let Err(reason) = written {
        eprintln!("{reason}");
        return ExitCode::FAILURE;
    }
    println!("PWM rate: {} Hz", certificate.pwm_rate);
    println!("{}", figures::table(std::slice::from_ref(&certificate.part)));
    for (ending, (within, beyond)) in &certificate.endings {
        println!("{ending}: {within} within the promise, {beyond} beyond");
    }
    println!(
        "written to {}: {} {} ({:.0} s)",
        out.display(),
        starts.display(),
        drawing.display(),
        begun.elapsed().as_secs_f64()
    );
    if certificate.part.is_met() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// A start of a cell.
struct Tried {
    grid: usize,
    cell: Cell,
    /// Share of the lock's torque that friction and load take.
    breakaway: f64,
    start: Start,
}

impl Tried {
    /// Returns whether the start is within the promise.
    fn is_promised(&self) -> bool {
        self.cell.is_promised() && self.breakaway <= BREAKAWAY_MAX
    }
}

/// Runs every grid over these motors on this board, or every `every`th of its cells, and draws the picture.
pub fn measure(
    board: &Board,
    presets: &[&'static Preset],
    every: usize,
) -> (Certificate, Result<String, String>) {
    let mut cells = Vec::new();
    for (grid, plan) in GRIDS.iter().enumerate() {
        for preset in presets {
            cells.extend(plan.cells(preset).map(|cell| (grid, cell)));
        }
    }
    let cells: Vec<(usize, Cell)> = cells.into_iter().step_by(every).collect();
    let tried: Vec<Tried> =
        map(&cells, |(grid, cell)| run(board, *grid, cell)).into_iter().flatten().collect();
    let refused = cells.len() - tried.len();
    (Certificate::new(board, &tried, refused), picture::svg(board, &tried))
}

fn run(board: &Board, grid: usize, cell: &Cell) -> Option<Tried> {
    let (plant, breakaway) = cell.plant(board)?;
    Some(Tried { grid, cell: *cell, breakaway, start: Start::of(plant) })
}

impl Certificate {
    fn new(board: &Board, tried: &[Tried], refused: usize) -> Self {
        let mut certificate = Self { pwm_rate: board.tick_rate, ..Self::default() };
        let rate = pwm_rate::argument(board);
        let promised: Vec<&Tried> = tried.iter().filter(|one| one.is_promised()).collect();
        let count =
            |of: &[&Tried], holds: fn(&Start) -> bool| of.iter().filter(|one| holds(&one.start)).count();
        let share = |part: usize, of: usize| 100.0 * part as f64 / of.max(1) as f64;
        let (started, first) = (count(&promised, Start::started), count(&promised, Start::started_at_once));
        let beyond: Vec<&Tried> = tried.iter().filter(|one| !one.is_promised()).collect();
        let all: Vec<&Tried> = tried.iter().collect();
        let unaccounted = all.len() - count(&all, Start::is_accounted_for);
        certificate.part = Part {
            part: "certificate".into(),
            command: format!("cargo xtask certificate{rate}"),
            figures: vec![
                Figure::new("starts", tried.len() as f64, "")
                    .note(format!("{refused} more that commissioning refuses")),
                Figure::new(
                    "within what is promised, started within Auto-restart",
                    share(started, promised.len()),
                    "%",
                )
                .at_least(STARTED)
                .note(format!("{started} of {}", promised.len())),
                Figure::new("of these at the first try", share(first, promised.len()), "%"),
                Figure::new(
                    "beyond what is promised, started",
                    share(count(&beyond, Start::started), beyond.len()),
                    "%",
                )
                .note(format!("{} of {}", count(&beyond, Start::started), beyond.len())),
                Figure::new(
                    "ends that are neither a start, Standby nor a named fault",
                    unaccounted as f64,
                    "",
                )
                .at_most(0.0),
            ],
            ..Part::default()
        };
        for one in tried.iter().filter(|one| !one.start.started()) {
            let (within, beyond) = certificate.endings.entry(ending(&one.start)).or_default();
            *(if one.is_promised() { within } else { beyond }) += 1;
            if one.is_promised() || !one.start.is_accounted_for() {
                certificate.part.failures.push(format!(
                    "{}; friction and load {:.0} % of the lock's torque: cargo xtask certificate --motors {}{rate}",
                    one.start,
                    100.0 * one.breakaway,
                    one.start.drawn.preset.name
                ));
            }
        }
        certificate.breakaway = BREAKAWAYS
            .windows(2)
            .map(|bounds| {
                let within =
                    |one: &&&Tried| (bounds[0]..bounds[1]).contains(&one.breakaway) && one.cell.is_promised();
                let of: Vec<&Tried> = all.iter().filter(within).copied().collect();
                (bounds[1], of.len() as u64, count(&of, Start::started) as u64)
            })
            .collect();
        certificate
    }

    /// Reads a file.
    ///
    /// # Errors
    /// Fails if there is no file, or if it has another content.
    pub fn read(path: &Path) -> Result<Self, String> {
        let text = fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
        serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))
    }

    /// Writes a file.
    ///
    /// # Errors
    /// Fails if it cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), String> {
        figures::write(path, self)
    }
}

/// Bounds of the shares of the lock's torque that are counted together.
const BREAKAWAYS: [f64; 8] = [0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 100.0];

fn ending(start: &Start) -> String {
    match start.ending {
        Ending::Fault(code) => {
            let row = narx_core::motor::Cause::TABLE.iter().find(|row| row.cause as u16 == code);
            format!("fault {code:#06x}, {}", row.map_or("", |row| row.meaning))
        }
        other => other.to_string(),
    }
}
