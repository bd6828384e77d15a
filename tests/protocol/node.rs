//! Tests of the node: commands, answers, broadcasts, and frames that it must ignore.

use crate::bench::{Bench, IDENTITY, frame, speed};
use narx_core::bus::narmotion::{FromDrive, MotorMode, ToDrive};
use narx_core::bus::{Frame, Id};
use narx_core::dictionary::{Parameters, number};
use narx_core::motor::guard::fault::FaultWord;
use narx_core::motor::machine::event::{Event, Health, RunRequest, Status};
use narx_core::motor::machine::state::State;
use narx_core::motor::sense::front_end::Board;
use narx_core::node::{Action, Node, SlowInputs};
use narx_core::units::{Amps, ElectricalSpeed, Volts, Watts};
use proptest::prelude::*;

#[test]
fn requests_and_set_points_become_commands() {
    let mut bench = Bench::new();
    bench.request(MotorMode::Drive);
    assert_eq!(bench.commands(), [(Some(RunRequest::Drive), ElectricalSpeed::ZERO)]);
    bench.send(ToDrive::MotorCommand { speed: 3000 });
    assert_eq!(bench.commands(), [(None, speed(3000, 4))]);
    bench.request(MotorMode::Reverse);
    assert_eq!(bench.commands(), [(Some(RunRequest::Reverse), speed(3000, 4))]);
    bench.request(MotorMode::Fault);
    bench.request(MotorMode::Standby);
    let requests: Vec<RunRequest> = bench.commands().iter().filter_map(|(request, _)| *request).collect();
    assert_eq!(requests, [RunRequest::Shutdown, RunRequest::Standby]);
    // A repeated request is a command again: it restarts the time-out.
    bench.request(MotorMode::Standby);
    assert_eq!(bench.commands().len(), 1);
}

#[test]
fn request_modes_that_do_not_exist_are_refused() {
    let mut bench = Bench::new();
    for mode in 4..16 {
        bench.node.handle_frame(&frame(0x0AAD_5202, mode << 32));
    }
    assert_eq!(bench.events(), []);
    assert_eq!((bench.refused(), bench.malformed()), (12, 0));
}

#[test]
fn the_set_point_is_echoed_as_accepted() {
    let enable = [number::HALL_ENABLE, number::SENSORLESS_ENABLE, number::OPEN_LOOP_ENABLE];
    // Enables of hall, sensorless, open loop; requested; accepted.
    let cases = [
        ([0, 0, 0], 12_345, 12_345),
        ([0, 0, 1], 12_345, 700),
        ([0, 1, 1], 12_345, 5000),
        ([0, 1, 0], 0, 400),
        ([1, 1, 1], 12_345, 4500),
        ([1, 0, 0], 0, 300),
        ([1, 0, 0], 300, 300),
        ([1, 0, 0], 3999, 3999),
    ];
    let mut parameters = Parameters::new();
    let levels = [
        (number::OPEN_LOOP_SPEED, 700),
        (number::SPEED_MAX_SL, 5000),
        (number::SPEED_MIN_SL, 400),
        (number::SPEED_MAX_HES, 4500),
        (number::SPEED_MIN_HES, 300),
    ];
    for (number, value) in levels {
        parameters.set(number, value).unwrap();
    }
    for (enables, asked, accepted) in cases {
        for (number, value) in enable.into_iter().zip(enables) {
            parameters.set(number, value).unwrap();
        }
        let mut bench = Bench::with_parameters(parameters.clone());
        bench.send(ToDrive::MotorCommand { speed: asked });
        assert_eq!(bench.messages(), [FromDrive::MotorCommand { speed: accepted }], "{enables:?} {asked}");
    }
}

#[test]
fn enables_written_while_driving_act_at_the_next_start() {
    let mut parameters = Parameters::new();
    parameters.set(number::OPEN_LOOP_ENABLE, 1).unwrap();
    let mut bench = Bench::with_parameters(parameters);
    bench.enter(State::OpenLoop);
    bench.write(number::HALL_ENABLE, 1);
    bench.enter(State::OpenLoop);
    bench.send(ToDrive::MotorCommand { speed: 9000 });
    assert_eq!(bench.messages(), [FromDrive::MotorCommand { speed: 500 }]);
    bench.enter(State::Standby);
    bench.send(ToDrive::MotorCommand { speed: 9000 });
    assert_eq!(bench.messages(), [FromDrive::MotorCommand { speed: 4000 }]);
}

#[test]
fn a_flood_of_requests_never_loses_the_stop() {
    use MotorMode::{Drive, Fault, Reverse, Standby};
    let mut bench = Bench::new();
    for _ in 0..100 {
        bench.request(Drive);
        bench.request(Standby);
    }
    let requests: Vec<RunRequest> = bench.commands().iter().filter_map(|(request, _)| *request).collect();
    assert!(requests.len() <= 8, "{requests:?}");
    assert_eq!(requests.last(), Some(&RunRequest::Standby));
    bench.request(Fault);
    for _ in 0..100 {
        bench.request(Drive);
        bench.request(Reverse);
    }
    let requests: Vec<RunRequest> = bench.commands().iter().filter_map(|(request, _)| *request).collect();
    assert!(requests.contains(&RunRequest::Shutdown), "{requests:?}");
    assert_eq!(requests.last(), Some(&RunRequest::Reverse));
}

#[test]
fn identity_is_answered() {
    let mut bench = Bench::new();
    bench.send(ToDrive::RequestBuildInfo);
    bench.send(ToDrive::RequestDeviceInfo);
    let number = IDENTITY.build_number;
    let expected = [
        FromDrive::BuildInfo { number, modified: false, date: 20_261_120 },
        FromDrive::DeviceInfo { hardware: 3, software: 0x0102, device_number: 1, address: 170 },
    ];
    assert_eq!(bench.messages(), expected);
}

#[test]
fn reboot_is_acknowledged_before_it_happens() {
    let mut bench = Bench::new();
    bench.enter(State::OpenLoop);
    bench.send(ToDrive::Reboot);
    assert_eq!((bench.refused(), bench.node.poll_action()), (1, None));
    bench.node.handle_status(Status { state: State::Fault, standstill: false, ..Status::default() });
    bench.send(ToDrive::Reboot);
    assert_eq!((bench.refused(), bench.node.poll_action()), (2, None), "it may still turn");
    bench.enter(State::Fault);
    bench.send(ToDrive::Reboot);
    assert_eq!(bench.node.poll_action(), None, "the acknowledgement waits");
    assert_eq!(bench.messages(), [FromDrive::Reboot]);
    assert_eq!(bench.node.poll_action(), Some(Action::Reboot));
    assert_eq!(bench.node.poll_action(), None);
}

#[test]
fn frames_that_are_not_accepted_change_nothing_but_a_counter() {
    let id = Id::extended(0x0AAD_5202).unwrap();
    let parameter = 0x0072_0000_0064_0000;
    // Frame, refused, malformed.
    let cases = [
        (Frame::remote(id, 8).unwrap(), 0, 1),
        (Frame::data(id, &[0, 0, 0, 1, 0, 0, 0]).unwrap(), 0, 1),
        (Frame::data(id, &[]).unwrap(), 0, 1),
        (Frame::full(Id::standard(0x202).unwrap(), [0, 0, 0, 1, 0, 0, 0, 0]), 0, 1),
        // Type 3, inbound type 0.
        (frame(0x0AAD_526E | 3 << 9, parameter), 0, 1),
        (frame(0x0AAD_506E, parameter), 0, 1),
        // Another master; another drive, which is not counted; both at once.
        (frame(0x0AAD_526E ^ 1 << 19, parameter), 1, 0),
        (frame(0x0AAD_526E ^ 1 << 11, parameter), 0, 0),
        (frame(0x0AAD_526E ^ 1 << 11 ^ 1 << 19, parameter), 0, 0),
        // The opcode does not exist, or has another type.
        (frame(0x0AAD_5203, 0), 1, 0),
        (frame(0x0AAD_5402, 1 << 32), 1, 0),
        (frame(0x0AAD_54C8, 0), 1, 0),
    ];
    for (frame, refused, malformed) in cases {
        let mut bench = Bench::new();
        let before = bench.node.clone();
        bench.node.handle_frame(&frame);
        assert_eq!((bench.refused(), bench.malformed()), (refused, malformed), "{frame:?}");
        assert_eq!(bench.node.parameters(), before.parameters());
        assert_eq!((bench.events(), bench.messages()), (vec![], vec![]), "{frame:?}");
    }
}

#[test]
fn faults_are_announced_at_once() {
    let mut bench = Bench::new();
    let warning = FaultWord::TEMPERATURE_WARNING;
    let standby = Status { state: State::Standby, ..Status::default() };
    bench.node.handle_status(Status { faults: warning, ..standby });
    assert_eq!(bench.messages(), [FromDrive::Faults(warning)]);
    let critical = FaultWord::OVER_VOLTAGE;
    let faults = warning | critical;
    let fault = Status { state: State::Fault, faults, critical, extended_code: 0x0201, ..Status::default() };
    bench.node.handle_status(fault);
    let announced = [FromDrive::CriticalFault { faults: critical, code: 0x0201 }, FromDrive::Faults(faults)];
    assert_eq!(bench.messages(), announced);
    bench.node.handle_status(fault);
    assert_eq!(bench.messages(), []);
    bench.node.handle_status(standby);
    assert_eq!(bench.messages(), [FromDrive::Faults(FaultWord::empty())], "clearing is no critical fault");
    assert_eq!(bench.read(number::EXTENDED_FAULT_CODE).0, 0);
}

#[test]
fn health_reaches_the_tick_and_the_mapping_flag() {
    let mut bench = Bench::new();
    let health = Health { store_faults: FaultWord::STORE_MISMATCH, self_test_failed: false };
    bench.node.handle_health(health);
    assert_eq!(bench.events(), [Event::Health(health)]);
    assert_eq!(bench.read(number::MEMORY_MAPPING_FLAG).0, 0);
}

#[test]
fn events_of_power_up() {
    let mut node = Node::new(IDENTITY, Board::BENCH);
    assert!(matches!(node.poll_event(), Some(Event::Coefficients(_))));
    assert!(node.poll_event().is_none());
    node.poll(0);
    let ids: Vec<u32> = std::iter::from_fn(|| node.poll_frame()).map(|frame| frame.id().raw()).collect();
    assert_eq!(ids, [0x1552_A803, 0x1552_A804], "the master counts as silent: no measurements");
}

#[test]
fn answers_go_before_measurements_and_what_finds_no_room_is_counted() {
    let mut bench = Bench::new();
    bench.node.poll(0);
    bench.send(ToDrive::RequestBuildInfo);
    let opcodes: Vec<u16> = bench.messages().iter().map(|message| message.opcode().raw()).collect();
    assert_eq!(opcodes, [3, 4, 0, 200, 201, 202, 203, 204, 205]);
    for _ in 0..40 {
        bench.send(ToDrive::RequestBuildInfo);
    }
    assert_eq!(bench.messages().len(), 32);
    assert_eq!(bench.read(number::FRAMES_LOST).0, 8);
    // Words and measurements that were not yet sent are replaced by newer ones.
    bench.node.poll(500);
    bench.node.poll(1000);
    assert_eq!(bench.messages().len(), 2 + 6);
    assert_eq!(bench.read(number::FRAMES_LOST).0, 8 + 2 + 6);
}

#[test]
fn a_node_survives_its_serialised_form() {
    let mut bench = Bench::new();
    bench.node.poll(0);
    bench.request(MotorMode::Drive);
    let bytes = postcard::to_stdvec(&bench.node).unwrap();
    let mut again: Node = postcard::from_bytes(&bytes).unwrap();
    assert_eq!(again, bench.node);
    assert_eq!(again.poll_event(), bench.node.poll_event());
    assert_eq!(again.poll_frame(), bench.node.poll_frame());
}

/// Strategy of frames that are often nearly valid.
fn any_frame() -> impl Strategy<Value = Frame> {
    let opcode = prop_oneof![3 => Just(2), 3 => Just(102), 3 => Just(110), 1 => 0..512_u32];
    let kind = prop_oneof![4 => Just(1), 1 => 0..4_u32];
    let source = prop_oneof![4 => Just(0x55), 1 => 0..256_u32];
    let destination = prop_oneof![4 => Just(0xAA), 1 => 0..256_u32];
    let length = prop_oneof![6 => Just(8), 1 => 0..=8_usize];
    let word = prop_oneof![0..300_u16, any::<u16>()];
    let words = [word.clone(), word.clone(), word.clone(), word];
    let shape = (0..4_u32, source, destination, kind, opcode);
    (shape, length, words, prop::bool::weighted(0.1), prop::bool::weighted(0.1)).prop_map(
        |((priority, source, destination, kind, opcode), length, words, remote, standard)| {
            let raw = priority << 27 | source << 19 | destination << 11 | kind << 9 | opcode;
            let id = if standard { Id::standard((raw & 0x7FF) as u16) } else { Id::extended(raw) }.unwrap();
            let bytes: Vec<u8> = words.iter().flat_map(|word: &u16| word.to_be_bytes()).collect();
            if remote { Frame::remote(id, length as u8) } else { Frame::data(id, &bytes[..length]) }.unwrap()
        },
    )
}

/// Type and opcode, if the frame is one for this drive; written from the protocol, not from the code.
fn received(frame: &Frame) -> Option<(u32, u32)> {
    let raw = frame.id().raw();
    let addressed = raw >> 19 & 0xFF == 0x55 && raw >> 11 & 0xFF == 0xAA;
    let shaped = frame.id().is_extended() && !frame.is_remote() && frame.dlc() == 8;
    (addressed && shaped).then_some((raw >> 9 & 3, raw & 0x1FF))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn only_valid_frames_change_anything(frames in prop::collection::vec(any_frame(), 1..20), state in 0..8_usize) {
        let mut bench = Bench::new();
        bench.enter(State::ALL[state]);
        for frame in frames {
            let before = bench.node.parameters().clone();
            let outputs = bench.node.outputs();
            let counted = i64::from(bench.refused()) + i64::from(bench.malformed());
            bench.node.handle_frame(&frame);
            let received = received(&frame);
            let data = frame.payload();
            let command = match received {
                Some((1, 2)) => data[3] & 0xF < 4,
                Some((1, 102)) => true,
                _ => false,
            };
            prop_assert_eq!(bench.commands().len(), usize::from(command), "{:?}", frame);
            if !matches!(received, Some((1, 110 | 113))) {
                prop_assert_eq!(bench.node.parameters(), &before);
            }
            if received.is_none() {
                prop_assert_eq!(bench.node.outputs(), outputs);
            }
            // Every frame is carried out, answered, counted, or for another node.
            let counted = i64::from(bench.refused()) + i64::from(bench.malformed()) - counted;
            let answers = bench.messages().len();
            prop_assert!(counted <= 1 && answers <= 1);
            if received.is_none() {
                prop_assert_eq!(answers, 0);
            }
            prop_assert!(bench.node.parameters().iter().all(|(row, raw)| row.accepts(raw)));
            bench.node.poll_action();
        }
    }

    #[test]
    fn no_report_makes_the_node_panic(bits in prop::array::uniform8(any::<i32>()), pole_pairs in 1..=50_i32, later: i32) {
        let mut parameters = Parameters::new();
        parameters.set(number::MOTOR_POLE_PAIRS, pole_pairs).unwrap();
        let mut bench = Bench::with_parameters(parameters);
        let status = Status {
            speed_hall: ElectricalSpeed::from_bits(bits[0]),
            speed_sensorless: ElectricalSpeed::from_bits(bits[1]),
            bus_voltage: Volts::from_bits(bits[2]),
            bus_current: Amps::from_bits(bits[3]),
            power: Watts::from_bits(bits[4]),
            sectors: bits[5],
            faults: FaultWord::from_bits_retain(bits[6] as u32),
            ..Status::default()
        };
        bench.node.handle_status(status);
        bench.node.handle_status(Status { sectors: later, ..status });
        bench.node.handle_inputs(SlowInputs { pressure: Volts::from_bits(bits[7]), ..SlowInputs::default() });
        bench.node.poll(u64::MAX);
        bench.node.poll(0);
        prop_assert!(bench.messages().len() >= 8);
    }
}
