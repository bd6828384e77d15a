//! The promises of control, measured on the bench: each figure with its unit, its goal and the command that
//! measures it again. Everything simulated has a seed; a failure is printed with the command that runs it
//! again.

mod case;
mod efficiency;
mod faults;
pub(crate) mod load_step;
mod operating;
pub(crate) mod picture;
mod range;
mod scope;
mod spinning;
mod start;
mod starts;
mod steady;
mod sweep;
mod top_speed;
mod trial;

pub use narx_host::parallel::map;
pub use operating::{Figures, Point};
pub use start::{Ending, Start};

use crate::floor;
use crate::pwm_rate::{self, PwmRate};
use clap::Args;
use narx_core::motor::Board;
use narx_report::figures::{self, Part, Report};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Arguments of `promises`, as `bench` passes them on.
#[derive(Args, Debug)]
pub struct Arguments {
    /// Number of random plants to start
    #[arg(long, default_value_t = 10_000)]
    pub runs: u64,
    /// Series of random plants; series S begins at seed S x 1 000 000
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Run one random plant again, by its seed, and write its run.svg, run.csv and run.narxrec
    #[arg(long)]
    pub case: Option<u64>,
    /// Measure these parts only, separated by commas; the figures of the others stay in the file
    #[arg(long, value_delimiter = ',', value_parser = names())]
    pub only: Vec<String>,
    #[command(flatten)]
    rate: PwmRate,
    /// Folder for bench.json and starts.svg; at another PWM rate than 10 kHz their names have it:
    /// bench-20kHz.json
    #[arg(long, default_value = "target")]
    pub out: PathBuf,
}

fn names() -> clap::builder::PossibleValuesParser {
    PARTS.map(|(name, _)| name).into()
}

/// Inputs of a part's measurement.
pub(crate) struct Context<'a> {
    /// Folder of the working copy.
    pub(crate) root: &'a Path,
    /// Board of every drive.
    pub(crate) board: Board,
    /// Seeds of the random plants.
    cases: Vec<u64>,
    /// Folder for pictures.
    out: &'a Path,
}

type Measure = fn(&Context<'_>) -> Part;

/// Name of the part about the bare tick by hand in C, which has 10 kHz: it is left out at any other rate.
const FLOOR: &str = "floor";

/// All parts in the order of the table: promises of control, then what the bench costs.
const PARTS: [(&str, Measure); 12] = [
    ("start", starts::part),
    ("soon", starts::nominal),
    ("spinning", spinning::part),
    ("steady", steady::part),
    ("load-step", load_step::part),
    ("top-speed", top_speed::part),
    ("range", range::part),
    ("efficiency", efficiency::part),
    ("faults", faults::part),
    ("sweep", sweep::part),
    ("scope", scope::part),
    (FLOOR, |context| floor::part(context.root)),
];

/// Measures, prints the table and writes `bench.json`; exit code 1 if a goal is missed.
pub fn command(root: &Path, arguments: &Arguments) -> ExitCode {
    arguments.rate.run(|board| match arguments.case {
        Some(seed) => case::replay(seed, board, &arguments.out.join(format!("case-{seed}")))
            .map_err(|error| format!("{}: {error}", arguments.out.display())),
        None => run(root, board, arguments),
    })
}

/// Measures the parts; returns true if no goal is missed.
fn run(root: &Path, board: &Board, arguments: &Arguments) -> Result<bool, String> {
    let path = pwm_rate::file(&arguments.out.join("bench.json"), board);
    let cases = starts::cases(arguments.seed, arguments.runs);
    let context = Context { root, board: *board, cases, out: &arguments.out };
    let mut measured = Vec::new();
    println!("PWM rate: {} Hz", board.tick_rate);
    for (name, measure) in PARTS {
        if !arguments.only.is_empty() && !arguments.only.iter().any(|only| only == name) {
            continue;
        }
        if name == FLOOR && board.tick_rate != pwm_rate::default() {
            continue;
        }
        let begun = Instant::now();
        println!("{name} ...");
        let part = Part { part: name.into(), command: repeat(name, board, arguments), ..measure(&context) };
        println!("  {:.0} s", begun.elapsed().as_secs_f64());
        // Each part is written as soon as it is measured, beside those that others have written meanwhile:
        // hours are not lost with one failure.
        let mut report = Report::read(&path)?;
        report.machine = figures::machine();
        report.replace(part.clone());
        report.write(&path)?;
        measured.push(part);
    }
    println!("\n{}\nwritten to {}", figures::table(&measured), path.display());
    Ok(measured.iter().all(Part::is_met))
}

/// Command that measures a part again.
fn repeat(name: &str, board: &Board, arguments: &Arguments) -> String {
    let mut text = format!("cargo xtask bench --only {name}{}", pwm_rate::argument(board));
    let random = ["start", "steady"].contains(&name);
    if random && arguments.runs != 10_000 {
        text += &format!(" --runs {}", arguments.runs);
    }
    if random && arguments.seed != 0 {
        text += &format!(" --seed {}", arguments.seed);
    }
    text
}
