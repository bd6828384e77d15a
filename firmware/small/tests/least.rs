//! The core without features, or with what finds the wiring of hall sensors alone: the vectors' bits are the
//! same, and services that are left out are refused.

use narx_core::bus::narmotion::{Addresses, ParameterStatus, ToDrive, XmlCommand};
use narx_core::dictionary::{Dictionary, number};
use narx_core::motor::machine::event::Status;
use narx_core::motor::{Board, Drive, State};
use narx_core::node::{Identity, Node, SlowInputs};
use narx_core::recording::{Recording, replay};
use narx_core::units::Volts;
use std::fs;
use std::path::Path;

const CALIBRATES: bool = cfg!(feature = "hall-calibration");

/// Vectors that begin with a hall calibration, which this build may leave out.
const CALIBRATIONS: [&str; 3] = ["hall-calibration", "rotor-lock-fault", "rotor-lock-stop"];

/// 64 bits are divided as 128 are.
#[test]
fn quotients_are_those_of_128_bits() {
    // Nearest, halves away from zero, a denominator of 0 as 1, saturating beyond +-2^46.
    let expected = |numerator: i64, denominator: i32| {
        let denominator = if denominator == 0 { 1 } else { i128::from(denominator) };
        let most = 1 << 46;
        let doubled = i128::from(numerator.clamp(-most, most)) << 17;
        let rounded = (doubled.abs() / denominator.abs() + 1) / 2 * doubled.signum() * denominator.signum();
        rounded.clamp(i32::MIN.into(), i32::MAX.into()) as i32
    };
    let numerators =
        [0, 1, 59, 60, 61, 1 << 15, 65_535, 1_000_003, 1 << 31, (1 << 46) - 1, 1 << 46, i64::MAX];
    let denominators = [0, 1, 2, 3, 7, 60, 1000, 65_536, 99_991, 1 << 30, i32::MAX];
    for (numerator, denominator) in numerators.iter().flat_map(|n| denominators.map(|d| (*n, d))) {
        for (numerator, denominator) in [
            (numerator, denominator),
            (-numerator, denominator),
            (numerator, -denominator),
            (-numerator, -denominator),
        ] {
            let quotient = Volts::from_ratio(numerator, denominator).to_bits();
            assert_eq!(quotient, expected(numerator, denominator), "{numerator} / {denominator}");
        }
    }
}

#[test]
fn every_vector_replays_to_its_digest() {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/vectors");
    let (mut replayed, mut wrong) = (0, Vec::new());
    for entry in fs::read_dir(directory).unwrap() {
        let path = entry.unwrap().path();
        let stem = path.file_stem().unwrap().to_str().unwrap().to_owned();
        let left_out = !CALIBRATES && CALIBRATIONS.contains(&&*stem);
        if left_out || path.extension().is_none_or(|extension| extension != "narxrec") {
            continue;
        }
        let outcome = replay::<Drive>(&Recording::open(&fs::read(&path).unwrap()).unwrap()).unwrap();
        replayed += 1;
        if !outcome.is_identical() {
            wrong.push(format!("{stem}: {:016x}, recorded {:016x}", outcome.digest, outcome.recorded_digest));
        }
    }
    assert!(replayed >= 33, "{replayed} vectors");
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Another package's features would make the test above say nothing.
#[test]
fn it_is_the_core_without_features() {
    let names: String = Dictionary::rows().map(|row| row.name()).collect();
    assert_eq!(names, "", "features are on: cargo test -p narx-small");
    assert!(Dictionary::find("").is_none() && Dictionary::find("Max duty cycle").is_none());
}

fn standing() -> Node {
    let mut node = Node::new(Identity::default(), Board::BENCH);
    node.handle_status(Status { state: State::Standby, ..Status::default() });
    node
}

#[test]
fn requests_for_what_is_left_out_are_refused_and_counted() {
    let mut node = standing();
    let requests = [
        ToDrive::TriggerScope,
        ToDrive::DownloadScope,
        ToDrive::DownloadXml(XmlCommand::Length),
        ToDrive::DownloadXml(XmlCommand::Start),
    ];
    for (before, request) in (0..).zip(requests) {
        assert_eq!(node.read_parameter(number::REFUSED_FRAMES), Some(before), "before {request:?}");
        node.handle_frame(&request.encode(Addresses::FACTORY));
        node.poll(0);
        while node.poll_frame().is_some() {}
        assert!(node.poll_bulk_frame().is_none() && node.poll_scope().is_none(), "{request:?}");
    }
    assert_eq!(node.read_parameter(number::REFUSED_FRAMES), Some(4));
    assert_eq!(node.read_parameter(number::SCOPE_STATE), Some(0));
}

#[test]
fn commands_of_what_is_left_out_are_answered_with_a_status() {
    use ParameterStatus::{Done, NotEquipped, Storage};
    let rows = [
        (number::HALL_CALIBRATE, if CALIBRATES { Done } else { NotEquipped }),
        (number::LOG_READ_REQUEST, NotEquipped),
        (number::LOG_ERASE_REQUEST, NotEquipped),
        (number::STORE, Storage),
        (number::SET_POSITION, Done),
    ];
    for (command, expected) in rows {
        let mut node = standing();
        assert_eq!(node.write_parameter(command, 0), Done, "{command}");
        assert_eq!(node.write_parameter(command, 1), expected, "{command}");
    }
}

#[test]
fn acceleration_reads_nothing() {
    let mut node = standing();
    let inputs = SlowInputs { accel: [Volts::from_milli(2_500); 3], ..SlowInputs::default() };
    (0..200).for_each(|_| node.handle_inputs(inputs));
    assert_eq!(
        (node.read_parameter(number::TILT), node.read_parameter(number::VIBRATION)),
        (Some(0), Some(0))
    );
}
