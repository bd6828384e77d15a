//! Control quality: the promises of narx about its control, on every motor of the market that comes with it
//! and on random motors, in both closed loops, as percentiles. A miss of a promise is listed with the command
//! that runs it again.

pub(crate) mod motor;
mod physics;
mod run;
mod table;

pub use table::{Quality, Row};

use crate::pwm_rate::{self, PwmRate};
use clap::Args;
use motor::Subject;
use narx_core::motor::Board;
use narx_host::parallel::map;
use narx_sim::presets::{PRESETS, Preset};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Arguments of `quality`.
#[derive(Args, Debug)]
pub struct Arguments {
    /// Number of random motors
    #[arg(long, default_value_t = 1_000)]
    pub motors: u64,
    /// Run one random motor again, by its seed, and print every run
    #[arg(long, conflicts_with = "motor")]
    pub case: Option<u64>,
    /// Run one motor of the market, by its name, and print every run
    #[arg(long)]
    pub motor: Option<String>,
    #[command(flatten)]
    rate: PwmRate,
    /// File for the figures [default: docs/evidence/quality.json; at another PWM rate than 10 kHz its name
    /// has it: quality-20kHz.json]
    #[arg(long)]
    pub out: Option<PathBuf>,
}

/// File for the figures at the default PWM rate.
const FILE: &str = "docs/evidence/quality.json";

/// Measures and writes; exit code 1 if a file cannot be written, or if a single motor was requested and
/// missed a promise.
pub fn command(root: &Path, arguments: &Arguments) -> ExitCode {
    arguments.rate.run(|board| run(root, board, arguments))
}

/// Measures, or runs one motor again; returns false if that motor missed a promise.
fn run(root: &Path, board: &Board, arguments: &Arguments) -> Result<bool, String> {
    match (arguments.case, &arguments.motor) {
        (Some(seed), _) => motor::random(board, seed)
            .ok_or(format!("seed {seed} draws no motor that commissioning takes"))
            .map(|s| tell(&s)),
        (_, Some(name)) => narx_sim::presets::preset(name)
            .ok_or_else(|| format!("no motor {name:?}: {}", PRESETS.map(|preset| preset.name).join(" ")))
            .map(|preset| tell(&motor::of_market(board, preset))),
        _ => {
            let begun = Instant::now();
            let out = arguments.out.clone().unwrap_or_else(|| pwm_rate::file(Path::new(FILE), board));
            let quality = measure(board, &PRESETS.each_ref(), arguments.motors);
            println!("{}", quality.text());
            println!("written to {} ({:.0} s)", out.display(), begun.elapsed().as_secs_f64());
            quality.write(&root.join(&out)).map(|()| true)
        }
    }
}

/// Measures these motors of the market, and `motors` random ones, with seeds from 0, on this board.
pub fn measure(board: &Board, presets: &[&Preset], motors: u64) -> Quality {
    let of_market: Vec<Subject> = presets.iter().map(|preset| motor::of_market(board, preset)).collect();
    let seeds: Vec<u64> = (0..motors).collect();
    let drawn: Vec<Subject> = map(&seeds, |seed| motor::random(board, *seed)).into_iter().flatten().collect();
    let mut quality = Quality::new(board, motors, drawn.len() as u64);
    for (of, subjects) in [("presets", of_market), ("random motors", drawn)] {
        let runs: Vec<run::Run> = map(&subjects, run::runs).into_iter().flatten().collect();
        let (unseen, seen): (Vec<run::Run>, Vec<run::Run>) = runs.into_iter().partition(|run| run.unseen);
        quality.judge(of, &seen);
        if !unseen.is_empty() {
            quality.judge(&format!("{of}, unseen"), &unseen);
        }
    }
    quality
}

/// Prints every run of one motor; returns true if none missed a promise.
fn tell(subject: &Subject) -> bool {
    println!("{:#?}\nsupply: {:.2} V", subject.preset.motor, subject.supply);
    let mut quality = Quality::new(&subject.board, 0, 0);
    for run in run::runs(subject) {
        println!("{}: {}", run.what, table::words(&run.outcome));
        quality.judge("this motor", std::slice::from_ref(&run));
    }
    for failure in &quality.failures {
        println!("missed: {}", failure.what);
    }
    quality.failures.is_empty()
}
