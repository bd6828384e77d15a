//! The table of promises and costs: the promises are measured by narx-lab; what they cost, and how fast the
//! tools are, needs compilers, an emulator, Python or Node, and is measured here.

mod callgrind;
mod decoding;
mod flash;
mod instructions;
mod page;
mod python;
mod speed;
mod tools;

use crate::programs::LAB_RELEASE;
use clap::Args;
use narx_report::figures::{self, Part, Report};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `bench`.
#[derive(Args, Debug)]
pub(crate) struct Arguments {
    /// Number of random plants to start
    #[arg(long, default_value_t = 10_000)]
    runs: u64,
    /// Series of random plants; series S begins at seed S x 1 000 000
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Run one random plant again, by its seed, and write its run.svg, run.csv and run.narxrec
    #[arg(long)]
    case: Option<u64>,
    /// Measure these parts only, separated by commas; the figures of the others stay in the file
    #[arg(long, value_delimiter = ',', value_parser = names())]
    only: Vec<String>,
    /// PWM frequency of the promises, Hz; at another one than 10000 only they are measured, into
    /// bench-20kHz.json and the like
    #[arg(long, allow_hyphen_values = true, default_value = PWM_RATE)]
    pwm_rate: String,
    /// Install what is missing (emulator, C compilers, valgrind, Python and npm packages); without this,
    /// parts that need it are left out, with a message
    #[arg(long)]
    all: bool,
    /// Folder for bench.json and starts.svg
    #[arg(long, default_value = "target")]
    out: PathBuf,
}

/// The rate of all other parts, Hz.
const PWM_RATE: &str = "10000";

fn names() -> clap::builder::PossibleValuesParser {
    PROMISES.into_iter().chain(PARTS.map(|(name, _)| name)).collect::<Vec<_>>().into()
}

/// Parts that narx-lab measures, on the bench alone.
const PROMISES: [&str; 12] = [
    "start",
    "soon",
    "steady",
    "load-step",
    "spinning",
    "top-speed",
    "range",
    "efficiency",
    "faults",
    "sweep",
    "scope",
    "floor",
];

/// Folder of the working copy, and whether missing tools may be installed.
pub(crate) struct Context<'a> {
    root: &'a Path,
    all: bool,
}

type Measure = fn(&Context<'_>) -> Part;

/// Parts that are measured here: cost of a tick, speed of the tools.
const PARTS: [(&str, Measure); 7] = [
    ("instructions", instructions::part),
    ("flash", flash::part),
    ("callgrind", callgrind::part),
    ("simulation", speed::part),
    ("python", python::part),
    ("logs", decoding::part),
    ("page", page::part),
];

/// Measures, prints the tables and writes `bench.json`; fails if a goal is missed.
pub(crate) fn run(root: &Path, arguments: &Arguments) -> Result<Vec<String>, String> {
    let chosen = |name: &str| arguments.only.is_empty() || arguments.only.iter().any(|only| only == name);
    let promises = PROMISES.into_iter().filter(|name| chosen(name)).collect::<Vec<_>>().join(",");
    if arguments.pwm_rate != PWM_RATE && promises.is_empty() && arguments.case.is_none() {
        return Err(format!("--pwm-rate {}: none of these parts depends on it", arguments.pwm_rate));
    }
    let kept = if promises.is_empty() && arguments.case.is_none() {
        Ok(Vec::new())
    } else {
        let mut call: Vec<OsString> = vec!["promises".into(), "--out".into(), (&arguments.out).into()];
        let mut option = |name: &str, value: String| call.extend([name.into(), value.into()]);
        option("--runs", arguments.runs.to_string());
        option("--seed", arguments.seed.to_string());
        option("--pwm-rate", arguments.pwm_rate.clone());
        match arguments.case {
            Some(case) => option("--case", case.to_string()),
            None => option("--only", promises),
        }
        LAB_RELEASE.run(root, &call)
    };
    if arguments.case.is_some() {
        return kept.map(|_| Vec::new());
    }
    if arguments.pwm_rate != PWM_RATE {
        return kept.map(|_| Vec::new()).map_err(|_| String::from("a promise is missed"));
    }
    let path = arguments.out.join("bench.json");
    let context = Context { root, all: arguments.all };
    let mut measured = Vec::new();
    for (name, measure) in PARTS.into_iter().filter(|(name, _)| chosen(name)) {
        let begun = Instant::now();
        println!("{name} ...");
        let command = format!("cargo xtask bench --only {name}");
        let part = Part { part: name.into(), command, ..measure(&context) };
        println!("  {:.0} s", begun.elapsed().as_secs_f64());
        // Each part is written as soon as it is measured: hours are not lost with one failure.
        let mut report = Report::read(&path)?;
        report.machine = figures::machine();
        report.replace(part.clone());
        report.write(&path)?;
        measured.push(part);
    }
    if !measured.is_empty() {
        println!("\n{}", figures::table(&measured));
    }
    kept.map_err(|_| String::from("a promise is missed"))?;
    if measured.iter().all(Part::is_met) {
        Ok(vec![format!("written to {}", path.display())])
    } else {
        Err("a goal is missed".into())
    }
}
