//! Tests of network management: every command byte, length and target in every state, and the function of
//! each state.

use crate::bench::{Bench, STATES, frame, node};
use narx_core::bus::eddycan::{
    Channels, ErrorCode, FromNode, NmtCommand, NmtState, PdoKind, SdoAction, Target, ToNode,
};
use narx_core::eddycan::Entry;

/// Of the targets, 0 and the factory node-id 1 address this node, all others do not.
#[test]
fn every_command_length_and_target_in_every_state() {
    for state in STATES {
        let bench = Bench::in_state(state, Channels::Single, &[]);
        for command in 0..=u8::MAX {
            for target in [0, 1, 2, 127, 128, 255] {
                for length in 0..=8 {
                    let mut bench = Bench { driver: bench.driver.clone(), now: bench.now };
                    let before = bench.driver.clone();
                    bench.give(&frame(0, &[command, target, 0, 0, 0, 0, 0, 0][..length]));
                    let received = length == 2 && target <= 1;
                    let unknown = received && target == 1 && !matches!(command, 1 | 2 | 0x80 | 0x81);
                    let expected = match command {
                        1 if received => NmtState::Operational,
                        2 if received => NmtState::Stopped,
                        0x80 if received => NmtState::PreOperational,
                        _ => state,
                    };
                    let what = format!("{state:?} {command:02X} to {target}, {length} bytes");
                    assert_eq!(bench.driver.state(), expected, "{what}");
                    let reset = received && command == 0x81;
                    if !received {
                        assert_eq!(bench.driver, before, "{what}");
                    }
                    let reports = if unknown { vec![FromNode::Error { code: 0x8200 }] } else { vec![] };
                    assert_eq!(bench.messages(), reports, "{what}");
                    assert_eq!(bench.driver.take_reset(), reset, "{what}");
                }
            }
        }
    }
}

/// Pre-Operational is for configuration, Operational sends positions, Stopped only takes commands (section
/// 3.4).
#[test]
fn what_each_state_does() {
    for (state, positions, answers) in
        [(NmtState::PreOperational, 0, 1), (NmtState::Operational, 3, 1), (NmtState::Stopped, 0, 0)]
    {
        let mut bench = Bench::in_state(state, Channels::Single, &[(Entry::UpdateTime, 10)]);
        bench.send(ToNode::Sync);
        bench.send(ToNode::RequestPdo { node: node(1), bytes: 4 });
        bench.driver.poll(bench.now);
        let pdos = bench.messages();
        assert_eq!(pdos.len(), positions, "{state:?}");
        assert_eq!(bench.sdo(0x2000, 0, SdoAction::Read).len(), answers, "{state:?}");
    }
}

#[test]
fn only_what_the_state_sends_is_left_when_it_changes() {
    let operational = || {
        let mut bench = Bench::in_state(NmtState::Operational, Channels::Single, &[]);
        bench.send(ToNode::Sync);
        bench
    };
    for state in [NmtState::PreOperational, NmtState::Stopped] {
        let mut bench = operational();
        bench.enter(state);
        assert_eq!(bench.frames(), [], "{state:?}");
    }
    let read = |bench: &mut Bench| bench.give(&frame(0x601, &[0x40, 0, 0x20, 0, 0, 0, 0, 0]));
    let mut bench = Bench::new(Channels::Single, &[]);
    read(&mut bench);
    bench.enter(NmtState::Stopped);
    assert_eq!(bench.frames(), [], "a Stopped node provides no SDO");
    bench.enter(NmtState::PreOperational);
    read(&mut bench);
    bench.enter(NmtState::Operational);
    assert_eq!(bench.frames().len(), 1, "what was done is confirmed");
}

#[test]
fn being_told_to_stay_changes_nothing() {
    for (state, command) in [
        (NmtState::PreOperational, NmtCommand::PreOperational),
        (NmtState::Operational, NmtCommand::Start),
        (NmtState::Stopped, NmtCommand::Stop),
    ] {
        let mut bench = Bench::in_state(state, Channels::Single, &[(Entry::UpdateTime, 10)]);
        bench.wait(3000);
        let before = bench.driver.clone();
        bench.send(ToNode::Nmt { command, target: Target::All });
        assert_eq!(bench.driver, before, "{state:?}");
    }
}

#[test]
fn autostart() {
    for (register, state) in [(0, NmtState::PreOperational), (1, NmtState::Operational)] {
        let values = [(Entry::CanConfig, register), (Entry::UpdateTime, 5)];
        let mut bench = Bench::new(Channels::Single, &values);
        assert_eq!(bench.driver.state(), state);
        let pdos = bench.pdos(20_000);
        assert_eq!(pdos.len(), if register == 1 { 4 } else { 0 });
        assert!(pdos.iter().all(|(_, kind, _)| *kind == PdoKind::Timer));
    }
}

/// A wrong command to this node is answered; a wrong broadcast is not, because 127 nodes would answer.
#[test]
fn unknown_commands_are_reported_by_the_node_that_is_meant() {
    let mut bench = Bench::new(Channels::Single, &[]);
    for (target, reports) in [(0, 0), (2, 0), (1, 1)] {
        bench.give(&frame(0, &[0x7F, target]));
        assert_eq!(bench.frames().len(), reports, "to {target}");
    }
    assert_eq!(ErrorCode::Protocol as u16, 0x8200);
}
