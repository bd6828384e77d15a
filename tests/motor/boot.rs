//! Tests of the boot: T01, T06, and events that must not follow from either.

use crate::rotor::ScriptedRotor;
use crate::scripted::{BOOT, Scripted, bus_code};
use crate::support::coefficients;
use narx_core::dictionary::number;
use narx_core::motor::machine::event::Health;
use narx_core::motor::{Event, FaultWord, RunRequest, State};

fn drive(changes: &[(u16, i32)]) -> Scripted {
    Scripted::new(coefficients(changes), ScriptedRotor::new(0.2, 0.0, true), 0)
}

/// T01 happens in the tick in which 0.5 s have elapsed, not before.
#[test]
fn standby_after_half_a_second_to_the_tick() {
    let mut script = drive(&[]);
    for tick in 1..=BOOT {
        script.tick(|_| {});
        let expected = if tick < BOOT { State::Initialization } else { State::Standby };
        assert_eq!(script.drive.state(), expected, "tick {tick}");
    }
}

/// A master that requests Drive all the time does not start a drive that has just reset; after Standby it
/// can.
#[test]
fn drive_requested_during_boot_starts_nothing() {
    let mut script = drive(&[(number::HALL_ENABLE, 1)]);
    script.request = RunRequest::Drive;
    for _ in 0..BOOT + 5_000 {
        script.tick(|_| {});
        assert!(!script.drive.state().is_driving());
    }
    script.ask(RunRequest::Standby);
    script.tick(|_| {});
    script.ask(RunRequest::Drive);
    script.tick(|_| {});
    assert_eq!(script.drive.state(), State::HallClosedLoop);
}

/// A bus voltage that comes up after the controller causes no fault once it is up.
#[test]
fn a_late_bus_is_forgotten() {
    let mut script = drive(&[]);
    for tick in 0..BOOT + 1 {
        script.tick(|samples| samples.bus_voltage = bus_code(if tick < 3_000 { 2.0 } else { 48.0 }));
    }
    for _ in 0..20 {
        script.tick(|_| {});
    }
    assert_eq!((script.status.state, script.status.critical), (State::Standby, FaultWord::empty()));
    assert_eq!((script.status.faults, script.status.extended_code), (FaultWord::empty(), 0));
}

/// T06 happens for each failure, with its code even if the mask calls nothing critical; it is acknowledged
/// only once its cause is gone.
#[test]
fn a_failed_boot_has_a_code() {
    let health = |store_faults, self_test_failed| Health { store_faults, self_test_failed };
    for (failure, code) in [
        (health(FaultWord::empty(), true), 0x1B02),
        (health(FaultWord::STORE_MISMATCH, false), 0x1A01),
        (health(FaultWord::STORE_ABSENT, false), 0x1E01),
        (health(FaultWord::STORE_VERSION, false), 0x1F01),
    ] {
        for mask in [0, -1] {
            let mut script = drive(&[(number::CRITICAL_FAULT_MASK, mask)]);
            script.drive.handle_event(Event::Health(failure));
            script.tick(|_| {});
            assert_eq!((script.drive.state(), script.status.extended_code), (State::Fault, code), "{mask:x}");
            for _ in 0..10_000 {
                script.tick(|_| {});
            }
            assert_eq!(script.drive.state(), State::Fault, "not cured: {code:04x}, mask {mask:x}");
            script.drive.handle_event(Event::Health(Health::default()));
            script.tick(|_| {});
            assert_eq!(script.drive.state(), State::Standby, "cured: {code:04x}, mask {mask:x}");
        }
    }
}
