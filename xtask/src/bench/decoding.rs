//! How fast a log becomes columns in Python, beside python-can with cantools: the program is `tests/python/bench_read_log.py`.

use super::report::Row;
use crate::driven;
use crate::test::python;
use std::path::Path;
use std::process::Command;

/// Goal: how many times as fast as python-can and cantools.
const RATIO_MIN: f64 = 30.0;

/// Rate and ratio on a million frames.
pub(super) fn rows(_: &[u64]) -> Vec<Row> {
    if Command::new("python3").arg("--version").output().is_err() {
        return vec![row("not measured: there is no python3".into(), true, [f64::NAN; 3], None)];
    }
    vec![match measure(super::root()) {
        Ok([ratio, own, reference]) => {
            let own_millions = own / 1e6;
            let measured = format!(
                "{own_millions:.2} million frames a second, {ratio:.0} times the {reference:.0} of python-can with cantools"
            );
            row(measured, ratio >= RATIO_MIN, [ratio, own, reference], None)
        }
        Err(reason) => row("failed".into(), false, [f64::NAN; 3], Some(reason)),
    }]
}

fn row(measured: String, met: bool, [ratio, own, reference]: [f64; 3], failure: Option<String>) -> Row {
    Row {
        promise: "a candump log of a million frames as columns in Python",
        goal: ">= 30 times python-can with cantools",
        measured,
        met,
        figures: vec![("frames a second", own), ("python-can and cantools", reference), ("ratio", ratio)],
        failures: failure.into_iter().collect(),
    }
}

/// Ratio, and the frames a second of both.
fn measure(root: &Path) -> Result<[f64; 3], String> {
    let mut command = Command::new(python::prepare(root)?);
    command.arg(root.join("tests/python/bench_read_log.py")).env("PYTHONDONTWRITEBYTECODE", "1");
    figures(&driven::output(&mut command)?)
}

/// The three numbers that the program prints first.
fn figures(text: &str) -> Result<[f64; 3], String> {
    let mut numbers = text.split_whitespace().map_while(|word| word.parse().ok());
    let mut next = || numbers.next().ok_or_else(|| format!("no figures in: {text}"));
    Ok([next()?, next()?, next()?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_three_numbers_count() {
        assert_eq!(figures("71.5 9800000 137000\n1000000 frames: ..."), Ok([71.5, 9_800_000.0, 137_000.0]));
        assert!(figures("Traceback").is_err());
        assert!(figures("71.5 9800000\n").is_err());
    }
}
