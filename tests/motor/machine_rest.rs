//! When the machine may be left alone: ticks in which it rests, and requests that it knows. Every reachable state is asked.

use super::machine_search::{coefficients, inputs, machine, reached};
use narx_core::motor::State;
use narx_core::motor::event::{Command, Request};
use narx_core::motor::machine::Refusal;
use narx_core::units::ElectricalSpeed;
use std::collections::HashSet;

/// No row of the table holds in a tick in which the machine rests; and it rests in every state. The drive wakes a machine whose health has changed.
#[test]
fn a_machine_that_rests_has_no_row_that_holds() {
    let c = coefficients(7);
    let mut states = HashSet::new();
    for before in reached() {
        for inputs in (0..64).map(inputs).filter(|inputs| !inputs.unhealthy) {
            let mut rested = machine(before);
            rested.pass(1);
            if !rested.rests(inputs.critical, inputs.stopped) {
                continue;
            }
            states.insert(before.state);
            let mut looked = rested;
            assert!(looked.advance(&c, &inputs).is_none(), "{before:?} {inputs:?}");
            // Nothing else is found out than for how long it rests.
            looked.wake();
            rested.wake();
            assert_eq!(looked, rested, "{inputs:?}");
        }
    }
    assert_eq!(states, HashSet::from(State::ALL));
}

/// A request that the machine knows is a set-point. In every state it knows one, and it knows no Standby while it drives.
#[test]
fn a_request_that_it_knows_only_feeds_the_time_out() {
    let mut states = HashSet::new();
    for before in reached() {
        for request in [Request::Standby, Request::Drive, Request::Reverse, Request::Shutdown] {
            let command = Command { request, speed: ElectricalSpeed::from_bits(7) };
            let (mut told, mut reminded) = (machine(before), machine(before));
            if told.knows(request) {
                states.insert(before.state);
                assert!(!(before.state.is_driving() && request == Request::Standby), "{before:?}");
                told.handle_command(command);
                reminded.handle_set_point(command.speed);
                assert_eq!(told, reminded, "{before:?}");
            }
        }
    }
    assert_eq!(states, HashSet::from(State::ALL));
}

/// Only what is driven can be reversed, and only by somebody who still wants it to run.
#[test]
fn nothing_is_reversed_that_is_not_driven() {
    let mut seen = HashSet::new();
    for before in reached() {
        let machine = machine(before);
        let asks = matches!(before.command.request, Request::Drive | Request::Reverse);
        seen.insert((before.state.is_driving(), asks, machine.reversing()));
        assert!(!machine.reversing() || (before.state.is_driving() && asks), "{before:?}");
    }
    let all = [
        (false, false, false),
        (false, true, false),
        (true, false, false),
        (true, true, false),
        (true, true, true),
    ];
    assert_eq!(seen, HashSet::from(all));
}

/// A start that was refused is spent: no tick takes it for one that is to come.
#[test]
fn a_refused_start_is_no_start() {
    let mut refused = 0;
    for before in reached() {
        let machine = machine(before);
        if machine.refusal() != Refusal::None {
            refused += 1;
            assert!(!machine.starting(), "{before:?}");
        }
    }
    assert!(refused > 0);
}
