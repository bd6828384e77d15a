//! Tests of the master: its commands, the times at which it sends, and its silence.

use crate::bench::frame;
use crate::pair::{Pair, is_command, said};
use narx_core::bus::narmotion::{FromDrive, MotorMode, ParameterStatus, RequestWord, StatusWord, ToDrive};
use narx_core::dictionary::{PARAMETER_COUNT, Parameters, number};
use narx_core::master::{Config, DescriptionReader, Download, Master, NotTaken, Request, Service};
use narx_core::motor::machine::event::{RunRequest, Status};
use narx_core::motor::machine::state::State;
use proptest::prelude::*;

const MS: u64 = 1000;

fn requested(mode: MotorMode) -> ToDrive {
    ToDrive::RequestWord(RequestWord { mode })
}

#[test]
fn set_points_alone_until_something_is_commanded() {
    let mut pair = Pair::quiet();
    pair.run(200);
    let sent: Vec<(u64, ToDrive)> =
        pair.sent.iter().copied().filter(|(_, message)| is_command(message)).collect();
    let expected: Vec<(u64, ToDrive)> =
        [0, 50, 100, 150].map(|at| (at * MS + 100, ToDrive::MotorCommand { speed: 0 })).into();
    assert_eq!(sent, expected);
    assert!(pair.bench.commands().iter().all(|(request, _)| request.is_none()), "nothing is acknowledged");
}

#[test]
fn a_master_that_asks_for_nothing_keeps_no_motor_turning() {
    let mut pair = Pair::quiet();
    let drives = Status { state: State::HallClosedLoop, ..Status::default() };
    pair.bench.node.handle_status(drives);
    pair.run(60);
    pair.take_sent(|_| true);
    // Set-points would restart the drive's time-out.
    pair.run(500);
    assert_eq!(pair.take_sent(is_command), []);
    pair.bench.node.handle_status(Status { state: State::Fault, ..drives });
    pair.run(100);
    assert_eq!(pair.take_sent(is_command).first(), Some(&ToDrive::MotorCommand { speed: 0 }));
    // A speed that was asked for is sent to a drive that another master has started.
    let mut pair = Pair::quiet();
    pair.bench.node.handle_status(drives);
    pair.run(60);
    pair.master.set_speed(900);
    pair.step();
    assert_eq!(pair.take_sent(is_command).last(), Some(&ToDrive::MotorCommand { speed: 900 }));
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
    assert_eq!(pair.take_sent(is_command), command);
    pair.run(49);
    assert_eq!(pair.take_sent(is_command), []);
    pair.run(1);
    assert_eq!(pair.take_sent(is_command), command);
    pair.master.set_speed(1200);
    pair.step();
    assert_eq!(pair.take_sent(is_command)[0], ToDrive::MotorCommand { speed: 1200 });
    pair.master.shut_down();
    pair.step();
    assert_eq!(pair.take_sent(is_command)[1], requested(MotorMode::Fault));
    assert_eq!((pair.master.requested(), pair.master.setpoint()), (Some(MotorMode::Fault), 1200));
    let requests: Vec<RunRequest> =
        pair.bench.commands().iter().filter_map(|(request, _)| *request).collect();
    assert_eq!(requests, [RunRequest::Standby, RunRequest::Reverse]);
}

#[test]
fn a_started_drive_is_fed_and_says_what_it_accepts() {
    let mut parameters = Parameters::new();
    parameters.set(number::HALL_ENABLE, 1).unwrap();
    let mut pair = Pair::with_parameters(Config::default(), parameters);
    pair.master.start(9000);
    pair.run(1);
    assert_eq!(
        pair.master.report().accepted_speed.map(|received| received.value),
        Some(4000),
        "parameter 103"
    );
    pair.master.set_speed(0);
    pair.run(1);
    assert_eq!(
        pair.master.report().accepted_speed.map(|received| received.value),
        Some(500),
        "parameter 104"
    );
    // Reading the parameters meanwhile does not delay the commands.
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
fn a_silent_master_receives_everything_and_sends_nothing() {
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
    assert_eq!(pair.master.parameters().get(number::CAN_TIMEOUT).map(|received| received.value), Some(250));
}

#[test]
fn polling_when_it_says_is_enough() {
    let script = |master: &mut Master| {
        master.request(Request::Read { number: 9 }).unwrap();
        master.request(Request::Run(Service::Store)).unwrap();
        master.request(Request::TriggerScope).unwrap();
        master.download(Download::Scope { words: 30 }).unwrap();
        master.start(2000);
        // For half a second its state is requested, though it never answers.
        master.handle_frame(&said(FromDrive::Status(StatusWord::default())), 0);
    };
    let frames = |master: &mut Master, now: u64| -> Vec<(u64, u32)> {
        std::iter::from_fn(|| master.poll_frame(now)).map(|frame| (now, frame.id().raw())).collect()
    };
    // No other message has this period.
    let config = Config { setpoint_period: 77 * MS, ..Config::default() };
    let mut eager = Master::new(config);
    script(&mut eager);
    let every_tick: Vec<_> = (0..4000 * MS).step_by(100).flat_map(|now| frames(&mut eager, now)).collect();
    let mut lazy = Master::new(config);
    script(&mut lazy);
    let mut sparse = Vec::new();
    let mut polls = 0;
    let mut now = 0;
    while now < 4000 * MS {
        sparse.extend(frames(&mut lazy, now));
        polls += 1;
        now = lazy.next_poll(now);
    }
    assert_eq!(sparse, every_tick);
    assert!(polls < 120, "{polls}");
}

/// A request that is made while the caller sleeps is due at once.
#[test]
fn what_is_asked_for_is_due_at_once() {
    let config = Config { setpoint_period: 1000 * MS, read_parameters: false, ..Config::default() };
    let mut master = Master::new(config);
    let drain = |master: &mut Master, now| std::iter::from_fn(|| master.poll_frame(now)).count();
    assert_eq!((drain(&mut master, 0), master.next_poll(7)), (1, 1000 * MS));
    master.request(Request::Read { number: 9 }).unwrap();
    assert_eq!((master.next_poll(7), drain(&mut master, 7)), (7, 1));
    let answer = FromDrive::Parameter { number: 9, value: 0, status: ParameterStatus::Done };
    master.handle_frame(&said(answer), 8);
    assert_eq!(master.next_poll(8), 1000 * MS);
    // Its state is requested, as long as the drive is present.
    master.handle_frame(&said(FromDrive::Status(StatusWord::default())), 9);
    assert_eq!(master.next_poll(9), 9);
    assert_eq!(master.next_poll(9 + config.lost_after), 1000 * MS);
    // The request of a start follows its set-point.
    master.start(2000);
    assert!(master.poll_frame(9).is_some());
    assert_eq!(master.next_poll(9), 9);
}

/// A master takes no more than a few KiB, which a small board can spare; each parameter takes 16 bytes of it.
#[test]
fn a_master_is_small() {
    assert!(size_of::<Master>() <= 4416, "{} bytes", size_of::<Master>());
    assert!(size_of::<DescriptionReader>() <= 512, "{} bytes", size_of::<DescriptionReader>());
}

#[test]
fn a_period_of_nothing_does_not_flood_the_bus() {
    let config = Config { setpoint_period: 0, timeout: 0, attempts: 255, lost_after: 0, ..Config::default() };
    let mut master = Master::new(config);
    assert_eq!((master.config().timeout, master.config().lost_after), (MS, MS));
    master.request(Request::BuildInfo).unwrap();
    let mut frames = [0, 0];
    for now in (0..100 * MS).step_by(100) {
        while let Some(frame) = master.poll_frame(now) {
            frames[usize::from(is_command(&ToDrive::decode(&frame).unwrap().1))] += 1;
        }
    }
    assert_eq!(frames, [100, 100], "one of each a millisecond");
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
        // The last instant is an instant like any other.
        master.handle_frame(&frame(0x1552_A803, 0), u64::MAX);
        master.poll_frame(u64::MAX);
    }
}
