//! Result of a comparison: printed, and stored in docs/evidence/conformance.json.

use super::covered::Covered;
use super::replayer::Replay;
use super::table::Table;
use crate::promises::map;
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::PathBuf;

/// Recordings of one origin, on every target.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Set {
    /// Origin of the recordings.
    pub name: String,
    /// Number of recordings.
    pub recordings: u64,
    /// Number of ticks.
    pub ticks: u64,
    /// Number of recordings, on each target, whose digest equals the recorded one.
    pub equal: Vec<u64>,
    /// Time that each target took, s.
    #[serde(skip)]
    pub seconds: Vec<f64>,
}

impl Set {
    /// Replays `files` on every target; the others are compared with the first one.
    ///
    /// # Errors
    /// Fails with every digest that differs, with the first tick and output.
    pub fn of(name: impl Into<String>, targets: &[&dyn Replay], files: &[PathBuf]) -> Result<Self, String> {
        let table = Table::new(targets, files);
        let wrong = table.differences(targets, files);
        if !wrong.is_empty() {
            return Err(wrong.join("\n"));
        }
        Ok(Self {
            name: name.into(),
            recordings: files.len() as u64,
            ticks: table.ticks(),
            equal: table.equal(),
            seconds: table.seconds().to_vec(),
        })
    }

    /// Formats the times that the targets took, in a line.
    pub(super) fn times(&self, targets: &[&dyn Replay]) -> String {
        let times = targets.iter().zip(&self.seconds);
        let times: Vec<String> =
            times.map(|(target, seconds)| format!("{} {seconds:.1} s", target.name())).collect();
        format!("{}, {} ticks: {}", self.name, self.ticks, times.join(", "))
    }
}

/// All results in one file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Conformance {
    /// Command that compares again.
    pub command: String,
    /// Commit of the code that ran.
    pub commit: String,
    /// Names of the targets, in the order of [`Set::equal`].
    pub targets: Vec<String>,
    /// Sets that were replayed.
    pub sets: Vec<Set>,
    /// Coverage of the recordings of all sets.
    pub covered: Covered,
}

impl Conformance {
    /// Number of equal digests.
    pub fn digests(&self) -> u64 {
        self.sets.iter().flat_map(|set| &set.equal).sum()
    }
}

/// Returns the coverage of these recordings together.
pub(super) fn covered(files: &[PathBuf]) -> Covered {
    let each = map(files, |file| fs::read(file).map(|bytes| Covered::of(&bytes)).unwrap_or_default());
    each.into_iter().fold(Covered::default(), Covered::and)
}
