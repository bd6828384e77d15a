//! Tests of the law of the deadlines on recordings: windows of worlds with many faults at once, and the
//! conformance vectors.

use narx_core::motor::machine::event::{Event, Status};
use narx_core::motor::{Drive, PwmCommand, Samples};
use narx_core::recording::{Recording, Replayable, replay_with};
use narx_host::parallel::map;
use narx_lab::vectors::{directory, scenarios};
use narx_lab::worlds::windows;
use serde::Deserialize;
use std::path::Path;

/// A drive, beside one that runs every station in every tick.
#[derive(Deserialize)]
struct Pair {
    drive: Drive,
    #[serde(skip)]
    woken: Option<Drive>,
    #[serde(skip)]
    tick: u64,
    /// First tick in which their answers differ, and the second one's answer.
    #[serde(skip)]
    differs: Option<String>,
}

impl Pair {
    fn woken(&mut self) -> &mut Drive {
        self.woken.get_or_insert_with(|| self.drive.clone())
    }

    fn compare<T: PartialEq + std::fmt::Debug>(&mut self, found: &T, expected: &T) {
        if self.differs.is_none() && found != expected {
            self.differs = Some(format!("tick {}: {found:?}, woken {expected:?}", self.tick));
        }
    }
}

impl Replayable for Pair {
    fn handle_event(&mut self, event: Event) {
        self.woken().handle_event(&event);
        self.drive.handle_event(event);
    }
    fn step(&mut self, samples: &Samples) -> PwmCommand {
        let woken = self.woken();
        woken.wake();
        let expected = woken.step(samples);
        let found = self.drive.step(samples);
        self.tick = samples.tick;
        self.compare(&found, &expected);
        found
    }
    fn poll_status(&mut self) -> Option<Status> {
        let expected = self.woken().poll_status();
        let found = self.drive.poll_status();
        self.compare(&found, &expected);
        found
    }
}

/// Replays a recording; returns its ticks if both drives answer alike throughout.
fn replay(bytes: &[u8]) -> Result<u64, String> {
    let recording = Recording::open(bytes).map_err(|error| format!("{error:?}"))?;
    let mut differs = None;
    let outcome = replay_with(&recording, |pair: &Pair, _, _| differs.clone_from(&pair.differs))
        .map_err(|error| format!("{error:?}"))?;
    differs.map_or(Ok(outcome.ticks), Err)
}

#[test]
fn worlds_keep_the_law() {
    let seeds: Vec<u64> = (1..=10).collect();
    let found = map(&seeds, |seed| {
        windows(*seed).iter().map(|window| (window.state, replay(&window.recording))).collect::<Vec<_>>()
    });
    let ticks: u64 = found.iter().flatten().filter_map(|(_, outcome)| outcome.as_ref().ok()).sum();
    let failed: Vec<_> = seeds
        .iter()
        .zip(&found)
        .flat_map(|(seed, windows)| {
            windows.iter().enumerate().map(move |(index, window)| (seed, index, window))
        })
        .filter(|(_, _, (_, outcome))| outcome.is_err())
        .collect();
    assert!(failed.is_empty(), "(seed, window, (state, what)): {failed:#?}");
    assert!(ticks > 10_000, "{ticks} ticks");
}

#[test]
fn vectors_keep_the_law() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let scenarios = scenarios(root).unwrap();
    let failed: Vec<_> = map(&scenarios, |scenario| {
        let path = directory(root).join(format!("{}.narxrec", scenario.name));
        let bytes = std::fs::read(&path).map_err(|error| format!("{error}; cargo xtask vectors"));
        (scenario.name.clone(), bytes.and_then(|bytes| replay(&bytes)))
    })
    .into_iter()
    .filter(|(_, outcome)| outcome.is_err())
    .collect();
    assert!(failed.is_empty(), "{failed:#?}");
}
