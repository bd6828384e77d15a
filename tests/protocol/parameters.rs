//! Tests of PARAMETER frames: states in which a write is allowed, reasons for refusals, and effects of a
//! write.

use crate::bench::Bench;
use narx_core::bus::narmotion::ParameterStatus::{
    self, Done, OutOfRange, ReadOnly, Storage, UnknownNumber, WrongState,
};
use narx_core::bus::narmotion::{DigitalOutputs, FromDrive, Measurement, MotorMode, ToDrive};
use narx_core::dictionary::{Access, Dictionary, Parameters, number};
use narx_core::motor::Coefficients;
use narx_core::motor::machine::event::{Event, HallCalibration, HallWiring, Status};
use narx_core::motor::machine::state::State;
use narx_core::motor::sense::front_end::Board;
use narx_core::node::SlowInputs;
use narx_core::units::{Amps, Celsius, Volts};

#[test]
fn writes_and_their_answers() {
    let cases: [(u16, i32, i32, ParameterStatus); 20] = [
        (number::CAN_TIMEOUT, 100, 100, Done),
        (number::CAN_TIMEOUT, 0, 100, OutOfRange),
        (number::CAN_TIMEOUT, 60_001, 100, OutOfRange),
        (number::CAN_TIMEOUT, -1, 100, OutOfRange),
        (number::HALL_OFFSET_ANGLE, -18_000, -18_000, Done),
        (number::HALL_OFFSET_ANGLE, -18_001, -18_000, OutOfRange),
        (number::CRITICAL_FAULT_MASK, -1, -1, Done),
        (number::SPEED_MAX_HES, 60_000, 60_000, Done),
        (number::SPEED_MAX_HES, 65_536, 60_000, OutOfRange),
        (number::MEMORY_MAPPING_FLAG, 0, 1, ReadOnly),
        (number::BUILD_NUMBER, 1, 42, ReadOnly),
        (number::DRIVE_STATE, 1, 1, ReadOnly),
        (122, 0, 0, UnknownNumber),
        (255, 7, 0, UnknownNumber),
        (u16::MAX, 7, 0, UnknownNumber),
        // Without a store and a log memory a 0 is just a 0; the rising edge is refused and changes nothing.
        (number::STORE, 0, 0, Done),
        (number::STORE, 1, 0, Storage),
        (number::STORE, 2, 0, OutOfRange),
        (number::LOG_ERASE_REQUEST, 0, 0, Done),
        (number::LOG_ERASE_REQUEST, 1, 0, Storage),
    ];
    let mut bench = Bench::new();
    for (number, value, read_back, status) in cases {
        let before = bench.node.parameters().clone();
        assert_eq!(bench.write(number, value), (read_back, status), "parameter {number} := {value}");
        if status != Done {
            assert_eq!(bench.node.parameters(), &before, "parameter {number} := {value}");
        }
    }
    assert_eq!((bench.refused(), bench.malformed()), (0, 0), "PARAMETER answers, it is not counted");
}

#[test]
fn every_number_answers_a_read() {
    let mut bench = Bench::new();
    for number in (0..400).chain([u16::MAX]) {
        let (value, status) = bench.read(number);
        match Dictionary::row(number) {
            Some(row) => {
                assert_eq!(status, Done);
                assert!(row.accepts(value), "parameter {number} reads {value}, outside its range");
            }
            None => assert_eq!((value, status), (0, UnknownNumber)),
        }
    }
}

#[test]
fn every_writable_parameter_takes_its_whole_range() {
    for row in Dictionary::rows().filter(|row| row.access != Access::ReadOnly && !row.command) {
        let mut bench = Bench::new();
        for value in [row.min(), row.max(), row.default()] {
            assert_eq!(bench.write(row.number, value as i32), (value as i32, Done), "{}", row.name());
            assert_eq!(bench.read(row.number), (value as i32, Done), "{}", row.name());
        }
        assert_eq!(
            bench.write(row.number, (row.min() - 1) as i32).1 == Done,
            row.accepts((row.min() - 1) as i32)
        );
        assert_eq!(
            bench.write(row.number, (row.max() + 1) as i32).1 == Done,
            row.accepts((row.max() + 1) as i32)
        );
    }
}

#[test]
fn state_decides_what_may_be_written() {
    // By category in the specification: these are live, the others need Standby, or Fault at standstill.
    let live = ["04", "06", "13", "15", "16"];
    // A rotor that coasts unseen has no speed either, and does not count as standing.
    let states = State::ALL.into_iter().flat_map(|state| [(state, true), (state, false)]);
    for (state, standstill) in states {
        let stopped = state == State::Standby || (state == State::Fault && standstill);
        for row in Dictionary::rows().filter(|row| row.access != Access::ReadOnly) {
            let mut bench = Bench::new();
            bench.node.handle_status(Status { state, standstill, ..Status::default() });
            bench.messages();
            let live = live.iter().any(|category| row.category.label().starts_with(category));
            let special = match row.number {
                number::HALL_SUPPLY_ENABLE => state != State::HallClosedLoop,
                number::HALL_CALIBRATE | number::AUTO_CALIBRATE => state == State::Standby,
                number::LOG_ERASE_REQUEST => !state.is_driving(),
                _ => true,
            };
            let expected = if (live || stopped) && special { Done } else { WrongState };
            assert_eq!(bench.write(row.number, row.min() as i32).1, expected, "{} in {state:?}", row.name());
        }
    }
}

/// Mechanical position in the broadcast after the tick has reported `sectors`, 0.01 degrees.
fn position(bench: &mut Bench, sectors: i32, now: u64) -> i32 {
    bench.node.handle_status(Status { state: State::Standby, sectors, ..Status::default() });
    bench.node.poll(now);
    let position = |message| match message {
        FromDrive::Measurement(Measurement::M1 { position, .. }) => Some(position),
        _ => None,
    };
    bench.messages().into_iter().find_map(position).expect("MEASUREMENT_1")
}

#[test]
fn a_rising_edge_is_0_then_1_as_written() {
    let mut bench = Bench::new();
    // 24 sectors of a motor with 4 pole pairs are one turn.
    assert_eq!(position(&mut bench, 24, 0), 36_000);
    assert_eq!(bench.write(number::POSITION_CALIBRATION, 9000), (9000, Done));
    assert_eq!(bench.write(number::SET_POSITION, 1), (1, Done), "power-up is no edge");
    assert_eq!(position(&mut bench, 24, 10_000), 36_000);
    assert_eq!(bench.write(number::SET_POSITION, 1), (1, Done), "a second 1 is none");
    assert_eq!(bench.write(number::SET_POSITION, 0), (0, Done));
    assert_eq!(position(&mut bench, 24, 20_000), 36_000);
    assert_eq!(bench.write(number::SET_POSITION, 1), (1, Done));
    assert_eq!(position(&mut bench, 24, 30_000), 9000);
    assert_eq!(position(&mut bench, 25, 40_000), 10_500);
    assert_eq!(bench.write(number::SET_POSITION, 1), (1, Done));
    assert_eq!(position(&mut bench, 26, 50_000), 12_000);
}

#[test]
fn accepted_changes_reach_the_tick_and_refused_ones_do_not() {
    let mut bench = Bench::new();
    let built = |events: &[Event]| events.iter().filter(|e| matches!(e, Event::Coefficients(_))).count();
    bench.write(number::SPEED_RATE, 1234);
    bench.write(number::SPEED_RATE, 1235);
    assert_eq!(built(&bench.events()), 1, "two writes before a poll build once");
    bench.write(number::SPEED_RATE, 0);
    bench.write(number::SCOPE_SAMPLES, 100);
    bench.write(number::DEVICE_NUMBER, 100);
    bench.read(number::SPEED_RATE);
    assert_eq!(bench.events(), []);
}

#[test]
fn what_the_tick_gets_is_what_the_set_builds() {
    let mut bench = Bench::new();
    let mut same = bench.node.parameters().clone();
    same.set(number::SPEED_KP_HES, 500_000).unwrap();
    bench.write(number::SPEED_KP_HES, 500_000);
    let expected = Coefficients::build(&same, &Board::BENCH).unwrap();
    assert_eq!(bench.events(), [Event::Coefficients(expected)]);
}

#[test]
fn a_set_that_does_not_build_is_reported_and_recovers() {
    let mut bench = Bench::new();
    assert_eq!(bench.write(number::SPEED_MIN_HES, 4001).1, Done, "each write is checked alone");
    assert!(matches!(bench.events()[..], [Event::Coefficients(_)]), "nobody needs it");
    bench.write(number::HALL_ENABLE, 1);
    assert_eq!(bench.events(), [Event::CoefficientsRejected]);
    assert_eq!(bench.read(number::REJECTED_PARAMETER), (number::SPEED_MIN_HES.into(), Done));
    bench.write(number::SPEED_MAX_HES, 4500);
    assert!(matches!(bench.events()[..], [Event::Coefficients(_)]));
    assert_eq!(bench.read(number::REJECTED_PARAMETER), (65_535, Done));
}

#[test]
fn hall_calibration_is_requested_withdrawn_and_adopted() {
    let mut bench = Bench::new();
    bench.write(number::HALL_CALIBRATE, 0);
    assert_eq!(bench.write(number::HALL_CALIBRATE, 1), (1, Done));
    assert_eq!(bench.events(), [Event::CalibrateHall(true)]);
    bench.write(number::HALL_CALIBRATE, 0);
    assert_eq!(bench.events(), [Event::CalibrateHall(false)]);
    bench.write(number::HALL_CALIBRATE, 1);
    assert_eq!(bench.events(), [Event::CalibrateHall(true)]);

    let report = |state, hall_calibration| Status { state, hall_calibration, ..Status::default() };
    bench.node.handle_status(report(State::OpenLoop, HallCalibration::Running));
    assert_eq!(bench.read(number::HALL_CALIBRATION_STATE), (1, Done));
    let wiring = HallWiring { order: 3, polarity: 5, offset: -8192 };
    bench.node.handle_status(report(State::Standby, HallCalibration::Done(wiring)));
    let expected = [
        (number::HALL_CALIBRATION_STATE, 2),
        (number::HALL_CALIBRATE, 0),
        (number::HALL_ORDER, 3),
        (number::HALL_POLARITY, 5),
        (number::STANDARD_HALL_SEQUENCE, 0),
        (number::HALL_OFFSET_ANGLE, -4500),
    ];
    for (number, value) in expected {
        assert_eq!(bench.read(number), (value, Done), "parameter {number}");
    }
    assert!(matches!(bench.events()[..], [Event::Coefficients(_)]));
    // A repeated report changes nothing that the master has written since.
    bench.write(number::HALL_ORDER, 0);
    bench.node.handle_status(report(State::Standby, HallCalibration::Done(wiring)));
    assert_eq!(bench.read(number::HALL_ORDER), (0, Done));
}

#[test]
fn a_failed_hall_calibration_changes_no_wiring() {
    let mut bench = Bench::new();
    let before = bench.node.parameters().clone();
    let hall_calibration = HallCalibration::Failed;
    bench.node.handle_status(Status { state: State::Standby, hall_calibration, ..Status::default() });
    assert_eq!(bench.node.parameters(), &before);
    assert_eq!(bench.events(), []);
    assert_eq!(bench.read(number::HALL_CALIBRATION_STATE), (3, Done));
}

#[test]
fn auto_calibration_zeroes_the_current_and_matches_the_supply() {
    let mut bench = Bench::new();
    bench.node.handle_status(Status {
        state: State::Standby,
        bus_current: Amps::from_milli(-35),
        bus_voltage: Volts::from_milli(48_250),
        ..Status::default()
    });
    // Without a nominal supply there is no reference for the calibration.
    bench.write(number::AUTO_CALIBRATE, 0);
    assert_eq!(bench.write(number::AUTO_CALIBRATE, 1), (0, OutOfRange));
    bench.write(number::NOMINAL_SUPPLY, 48_000);
    bench.events();
    bench.write(number::AUTO_CALIBRATE, 0);
    assert_eq!(bench.write(number::AUTO_CALIBRATE, 1), (1, Done));
    assert_eq!(bench.read(number::HV_CURRENT_OFFSET), (35, Done));
    assert_eq!(bench.read(number::HV_VOLTAGE_OFFSET), (-250, Done));
    assert!(matches!(bench.events()[..], [Event::Coefficients(_)]));
    // A supply far from nominal is not corrected as a calibration error.
    bench.write(number::NOMINAL_SUPPLY, 24_000);
    bench.write(number::AUTO_CALIBRATE, 0);
    assert_eq!(bench.write(number::AUTO_CALIBRATE, 1), (0, OutOfRange));
    assert_eq!(bench.read(number::HV_CURRENT_OFFSET), (35, Done));
    // Category 02 returns to its factory values.
    bench.write(number::RESET_CALIBRATION, 0);
    assert_eq!(bench.write(number::RESET_CALIBRATION, 1), (1, Done));
    assert_eq!(bench.read(number::HV_CURRENT_OFFSET), (0, Done));
    assert_eq!(bench.read(number::NOMINAL_SUPPLY), (24_000, Done));
}

#[test]
fn slow_inputs_are_calibrated() {
    let mut bench = Bench::new();
    bench.node.handle_inputs(SlowInputs {
        ambient_temperature: Celsius::from_milli(25_000),
        external_temperature: Celsius::from_milli(150_000),
        pressure: Volts::from_milli(1000),
        ..SlowInputs::default()
    });
    let slow = |bench: &mut Bench| match bench.events()[..] {
        [.., Event::Slow(slow)] => (slow.temperature.scaled(1000), slow.pressure.scaled(1000)),
        ref other => panic!("{other:?}"),
    };
    assert_eq!(slow(&mut bench), (25_000, 1000));
    bench.write(number::TEMPERATURE_OFFSET, -15);
    assert_eq!(slow(&mut bench), (23_500, 1000));
    bench.write(number::TEMPERATURE_SOURCE, 1);
    bench.write(number::PRESSURE_CALIB_GAIN, 2_000_000);
    bench.write(number::PRESSURE_CALIB_OFFSET, -100);
    assert_eq!(slow(&mut bench), (148_500, 1900));
}

#[test]
fn restore_wants_the_serial_number_and_changes_nothing_before_the_reboot() {
    let mut parameters = Parameters::new();
    parameters.set(number::DEVICE_NUMBER, 77).unwrap();
    parameters.set(number::HV_CURRENT_OFFSET, 12).unwrap();
    parameters.set(number::SPEED_RATE, 4321).unwrap();
    let mut bench = Bench::with_parameters(parameters);
    let before = bench.node.parameters().clone();
    for serial in [0, 1, 76, 78, u16::MAX] {
        bench.send(ToDrive::RestoreFactory { serial });
    }
    assert_eq!(bench.refused(), 5);
    for state in [State::Standby, State::HallClosedLoop, State::Fault] {
        bench.enter(state);
        bench.send(ToDrive::RestoreFactory { serial: 77 });
        assert_eq!(bench.refused(), 5, "{state:?}: at any moment");
        assert_eq!(bench.node.parameters(), &before);
        assert_eq!((bench.events(), bench.messages()), (vec![], vec![]), "Figure 14 prints no answer");
    }
}

/// The device number in force is the one of power-up, as with the addresses.
#[test]
fn a_new_device_number_waits_for_the_reboot() {
    let mut bench = Bench::new();
    assert_eq!(bench.write(number::DEVICE_NUMBER, 77), (77, Done));
    for (serial, refused) in [(77, 1), (1, 1)] {
        bench.send(ToDrive::RestoreFactory { serial });
        assert_eq!(bench.refused(), refused, "{serial}");
    }
    bench.send(ToDrive::RequestDeviceInfo);
    assert!(matches!(bench.messages()[..], [FromDrive::DeviceInfo { device_number: 1, .. }]));
    let mut rebooted = Bench::with_parameters(bench.node.parameters().clone());
    rebooted.send(ToDrive::RequestDeviceInfo);
    assert!(matches!(rebooted.messages()[..], [FromDrive::DeviceInfo { device_number: 77, .. }]));
}

#[test]
fn a_new_address_waits_for_the_reboot() {
    let mut bench = Bench::new();
    assert_eq!(bench.write(number::SLAVE_CAN_ADDRESS, 7), (7, Done));
    assert_eq!(bench.read(number::SLAVE_CAN_ADDRESS), (7, Done), "still received at the old address");
    let rebooted = Bench::with_parameters(bench.node.parameters().clone());
    assert_eq!(rebooted.node.addresses().drive, 7);
}

#[test]
fn a_line_is_either_an_output_or_a_shutdown_input() {
    let output = DigitalOutputs { enable1: true, value1: true, ..DigitalOutputs::default() };
    let mut bench = Bench::new();
    bench.send(ToDrive::DigitalOutputs(output));
    assert_eq!(bench.node.outputs().digital, output);
    assert_eq!(bench.write(number::SHUTDOWN_INPUT, 1), (0, WrongState));
    assert_eq!(bench.write(number::SHUTDOWN_INPUT, 2), (2, Done));
    let both = DigitalOutputs { enable2: true, ..output };
    bench.send(ToDrive::DigitalOutputs(both));
    assert_eq!((bench.node.outputs().digital, bench.refused()), (output, 1));
    bench.request(MotorMode::Standby);
    assert_eq!(bench.node.outputs().digital, output);
}

#[test]
fn hall_supply_is_not_cut_under_a_running_motor() {
    let mut bench = Bench::new();
    assert!(bench.node.outputs().hall_supply);
    bench.enter(State::HallClosedLoop);
    bench.send(ToDrive::DisableHallSupply(true));
    assert_eq!(bench.write(number::HALL_SUPPLY_ENABLE, 0), (1, WrongState));
    assert!(bench.node.outputs().hall_supply);
    assert_eq!(bench.refused(), 1);
    bench.enter(State::Standby);
    bench.send(ToDrive::DisableHallSupply(true));
    assert!(!bench.node.outputs().hall_supply);
    assert_eq!(bench.write(number::HALL_SUPPLY_ENABLE, 1), (1, Done));
    assert!(!bench.node.outputs().hall_supply, "Disable_Hall_PS wins");
    bench.send(ToDrive::DisableHallSupply(false));
    assert!(bench.node.outputs().hall_supply);
    bench.write(number::HALL_SUPPLY_ENABLE, 0);
    assert!(!bench.node.outputs().hall_supply);
}
