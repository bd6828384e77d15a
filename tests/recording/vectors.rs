//! Tests of the conformance vectors in `tests/vectors`: every recording replays here to the digest in it, and
//! shows the behaviour for which its scenario is named.

use narx_core::motor::machine::event::{Event, Status};
use narx_core::motor::{Drive, PwmCommand, Samples};
use narx_core::recording::{BEHAVIOUR_VERSION, LAYOUT_VERSION, Recording, Replayable, replay_with};
use narx_lab::vectors::{Scenario, Seen, directory, scenarios};
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// The drive with its reports recorded.
#[derive(Deserialize)]
struct Witness {
    drive: Drive,
    #[serde(skip)]
    reports: Vec<Status>,
}

impl Replayable for Witness {
    fn handle_event(&mut self, event: Event) {
        self.drive.handle_event(event);
    }
    fn step(&mut self, samples: &Samples) -> PwmCommand {
        self.drive.step(samples)
    }
    fn poll_status(&mut self) -> Option<Status> {
        let status = self.drive.poll_status();
        self.reports.extend(status);
        status
    }
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

fn file(scenario: &Scenario) -> Vec<u8> {
    let path = directory(&root()).join(format!("{}.narxrec", scenario.name));
    std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}; cargo xtask vectors", path.display()))
}

/// Errors of a vector; none if it is as expected.
fn wrong(scenario: &Scenario) -> Vec<String> {
    let bytes = file(scenario);
    let recording = Recording::open(&bytes).unwrap();
    let mut seen = Seen::new(scenario.plant.board.tick_rate);
    let mut reported = 0;
    let outcome = replay_with(&recording, |witness: &Witness, _, _| {
        // The report of a tick is polled after the tick and before this.
        witness.reports[reported..].iter().for_each(|status| seen.note(status));
        reported = witness.reports.len();
    })
    .unwrap();
    let pole_pairs = f64::from(scenario.plant.motor.pole_pairs);
    let speed = seen.electrical_speed() * 60.0 / pole_pairs;
    let mut wrong = scenario.expect.misses(&seen, Some(speed));
    if outcome.digest != outcome.recorded_digest {
        wrong.push(format!("digest {:016x}, recorded {:016x}", outcome.digest, outcome.recorded_digest));
    }
    let ticks = (scenario.seconds * f64::from(scenario.plant.board.tick_rate)).round() as u64;
    let header = recording.header();
    let versions = (header.behaviour_version, header.layout_version);
    if outcome.ticks != ticks
        || versions != (BEHAVIOUR_VERSION, LAYOUT_VERSION)
        || header.label != scenario.name
    {
        wrong.push(format!("{} ticks of {ticks}, header {header:?}", outcome.ticks));
    }
    wrong
}

#[test]
fn every_vector_replays_and_reaches_what_it_is_named_for() {
    let scenarios = scenarios(&root()).unwrap();
    assert!(scenarios.len() >= 33, "{} vectors", scenarios.len());
    let failed: Vec<_> = scenarios
        .iter()
        .map(|scenario| (scenario.name.as_str(), wrong(scenario)))
        .filter(|(_, wrong)| !wrong.is_empty())
        .collect();
    assert!(failed.is_empty(), "{failed:#?}");
}

/// The test above can fail: the recording of another vector does not meet a scenario's expectations.
#[test]
fn a_vector_under_another_name_is_noticed() {
    let mut scenarios = scenarios(&root()).unwrap();
    let names: Vec<String> = scenarios.iter().map(|scenario| scenario.name.clone()).collect();
    let count = names.len();
    for (index, scenario) in scenarios.iter_mut().enumerate() {
        scenario.name = names[(index + 1) % count].clone();
    }
    for scenario in &scenarios {
        assert!(!wrong(scenario).is_empty(), "{}", scenario.name);
    }
}

/// All vectors together are small enough to be stored beside the sources.
#[test]
fn vectors_stay_small() {
    let bytes: usize = scenarios(&root()).unwrap().iter().map(|scenario| file(scenario).len()).sum();
    assert!(bytes < 2_000_000, "{bytes} bytes");
}
