//! What a comparison came to: printed, and kept in docs/evidence/conformance.json.

use super::covered::Covered;
use super::replayer::Replay;
use super::table::Table;
use crate::bench::map;
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::PathBuf;

/// Recordings of one origin, on every target.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Set {
    /// Where they come from.
    pub name: String,
    /// How many.
    pub recordings: u64,
    /// Their ticks.
    pub ticks: u64,
    /// Of how many the digest is the recorded one, on each target.
    pub equal: Vec<u64>,
    /// How long each target took, s.
    #[serde(skip)]
    pub seconds: Vec<f64>,
}

impl Set {
    /// Replays `files` on every target; the first one is whom the others are compared with.
    ///
    /// # Errors
    /// Every digest that differs, with the first tick and output.
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

    /// How long each target took, in a line.
    pub(super) fn times(&self, targets: &[&dyn Replay]) -> String {
        let times = targets.iter().zip(&self.seconds);
        let times: Vec<String> =
            times.map(|(target, seconds)| format!("{} {seconds:.1} s", target.name())).collect();
        format!("{}, {} ticks: {}", self.name, self.ticks, times.join(", "))
    }
}

/// Everything in one file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Conformance {
    /// What compares again.
    pub command: String,
    /// The code that ran.
    pub commit: String,
    /// Names of the targets, in the order of [`Set::equal`].
    pub targets: Vec<String>,
    /// What was replayed.
    pub sets: Vec<Set>,
    /// What the recordings of all sets lead the drive through.
    pub covered: Covered,
}

impl Conformance {
    /// Digests that are equal.
    pub fn digests(&self) -> u64 {
        self.sets.iter().flat_map(|set| &set.equal).sum()
    }
}

/// What these recordings lead the drive through, all together.
pub(super) fn covered(files: &[PathBuf]) -> Covered {
    let each = map(files, |file| fs::read(file).map(|bytes| Covered::of(&bytes)).unwrap_or_default());
    each.into_iter().fold(Covered::default(), Covered::and)
}
