//! Tests of the master's knowledge of the drive: words, faults, states, measurements, parameters, with their
//! ages.

use crate::bench::frame;
use crate::pair::{Pair, is_request, said};
use narx_core::bus::narmotion::{
    Addresses, ControlMode, FromDrive, Measurement, MotorMode, Opcode, ParameterStatus, SIGNALS, StatusWord,
    ToDrive,
};
use narx_core::dictionary::{Access, Decimal, PARAMETER_COUNT, number};
use narx_core::master::{Config, Master, Received};
use narx_core::motor::guard::fault::{Cause, FaultWord};
use narx_core::motor::machine::state::State;

const MS: u64 = 1000;

#[test]
fn parameters_are_read_at_the_beginning_and_kept() {
    let mut pair = Pair::new(Config::default());
    pair.step();
    assert_eq!(
        (pair.master.parameters().known(), pair.master.parameters_to_read()),
        (0, 0),
        "nobody was received yet"
    );
    pair.run(400);
    assert_eq!((pair.master.parameters().known(), pair.master.parameters_to_read()), (PARAMETER_COUNT, 0));
    for (row, received) in pair.master.parameters().iter() {
        let received = received.unwrap();
        let live = row.access == Access::ReadOnly;
        assert!(
            live || Some(received.value) == pair.bench.node.parameters().value(row.number),
            "{}",
            row.name()
        );
        assert!(received.at <= pair.now && received.age(pair.now) <= 400 * MS);
    }
    assert_eq!(pair.master.parameters().find("CAN TimeOut period").map(|received| received.value), Some(250));
    assert_eq!(pair.master.parameters().get(122), None);

    let mut quiet = Pair::quiet();
    quiet.run(400);
    assert_eq!(quiet.take_sent(is_request), [], "not asked to read");
    quiet.master.read_parameters();
    quiet.run(400);
    assert_eq!(quiet.master.parameters().known(), PARAMETER_COUNT);
}

#[test]
fn reading_that_begins_anew_leaves_nothing_out() {
    let mut pair = Pair::new(Config::default());
    pair.run(100);
    // Waits for the time between a request and its answer.
    loop {
        pair.step();
        let asked = !pair.take_sent(is_request).is_empty();
        if asked && pair.master.parameters_to_read() < 50 {
            break;
        }
    }
    let begin = pair.now;
    pair.master.read_parameters();
    pair.run(400);
    assert!(pair.master.parameters().iter().all(|(_, received)| received.unwrap().at > begin));
}

#[test]
fn a_drive_that_comes_back_is_read_again() {
    let mut pair = Pair::new(Config::default());
    pair.run(400);
    // The drive falls silent: no frame arrives at the master.
    let silence = |pair: &mut Pair, milliseconds: u64| {
        for _ in 0..milliseconds * 10 {
            pair.now += 100;
            while pair.master.poll_frame(pair.now).is_some() {}
        }
    };
    silence(&mut pair, 400);
    assert!(pair.master.is_connected(pair.now));
    silence(&mut pair, 200);
    assert!(!pair.master.is_connected(pair.now));
    assert_eq!(pair.master.parameters().known(), PARAMETER_COUNT, "old values with their age");
    pair.bench.node.write_parameter(number::SPEED_RATE, 1234);
    pair.run(400);
    assert!(pair.master.is_connected(pair.now));
    assert_eq!(pair.master.parameters().get(number::SPEED_RATE).map(|received| received.value), Some(1234));
}

#[test]
fn a_drive_that_seldom_speaks_is_not_lost() {
    let mut pair = Pair::new(Config::default());
    pair.bench.node.write_parameter(number::AUTOSEND_PERIOD, 1000);
    pair.run(500);
    let last = pair.master.report().last.unwrap();
    assert!(pair.master.is_connected(last + 2_999 * MS));
    assert!(!pair.master.is_connected(last + 3_000 * MS));
}

#[test]
fn what_the_drive_says_is_kept_with_its_time() {
    let mut master = Master::new(Config::default());
    assert_eq!((master.report().status, master.state(), master.speed()), (None, None, None));
    let status = StatusWord {
        mode: MotorMode::Reverse,
        control: ControlMode::Hall,
        logging: 3,
        memory_full: true,
        memory_erased: false,
        read_enable: true,
        erase_enable: false,
    };
    let faults = FaultWord::OVER_VOLTAGE | FaultWord::TEMPERATURE_WARNING;
    let critical = FaultWord::OVER_VOLTAGE;
    master.handle_frame(&said(FromDrive::Status(status)), 100);
    master.handle_frame(&said(FromDrive::Faults(faults)), 200);
    master.handle_frame(&said(FromDrive::CriticalFault { faults: critical, code: 0x0201 }), 300);
    let report = *master.report();
    assert_eq!(report.status, Some(Received { value: status, at: 100 }));
    assert_eq!(report.faults, Some(Received { value: faults, at: 200 }));
    let fault = report.critical.unwrap();
    assert_eq!((fault.value.faults, fault.at, fault.age(1300)), (critical, 300, 1000));
    assert_eq!(fault.value.cause().map(|row| row.cause), Some(Cause::OverVoltage));
    assert_eq!(report.last, Some(300));
    assert_eq!(master.state(), Some(State::HallClosedLoop));
}

#[test]
fn the_exact_state_is_asked_for() {
    for state in State::ALL {
        let mut pair = Pair::quiet();
        pair.bench.enter(state);
        pair.run(60);
        assert_eq!(pair.master.state(), Some(state));
    }
    // A state that contradicts a newer status word is not reported.
    let mut pair = Pair::quiet();
    pair.bench.enter(State::OpenLoop);
    pair.run(60);
    let standby = said(FromDrive::Status(StatusWord::default()));
    pair.master.handle_frame(&standby, pair.now);
    assert_eq!(pair.master.state(), None);
}

#[test]
fn measurements_have_names_units_and_ages() {
    let mut master = Master::new(Config::default());
    assert!(master.measurements().iter().all(|(_, received)| received.is_none()));
    let frames = [
        Measurement::M0 { accel: [-1000, 2, 3], dsi1: true },
        Measurement::M1 { speed_sensorless: -4000, position: -123_456, power: 1500 },
        Measurement::M2 { bus_voltage: 4801, bus_current: -7, rail_6v: 6000, rail_14v: 14_000 },
        Measurement::M3 { temperature: 1855, accel_reference: 1800, reference: 383, asi: -1 },
        Measurement::M4 { phase_voltage: [1, -1, 2], pressure: 55 },
        Measurement::M5 { speed_hall: 3999, dsi2: false },
        Measurement::M7([1, 2, 3, 4]),
        Measurement::M8([5, 6, 7, 8]),
    ];
    for (at, measurement) in (0..).zip(frames) {
        master.handle_frame(&said(FromDrive::Measurement(measurement)), at);
    }
    let text: Vec<String> = master
        .measurements()
        .iter()
        .map(|(signal, received)| format!("{} {} {}", signal.name, received.unwrap().value, signal.unit))
        .collect();
    let expected = [
        "Accel X -1 g",
        "Accel Y 0.002 g",
        "Accel Z 0.003 g",
        "DSI1_DSP 1 -",
        "Mechanical estimated speed SL -4000 rpm",
        "Mechanical position -1234.56 deg",
        "Electrical input Power 150 W",
        "HV Voltage 48.01 V",
        "HV Current -0.007 A",
        "+6V_MEAS 6 V",
        "Driver 14V Voltage 14 V",
        "Ambient Temperature 185.5 °C",
        "Vref Accel (+1.8V) 1.8 V",
        "+0.383VREF 0.383 V",
        "ASI_DSP -0.001 V",
        "VoltagePhaseA 0.01 V",
        "VoltagePhaseB -0.01 V",
        "VoltagePhaseC 0.02 V",
        "PIN_MEAS 0.055 V",
        "Mechanical estimated speed HES 3999 rpm",
        "DSI2_DSP 0 -",
    ];
    assert_eq!(text, expected);
    let voltage = Received { value: Decimal { digits: 4801, exponent: -2 }, at: 2 };
    assert_eq!(master.measurements().find("hv voltage"), Some(voltage));
    assert_eq!(master.measurements().get(&SIGNALS[7]), Some(voltage));
    let frame = |number| master.measurements().frame(Opcode::new(number).unwrap());
    assert_eq!(frame(207), Some(Received { value: Measurement::M7([1, 2, 3, 4]), at: 6 }));
    assert_eq!(frame(208), Some(Received { value: Measurement::M8([5, 6, 7, 8]), at: 7 }));
    assert_eq!((frame(206), frame(209), frame(110)), (None, None, None));
}

/// The reported speed is that of the control mode, by SL and HES; the mode at rest reports 0.
#[test]
fn the_speed_is_that_of_the_control_mode() {
    use ControlMode::{Hall, Off, OpenLoop, Sensorless};
    for (control, sensorless, hall, expected) in [
        (Some(Hall), 0, 3999, 3999),
        (Some(Hall), -12, 0, 0),
        (Some(Sensorless), -4000, 0, -4000),
        (Some(Sensorless), 0, 3, 0),
        // The speed is the field's, whatever the hall sensors see of the rotor behind it.
        (Some(OpenLoop), 500, 0, 500),
        (Some(OpenLoop), 500, 490, 500),
        // The field of a calibration is not reported.
        (Some(OpenLoop), 0, -60, -60),
        // A coasting rotor.
        (Some(Off), 0, 1200, 1200),
        (Some(Off), 1300, 0, 1300),
        (Some(Off), 0, 0, 0),
        (None, -4000, 3999, -4000),
    ] {
        let mut master = Master::new(Config::default());
        if let Some(control) = control {
            let status = StatusWord { mode: MotorMode::Drive, control, ..StatusWord::default() };
            master.handle_frame(&said(FromDrive::Status(status)), 0);
        }
        assert_eq!(master.speed(), None);
        let m1 = Measurement::M1 { speed_sensorless: sensorless, position: 0, power: 0 };
        for measurement in [m1, Measurement::M5 { speed_hall: hall, dsi2: false }] {
            master.handle_frame(&said(FromDrive::Measurement(measurement)), 9);
        }
        let case = format!("{control:?}, {sensorless} rpm by SL, {hall} rpm by HES");
        assert_eq!(master.speed(), Some(Received { value: expected, at: 9 }), "{case}");
        assert_eq!(master.speed(), master.measurements().speed(control), "{case}");
    }
}

#[test]
fn other_addresses_are_somebody_elses() {
    let addresses = Addresses { drive: 17, master: 4 };
    let mut master = Master::new(Config { addresses, ..Config::default() });
    let sent = ToDrive::decode(&master.poll_frame(0).unwrap()).unwrap();
    assert_eq!((sent.0.source, sent.0.destination), (4, 17));
    let status = FromDrive::Status(StatusWord::default());
    let elsewhere = [
        Addresses::FACTORY,
        Addresses { drive: 17, master: 5 },
        Addresses { drive: 18, master: 4 },
        Addresses { drive: 4, master: 17 },
    ];
    for (at, addresses) in (0..).zip(elsewhere) {
        master.handle_frame(&status.encode(addresses), at);
        assert_eq!(master.report().last, None);
    }
    master.handle_frame(&frame(0x1552_A803, 4 << 32), 5);
    master.handle_frame(&status.encode(addresses), 6);
    assert_eq!(master.report().last, Some(6));
}

/// A drive of another version has parameters that this dictionary does not have; they are ignored.
#[test]
fn a_parameter_that_is_not_known_here_is_passed_over() {
    let mut master = Master::new(Config::default());
    let answer = FromDrive::Parameter { number: 9999, value: 7, status: ParameterStatus::Done };
    master.handle_frame(&said(answer), 5);
    assert_eq!((master.parameters().known(), master.parameters().get(9999)), (0, None));
    assert!(master.is_connected(5));
}
