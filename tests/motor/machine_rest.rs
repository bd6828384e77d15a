//! Tests of the ticks in which the state machine need not run: those in which it rests, those until it is
//! due, and requests that it already knows. They cover every reachable state.

use super::machine_search::{Memory, as_of, coefficients, inputs, machine, memory, reached, start};
use narx_core::motor::State;
use narx_core::motor::clock::Instant;
use narx_core::motor::machine::event::{Command, RunRequest};
use narx_core::motor::machine::{Machine, Refusal};
use narx_core::units::ElectricalSpeed;
use std::collections::HashSet;

/// Memory of the machine as of `now`, except the time for which it rests.
fn known(now: Instant, mut machine: Machine) -> Memory {
    machine.wake(now);
    as_of(now, memory(&machine))
}

/// In a tick in which the machine rests no row of the table holds, and it can rest in every state. The drive
/// wakes a machine whose health has changed, or whose calibration has a result.
#[test]
fn a_machine_that_rests_has_no_row_that_holds() {
    let c = coefficients(7);
    let mut states = HashSet::new();
    let now = start().next();
    for before in reached() {
        let rested = machine(before);
        for inputs in (0..64).map(inputs).filter(|inputs| !inputs.unhealthy && !inputs.calibrated) {
            if !rested.rests(now, inputs.critical, inputs.stopped) {
                continue;
            }
            states.insert(before.state);
            let mut looked = rested;
            assert!(looked.advance(&c, now, &inputs).is_none(), "{before:?} {inputs:?}");
            // Nothing changes but the time for which it rests.
            assert_eq!(known(now, looked), known(now, rested), "{inputs:?}");
        }
    }
    assert_eq!(states, HashSet::from(State::ALL));
}

/// A machine that runs only when it is due, or when the drive must run it (a critical fault, a rotor that
/// stands, a calibration with a result), changes as one that checks its table in every tick: to the same
/// state, by the same row, in the same tick.
#[test]
fn a_machine_that_is_asked_when_it_is_due_changes_as_one_that_looks() {
    let c = coefficients(7);
    let (mut asked, mut ticks) = (0, 0);
    for before in reached() {
        let unchanged = machine(before);
        for inputs in (0..64).map(inputs).filter(|inputs| !inputs.unhealthy) {
            let (mut sleeps, mut looks) = (unchanged, unchanged);
            let mut now = start();
            // Longer than the longest time.
            for tick in 1..=6 {
                now = now.next();
                if inputs.calibrated && sleeps.calibrating() {
                    sleeps.wake(now);
                }
                let is_asked = !sleeps.rests(now, inputs.critical, inputs.stopped);
                let found = if is_asked { sleeps.step(&c, now, &inputs) } else { None };
                let expected = looks.advance(&c, now, &inputs);
                let [found, expected] = [found, expected]
                    .map(|change| change.map(|change| (change.row.from, change.row.to, change.timed_out)));
                assert_eq!(found, expected, "{before:?} {inputs:?}, tick {tick}");
                let of = |machine: &Machine| {
                    (machine.state(), machine.age(now), machine.command_expired(&c, now), machine.refusal())
                };
                assert_eq!(of(&sleeps), of(&looks), "{before:?} {inputs:?}, tick {tick}");
                asked += u32::from(is_asked);
                ticks += 1;
            }
            assert_eq!(known(now, sleeps), known(now, looks), "{before:?} {inputs:?}");
        }
    }
    println!("asked in {asked} of {ticks} ticks");
    assert!(asked < ticks, "it is asked in every tick");
}

/// A request that the machine already knows acts as a set-point. In every state there is such a request, and
/// while driving it is never Standby.
#[test]
fn a_request_that_it_knows_only_feeds_the_time_out() {
    let mut states = HashSet::new();
    for before in reached() {
        for request in [RunRequest::Standby, RunRequest::Drive, RunRequest::Reverse, RunRequest::Shutdown] {
            let command = Command { request, speed: ElectricalSpeed::from_bits(7) };
            let (mut told, mut reminded) = (machine(before), machine(before));
            if told.knows(request) {
                states.insert(before.state);
                assert!(!(before.state.is_driving() && request == RunRequest::Standby), "{before:?}");
                told.handle_command(start(), command);
                reminded.handle_set_point(start(), command.speed);
                // Only the time at which it is due differs: a deadline may be early.
                assert_eq!(known(start(), told), known(start(), reminded), "{before:?}");
            }
        }
    }
    assert_eq!(states, HashSet::from(State::ALL));
}

/// Only a driven motor can be reversed, and only while it is requested to run.
#[test]
fn nothing_is_reversed_that_is_not_driven() {
    let mut seen = HashSet::new();
    for before in reached() {
        let machine = machine(before);
        let asks = matches!(before.command.request, RunRequest::Drive | RunRequest::Reverse);
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

/// A start that was refused is over: no later tick expects it.
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
