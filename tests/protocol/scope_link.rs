//! Tests of the node between a master and the scope: the messages that it passes on, and its knowledge before
//! the scope has answered.

use crate::bench::Bench;
use narx_core::bus::narmotion::{FromDrive, ParameterStatus, ToDrive};
use narx_core::dictionary::number;
use narx_core::scope::{Block, ScopeReply, ScopeTask, State};

/// Arming and forcing are one message: the second of two does not overtake the first.
#[test]
fn nothing_is_forced_before_the_scope_is_armed() {
    let mut bench = Bench::new();
    bench.write(number::SCOPE_CHANNELS, 1);
    bench.send(ToDrive::TriggerScope);
    bench.send(ToDrive::TriggerScope);
    assert_eq!(bench.refused(), 1);
    assert!(matches!(bench.node.poll_scope(), Some(ScopeTask::Arm(_))));
    bench.node.handle_scope(ScopeReply::State(State::Armed, 0));
    bench.send(ToDrive::TriggerScope);
    assert_eq!((bench.node.poll_scope(), bench.node.poll_scope()), (Some(ScopeTask::Force), None));
    assert_eq!(bench.refused(), 1);
}

/// Parameter 25 refers to the coming record: inputs are recorded in every tick, whatever the prescaler.
#[test]
fn the_sampling_time_of_inputs_is_a_tick() {
    let mut bench = Bench::new();
    bench.write(number::SCOPE_CHANNELS, 1);
    bench.write(number::SCOPE_PRESCALER, 10);
    assert_eq!(bench.read(number::SCOPE_SAMPLING_TIME), (1000, ParameterStatus::Done));
    bench.write(number::SCOPE_INPUTS, 1);
    assert_eq!(bench.read(number::SCOPE_SAMPLING_TIME), (100, ParameterStatus::Done));
}

/// A block for which there is no room is not sent, nor are those after it: the record has no gap, and the
/// block can be reported again.
#[test]
fn a_block_without_room_is_told_again() {
    let mut bench = Bench::new();
    bench.node.handle_scope(ScopeReply::State(State::Done, 60));
    bench.send(ToDrive::DownloadScope);
    assert_eq!(bench.node.poll_scope(), Some(ScopeTask::Read));
    let block = |address| ScopeReply::Block(Block { address, words: [address; 3], last: address == 57 });
    let mut next = 0;
    while bench.node.takes_scope_report() {
        bench.node.handle_scope(block(next));
        next += 3;
    }
    bench.node.handle_scope(block(next));
    bench.node.handle_scope(block(next + 3));
    let mut sent = Vec::new();
    while let Some(frame) = bench.node.poll_bulk_frame() {
        let FromDrive::ScopeData { address, data } = FromDrive::decode(&frame).unwrap().1 else {
            panic!("{frame:?}")
        };
        assert_eq!(data, [address; 3]);
        sent.push(address);
        bench.node.handle_scope(block(next));
        next += 3;
    }
    assert_eq!(sent, (0..60).step_by(3).collect::<Vec<u16>>());
}
