//! Tests of the master's requests to the node: answers, refusals, time-outs.

use crate::bench::IDENTITY;
use crate::pair::{Pair, is_request, said};
use narx_core::bus::narmotion::{DigitalOutputs, FromDrive, ParameterStatus, ToDrive};
use narx_core::dictionary::{Dictionary, number};
use narx_core::master::{
    Answer, BuildInfo, Config, DeviceInfo, Master, NotTaken, Received, Request, RequestError, Service,
};
use narx_core::motor::machine::event::Status;
use narx_core::motor::machine::state::State;
use narx_core::node::Action;
use narx_core::scope::{ScopeReply, State as ScopeState};
use narx_core::units::Volts;

const MS: u64 = 1000;

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
    assert_eq!(pair.bench.node.parameters().value(number::SPEED_RATE).unwrap(), 777);
    let build = BuildInfo { number: IDENTITY.build_number, modified: false, date: 20_261_120 };
    assert_eq!(pair.master.report().build.map(|received| received.value), Some(build));
    let device = DeviceInfo { hardware: 3, software: 0x0102, device_number: 1, address: 170 };
    assert_eq!(pair.master.report().device.map(|received| received.value), Some(device));
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
            "parameter 261 \"Drive state\": only the drive writes it",
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
        // At a bus voltage of 0 V calibration is impossible.
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
        assert_eq!(
            pair.ask(Request::Write { number: number::NOMINAL_SUPPLY, raw: 48_000 }).result,
            Ok(48_000)
        );
        pair.take_sent(is_request);
        let bus_voltage = Volts::from_milli(48_100);
        pair.bench.node.handle_status(Status { state: State::Standby, bus_voltage, ..Status::default() });
        let number = service as u16;
        // Twice: the second command needs its own edge.
        for _ in 0..2 {
            assert_eq!(pair.ask(Request::Run(service)).result, Ok(1), "{service:?}");
            let edge = [0, 1].map(|value| ToDrive::SetParameter { number, value });
            assert_eq!(pair.take_sent(is_request), edge, "{service:?}");
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
    // This node has no scope: the request to arm has neither succeeded nor been refused.
    assert_eq!(pair.ask(Request::TriggerScope).result, Ok(0));
    pair.bench.node.handle_scope(ScopeReply::State(ScopeState::Recording, 0));
    assert_eq!(pair.ask(Request::TriggerScope).result, refused, "it records");
    assert_eq!(RequestError::NotObeyed.to_string(), "the drive has refused the request");
    assert_eq!(pair.bench.refused(), 3);
}

#[test]
fn factory_values_are_restored_in_the_store_and_stay_as_they_are_in_force() {
    let mut pair = Pair::new(Config::default());
    pair.run(400);
    pair.ask(Request::Write { number: number::SPEED_RATE, raw: 777 }).result.unwrap();
    assert_eq!(pair.ask(Request::RestoreFactory { serial: 2 }).result, Err(RequestError::NotObeyed));
    assert_eq!(pair.ask(Request::RestoreFactory { serial: 1 }).result, Ok(0));
    pair.run(400);
    assert_eq!(pair.master.parameters().get(number::SPEED_RATE).map(|received| received.value), Some(777));
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
            if is_request(&message) {
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

/// A store may wait long, until the drive is at rest: it is requested a hundred times at least, and a
/// caller's own requests beyond that still work.
#[test]
fn a_store_is_asked_for_a_hundred_times_at_least() {
    let rows = [(3, 100), (100, 100), (101, 101), (u8::MAX, 255)];
    let numbers = [number::STORE, number::STORE_ONCE];
    for ((attempts, expected), number) in rows.into_iter().flat_map(|row| numbers.map(|number| (row, number)))
    {
        let store = ToDrive::SetParameter { number, value: 1 };
        let mut master = Master::new(Config { timeout: 20 * MS, attempts, ..Config::default() });
        master.request(Request::Write { number, raw: 1 }).unwrap();
        let mut asked = 0;
        for now in (0..300 * 20 * MS).step_by(20 * MS as usize) {
            let sent = std::iter::from_fn(|| master.poll_frame(now));
            asked += sent.filter(|frame| ToDrive::decode(frame).unwrap().1 == store).count();
        }
        assert_eq!(asked, expected, "parameter {number}, {attempts} attempts");
    }
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
    assert_eq!(master.parameters().get(number::SPEED_RATE), Some(Received { value: 1000, at: 10 }));
    master.handle_frame(&answer(5000, ParameterStatus::Done), 20);
    assert_eq!(master.poll_answer().map(|answer| answer.result), Some(Ok(5000)));
    // Nor the other way round: a refused write does not count as the answer to a read.
    master.request(Request::Read { number: number::SPEED_RATE }).unwrap();
    while master.poll_frame(100).is_some() {}
    master.handle_frame(&answer(5000, ParameterStatus::WrongState), 110);
    assert_eq!(master.poll_answer(), None);
}
