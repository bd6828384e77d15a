//! How fast the bench is: simulated seconds a second on one thread, the real core in the loop, beside a hand-tuned C loop of
//! a simpler plant (`xtask/floor/plant.c`) in the same run.

use super::python;
use super::report::{self, Row};
use crate::driven;
use crate::install;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// Runs of each, in turns: a machine with other work only ever makes a run slower, so the fastest counts.
const ROUNDS: usize = 5;
/// Measured ticks of a run.
const TICKS: &str = "40000";
/// Simulated seconds of a run of the C loop.
const FLOOR_SECONDS: &str = "10";
/// Goals: simulated seconds a second, and the ratio to the C loop.
const RATE_MIN: f64 = 200.0;
const RATIO_MIN: f64 = 0.6;

/// Measures and prints the rates alone, from Python if asked; exit code 1 if a goal is not reached.
pub fn command(from_python: bool) -> ExitCode {
    let rows = if from_python { python::rows(&[]) } else { rows(&[]) };
    report::print(&rows);
    if rows.iter().all(|row| row.met) { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Rate and ratio in hall and sensorless mode.
pub(super) fn rows(_: &[u64]) -> Vec<Row> {
    let root = super::root();
    let bench = driven::build(root);
    let floor = compile_floor(root);
    let mut best = [0.0f64; 2];
    let mut best_floor = 0.0f64;
    let mut failures = Vec::new();
    for _ in 0..ROUNDS {
        for (best, mode) in best.iter_mut().zip(driven::MODES) {
            let rate = bench
                .as_ref()
                .map_err(Clone::clone)
                .and_then(|program| rate(Command::new(program).args([mode, TICKS])));
            keep(best, rate, &mut failures);
        }
        if let Ok(program) = &floor {
            keep(&mut best_floor, rate(Command::new(program).arg(FLOOR_SECONDS)), &mut failures);
        }
    }
    failures.sort();
    failures.dedup();
    let no_floor = floor.err();
    let names = [
        ("simulation, hall sensors, 3000 rpm, rated load", "hall rate", "hall ratio"),
        ("simulation, sensorless, 3000 rpm, rated load", "sensorless rate", "sensorless ratio"),
    ];
    names
        .into_iter()
        .zip(best)
        .map(|(names, rate)| row(names, rate, best_floor, &no_floor, &failures))
        .collect()
}

fn row(
    (promise, rate_name, ratio_name): (&'static str, &'static str, &'static str),
    rate: f64,
    floor: f64,
    no_floor: &Option<String>,
    failures: &[String],
) -> Row {
    let ratio = if floor > 0.0 { rate / floor } else { f64::NAN };
    let beside = match no_floor {
        Some(reason) => format!("no C loop beside it: {reason}"),
        None => {
            format!("{ratio:.2} of the {floor:.0} of a C loop with a simpler plant (xtask/floor/plant.c)")
        }
    };
    Row {
        promise,
        goal: ">= 200 simulated s a s, >= 0.6 of a C loop",
        measured: format!("{rate:.1} simulated seconds a second, {beside}"),
        met: rate >= RATE_MIN && (ratio >= RATIO_MIN || no_floor.is_some()),
        figures: vec![(rate_name, rate), (ratio_name, ratio), ("C loop rate", floor)],
        failures: failures.to_vec(),
    }
}

fn keep(best: &mut f64, rate: Result<f64, String>, failures: &mut Vec<String>) {
    match rate {
        Ok(rate) => *best = best.max(rate),
        Err(reason) => failures.push(reason),
    }
}

/// The first number that a program prints.
fn rate(command: &mut Command) -> Result<f64, String> {
    let text = driven::output(command)?;
    let first = text.split_whitespace().next().and_then(|word| word.parse().ok());
    first.ok_or_else(|| format!("no figure in: {text}"))
}

/// The C loop, for this very machine.
fn compile_floor(root: &Path) -> Result<PathBuf, String> {
    let program = install::target_directory(root).join("floor");
    let source = root.join("xtask/floor/plant.c");
    let mut compiler = Command::new("cc");
    compiler.args(["-O3", "-march=native", "-o"]).arg(&program).arg(source);
    driven::output(&mut compiler).map(|_| program)
}
