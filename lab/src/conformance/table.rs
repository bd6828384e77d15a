//! Table of digests, with a row for each vector and a column for each target.

use super::answer::Answer;
use super::difference::locate;
use super::replayer::{Replay, stem};
use crate::promises::map;
use std::fmt;
use std::path::PathBuf;
use std::time::Instant;

/// Answers of every target to every recording.
#[derive(Debug)]
pub struct Table {
    names: Vec<String>,
    stems: Vec<String>,
    /// A column for each target.
    answers: Vec<Vec<Result<Answer, String>>>,
    /// Time that each target took, s.
    seconds: Vec<f64>,
}

impl Table {
    /// Replays every file on every target, as many targets at once as the machine has processors.
    pub fn new(targets: &[&dyn Replay], files: &[PathBuf]) -> Self {
        let ask = |target: &&dyn Replay| {
            let begun = Instant::now();
            (target.replay(files, None), begun.elapsed().as_secs_f64())
        };
        let (answers, seconds) = map(targets, ask).into_iter().unzip();
        Self {
            names: targets.iter().map(|target| target.name().to_owned()).collect(),
            stems: files.iter().map(|file| stem(file)).collect(),
            answers,
            seconds,
        }
    }

    /// Number of cells.
    pub const fn len(&self) -> usize {
        self.names.len() * self.stems.len()
    }

    /// Returns whether there is no cell.
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Ticks of all recordings, as the first target has replayed them.
    pub fn ticks(&self) -> u64 {
        self.answers.first().into_iter().flatten().flatten().map(|answer| answer.ticks).sum()
    }

    /// Number of recordings, on each target, whose digest equals the recorded one.
    pub fn equal(&self) -> Vec<u64> {
        self.answers.iter().map(|column| column.iter().filter(|cell| is_same(cell)).count() as u64).collect()
    }

    /// Time that each target took, s.
    pub fn seconds(&self) -> &[f64] {
        &self.seconds
    }

    /// Returns a line for every cell that is not as expected. For a target that differs from the first one
    /// the place of the difference is searched.
    pub fn differences(&self, targets: &[&dyn Replay], files: &[PathBuf]) -> Vec<String> {
        let mut lines = Vec::new();
        for (row, file) in files.iter().enumerate() {
            let stem = &self.stems[row];
            let reference = &self.answers[0][row];
            for (column, target) in targets.iter().enumerate() {
                let name = &self.names[column];
                match (&self.answers[column][row], reference) {
                    (Err(reason), _) => lines.push(format!("{stem}: {name}: {reason}")),
                    (Ok(answer), Ok(reference)) if column > 0 && answer != reference => {
                        lines.push(match locate(targets[0], *target, file) {
                            Ok(Some(difference)) => format!("{stem}: {name}: {difference}"),
                            Ok(None) => format!("{stem}: {name}: {answer:?}, but {reference:?} before"),
                            Err(reason) => format!("{stem}: {name}: {reason}"),
                        });
                    }
                    (Ok(answer), _) if answer.recorded != Some(answer.digest) => lines.push(format!(
                        "{stem}: {name}: digest {:016x}, but {:016x} was recorded: the control core has changed \
                         (cargo xtask vectors)",
                        answer.digest,
                        answer.recorded.unwrap_or_default(),
                    )),
                    _ => {}
                }
            }
        }
        lines
    }
}

/// Returns whether the replay gave the recorded digest.
fn is_same(cell: &Result<Answer, String>) -> bool {
    cell.as_ref().is_ok_and(|answer| answer.recorded == Some(answer.digest))
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let wide = self.stems.iter().map(String::len).max().unwrap_or(0);
        write!(f, "{:<wide$} {:>6} {:>16}", "vector", "ticks", "digest")?;
        for name in &self.names {
            write!(f, "  {name}")?;
        }
        for (row, stem) in self.stems.iter().enumerate() {
            match self.answers.first().and_then(|column| column.get(row)) {
                Some(Ok(answer)) => write!(f, "\n{stem:<wide$} {:>6} {:016x}", answer.ticks, answer.digest)?,
                _ => write!(f, "\n{stem:<wide$} {:>6} {:>16}", "", "")?,
            }
            for (name, column) in self.names.iter().zip(&self.answers) {
                let verdict = match &column[row] {
                    cell if is_same(cell) => "same",
                    Ok(_) => "DIFFERS",
                    Err(_) => "ERROR",
                };
                write!(f, "  {verdict:<0$}", name.len())?;
            }
        }
        Ok(())
    }
}
