//! The master and the node: commands, requests and their refusals, time-outs, what is heard, silence.

use crate::bench::{IDENTITY, frame};
use crate::pair::{Pair, said};
use narx_core::bus::narmotion::{
    Addresses, ControlMode, DigitalOutputs, FromDrive, Measurement, MotorMode, Opcode, ParameterStatus,
    RequestWord, SIGNALS, StatusWord, ToDrive,
};
use narx_core::dictionary::{Access, Decimal, Dictionary, PARAMETER_COUNT, Parameters, number};
use narx_core::master::{
    Answer, BuildInfo, Config, DeviceInfo, Download, Heard, Master, NotTaken, Request, RequestError, Service,
};
use narx_core::motor::event::{Request as MotorRequest, Status};
use narx_core::motor::fault::{Cause, FaultWord};
use narx_core::motor::state::State;
use narx_core::node::Action;
use narx_core::units::Volts;
use proptest::prelude::*;

const MS: u64 = 1000;

/// What is not a set-point, a request word or a read of the exact state.
fn asked(message: &ToDrive) -> bool {
    !matches!(
        message,
        ToDrive::MotorCommand { .. }
            | ToDrive::RequestWord(_)
            | ToDrive::RequestParameter { number: number::DRIVE_STATE }
    )
}

fn requested(mode: MotorMode) -> ToDrive {
    ToDrive::RequestWord(RequestWord { mode })
}

#[test]
fn set_points_alone_until_something_is_commanded() {
    let mut pair = Pair::quiet();
    pair.run(200);
    let sent: Vec<(u64, ToDrive)> = pair
        .sent
        .iter()
        .copied()
        .filter(|(_, message)| !matches!(message, ToDrive::RequestParameter { .. }))
        .collect();
    let expected: Vec<(u64, ToDrive)> =
        [0, 50, 100, 150].map(|at| (at * MS + 100, ToDrive::MotorCommand { speed: 0 })).into();
    assert_eq!(sent, expected);
    assert!(pair.bench.commands().iter().all(|(request, _)| request.is_none()), "nothing is acknowledged");
}

#[test]
fn commands_go_out_at_once_and_are_repeated() {
    let mut pair = Pair::quiet();
    pair.master.stop();
    pair.run(60);
    pair.take_sent(|_| true);
    pair.master.start(-3000);
    pair.step();
    let command = [ToDrive::MotorCommand { speed: 3000 }, requested(MotorMode::Reverse)];
    assert_eq!(pair.take_sent(asked_or_commanded), command);
    pair.run(49);
    assert_eq!(pair.take_sent(asked_or_commanded), []);
    pair.run(1);
    assert_eq!(pair.take_sent(asked_or_commanded), command);
    pair.master.set_speed(1200);
    pair.step();
    assert_eq!(pair.take_sent(asked_or_commanded)[0], ToDrive::MotorCommand { speed: 1200 });
    pair.master.shut_down();
    pair.step();
    assert_eq!(pair.take_sent(asked_or_commanded)[1], requested(MotorMode::Fault));
    assert_eq!((pair.master.requested(), pair.master.setpoint()), (Some(MotorMode::Fault), 1200));
    let requests: Vec<MotorRequest> =
        pair.bench.commands().iter().filter_map(|(request, _)| *request).collect();
    assert_eq!(requests, [MotorRequest::Standby, MotorRequest::Reverse]);
}

fn asked_or_commanded(message: &ToDrive) -> bool {
    !matches!(message, ToDrive::RequestParameter { number: number::DRIVE_STATE })
}

#[test]
fn a_started_drive_is_fed_and_says_what_it_accepts() {
    let mut parameters = Parameters::new();
    parameters.set(number::HALL_ENABLE, 1).unwrap();
    let mut pair = Pair::with_parameters(Config::default(), parameters);
    pair.master.start(9000);
    pair.run(1);
    assert_eq!(pair.master.report().accepted_speed.map(|heard| heard.value), Some(4000), "parameter 103");
    pair.master.set_speed(0);
    pair.run(1);
    assert_eq!(pair.master.report().accepted_speed.map(|heard| heard.value), Some(500), "parameter 104");
    // The mirror is filled meanwhile, and does not hold the commands up.
    pair.take_sent(|_| true);
    pair.run(400);
    let fed: Vec<u64> = pair
        .sent
        .iter()
        .filter(|(_, message)| matches!(message, ToDrive::RequestWord(_)))
        .map(|(at, _)| *at)
        .collect();
    assert_eq!(fed.len(), 8);
    assert!(fed.windows(2).all(|pair| pair[1] - pair[0] == 50 * MS), "{fed:?}");
    assert_eq!(pair.master.parameters().known(), PARAMETER_COUNT);
}

#[test]
fn parameters_are_read_at_the_beginning_and_kept() {
    let mut pair = Pair::new(Config::default());
    pair.step();
    assert_eq!(
        (pair.master.parameters().known(), pair.master.parameters_to_read()),
        (0, 0),
        "nobody was heard yet"
    );
    pair.run(400);
    assert_eq!((pair.master.parameters().known(), pair.master.parameters_to_read()), (PARAMETER_COUNT, 0));
    for (row, heard) in pair.master.parameters().iter() {
        let heard = heard.unwrap();
        let live = row.access == Access::ReadOnly;
        assert!(live || Some(heard.value) == pair.bench.node.parameters().value(row.number), "{}", row.name);
        assert!(heard.at <= pair.now && heard.age(pair.now) <= 400 * MS);
    }
    assert_eq!(pair.master.parameters().find("CAN TimeOut period").map(|heard| heard.value), Some(250));
    assert_eq!(pair.master.parameters().get(122), None);

    let mut quiet = Pair::quiet();
    quiet.run(400);
    assert_eq!(quiet.take_sent(asked), [], "not asked to read");
    quiet.master.read_parameters();
    quiet.run(400);
    assert_eq!(quiet.master.parameters().known(), PARAMETER_COUNT);
}

#[test]
fn a_drive_that_comes_back_is_read_again() {
    let mut pair = Pair::new(Config::default());
    pair.run(400);
    // It falls silent: nothing arrives at the master.
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
    assert_eq!(pair.master.parameters().get(number::SPEED_RATE).map(|heard| heard.value), Some(1234));
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
fn reads_and_writes_are_answered_in_their_order() {
    let mut pair = Pair::quiet();
    let requests = [
        Request::write("speed setpoint rate", 777).unwrap(),
        Request::read("Speed Setpoint Rate").unwrap(),
        Request::BuildInfo,
        Request::Read { number: number::CAN_TIMEOUT },
        Request::DeviceInfo,
    ];
    for request in requests {
        pair.master.request(request).unwrap();
    }
    pair.run(20);
    let answers: Vec<Answer> = std::iter::from_fn(|| pair.master.poll_answer()).collect();
    let values = [777, 777, 0, 250, 0];
    let expected: Vec<Answer> = requests
        .into_iter()
        .zip(values)
        .map(|(request, value)| Answer { request, result: Ok(value) })
        .collect();
    assert_eq!(answers, expected);
    assert_eq!(pair.bench.node.parameters().raw(number::SPEED_RATE), 777);
    let build = BuildInfo { number: IDENTITY.build_number, modified: false, date: 20_261_120 };
    assert_eq!(pair.master.report().build.map(|heard| heard.value), Some(build));
    let device = DeviceInfo { hardware: 3, software: 0x0102, device_number: 1, address: 170 };
    assert_eq!(pair.master.report().device.map(|heard| heard.value), Some(device));
    assert_eq!((Request::read("no such name"), Request::write("no such name", 1)), (None, None));
}

#[test]
fn refusals_carry_their_reason() {
    use ParameterStatus::{OutOfRange, ReadOnly, Storage, UnknownNumber, WrongState};
    let cases: [(State, Request, ParameterStatus, Option<i32>, &str); 9] = [
        (
            State::Standby,
            Request::Read { number: 122 },
            UnknownNumber,
            None,
            "parameter 122: there is no such parameter",
        ),
        (
            State::Standby,
            Request::Write { number: 9999, raw: 1 },
            UnknownNumber,
            Some(1),
            "parameter 9999: there is no such parameter",
        ),
        (
            State::Standby,
            Request::Write { number: number::DRIVE_STATE, raw: 1 },
            ReadOnly,
            Some(1),
            "parameter 261 \"Drive state\": the drive alone writes it",
        ),
        (
            State::Standby,
            Request::Write { number: number::OVER_VOLTAGE, raw: 62_500 },
            OutOfRange,
            Some(62_500),
            "parameter 119 \"Over-voltage HV threshold\": 62.5 V is outside 18 to 62 V",
        ),
        (
            State::HallClosedLoop,
            Request::Write { number: number::CAN_TIMEOUT, raw: 100 },
            WrongState,
            Some(100),
            "parameter 114 \"Can TimeOut period\": not in this state of the drive",
        ),
        (
            State::HallClosedLoop,
            Request::Run(Service::ResetCalibration),
            WrongState,
            Some(0),
            "parameter 258 \"Reset calibration parameters\": not in this state of the drive",
        ),
        // A bus of 0 V is no calibration.
        (
            State::Standby,
            Request::Run(Service::AutoCalibrate),
            OutOfRange,
            Some(1),
            "parameter 259 \"Auto-calibrate\": out of range",
        ),
        (
            State::Standby,
            Request::Run(Service::Store),
            Storage,
            Some(1),
            "parameter 256 \"Store parameters\": the parameter store or log memory is missing, busy or failed",
        ),
        (
            State::Standby,
            Request::Run(Service::EraseLog),
            Storage,
            Some(1),
            "parameter 76 \"Logging erase request\": the parameter store or log memory is missing, busy or failed",
        ),
    ];
    for (state, request, status, offered, text) in cases {
        let mut pair = Pair::quiet();
        pair.bench.enter(state);
        let before = pair.bench.node.parameters().clone();
        let error = pair.ask(request).result.unwrap_err();
        let RequestError::Refused(refusal) = error else { panic!("{request:?}: {error:?}") };
        assert_eq!((refusal.status, refusal.offered), (status, offered), "{request:?}");
        assert_eq!(refusal.parameter, Dictionary::row(refusal.number));
        assert_eq!(refusal.stored, pair.bench.node.read_parameter(refusal.number).unwrap_or(0));
        assert_eq!(error.to_string(), text);
        assert_eq!(pair.bench.node.parameters(), &before, "{request:?}");
    }
}

#[test]
fn services_are_rising_edges() {
    for service in
        [Service::SetPosition, Service::ResetCalibration, Service::AutoCalibrate, Service::CalibrateHall]
    {
        let mut pair = Pair::quiet();
        let bus_voltage = Volts::from_milli(48_100);
        pair.bench.node.handle_status(Status { state: State::Standby, bus_voltage, ..Status::default() });
        let number = service as u16;
        // Twice: the second needs its own edge.
        for _ in 0..2 {
            assert_eq!(pair.ask(Request::Run(service)).result, Ok(1), "{service:?}");
            let edge = [0, 1].map(|value| ToDrive::SetParameter { number, value });
            assert_eq!(pair.take_sent(asked), edge, "{service:?}");
        }
        assert!(Dictionary::row(number).unwrap().command);
    }
    let services = [Service::Store, Service::StoreOnce, Service::EraseLog].map(|service| service as u16);
    assert!(services.iter().all(|number| Dictionary::row(*number).unwrap().command));
}

#[test]
fn messages_without_an_answer_are_checked_by_the_refused_frames() {
    let outputs = DigitalOutputs { enable1: true, value1: true, ..DigitalOutputs::default() };
    let mut pair = Pair::quiet();
    assert_eq!(pair.ask(Request::DigitalOutputs(outputs)).result, Ok(0));
    assert_eq!(pair.bench.node.outputs().digital, outputs);
    assert_eq!(pair.ask(Request::DisableHallSupply(true)).result, Ok(0));
    assert!(!pair.bench.node.outputs().hall_supply);

    pair.ask(Request::DigitalOutputs(DigitalOutputs::default())).result.unwrap();
    assert_eq!(pair.ask(Request::Write { number: number::SHUTDOWN_INPUT, raw: 1 }).result, Ok(1));
    let refused = Err(RequestError::NotObeyed);
    assert_eq!(pair.ask(Request::DigitalOutputs(outputs)).result, refused, "the line is an input now");
    pair.bench.enter(State::HallClosedLoop);
    assert_eq!(pair.ask(Request::DisableHallSupply(false)).result, refused);
    assert_eq!(pair.ask(Request::TriggerScope).result, refused, "there is none yet");
    assert_eq!(RequestError::NotObeyed.to_string(), "the drive has refused the request");
    assert_eq!(pair.bench.refused(), 3);
}

#[test]
fn factory_values_are_restored_and_read_again() {
    let mut pair = Pair::new(Config::default());
    pair.run(400);
    pair.ask(Request::Write { number: number::SPEED_RATE, raw: 777 }).result.unwrap();
    assert_eq!(pair.ask(Request::RestoreFactory { serial: 2 }).result, Err(RequestError::NotObeyed));
    assert_eq!(pair.master.parameters().get(number::SPEED_RATE).map(|heard| heard.value), Some(777));
    assert_eq!(pair.ask(Request::RestoreFactory { serial: 1 }).result, Ok(0));
    assert!(pair.master.parameters_to_read() > 0, "every value may be another one");
    pair.run(400);
    let factory = Parameters::new().raw(number::SPEED_RATE);
    assert_eq!(pair.master.parameters().get(number::SPEED_RATE).map(|heard| heard.value), Some(factory));
}

#[test]
fn reboot_is_acknowledged_and_never_repeated() {
    let mut pair = Pair::new(Config::default());
    pair.run(400);
    pair.master.request(Request::Reboot).unwrap();
    for _ in 0..5 {
        pair.step();
    }
    assert_eq!(pair.master.poll_answer(), Some(Answer { request: Request::Reboot, result: Ok(0) }));
    assert_eq!(pair.bench.node.poll_action(), Some(Action::Reboot));
    assert!(pair.master.report().reboot.is_some());
    assert!(pair.master.parameters().known() < 10, "what was read may be another now");

    let mut pair = Pair::quiet();
    pair.bench.enter(State::OpenLoop);
    assert_eq!(pair.ask(Request::Reboot).result, Err(RequestError::NoAnswer), "refused in silence");
    assert_eq!(pair.take_sent(|message| *message == ToDrive::Reboot).len(), 1);
    assert_eq!(pair.bench.refused(), 1);
}

#[test]
fn what_is_not_answered_is_repeated_and_given_up() {
    let config = Config { timeout: 20 * MS, attempts: 3, ..Config::default() };
    let mut master = Master::new(config);
    let lonely =
        [Request::Read { number: 5 }, Request::BuildInfo, Request::DisableHallSupply(true), Request::Reboot];
    for request in lonely {
        master.request(request).unwrap();
    }
    let mut asked_at: Vec<(u64, ToDrive)> = Vec::new();
    let mut answers = Vec::new();
    for now in (0..400 * MS).step_by(100) {
        while let Some(frame) = master.poll_frame(now) {
            let message = ToDrive::decode(&frame).unwrap().1;
            if asked(&message) {
                asked_at.push((now / MS, message));
            }
        }
        answers.extend(master.poll_answer());
    }
    let read = |number| ToDrive::RequestParameter { number };
    let expected = [
        (0, read(5)),
        (20, read(5)),
        (40, read(5)),
        (60, ToDrive::RequestBuildInfo),
        (80, ToDrive::RequestBuildInfo),
        (100, ToDrive::RequestBuildInfo),
        (120, read(number::REFUSED_FRAMES)),
        (140, read(number::REFUSED_FRAMES)),
        (160, read(number::REFUSED_FRAMES)),
        (180, ToDrive::Reboot),
    ];
    assert_eq!(asked_at, expected);
    let given_up = lonely.map(|request| Answer { request, result: Err(RequestError::NoAnswer) });
    assert_eq!(answers, given_up);
    assert_eq!(RequestError::NoAnswer.to_string(), "the drive does not answer");
}

#[test]
fn a_lost_request_or_answer_costs_one_time_out() {
    for lost in 0..2 {
        let mut pair = Pair::quiet();
        pair.run(60);
        pair.master.request(Request::Write { number: number::SPEED_RATE, raw: 4321 }).unwrap();
        pair.fates = (0..=lost).map(|frame| if frame == lost { vec![] } else { vec![0] }).collect();
        let begin = pair.now;
        // Only the write and its answer are on the bus in the next two ticks.
        assert_eq!(pair.answer().result, Ok(4321), "{lost}");
        let took = pair.now - begin;
        assert!((100 * MS..102 * MS).contains(&took), "{took}");
    }
}

#[test]
fn eight_requests_have_room_until_their_answers_are_taken() {
    let mut pair = Pair::quiet();
    let request = Request::Read { number: 1 };
    (0..8).for_each(|_| pair.master.request(request).unwrap());
    assert_eq!(pair.master.request(request), Err(NotTaken::Full));
    pair.run(50);
    assert_eq!(pair.master.request(request), Err(NotTaken::Full), "none was taken");
    assert!(pair.master.poll_answer().is_some());
    assert_eq!(pair.master.request(request), Ok(()));
    pair.run(50);
    assert_eq!(std::iter::from_fn(|| pair.master.poll_answer()).count(), 8, "and none is lost");
    assert_eq!(NotTaken::Full.to_string(), "earlier answers were not taken yet");
}

#[test]
fn a_late_read_is_not_taken_for_the_answer_to_a_write() {
    let mut master = Master::new(Config { read_parameters: false, ..Config::default() });
    master.request(Request::Write { number: number::SPEED_RATE, raw: 5000 }).unwrap();
    while master.poll_frame(0).is_some() {}
    let answer = |value, status| said(FromDrive::Parameter { number: number::SPEED_RATE, value, status });
    master.handle_frame(&answer(1000, ParameterStatus::Done), 10);
    assert_eq!(master.poll_answer(), None);
    assert_eq!(master.parameters().get(number::SPEED_RATE), Some(Heard { value: 1000, at: 10 }));
    master.handle_frame(&answer(5000, ParameterStatus::Done), 20);
    assert_eq!(master.poll_answer().map(|answer| answer.result), Some(Ok(5000)));
    // Nor the other way round: a refused write for the answer to a read.
    master.request(Request::Read { number: number::SPEED_RATE }).unwrap();
    while master.poll_frame(100).is_some() {}
    master.handle_frame(&answer(5000, ParameterStatus::WrongState), 110);
    assert_eq!(master.poll_answer(), None);
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
    assert_eq!(report.status, Some(Heard { value: status, at: 100 }));
    assert_eq!(report.faults, Some(Heard { value: faults, at: 200 }));
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
    // A state that contradicts a newer status word is not told.
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
    assert!(master.measurements().iter().all(|(_, heard)| heard.is_none()));
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
        .map(|(signal, heard)| format!("{} {} {}", signal.name, heard.unwrap().value, signal.unit))
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
    let voltage = Heard { value: Decimal { digits: 4801, exponent: -2 }, at: 2 };
    assert_eq!(master.measurements().find("hv voltage"), Some(voltage));
    assert_eq!(master.measurements().get(&SIGNALS[7]), Some(voltage));
    let frame = |number| master.measurements().frame(Opcode::new(number).unwrap());
    assert_eq!(frame(207), Some(Heard { value: Measurement::M7([1, 2, 3, 4]), at: 6 }));
    assert_eq!(frame(208), Some(Heard { value: Measurement::M8([5, 6, 7, 8]), at: 7 }));
    assert_eq!((frame(206), frame(209), frame(110)), (None, None, None));
    // Which speed counts depends on the control mode.
    assert_eq!(master.speed(), Some(Heard { value: -4000, at: 1 }));
    let hall = StatusWord { mode: MotorMode::Drive, control: ControlMode::Hall, ..StatusWord::default() };
    master.handle_frame(&said(FromDrive::Status(hall)), 9);
    assert_eq!(master.speed(), Some(Heard { value: 3999, at: 5 }));
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

#[test]
fn a_silent_master_hears_everything_and_sends_nothing() {
    let mut pair = Pair::new(Config { silent: true, ..Config::default() });
    pair.master.start(1000);
    pair.bench.node.handle_status(Status { state: State::Standby, ..Status::default() });
    for request in [Request::BuildInfo, Request::Reboot, Request::Read { number: 1 }] {
        assert_eq!(pair.master.request(request), Err(NotTaken::Silent));
    }
    assert_eq!(NotTaken::Silent.to_string(), "the master is silent");
    pair.run(200);
    assert_eq!((pair.take_sent(|_| true), pair.master.parameters_to_read()), (vec![], 0));
    assert!(pair.master.is_connected(pair.now));
    assert!(pair.master.measurements().find("HV Voltage").is_some());
    // Answers to another master at the same address fill the mirror.
    pair.bench.send(ToDrive::RequestParameter { number: number::CAN_TIMEOUT });
    pair.run(1);
    assert_eq!(pair.master.parameters().get(number::CAN_TIMEOUT).map(|heard| heard.value), Some(250));
}

#[test]
fn polling_when_it_says_is_enough() {
    let script = |master: &mut Master| {
        master.request(Request::Read { number: 9 }).unwrap();
        master.request(Request::Run(Service::Store)).unwrap();
        master.request(Request::TriggerScope).unwrap();
        master.start(2000);
    };
    let frames = |master: &mut Master, now: u64| -> Vec<(u64, u32)> {
        std::iter::from_fn(|| master.poll_frame(now)).map(|frame| (now, frame.id().raw())).collect()
    };
    let mut eager = Master::new(Config::default());
    script(&mut eager);
    let every_tick: Vec<_> = (0..2000 * MS).step_by(100).flat_map(|now| frames(&mut eager, now)).collect();
    let mut lazy = Master::new(Config::default());
    script(&mut lazy);
    let mut sparse = Vec::new();
    let mut polls = 0;
    let mut now = 0;
    while now < 2000 * MS {
        sparse.extend(frames(&mut lazy, now));
        polls += 1;
        now = lazy.next_poll(now);
    }
    assert_eq!(sparse, every_tick);
    assert!(polls < 100, "{polls}");
}

#[test]
fn a_period_of_nothing_does_not_flood_the_bus() {
    let mut master = Master::new(Config { setpoint_period: 0, ..Config::default() });
    let mut frames = 0;
    for now in (0..100 * MS).step_by(100) {
        while master.poll_frame(now).is_some() {
            frames += 1;
        }
    }
    assert_eq!(frames, 100, "one a millisecond");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn random_frames_never_disturb(
        silent: bool,
        frames in prop::collection::vec((0..220_u32, any::<u64>(), 0..3_u32, 0..20_000_u64), 1..200),
        calls in prop::collection::vec(0..12_u32, 20),
    ) {
        let mut master = Master::new(Config { silent, ..Config::default() });
        let mut now = 0;
        let mut calls = calls.into_iter().cycle();
        for (opcode, bytes, kind, pause) in frames {
            now += pause;
            let base = if kind == 0 { 0x1552_A800 } else { 0x0AAD_5000 | kind << 9 };
            master.handle_frame(&frame(base | opcode, bytes), now);
            let number = (bytes >> 48) as u16;
            match calls.next().unwrap() {
                0 => master.start(bytes as i32),
                1 => master.set_speed(number),
                2 => master.stop(),
                3 => { let _ = master.request(Request::Read { number }); }
                4 => { let _ = master.request(Request::Write { number, raw: bytes as i32 }); }
                5 => { let _ = master.request(Request::Reboot); }
                6 => { let _ = master.request(Request::RestoreFactory { serial: number }); }
                7 => { let _ = master.download(Download::Description); }
                8 => { let _ = master.download(Download::Scope { words: number.into() }); }
                9 => { let _ = master.download(Download::Log { first: bytes as u32, records: number.into() }); }
                10 => master.abort_download(),
                _ => { master.poll_answer(); master.poll_chunk(); master.poll_download(); }
            }
            let mut sent = 0;
            while let Some(frame) = master.poll_frame(now) {
                prop_assert!(ToDrive::decode(&frame).is_ok());
                sent += 1;
                prop_assert!(sent <= 4);
            }
            if silent {
                prop_assert_eq!(sent, 0);
            }
            prop_assert!(master.next_poll(now) >= now);
        }
        // The end of time is an instant like any other.
        master.handle_frame(&frame(0x1552_A803, 0), u64::MAX);
        master.poll_frame(u64::MAX);
    }
}
