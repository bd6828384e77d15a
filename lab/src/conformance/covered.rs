//! Coverage of recordings: states, transitions, faults and events that they contain.

use crate::worlds::Counts;
use narx_core::motor::guard::fault::FaultWord;
use narx_core::motor::machine::state::TRANSITIONS;
use narx_core::motor::{Drive, Event, PwmCommand, Samples, State, Status};
use narx_core::recording::{Recording, Replayable, replay_with};
use serde::{Deserialize, Serialize};

/// Names of the events that a recording can hold.
const EVENTS: [&str; 7] = [
    "command",
    "coefficients",
    "coefficients rejected",
    "slow measurements",
    "health",
    "hall calibration",
    "set-point",
];

const fn index(event: &Event) -> usize {
    match event {
        Event::Command(_) => 0,
        Event::Coefficients(_) => 1,
        Event::CoefficientsRejected => 2,
        Event::Slow(_) => 3,
        Event::Health(_) => 4,
        Event::CalibrateHall(_) => 5,
        Event::SetPoint(_) => 6,
    }
}

/// Sums over recordings. An item that none of them reaches is listed with 0.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Covered {
    /// Total number of ticks.
    pub ticks: u64,
    /// Ticks in each state.
    pub states: Counts,
    /// Number of times that each transition of Table 7 was taken.
    pub transitions: Counts,
    /// Number of recordings in which each fault was seen.
    pub faults: Counts,
    /// Number of events of each kind.
    pub events: Counts,
}

impl Default for Covered {
    fn default() -> Self {
        let counts = |names: &[&str]| names.iter().map(|name| ((*name).to_owned(), 0)).collect();
        Self {
            ticks: 0,
            states: counts(&State::ALL.map(State::name)),
            transitions: TRANSITIONS.iter().map(|row| (row.to_string(), 0)).collect(),
            faults: counts(&FaultWord::all().iter_names().map(|(name, _)| name).collect::<Vec<_>>()),
            events: counts(&EVENTS),
        }
    }
}

impl Covered {
    /// Returns the coverage of one recording. A replay that fails is reported elsewhere, and covers nothing.
    pub fn of(bytes: &[u8]) -> Self {
        let mut covered = Self::default();
        let count = |counts: &mut Counts, name: &str, by| *counts.entry(name.to_owned()).or_default() += by;
        let (mut states, mut steps, mut events) = ([0; 8], [[0; 8]; 8], [0; EVENTS.len()]);
        let (mut faults, mut before) = (FaultWord::empty(), None);
        let replayed = Recording::open(bytes).ok().and_then(|recording| {
            replay_with::<Watched>(&recording, |watched, _, _| {
                let state = watched.drive.state();
                states[state as usize] += 1;
                if let Some(before) = before.replace(state)
                    && before != state
                {
                    steps[before as usize][state as usize] += 1;
                }
                faults |= watched.drive.faults();
                events = watched.events;
            })
            .ok()
        });
        let Some(outcome) = replayed else { return covered };
        covered.ticks = outcome.ticks;
        for (state, ticks) in State::ALL.into_iter().zip(states) {
            count(&mut covered.states, state.name(), ticks);
        }
        // Rows of one name lead from the same state to the same state.
        for row in &TRANSITIONS {
            covered.transitions.insert(row.to_string(), steps[row.from as usize][row.to as usize]);
        }
        faults.iter_names().for_each(|(name, _)| count(&mut covered.faults, name, 1));
        EVENTS.into_iter().zip(events).for_each(|(name, times)| count(&mut covered.events, name, times));
        covered
    }

    /// Adds another coverage.
    #[must_use]
    pub fn and(mut self, other: Self) -> Self {
        self.ticks += other.ticks;
        for (all, more) in [
            (&mut self.states, other.states),
            (&mut self.transitions, other.transitions),
            (&mut self.faults, other.faults),
            (&mut self.events, other.events),
        ] {
            for (name, count) in more {
                *all.entry(name).or_default() += count;
            }
        }
        self
    }
}

/// A drive whose events are counted.
#[derive(Deserialize)]
struct Watched {
    drive: Drive,
    #[serde(skip)]
    events: [u64; EVENTS.len()],
}

impl Replayable for Watched {
    fn handle_event(&mut self, event: Event) {
        self.events[index(&event)] += 1;
        self.drive.handle_event(event);
    }

    fn step(&mut self, samples: &Samples) -> PwmCommand {
        self.drive.step(samples)
    }

    fn poll_status(&mut self) -> Option<Status> {
        self.drive.poll_status()
    }
}
