//! Conformance vectors that are made when they are needed: windows of worlds with many faults at once, and
//! one long recording.

use super::evidence::Set;
use super::replayer::Replay;
use crate::promises::map;
use crate::worlds::{Window, long, windows};
use clap::Args;
use narx_core::motor::State;
use narx_report::steps;
use std::fs;
use std::path::{Path, PathBuf};

/// Number of recordings, their worlds, and the length of the long one.
#[derive(Args, Clone, Copy, Debug)]
pub struct Random {
    /// Number of recordings
    #[arg(long, default_value_t = Self::default().count)]
    pub count: usize,
    /// First world
    #[arg(long, default_value_t = Self::default().first)]
    pub first: u64,
    /// Number of ticks of the long recording
    #[arg(long, default_value_t = Self::default().ticks)]
    pub ticks: u64,
}

impl Default for Random {
    fn default() -> Self {
        Self { count: 1000, first: 1, ticks: 1_000_000 }
    }
}

/// Worlds that are run at once, and largest number of such batches.
const WORLDS: u64 = 32;
const BATCHES_MAX: u64 = 128;

impl Random {
    /// Makes the recordings in `directory` and replays them on every target; the others are compared with the
    /// first one.
    ///
    /// # Errors
    /// Fails with every digest that differs, with the first tick and output, or with a state in which no
    /// recording begins.
    pub fn compare(&self, targets: &[&dyn Replay], directory: &Path) -> steps::Outcome {
        let (sets, files) = self.sets(targets, directory)?;
        let ticks: u64 = sets.iter().map(|set| set.ticks).sum();
        let closing = format!(
            "{} digests equal: {} recordings of worlds from {} on, {ticks} ticks, x {} targets",
            files.len() * targets.len(),
            files.len(),
            self.first,
            targets.len()
        );
        Ok([closing].into_iter().chain(sets.iter().map(|set| set.times(targets))).collect())
    }

    /// Replays the recordings as sets; returns the sets, with the files that were replayed.
    pub(super) fn sets(
        &self,
        targets: &[&dyn Replay],
        directory: &Path,
    ) -> Result<(Vec<Set>, Vec<PathBuf>), String> {
        let mut recordings: Vec<(String, Vec<u8>)> = self
            .windows()?
            .into_iter()
            .enumerate()
            .map(|(index, window)| (format!("random-{index:04}"), window.recording))
            .collect();
        recordings.push(("long".into(), long(self.first, self.ticks)));
        let files = write(directory, &recordings)?;
        let (life, windows) = files.split_last().ok_or("no recording")?;
        let sets = [("windows of worlds", windows), ("one life", std::slice::from_ref(life))];
        let sets: Result<Vec<Set>, String> =
            sets.into_iter().map(|(name, files)| Set::of(name, targets, files)).collect();
        let sets = sets.map_err(|wrong| format!("{wrong}\nThe recordings are in {}", directory.display()))?;
        Ok((sets, files))
    }

    /// Makes windows until there are enough and every state is among them. Of each state it returns the same
    /// number, as far as there are.
    fn windows(&self) -> Result<Vec<Window>, String> {
        let mut found: Vec<Window> = Vec::new();
        let misses = |found: &[Window]| {
            State::ALL.into_iter().find(|state| !found.iter().any(|window| window.state == *state))
        };
        for batch in 0..BATCHES_MAX {
            if found.len() >= self.count && misses(&found).is_none() {
                break;
            }
            let first = self.first + batch * WORLDS;
            let seeds: Vec<u64> = (first..first + WORLDS).collect();
            found.extend(map(&seeds, |seed| windows(*seed)).into_iter().flatten());
        }
        if let Some(state) = misses(&found) {
            return Err(format!("none of {} windows begins in {}", found.len(), state.name()));
        }
        let mut ranks = [0; State::ALL.len()];
        let mut ranked: Vec<(usize, Window)> = found
            .into_iter()
            .map(|window| {
                let rank = &mut ranks[window.state as usize];
                *rank += 1;
                (*rank, window)
            })
            .collect();
        ranked.sort_by_key(|(rank, _)| *rank);
        Ok(ranked.into_iter().take(self.count).map(|(_, window)| window).collect())
    }
}

/// Writes the recordings into an empty directory.
fn write(directory: &Path, recordings: &[(String, Vec<u8>)]) -> Result<Vec<PathBuf>, String> {
    let fail = |path: &Path| {
        let path = path.display().to_string();
        move |error: std::io::Error| format!("{path}: {error}")
    };
    if directory.exists() {
        fs::remove_dir_all(directory).map_err(fail(directory))?;
    }
    fs::create_dir_all(directory).map_err(fail(directory))?;
    recordings
        .iter()
        .map(|(name, bytes)| {
            let path = directory.join(format!("{name}.narxrec"));
            fs::write(&path, bytes).map_err(fail(&path))?;
            Ok(path)
        })
        .collect()
}
