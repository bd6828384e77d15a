//! What many worlds come to: printed, and kept in docs/evidence/worlds.json.

use super::mishap::KINDS;
use super::never::NEVER;
use super::world::{Story, TICK};
use crate::figures;
use narx_core::motor::State;
use narx_core::motor::fault::FaultWord;
use narx_sim::plant::Injection;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::fs;
use std::path::Path;

/// A count of each, in the order in which they are named.
type Counts = Vec<(String, u64)>;

/// Sums over worlds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Total {
    /// What runs them again.
    pub command: String,
    /// The code that ran.
    pub commit: String,
    /// The first world.
    pub first: u64,
    /// Worlds, from the first on.
    pub worlds: u64,
    /// Simulated.
    pub hours: f64,
    /// Power-ups.
    pub boots: u64,
    /// Restarts that the operator asked for.
    pub resets: u64,
    /// Times that the drive's controller left the bus.
    pub bus_offs: u64,
    /// Frames on the bus.
    pub frames: u64,
    /// Mishaps of each kind.
    pub mishaps: Counts,
    /// What was broken of all that can break.
    pub injections: Counts,
    /// Ticks in each state.
    pub states: Counts,
    /// Worlds in which each fault was seen.
    pub faults: Counts,
    /// What may never happen, and in how many worlds it did.
    pub invariants: Counts,
    /// Worlds at whose end the motor did not start, and did not in a drive to which nothing had happened either.
    pub unable: Vec<u64>,
    /// Worlds in which something happened that may not, and what.
    pub failures: Vec<(u64, String)>,
}

fn counts<'a>(names: impl IntoIterator<Item = &'a str>) -> Counts {
    names.into_iter().map(|name| (name.to_owned(), 0)).collect()
}

impl Total {
    /// Of no world yet.
    pub fn new(command: String, commit: String, first: u64) -> Self {
        Self {
            command,
            commit,
            first,
            worlds: 0,
            hours: 0.0,
            boots: 0,
            resets: 0,
            bus_offs: 0,
            frames: 0,
            mishaps: counts(KINDS.map(|kind| kind.name())),
            injections: counts(Injection::NAMES),
            states: counts(State::ALL.map(|state| state.name())),
            faults: counts(FaultWord::all().iter_names().map(|(name, _)| name)),
            invariants: counts(NEVER.map(|never| never.name())),
            unable: Vec::new(),
            failures: Vec::new(),
        }
    }

    /// One world more.
    pub fn add(&mut self, story: &Story) {
        self.worlds += 1;
        self.boots += story.boots;
        self.resets += story.resets;
        self.bus_offs += story.bus_offs;
        self.frames += story.frames;
        for ((_, all), count) in self.mishaps.iter_mut().zip(story.mishaps) {
            *all += count;
        }
        for ((_, all), count) in self.injections.iter_mut().zip(story.injections) {
            *all += count;
        }
        for ((_, all), ticks) in self.states.iter_mut().zip(story.states) {
            *all += ticks;
        }
        let ticks: u64 = self.states.iter().map(|(_, ticks)| ticks).sum();
        self.hours = ticks as f64 * TICK / 3600.0;
        let seen = FaultWord::all().iter().map(|fault| u64::from(story.faults & fault.bits() != 0));
        for ((_, all), count) in self.faults.iter_mut().zip(seen) {
            *all += count;
        }
        if story.unable {
            self.unable.push(story.seed);
        }
        if let Some(broken) = &story.broken {
            self.invariants[broken.never as usize].1 += 1;
            self.failures.push((story.seed, broken.to_string()));
        }
    }

    /// Reads the file.
    ///
    /// # Errors
    /// There is none, or it is not one of these.
    pub fn read(path: &Path) -> Result<Self, String> {
        let text = fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
        serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))
    }

    /// Writes it.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), String> {
        figures::write(path, self)
    }
}

impl fmt::Display for Total {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { commit, first, worlds, hours, boots, resets, bus_offs, frames, .. } = self;
        writeln!(
            f,
            "{worlds} worlds from {first} on, {hours:.2} simulated hours, {boots} boots, {resets} resets, {bus_offs} bus-offs, {frames} frames, commit {commit}"
        )?;
        let list = |counts: &Counts| {
            counts.iter().map(|(name, count)| format!("{name} {count}")).collect::<Vec<_>>().join(", ")
        };
        let states: Vec<String> =
            self.states.iter().map(|(name, ticks)| format!("{name} {:.0} s", *ticks as f64 * TICK)).collect();
        writeln!(f, "states: {}", states.join(", "))?;
        writeln!(f, "mishaps: {}", list(&self.mishaps))?;
        writeln!(f, "broken parts: {}", list(&self.injections))?;
        writeln!(f, "worlds with a fault: {}", list(&self.faults))?;
        writeln!(
            f,
            "{} worlds whose motor does not start in a drive to which nothing has happened either",
            self.unable.len()
        )?;
        write!(f, "{} worlds in which something happened that may not", self.failures.len())
    }
}
