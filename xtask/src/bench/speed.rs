//! Speed of the bench: simulated seconds per second on one thread, with the real core in the loop, beside a
//! hand-tuned C loop of a simpler plant (`lab/floor/plant.c`) in the same run.

use super::Context;
use crate::driven;
use narx_report::figures::{Figure, Part};
use narx_report::steps;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Runs of each program, in turns. Other work of the machine only ever makes a run slower, so the fastest
/// counts.
const ROUNDS: usize = 5;
/// Number of measured ticks of a run.
const TICKS: &str = "40000";
/// Simulated seconds of a run of the C loop.
const FLOOR_SECONDS: &str = "10";
/// Goals: simulated seconds per second, and the ratio to the C loop.
const RATE_MIN: f64 = 200.0;
const RATIO_MIN: f64 = 0.6;

/// Measures rate and ratio in hall and sensorless mode.
pub(super) fn part(context: &Context<'_>) -> Part {
    let root = context.root;
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
    let without = floor.as_ref().err().map(|reason| format!("no C loop beside it: {reason}"));
    let mut figures = Vec::new();
    for (mode, rate) in driven::MODES.into_iter().zip(best) {
        figures.push(
            Figure::new(format!("simulation, {mode}, 3000 rpm, rated load"), rate, "simulated s/s")
                .at_least(RATE_MIN)
                .note("one thread, the real core in the loop"),
        );
        let ratio = Figure::new(format!("simulation, {mode}, beside the C loop"), rate / best_floor, "");
        figures.push(match &without {
            Some(reason) => Figure::new(ratio.name, f64::NAN, "").note(reason.clone()),
            None => ratio.at_least(RATIO_MIN),
        });
    }
    if without.is_none() {
        let floor = Figure::new("a C loop with a simpler plant", best_floor, "simulated s/s");
        figures.push(floor.note("lab/floor/plant.c"));
    }
    Part::new(figures, failures)
}

fn keep(best: &mut f64, rate: Result<f64, String>, failures: &mut Vec<String>) {
    match rate {
        Ok(rate) => *best = best.max(rate),
        Err(reason) => failures.push(reason),
    }
}

/// Runs a program; returns the first number that it prints.
fn rate(command: &mut Command) -> Result<f64, String> {
    let text = steps::output(command)?;
    let first = text.split_whitespace().next().and_then(|word| word.parse().ok());
    first.ok_or_else(|| format!("no figure in: {text}"))
}

/// Compiles the C loop for this very machine.
fn compile_floor(root: &Path) -> Result<PathBuf, String> {
    let program = narx_report::target_directory(root).join("floor");
    let source = root.join("lab/floor/plant.c");
    let mut compiler = Command::new("cc");
    compiler.args(["-O3", "-march=native", "-o"]).arg(&program).arg(source);
    steps::output(&mut compiler).map(|_| program)
}
