//! Tests of Table 7 against code written from the specification, for every state and every set of conditions.
//!
//! `expected` was written from Table 6, Table 7 and the project's decisions on them, not from the core's
//! table: plain `if`s in the order critical fault, Standby request, communication time-out, reversal, time
//! and speed.

use narx_core::motor::State;
use narx_core::motor::machine::state::{Conditions, TRANSITIONS, transition};

/// Result by the specification: the transition's name and the state after it.
fn expected(state: State, c: Conditions) -> Option<(&'static str, State)> {
    let has = |condition| c.contains(condition);
    match state {
        State::Initialization => boot(&has),
        State::Standby => start(&has),
        State::RotorLock => {
            if has(Conditions::CRITICAL) {
                return Some(("T26", State::Fault));
            }
            if has(Conditions::STANDBY) {
                return Some(("T21", State::Standby));
            }
            if has(Conditions::EXPIRED) {
                return Some(("T26", State::Fault));
            }
            // The rotor is held: there is nothing to decelerate.
            if has(Conditions::REVERSAL) {
                return Some(("T21", State::Standby));
            }
            has(Conditions::ELAPSED).then_some(("T23", State::OpenLoop))
        }
        State::OpenLoop => open_loop(&has),
        State::SensorlessClosedLoop => {
            if has(Conditions::CRITICAL) || (has(Conditions::EXPIRED) && !has(Conditions::STANDBY)) {
                return Some(("T46", State::Fault));
            }
            if has(Conditions::STANDBY) {
                return Some(("T41", State::Standby));
            }
            match (has(Conditions::STOPPED), has(Conditions::REVERSAL)) {
                (true, true) => Some(("T41", State::Standby)),
                (true, false) if has(Conditions::OTHER_SOURCE) => Some(("T45", State::HallClosedLoop)),
                (true, false) => Some(("T47", State::SensorlessAutoRestart)),
                (false, _) => None,
            }
        }
        State::HallClosedLoop => {
            if has(Conditions::CRITICAL) || (has(Conditions::EXPIRED) && !has(Conditions::STANDBY)) {
                return Some(("T56", State::Fault));
            }
            let reversed = has(Conditions::REVERSAL) && has(Conditions::STOPPED);
            if has(Conditions::STANDBY) || reversed {
                return Some(("T51", State::Standby));
            }
            let other = has(Conditions::OTHER_SOURCE) && !has(Conditions::REVERSAL);
            other.then_some(("T54", State::SensorlessClosedLoop))
        }
        State::Fault => {
            let cured = has(Conditions::ACKNOWLEDGED) && !has(Conditions::CRITICAL);
            cured.then_some(("T61", State::Standby))
        }
        State::SensorlessAutoRestart => {
            if has(Conditions::CRITICAL) || (has(Conditions::EXPIRED) && !has(Conditions::STANDBY)) {
                return Some(("T76", State::Fault));
            }
            if has(Conditions::STANDBY) {
                return Some(("T71", State::Standby));
            }
            // The other direction from rest: no wait is needed.
            if has(Conditions::REVERSAL) && has(Conditions::STOPPED) {
                return Some(("T71", State::Standby));
            }
            match (has(Conditions::ELAPSED), has(Conditions::STOPPED)) {
                (true, true) => Some(("T71", State::Standby)),
                (true, false) => Some(("T74", State::SensorlessClosedLoop)),
                (false, _) => None,
            }
        }
    }
}

/// T06 and T01: boot time alone is not enough, the self-tests must have passed.
fn boot(has: &impl Fn(Conditions) -> bool) -> Option<(&'static str, State)> {
    if has(Conditions::UNHEALTHY) {
        return Some(("T06", State::Fault));
    }
    has(Conditions::BOOTED).then_some(("T01", State::Standby))
}

/// Table 6 with its priority. A request for Standby, or one that was not renewed within the time-out, starts
/// nothing.
fn start(has: &impl Fn(Conditions) -> bool) -> Option<(&'static str, State)> {
    if has(Conditions::CRITICAL) {
        return Some(("T16", State::Fault));
    }
    if !has(Conditions::START) || has(Conditions::STANDBY) || has(Conditions::EXPIRED) {
        return None;
    }
    if has(Conditions::CALIBRATION) {
        Some(("T12", State::RotorLock))
    } else if has(Conditions::HALL) {
        Some(("T15", State::HallClosedLoop))
    } else if has(Conditions::SENSORLESS) {
        Some(("T12", State::RotorLock))
    } else if has(Conditions::OPEN_LOOP) {
        Some(("T13", State::OpenLoop))
    } else {
        None
    }
}

fn open_loop(has: &impl Fn(Conditions) -> bool) -> Option<(&'static str, State)> {
    if has(Conditions::CRITICAL) {
        return Some(("T36", State::Fault));
    }
    if has(Conditions::STANDBY) {
        return Some(("T31", State::Standby));
    }
    if has(Conditions::EXPIRED) {
        return Some(("T36", State::Fault));
    }
    // The result of an earlier calibration must not stop an ordinary open-loop run.
    if has(Conditions::CALIBRATION) && has(Conditions::CALIBRATED) {
        return Some(("T31", State::Standby));
    }
    if has(Conditions::REVERSAL) {
        return has(Conditions::STOPPED).then_some(("T31", State::Standby));
    }
    let sensorless = has(Conditions::SENSORLESS) && !has(Conditions::HALL) && !has(Conditions::CALIBRATION);
    (has(Conditions::ELAPSED) && sensorless).then_some(("T34", State::SensorlessClosedLoop))
}

#[test]
fn every_state_and_every_set_of_conditions() {
    let mut checked = 0;
    let mut fired = 0;
    for state in State::ALL {
        for bits in 0..=u16::MAX {
            let conditions = Conditions::from_bits(bits).unwrap();
            let found = transition(state, conditions).map(|row| (row.to_string(), row.to));
            assert_eq!(
                found.as_ref().map(|(name, to)| (name.as_str(), *to)),
                expected(state, conditions),
                "{state:?} with {conditions:?}"
            );
            checked += 1;
            fired += u32::from(found.is_some());
        }
    }
    println!("{checked} cases, {fired} of them with a transition");
    assert_eq!(checked, 8 * 65_536);
}

/// Every row of Table 7 and the added ones (T06, T16, T76, T54, T45) exist, and every row can be the one that
/// fires.
#[test]
fn every_row_of_table_7_can_fire() {
    let mut names = [
        "T01", "T12", "T13", "T15", "T21", "T23", "T26", "T31", "T34", "T36", "T41", "T46", "T47", "T51",
        "T56", "T61", "T71", "T74", "T06", "T16", "T76", "T54", "T45",
    ]
    .to_vec();
    for row in &TRANSITIONS {
        let chosen = transition(row.from, row.all);
        assert!(
            chosen.is_some_and(|chosen| (chosen.all, chosen.none) == (row.all, row.none)),
            "a row before {row} {:?} -> {:?} always wins",
            row.from,
            row.to
        );
        names.retain(|name| *name != row.to_string());
    }
    assert!(names.is_empty(), "missing: {names:?}");
}

#[test]
fn states_carry_the_numbers_and_powers_of_section_7() {
    let names = [
        "Initialization",
        "Standby",
        "Rotor lock",
        "Open-loop",
        "Sensorless Closed-loop",
        "Closed-loop Hall Effect Sensors",
        "Fault",
        "Sensorless Auto-Restart",
    ];
    assert_eq!(State::ALL.map(State::name), names);
    for (number, state) in State::ALL.into_iter().enumerate() {
        assert_eq!(state as usize, number);
        assert_eq!(state.is_driving(), [2, 3, 4, 5, 7].contains(&number), "{state:?}");
    }
}
