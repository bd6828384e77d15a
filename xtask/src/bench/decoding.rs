//! How fast a log becomes columns in Python, beside python-can with cantools: the program is `tests/python/bench_read_log.py`.

use super::report::Row;
use crate::driven;
use crate::test::python;
use std::process::Command;

/// Goal: how many times as fast as python-can and cantools.
const RATIO_MIN: f64 = 30.0;

/// Rate and ratio on a million frames.
pub(super) fn rows(_: &[u64]) -> Vec<Row> {
    let root = super::root();
    let measured = python::prepare(root).and_then(|python| {
        let mut command = Command::new(python);
        command.arg(root.join("tests/python/bench_read_log.py")).env("PYTHONDONTWRITEBYTECODE", "1");
        figures(&driven::output(&mut command)?)
    });
    let ([ratio, own, reference], failure) = match measured {
        Ok(figures) => (figures, None),
        Err(reason) => ([f64::NAN; 3], Some(reason)),
    };
    vec![Row {
        promise: "a candump log of a million frames as columns in Python",
        goal: ">= 30 times python-can with cantools",
        measured: match &failure {
            Some(_) => "not measured: it needs Python with what tests/python/requirements.txt names".into(),
            None => format!(
                "{:.2} million frames a second, {ratio:.0} times the {reference:.0} of python-can with cantools",
                own / 1e6
            ),
        },
        met: ratio >= RATIO_MIN,
        figures: vec![("frames a second", own), ("python-can and cantools", reference), ("ratio", ratio)],
        failures: failure.into_iter().collect(),
    }]
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
