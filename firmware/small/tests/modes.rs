//! A build with fewer control modes: the PWM commands of what it can run are those of the full build, bit for
//! bit, and the modes that it leaves out cannot be enabled. `cargo xtask test` runs this for hall sensors
//! alone, for sensorless alone and for all modes.

use narx_core::bus::narmotion::ParameterStatus;
use narx_core::dictionary::{Parameters, number};
use narx_core::motor::machine::event::Status;
use narx_core::motor::{Board, Coefficients, Drive, EdgeSource, State};
use narx_core::node::{Identity, Node};
use narx_core::recording::{Digest, Recording, Tick};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

const HALL: bool = cfg!(feature = "hall");
const SENSORLESS: bool = cfg!(feature = "sensorless");
const OPEN_LOOP: bool = cfg!(feature = "open-loop");
const CALIBRATES: bool = cfg!(feature = "hall-calibration");

/// Returns whether this build can run a scenario: it has the modes of the states in it.
fn can_run(scenario: &str) -> bool {
    let has = |state: &str| scenario.contains(state);
    (HALL || !has("HallClosedLoop"))
        && (SENSORLESS || !has("Sensorless"))
        && (OPEN_LOOP || has("Sensorless") || !has("OpenLoop"))
        && (CALIBRATES || !calibrates(scenario))
}

fn calibrates(scenario: &str) -> bool {
    scenario.contains("RotorLock") && !scenario.contains("Sensorless")
}

/// Digest of the PWM commands of a recording. Where no state uses the hall sensors, the motor has none: a
/// full build observes them in every state, and an edge may put off a task of the millisecond by a tick.
fn commands(recording: &[u8], has_halls: bool) -> u64 {
    let recording = Recording::open(recording).unwrap();
    let mut drive: Drive = postcard::from_bytes(recording.state()).unwrap();
    let mut digest = Digest::default();
    for tick in recording.ticks() {
        let Tick { event, mut samples } = tick.unwrap();
        if !has_halls {
            samples.hall = 0;
            samples.edges.retain(|edge| edge.source != EdgeSource::Hall);
        }
        if let Some(event) = event {
            drive.handle_event(event);
        }
        digest.update(&drive.step(&samples), None);
    }
    digest.value()
}

#[test]
fn commands_are_those_of_the_full_build() {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests");
    let golden = tests.join("golden/commands.txt");
    let mut digests = BTreeMap::new();
    for entry in fs::read_dir(tests.join("vectors")).unwrap() {
        let path = entry.unwrap().path();
        let recording = path.with_extension("narxrec");
        if path.extension().is_none_or(|extension| extension != "toml") || !recording.exists() {
            continue;
        }
        let scenario = fs::read_to_string(&path).unwrap();
        if !can_run(&scenario) {
            continue;
        }
        let uses_halls = scenario.contains("HallClosedLoop") || calibrates(&scenario);
        let digest = commands(&fs::read(&recording).unwrap(), uses_halls);
        digests.insert(path.file_stem().unwrap().to_str().unwrap().to_owned(), digest);
    }
    let lines: Vec<String> = digests.iter().map(|(name, digest)| format!("{name} {digest:016x}")).collect();
    if HALL && SENSORLESS && OPEN_LOOP && CALIBRATES && std::env::var_os("UPDATE").is_some() {
        let head = "# CRC-64/XZ of the PWM commands of each vector. Made anew by `cargo xtask generate`.\n";
        fs::write(&golden, format!("{head}{}\n", lines.join("\n"))).unwrap();
    }
    let golden = fs::read_to_string(golden).unwrap();
    assert!(lines.len() >= 10, "{} vectors", lines.len());
    for line in &lines {
        assert!(
            golden.lines().any(|known| known == line),
            "{line}: not the command digest of the full build"
        );
    }
}

/// Parameters that enable the modes, and whether this build has them.
const MODES: [(u16, bool); 3] = [
    (number::HALL_ENABLE, HALL),
    (number::SENSORLESS_ENABLE, SENSORLESS),
    (number::OPEN_LOOP_ENABLE, OPEN_LOOP),
];

#[test]
fn a_master_is_told_that_a_mode_is_left_out() {
    for (switch, present) in MODES {
        let mut node = Node::new(Identity::default(), Board::BENCH);
        node.handle_status(Status { state: State::Standby, ..Status::default() });
        let expected = if present { ParameterStatus::Done } else { ParameterStatus::NotEquipped };
        assert_eq!(node.write_parameter(switch, 1), expected, "{switch}");
        assert_eq!(node.read_parameter(switch), Some(present.into()), "{switch}");
    }
}

#[test]
fn a_mode_that_is_left_out_cannot_be_enabled() {
    for (switch, present) in MODES {
        let mut parameters = Parameters::new();
        parameters.set(switch, 1).unwrap();
        match Coefficients::build(&parameters, &Board::BENCH) {
            Ok(_) => assert!(present, "{switch} was accepted"),
            // The factory's set fits no motor without further parameters, whichever modes there are.
            Err(error) if present => assert_ne!((error.parameter, error.max), (switch, 0)),
            Err(error) => assert_eq!((error.parameter, error.min, error.max), (switch, 0, 0)),
        }
    }
}
