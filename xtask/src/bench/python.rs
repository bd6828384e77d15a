//! Speed of the bench from Python, beside the Rust bench and beside other motor simulators in Python
//! (`python/benches/speed.py`), all in the same run.

use super::{Context, tools};
use crate::{driven, install};
use narx_report::figures::{Figure, Part};
use narx_report::steps;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Runs of each program, in turns. Other work of the machine only ever makes a run slower, so the fastest
/// counts.
const ROUNDS: usize = 5;
/// Number of measured ticks of a run of the Rust bench: as many as the script's.
const TICKS: &str = "400000";
/// Goal: share of the Rust bench's rate, which keeps nothing; with no trace, and with one of eight signals.
const RATIO_MIN: f64 = 0.9;
/// Other simulators, as the script names them. Each runs once in a round, but the slow ones only once in all.
const OTHERS: [(&str, usize); 3] = [("numba", ROUNDS), ("motulator", 1), ("gym-electric-motor", 1)];

/// Measures the rate in hall and sensorless mode, then the others'.
pub(super) fn part(context: &Context<'_>) -> Part {
    let environment = narx_report::target_directory(context.root).join(ENVIRONMENT);
    if let Err(reason) = tools::python_environment(context, &environment) {
        return Part::skipped(reason);
    }
    match prepare(context.root) {
        Ok(programs) => measure(&programs),
        Err(reason) => Part::new(
            vec![Figure::new("simulation from Python", f64::NAN, "").at_least(RATIO_MIN)],
            vec![reason],
        ),
    }
}

/// Folder of its packages.
const ENVIRONMENT: &str = "python-benches";

struct Programs {
    /// Path of the program of the Rust bench.
    driven: PathBuf,
    python: PathBuf,
    script: PathBuf,
}

/// Builds the programs, with the package in an environment of its own.
fn prepare(root: &Path) -> Result<Programs, String> {
    let driven = driven::build(root)?;
    let (target, benches) = (narx_report::target_directory(root), root.join("python/benches"));
    let python = install::python_environment(&target.join(ENVIRONMENT), &benches.join("requirements.txt"))?;
    let mut pip = Command::new(&python);
    pip.args(["-m", "pip", "install", "--quiet", "--force-reinstall", "--no-deps"]).arg(root.join("python"));
    steps::run(pip.env("CARGO_TARGET_DIR", &target))?;
    Ok(Programs { driven, python, script: benches.join("speed.py") })
}

/// The fastest of several runs: its rate, and the program's description of itself.
#[derive(Default)]
struct Best {
    rate: f64,
    what: String,
    failure: Option<String>,
}

impl Best {
    fn keep(&mut self, command: &mut Command) {
        match run(command) {
            Ok((rate, _)) if rate <= self.rate => {}
            Ok((rate, what)) => (self.rate, self.what) = (rate, what),
            Err(reason) => self.failure = Some(reason),
        }
    }
}

/// Runs a program; returns the first number that it prints, and the rest.
fn run(command: &mut Command) -> Result<(f64, String), String> {
    let text = steps::output(command)?;
    let (first, what) = text.trim().split_once(' ').unwrap_or((text.trim(), ""));
    let rate = first.parse().map_err(|_| format!("no figure in: {text}"))?;
    Ok((rate, what.to_owned()))
}

fn measure(programs: &Programs) -> Part {
    let script = |contender: &str| {
        let mut command = Command::new(&programs.python);
        command.arg(&programs.script).arg(contender).env("PYTHONDONTWRITEBYTECODE", "1");
        command
    };
    let [mut rust, mut bare, mut eight, mut kept] = [(); 4].map(|()| driven::MODES.map(|_| Best::default()));
    let mut others = OTHERS.map(|_| Best::default());
    for round in 0..ROUNDS {
        for (index, mode) in driven::MODES.into_iter().enumerate() {
            rust[index].keep(Command::new(&programs.driven).args([mode, TICKS]));
            bare[index].keep(&mut script(mode));
            eight[index].keep(&mut script(&format!("{mode}-eight")));
            kept[index].keep(&mut script(&format!("{mode}-kept")));
        }
        for (best, (name, rounds)) in others.iter_mut().zip(OTHERS) {
            if round < rounds {
                best.keep(&mut script(name));
            }
        }
    }
    let mut part = Part::default();
    for (index, mode) in driven::MODES.into_iter().enumerate() {
        let [rust, bare, eight, kept] = [&rust, &bare, &eight, &kept].map(|bests| &bests[index]);
        let beside = |name: &str, rate: f64| {
            Figure::new(format!("simulation from Python, {mode}, {name}"), rate / rust.rate, "")
        };
        part.figures.extend([
            Figure::new(format!("simulation from Python, {mode}"), bare.rate, "simulated s/s")
                .note(format!("the Rust bench beside it: {:.1}", rust.rate)),
            beside("of the Rust bench's", bare.rate).at_least(RATIO_MIN),
            beside("with a trace of eight signals", eight.rate).at_least(RATIO_MIN).note(&*eight.what),
            beside("with trace and recording", kept.rate),
        ]);
        part.failures.extend([rust, bare, eight, kept].into_iter().filter_map(|best| best.failure.clone()));
    }
    for (best, (name, _)) in others.into_iter().zip(OTHERS) {
        // A simulator that cannot be installed is not a failure, but it is reported.
        let rate = if best.rate > 0.0 { best.rate } else { f64::NAN };
        part.figures
            .push(Figure::new(format!("{name}, for comparison"), rate, "simulated s/s").note(best.what));
        part.failures.extend(best.failure);
    }
    part
}
