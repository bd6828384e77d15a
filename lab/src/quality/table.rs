//! Percentiles of all runs, and the misses of promises.

use super::run::{METRICS, MODES, Outcome, Run};
use crate::promises::load_step;
use crate::pwm_rate;
use narx_core::motor::Board;
use serde::{Deserialize, Serialize};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// All results of the measurement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// Command that measures again.
    pub command: String,
    /// PWM rate, Hz.
    #[serde(default = "pwm_rate::default")]
    pub pwm_rate: u32,
    /// Number of random motors that were requested.
    pub asked: u64,
    /// Number of random motors that were drawn.
    pub motors: u64,
    /// A row for each population, mode and metric.
    pub rows: Vec<Row>,
    /// Misses of promises.
    pub failures: Vec<Failure>,
}

/// A metric of a population in a mode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Population of motors.
    pub of: String,
    /// Control mode.
    pub mode: String,
    /// Name of the metric.
    pub metric: String,
    /// Its unit.
    pub unit: String,
    /// Promised bound.
    pub most: f64,
    /// Number of runs that have the figure.
    pub runs: u64,
    /// Number of runs beyond the bound.
    pub outside: u64,
    /// Median of the runs.
    pub median: f64,
    /// 95th percentile.
    pub p95: f64,
    /// 99th percentile.
    pub p99: f64,
    /// Largest value.
    pub worst: f64,
}

/// A run that missed a promise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Failure {
    /// Description of the run, and the missed promise.
    pub what: String,
    /// Command that runs it again.
    pub command: String,
}

/// The metric of load steps.
const STEP: &str = "load step of rated torque, within 1 % again";
/// The metric of runs that did not reach their point.
const LOST: &str = "runs that lost step or never reached their speed";
/// The metric of runs that the drive's limits forbid.
const LIMITED: &str = "points that the drive's limits forbid";

impl Row {
    /// Returns whether the row is a promise: points that limits forbid are only counted.
    pub fn is_promise(&self) -> bool {
        self.metric != LIMITED
    }
}

impl Quality {
    pub(super) fn new(board: &Board, asked: u64, motors: u64) -> Self {
        let command = format!("cargo xtask quality --motors {asked}{}", pwm_rate::argument(board));
        Self { command, pwm_rate: board.tick_rate, asked, motors, rows: Vec::new(), failures: Vec::new() }
    }

    /// Adds the rows of a population.
    pub(super) fn judge(&mut self, of: &str, runs: &[Run]) {
        for mode in MODES {
            let runs: Vec<&Run> = runs.iter().filter(|run| run.mode == mode).collect();
            if runs.is_empty() {
                continue;
            }
            for metric in &METRICS {
                let values = runs.iter().filter_map(|run| match &run.outcome {
                    Outcome::Steady(figures) => Some(((metric.of)(figures), *run)),
                    _ => None,
                });
                self.add(of, mode.name(), metric.name, metric.unit, metric.most, values.collect());
            }
            let steps = runs.iter().filter_map(|run| match run.outcome {
                Outcome::Step(seconds) => Some((seconds, *run)),
                _ => None,
            });
            self.add(of, mode.name(), STEP, "s", load_step::BACK, steps.collect());
            let flag = |holds: bool, run| (f64::from(u8::from(holds)), run);
            let tried = runs.iter().filter(|run| !matches!(run.outcome, Outcome::Limited(_)));
            let lost = tried.map(|run| flag(matches!(run.outcome, Outcome::Lost(_)), *run));
            self.add(of, mode.name(), LOST, "", 0.0, lost.collect());
            let limited = runs.iter().map(|run| flag(matches!(run.outcome, Outcome::Limited(_)), *run));
            // Not a promise: it shows to which part of the drawn points the figures apply.
            self.add(of, mode.name(), LIMITED, "", 1.0, limited.collect());
        }
    }

    fn add(
        &mut self,
        of: &str,
        mode: &str,
        metric: &str,
        unit: &str,
        most: f64,
        mut values: Vec<(f64, &Run)>,
    ) {
        values.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        let beyond = values.iter().filter(|(value, _)| *value > most);
        let failures = beyond.map(|(value, run)| {
            let shown = match &run.outcome {
                Outcome::Lost(why) => why.clone(),
                _ => format!("{metric} {value:.2} {unit}, {most} promised"),
            };
            Failure { what: format!("{}: {shown}", run.what), command: run.command.clone() }
        });
        let failures: Vec<Failure> = failures.collect();
        let flag = unit.is_empty();
        let counted = values.iter().filter(|(value, _)| *value > 0.0).count();
        self.rows.push(Row {
            of: of.into(),
            mode: mode.into(),
            metric: metric.into(),
            unit: unit.into(),
            most,
            runs: values.len() as u64,
            outside: if flag { counted } else { failures.len() } as u64,
            median: percentile(&values, 0.5),
            p95: percentile(&values, 0.95),
            p99: percentile(&values, 0.99),
            worst: percentile(&values, 1.0),
        });
        self.failures.extend(failures);
    }

    /// Formats the table for a terminal, failures first.
    pub fn text(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        for failure in &self.failures {
            let _ = writeln!(text, "{}\n    {}", failure.what, failure.command);
        }
        let _ = writeln!(
            text,
            "PWM rate: {} Hz; {} random motors of {} seeds",
            self.pwm_rate, self.motors, self.asked
        );
        let _ = writeln!(
            text,
            "{:<22} {:<10} {:<50} {:>6} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8}",
            "motors", "mode", "metric", "runs", "median", "95 %", "99 %", "worst", "goal", "outside"
        );
        for row in &self.rows {
            let metric = format!("{} {}", row.metric, row.unit);
            let _ = write!(text, "{:<22} {:<10} {:<50} {:>6}", row.of, row.mode, metric.trim_end(), row.runs);
            if row.unit.is_empty() {
                let _ = writeln!(text, " {:>44} {:>8}", "", row.outside);
            } else {
                let Row { median, p95, p99, worst, most, outside, .. } = row;
                let _ = writeln!(
                    text,
                    " {median:>8.2} {p95:>8.2} {p99:>8.2} {worst:>8.2} {most:>8.1} {outside:>8}"
                );
            }
        }
        text
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
        narx_report::figures::write(path, self)
    }
}

/// Percentile of sorted values; 0 if there are none.
fn percentile(values: &[(f64, &Run)], share: f64) -> f64 {
    let place = (share * values.len() as f64).ceil() as usize;
    let value = values.get(place.saturating_sub(1)).map_or(0.0, |(value, _)| *value);
    // Four digits after the point suffice for a percentile.
    (value * 1e4).round() / 1e4
}

/// Describes a run's result in words.
pub(super) fn words(outcome: &Outcome) -> String {
    match outcome {
        Outcome::Limited(why) => format!("not run: {why}"),
        Outcome::Lost(why) => format!("lost: {why}"),
        Outcome::Step(seconds) => format!("within 1 % again after {seconds:.2} s"),
        Outcome::Steady(figures) => {
            let each = METRICS
                .iter()
                .map(|metric| format!("{} {:.2} {}", metric.name, (metric.of)(figures), metric.unit));
            each.collect::<Vec<_>>().join(", ")
        }
    }
}
