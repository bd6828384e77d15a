//! Tests that a request for missing equipment of a board is refused: each part of the table, by every kind of
//! request.

use super::bench::Bench;
use narx_core::bus::narmotion::{DigitalOutputs, FromDrive, Measurement, ParameterStatus, ToDrive};
use narx_core::dictionary::{Dictionary, Parameters, number};
use narx_core::motor::machine::event::Event;
use narx_core::motor::{Board, Equipment, Status};
use narx_core::node::SlowInputs;
use narx_core::units::{Celsius, Volts};

/// A bench whose board has everything but `part`.
fn without(part: Equipment, parameters: Parameters) -> Bench {
    Bench::on_board(Board { equipment: Equipment::all().difference(part), ..Board::BENCH }, parameters)
}

/// Parameters with values that need the part.
fn asking(part: Equipment) -> &'static [(u16, i32)] {
    match part {
        Equipment::EXTERNAL_TEMPERATURE => &[(number::TEMPERATURE_SOURCE, 1)],
        Equipment::HALL_SUPPLY_SWITCH => &[(number::HALL_SUPPLY_ENABLE, 0)],
        Equipment::DIGITAL_INPUTS => &[(number::SHUTDOWN_INPUT, 1), (number::SHUTDOWN_INPUT, 2)],
        Equipment::ACCELEROMETER => &[
            (number::ACCEL_USE_REFERENCE, 0),
            (number::ACCEL_X_OFFSET, 1),
            (number::ACCEL_Y_OFFSET, 1),
            (number::ACCEL_Z_OFFSET, 1),
            (number::ACCEL_MEAS_OFFSET, 1_700),
        ],
        Equipment::PRESSURE => &[
            (number::PRESSURE_CALIB_OFFSET, 1),
            (number::PRESSURE_CALIB_GAIN, 1),
            (number::PRESSURE_MEAS_OFFSET, 1),
            (number::PRESSURE_MEAS_GAIN, 1),
            (number::OVER_PRESSURE, 1_000),
        ],
        Equipment::LOG => &[
            (number::LOGGING_SLOT_FIRST, 8),
            (number::LOGGING_SLOT_LAST, 8),
            (number::LOG_READ_REQUEST, 1),
            (number::LOG_ERASE_REQUEST, 1),
        ],
        // It has no parameter: see `lines_that_the_board_cannot_drive_are_refused`.
        Equipment::DIGITAL_OUTPUTS => &[],
        other => panic!("{other:?} has no row in this test"),
    }
}

/// Without a part of the table the parameters that need it are refused with a code of their own, keep their
/// factory values, and accept these; with the part they are accepted.
#[test]
fn a_parameter_of_a_missing_part_is_refused() {
    for (_, part) in Equipment::all().iter_names() {
        let mut bench = without(part, Parameters::new());
        for (number, value) in asking(part) {
            let factory = Dictionary::row(*number).unwrap().factory_raw();
            assert_ne!(*value, factory);
            let answer = bench.write(*number, *value);
            assert_eq!(answer, (factory, ParameterStatus::NotEquipped), "{part:?}: {number} = {value}");
            assert_eq!(bench.write(*number, factory), (factory, ParameterStatus::Done));
        }
        // Refused by an answer, so not counted.
        assert_eq!(bench.refused(), 0);
        let mut bench = Bench::new();
        for (number, value) in asking(part) {
            let (_, status) = bench.write(*number, *value);
            assert_ne!(status, ParameterStatus::NotEquipped, "{part:?}: {number} = {value}");
        }
    }
}

/// A stored set from another board, at power-up or from a flash that answers later, uses no missing part.
#[test]
fn a_stored_value_of_a_missing_part_counts_as_its_factory_value() {
    for (_, part) in Equipment::all().iter_names() {
        for (number, value) in
            asking(part).iter().filter(|(number, _)| !Dictionary::row(*number).unwrap().command)
        {
            let factory = Dictionary::row(*number).unwrap().factory_raw();
            let mut stored = Parameters::new();
            stored.set(*number, *value).unwrap();
            let mut bench = without(part, stored.clone());
            assert_eq!(bench.read(*number).0, factory, "{part:?}: {number} = {value}");
            assert_eq!(Bench::with_parameters(stored).read(*number).0, *value);
        }
    }
}

/// Fault logic and derating use a temperature that the board measures, whatever was stored.
#[test]
fn protection_watches_a_temperature_that_exists() {
    let mut stored = Parameters::new();
    stored.set(number::TEMPERATURE_SOURCE, 1).unwrap();
    let mut bench = without(Equipment::EXTERNAL_TEMPERATURE, stored);
    let (ambient, external) = (Celsius::from_ratio(90, 1), Celsius::ZERO);
    bench.node.handle_inputs(SlowInputs {
        ambient_temperature: ambient,
        external_temperature: external,
        ..SlowInputs::default()
    });
    let watched: Vec<Celsius> = bench
        .events()
        .into_iter()
        .filter_map(|event| match event {
            Event::Slow(slow) => Some(slow.temperature),
            _ => None,
        })
        .collect();
    assert_eq!(watched, [ambient]);
}

#[test]
fn lines_that_the_board_cannot_drive_are_refused() {
    let mut bench = without(Equipment::DIGITAL_OUTPUTS, Parameters::new());
    let inputs = DigitalOutputs { value1: true, value2: true, ..DigitalOutputs::default() };
    for (outputs, refused) in [
        (DigitalOutputs { enable1: true, ..inputs }, 1),
        (DigitalOutputs { enable2: true, ..inputs }, 2),
        (inputs, 2),
    ] {
        bench.send(ToDrive::DigitalOutputs(outputs));
        assert_eq!(bench.refused(), refused, "{outputs:?}");
        let digital = bench.node.outputs().digital;
        assert!(!digital.enable1 && !digital.enable2);
    }
}

#[test]
fn a_supply_that_cannot_be_switched_is_not_switched_off() {
    let mut bench = without(Equipment::HALL_SUPPLY_SWITCH, Parameters::new());
    bench.send(ToDrive::DisableHallSupply(true));
    assert_eq!(bench.refused(), 1);
    assert!(bench.node.outputs().hall_supply);
    bench.send(ToDrive::DisableHallSupply(false));
    assert_eq!(bench.refused(), 1, "it is as parameter 97 says");
}

/// A measurement of a missing part reads 0: 0 V at the accelerometer's lines would be -3.6 g.
#[test]
fn a_measurement_of_a_missing_part_is_0() {
    let mut bench = without(Equipment::ACCELEROMETER.union(Equipment::PRESSURE), Parameters::new());
    bench.node.handle_status(Status { command_expired: false, ..Status::default() });
    for _ in 0..100 {
        bench.node.handle_inputs(SlowInputs { accel_reference: Volts::ZERO, ..SlowInputs::default() });
    }
    bench.node.poll(1_000_000);
    let mut seen = 0;
    for message in bench.messages() {
        match message {
            FromDrive::Measurement(Measurement::M0 { accel, .. }) => {
                assert_eq!(accel, [0; 3]);
                seen += 1;
            }
            FromDrive::Measurement(Measurement::M4 { pressure, .. }) => {
                assert_eq!(pressure, 0);
                seen += 1;
            }
            _ => {}
        }
    }
    assert_eq!(seen, 2);
    assert_eq!((bench.read(number::TILT).0, bench.read(number::VIBRATION).0), (0, 0));
}
