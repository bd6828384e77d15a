//! Speed of turning a log into columns in Python, beside python-can with cantools: the program is
//! `tests/python/bench_read_log.py`.

use super::{Context, tools};
use narx_report::figures::{Figure, Part};
use narx_report::steps;
use std::path::Path;
use std::process::Command;

/// Goal: ratio of the rate to that of python-can and cantools.
const RATIO_MIN: f64 = 30.0;

/// Measures rate and ratio on a million frames.
pub(super) fn part(context: &Context<'_>) -> Part {
    let python = match tools::python_package(context) {
        Ok(python) => python,
        Err(reason) => return Part::skipped(reason),
    };
    let name = "a candump log of a million frames as columns in Python";
    match measure(context.root, &python) {
        Ok([ratio, own, reference]) => Part::new(
            vec![
                Figure::new(name, own / 1e6, "million frames/s"),
                Figure::new("the same by python-can with cantools", reference / 1e6, "million frames/s"),
                Figure::new("ratio of these", ratio, "").at_least(RATIO_MIN),
            ],
            Vec::new(),
        ),
        Err(reason) => Part::new(vec![Figure::new(name, f64::NAN, "").at_least(RATIO_MIN)], vec![reason]),
    }
}

/// Measures the ratio, and the frames per second of both.
fn measure(root: &Path, python: &Path) -> Result<[f64; 3], String> {
    let mut command = Command::new(python);
    command.arg(root.join("tests/python/bench_read_log.py")).env("PYTHONDONTWRITEBYTECODE", "1");
    figures(&steps::output(&mut command)?)
}

/// Parses the three numbers that the program prints first.
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
