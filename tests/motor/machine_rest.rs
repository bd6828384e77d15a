//! When the machine may be left alone: ticks that rest, how long that lasts, and requests that it knows. Every reachable state is asked.

use super::machine_search::{BOOT, coefficients, inputs, machine, reached, wanted};
use narx_core::motor::State;
use narx_core::motor::event::{Command, Request};
use narx_core::motor::machine::{Inputs, Refusal};
use narx_core::units::ElectricalSpeed;
use std::collections::HashSet;

/// A tick that rests looks at no row of the table, and none would have held. Whoever waits for a master rests.
#[test]
fn a_tick_that_rests_leaves_nothing_out() {
    let c = coefficients(7);
    for before in reached() {
        for inputs in (0..64).map(inputs) {
            let Inputs { critical, stopped, unhealthy, .. } = inputs;
            let mut rested = machine(before);
            let rests = rested.rests(&c, critical, stopped, unhealthy);
            let mut looked = rested;
            if rests {
                assert!(looked.advance(&c, &inputs).is_none(), "{before:?} {inputs:?}");
                assert_eq!(looked, rested, "{inputs:?}");
            }
            let waits = match before.state {
                State::Initialization => before.age + 1 < BOOT && !unhealthy,
                State::Standby => !critical && wanted(before.command.request).is_none(),
                State::Fault => !before.acknowledged,
                _ => continue,
            };
            assert_eq!(rests, waits, "{before:?} {inputs:?}");
        }
    }
}

/// A driven machine is calm for just as many ticks as it rests for by itself; also when a set-point comes that it hears of later.
#[test]
fn calm_lasts_as_long_as_the_machine_rests() {
    let c = coefficients(7);
    let (mut longest, mut latest) = (0, 0);
    for before in reached() {
        let mut resting = machine(before);
        let rests = (0..).take_while(|_| resting.rests(&c, false, false, false)).take(9).count();
        let calm = machine(before).calm(&c);
        assert_eq!(calm as usize, if before.state.is_driving() { rests } else { 0 }, "{before:?}");
        longest = calm.max(longest);
        for slept in [0, 1, 3] {
            let mut late = machine(before);
            late.handle_set_point(ElectricalSpeed::ZERO, slept);
            let calm = late.calm(&c);
            if calm > 0 {
                assert_eq!(late.calm_since(&c, slept), calm, "{before:?} {slept}");
                latest = calm.max(latest);
            }
        }
    }
    assert!(longest >= 1 && latest > longest, "{longest} {latest}");
}

/// A request that it knows is a set-point, in whatever state; and ticks of which it hears later are those before the set-point.
#[test]
fn a_request_that_it_knows_only_feeds_the_time_out() {
    let mut known = HashSet::new();
    for before in reached() {
        for request in [Request::Standby, Request::Drive, Request::Reverse, Request::Shutdown] {
            let command = Command { request, speed: ElectricalSpeed::from_bits(7) };
            let (mut told, mut reminded, mut late) = (machine(before), machine(before), machine(before));
            told.handle_command(command);
            reminded.handle_set_point(command.speed, 0);
            let knows = machine(before).knows(request);
            // Of what is driven it may know less: a Standby ends that in the same tick.
            let none = told == reminded;
            assert!(
                if before.state.is_driving() { !knows || none } else { knows == none },
                "{before:?} {request:?}"
            );
            if knows {
                known.insert((before.state, request as u8));
            }
            for slept in [1, 3, 1000] {
                late.handle_set_point(command.speed, slept);
                late.sleep(slept);
                assert_eq!(
                    late.command_expired(&coefficients(0)),
                    reminded.command_expired(&coefficients(0))
                );
            }
        }
    }
    // In every state something is known, and a driven one knows no Standby.
    assert_eq!(
        known.iter().map(|(state, _)| state).collect::<HashSet<_>>().len(),
        State::ALL.len(),
        "{known:?}"
    );
    assert!(known.iter().all(|(state, request)| !(state.is_driving() && *request == Request::Standby as u8)));
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
