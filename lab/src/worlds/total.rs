//! Results of many worlds: printed, and stored in docs/evidence/worlds.json.

use super::mishap::KINDS;
use super::never::NEVER;
use super::world::Story;
use narx_core::motor::State;
use narx_core::motor::guard::fault::FaultWord;
use narx_sim::plant::Injection;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;

/// Counts by name.
pub type Counts = BTreeMap<String, u64>;

/// Sums over worlds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Total {
    /// Command that runs them again.
    pub command: String,
    /// Commit of the code that ran.
    pub commit: String,
    /// Number of the first world.
    pub first: u64,
    /// Number of worlds, from the first on.
    pub worlds: u64,
    /// Simulated time, hours.
    pub hours: f64,
    /// Number of power-ups.
    pub boots: u64,
    /// Number of restarts that the operator requested.
    pub resets: u64,
    /// Number of times that the drive's controller went bus-off.
    pub bus_offs: u64,
    /// Number of frames on the bus.
    pub frames: u64,
    /// Number of mishaps of each kind.
    pub mishaps: Counts,
    /// Number of failures of each kind that can be injected.
    pub injections: Counts,
    /// Time in each state, microseconds.
    pub states: Counts,
    /// Identifications that came to a result.
    #[serde(default)]
    pub identified: u64,
    /// Worlds with a second drive on the bus.
    #[serde(default)]
    pub neighbours: u64,
    /// Time in which second drives have driven their motors, microseconds.
    #[serde(default)]
    pub neighbours_driven: u64,
    /// Number of worlds in which each fault was seen.
    pub faults: Counts,
    /// Invariants, and the number of worlds in which each was broken.
    pub invariants: Counts,
    /// Worlds at whose end the motor did not start, and did not start with an untouched drive either.
    pub unable: Vec<u64>,
    /// Worlds with a broken invariant, and its description.
    pub failures: Vec<(u64, String)>,
}

fn counts<'a>(names: impl IntoIterator<Item = &'a str>) -> Counts {
    names.into_iter().map(|name| (name.to_owned(), 0)).collect()
}

fn add<'a>(counts: &mut Counts, more: impl IntoIterator<Item = (&'a str, u64)>) {
    for (name, count) in more {
        *counts.entry(name.to_owned()).or_default() += count;
    }
}

impl Total {
    /// Builds an empty sum.
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
            states: counts(State::ALL.map(State::name)),
            identified: 0,
            neighbours: 0,
            neighbours_driven: 0,
            faults: counts(FaultWord::all().iter_names().map(|(name, _)| name)),
            invariants: counts(NEVER.map(|never| never.name())),
            unable: Vec::new(),
            failures: Vec::new(),
        }
    }

    /// Adds a world.
    pub fn add(&mut self, story: &Story) {
        self.worlds += 1;
        self.boots += story.boots;
        self.resets += story.resets;
        self.bus_offs += story.bus_offs;
        self.frames += story.frames;
        add(&mut self.mishaps, KINDS.map(|kind| kind.name()).into_iter().zip(story.mishaps));
        add(&mut self.injections, Injection::NAMES.into_iter().zip(story.injections));
        add(&mut self.states, State::ALL.map(State::name).into_iter().zip(story.states));
        let faults = FaultWord::from_bits_truncate(story.faults);
        add(&mut self.faults, faults.iter_names().map(|(name, _)| (name, 1)));
        self.hours = self.states.values().sum::<u64>() as f64 * 1e-6 / 3600.0;
        self.identified += story.identified;
        self.neighbours += u64::from(story.neighbour.is_some());
        self.neighbours_driven += story.neighbour.unwrap_or(0);
        if story.unable {
            self.unable.push(story.seed);
        }
        if let Some(broken) = &story.broken {
            add(&mut self.invariants, [(broken.never.name(), 1)]);
            self.failures.push((story.seed, broken.to_string()));
        }
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
            self.states.iter().map(|(name, time)| format!("{name} {:.0} s", *time as f64 * 1e-6)).collect();
        writeln!(f, "states: {}", states.join(", "))?;
        writeln!(f, "mishaps: {}", list(&self.mishaps))?;
        writeln!(f, "identified: {}", self.identified)?;
        let driven = self.neighbours_driven as f64 * 1e-6;
        writeln!(
            f,
            "worlds with two drives: {}, of which the second drove for {driven:.0} s",
            self.neighbours
        )?;
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
