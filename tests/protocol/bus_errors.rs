//! Tests of a bus that is disturbed, lost and restored: the drive's reports, and its operation meanwhile.

use super::bench::Bench;
use super::wired::Wired;
use narx_core::bus::narmotion::{FromDrive, Measurement, MotorMode, ParameterStatus, StatusWord, ToDrive};
use narx_core::bus::{BusState, ErrorState, Frame};
use narx_core::dictionary::number;
use narx_core::motor::State;
use narx_core::motor::guard::fault::{Cause, FaultWord};
use narx_sim::can::Attachment;
use narx_sim::plant::Input;

/// Bit of a frame that is disturbed: within its identifier.
const BIT: u32 = 20;
/// Recovery time, ticks: 128 times 11 bits at 500 kbit/s.
const RECOVERY: u64 = 29;

/// A turning motor on a bus with a third node: while the master is off the bus another node must acknowledge
/// the drive's frames.
fn witnessed() -> Wired {
    let mut wired = Wired::turning();
    wired.bench.set_other(Attachment::Normal);
    wired
}

#[test]
fn the_state_of_the_controller_is_read_as_parameters() {
    let mut bench = Bench::new();
    let numbers = [number::BUS_STATE, number::TRANSMIT_ERRORS, number::RECEIVE_ERRORS, number::BUS_OFFS];
    let course = [
        (ErrorState::Active, 8, 1, [0, 8, 1, 0]),
        (ErrorState::Passive, 128, 3, [1, 128, 3, 0]),
        (ErrorState::BusOff, 256, 3, [2, 256, 3, 1]),
        (ErrorState::BusOff, 256, 3, [2, 256, 3, 1]),
        (ErrorState::Active, 0, 0, [0, 0, 0, 1]),
        (ErrorState::BusOff, 256, 0, [2, 256, 0, 2]),
        (ErrorState::Active, 0, 0, [0, 0, 0, 2]),
    ];
    for (error, transmit_errors, receive_errors, expected) in course {
        bench.node.handle_bus_state(BusState { error, transmit_errors, receive_errors });
        assert_eq!(numbers.map(|number| bench.node.read_parameter(number).unwrap()), expected, "{error:?}");
    }
}

#[test]
fn what_waited_for_a_lost_bus_is_not_sent() {
    let mut bench = Bench::new();
    bench.send(ToDrive::RequestParameter { number: 1 });
    bench.node.poll(0);
    bench.node.handle_bus_state(BusState { error: ErrorState::BusOff, ..BusState::default() });
    bench.node.poll(1000);
    assert_eq!((bench.node.poll_frame(), bench.node.poll_bulk_frame()), (None, None));
    let lost = bench.node.read_parameter(number::FRAMES_LOST);
    // The answer, two words and six measurements.
    assert_eq!(lost, Some(9));
    bench.node.handle_bus_state(BusState::default());
    bench.node.poll(1001);
    let opcodes: Vec<u16> = bench.messages().iter().map(|message| message.opcode().raw()).collect();
    assert_eq!(opcodes, [3, 4, 200, 201, 202, 203, 204, 205], "the present, at once");
}

/// A node carries out requests that came before its controller was off the bus. It can answer none of them,
/// with or without room, and each answer is counted once.
#[test]
fn every_answer_without_a_bus_is_counted_once() {
    for reads in [1, 31, 32, 33, 40, 100] {
        let mut bench = Bench::new();
        bench.node.handle_bus_state(BusState { error: ErrorState::BusOff, ..BusState::default() });
        for _ in 0..reads {
            bench.send(ToDrive::RequestParameter { number: 1 });
            assert_eq!(bench.node.poll_frame(), None);
        }
        bench.node.handle_bus_state(BusState::default());
        assert_eq!(bench.node.read_parameter(number::FRAMES_LOST), Some(reads));
        assert_eq!(bench.messages(), []);
        bench.send(ToDrive::RequestParameter { number: number::FRAMES_LOST });
        let answer =
            FromDrive::Parameter { number: number::FRAMES_LOST, value: reads, status: ParameterStatus::Done };
        assert_eq!(bench.messages(), [answer], "and the next one is answered");
    }
}

/// If the bus takes no frames but does not fail, because no other node is there, only the newest of each
/// repeated message waits.
#[test]
fn a_bus_that_takes_nothing_keeps_the_newest_words() {
    let mut bench = Bench::new();
    for broadcast in 0..100 {
        bench.node.poll(broadcast * 500);
    }
    bench.enter(State::HallClosedLoop);
    bench.node.poll(100 * 500);
    let messages = bench.messages();
    assert_eq!(messages.len(), 8, "{messages:?}");
    assert!(
        matches!(messages[0], FromDrive::Status(StatusWord { mode: MotorMode::Drive, .. })),
        "{messages:?}"
    );
}

/// The drive goes on if every frame is disturbed for 100 ms, which is less than the command time-out, and
/// comes back with new frames.
#[test]
fn the_drive_goes_on_over_a_bus_off_and_comes_back_with_fresh_frames() {
    let mut wired = witnessed();
    wired.put(Input::Asi, 1.0);
    wired.run(0.1);
    wired.send(ToDrive::RequestParameter { number: number::DEVICE_NUMBER });
    wired.step();
    wired.received.clear();
    wired.bench.disturb_bus(u32::MAX, BIT);
    let mut seen = vec![0];
    for tick in 0..1000 {
        if tick == 500 {
            wired.put(Input::Asi, 2.0);
        }
        wired.step();
        seen.push(wired.look(number::BUS_STATE));
        assert_eq!(wired.bench.status().state, State::HallClosedLoop);
    }
    seen.dedup();
    assert_eq!(seen[..4], [0, 1, 2, 0], "error active, passive, bus-off and back");
    assert!((wired.speed() - 1500.0).abs() < 20.0);
    assert_eq!(wired.take_messages(), []);
    let bus_offs = wired.look(number::BUS_OFFS);
    assert!(bus_offs > 5, "each time it comes back it is disturbed again: {bus_offs}");

    wired.bench.disturb_bus(0, 0);
    let mended = wired.bench.now_ns();
    wired.run(0.2);
    let from_drive = |(_, frame): &&(u64, Frame)| FromDrive::decode(frame).is_ok();
    let first = wired.received.iter().find(from_drive).unwrap().0 - mended;
    println!("{bus_offs} times bus-off in 100 ms, first frame {first} ns after the bus was mended");
    assert!(first < (RECOVERY + 10) * 100_000, "{first} ns");
    let messages = wired.take_messages();
    for message in &messages {
        assert!(!matches!(message, FromDrive::Parameter { .. }), "the answer is stale");
        if let FromDrive::Measurement(Measurement::M3 { asi, .. }) = message {
            assert!((asi - 2000).abs() <= 1, "{asi}");
        }
    }
    assert!(messages.len() > 16, "and broadcasts go on");
    assert_eq!(wired.bench.status().state, State::HallClosedLoop);
    assert_eq!((wired.read(number::BUS_STATE), wired.read(number::BUS_OFFS)), (0, bus_offs));
}

/// If the disturbance lasts longer than the command time-out, the bridge is switched off, and the first
/// frames on the restored bus report the reason.
#[test]
fn a_bus_that_stays_away_ends_in_the_command_time_out() {
    let mut wired = witnessed();
    wired.bench.disturb_bus(u32::MAX, BIT);
    let lost = wired.bench.now_ns();
    while wired.bench.status().state == State::HallClosedLoop {
        wired.step();
        assert!(wired.bench.now_ns() - lost < 260_000_000, "250 ms from the last command that came through");
    }
    assert!(wired.bench.now_ns() - lost > 190_000_000, "which was 50 ms old at most");
    assert_eq!(wired.look(number::EXTENDED_FAULT_CODE), Cause::CommandTimeout as i32);
    wired.run(0.2);
    wired.received.clear();
    wired.bench.disturb_bus(0, 0);
    wired.run(0.02);
    let messages = wired.take_messages();
    let critical =
        FromDrive::CriticalFault { faults: FaultWord::DEVICE_TIMEOUT, code: Cause::CommandTimeout as u16 };
    assert!(messages.contains(&critical), "{messages:?}");
    assert!(messages.contains(&FromDrive::Faults(FaultWord::DEVICE_TIMEOUT)), "{messages:?}");
    let faulted =
        |message: &FromDrive| matches!(message, FromDrive::Status(StatusWord { mode: MotorMode::Fault, .. }));
    assert!(messages.iter().any(faulted), "{messages:?}");
}
