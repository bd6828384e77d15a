//! When the fault logic need not look: a tick that may leave it out is one in which it would find nothing.

use crate::protection::{QUANTITIES, healthy, limits, with};
use narx_core::motor::guard::protection::{Evidence, Health, Protection, ProtectionCoefficients};
use narx_core::motor::rotor::hall::HallEvents;
use narx_core::motor::{Cause, FaultWord, Lines};

fn at_rest(c: &ProtectionCoefficients) -> Protection {
    let mut protection = Protection::default();
    assert!(!protection.is_quiet(), "nothing was looked at yet");
    protection.step(c, &healthy());
    protection
}

/// The tick with this evidence may leave it out.
fn is_left_out(protection: &Protection, c: &ProtectionCoefficients, evidence: &Evidence) -> bool {
    let (voltage, current) =
        (evidence.measured.bus_voltage.to_bits(), evidence.measured.bus_current.to_bits());
    protection.stays_quiet(evidence.speed)
        && protection.stays_quiet_at(c, &evidence.slow)
        && c.bus_voltage().contains(voltage)
        && c.bus_current().contains(current)
        && !evidence.lines.intersects(c.lines())
}

/// Up to each threshold, and not a thousandth beyond it.
#[test]
fn every_quantity_stirs_it_at_its_threshold() {
    let mut c = limits(u32::MAX);
    for (cause, within, beyond, ..) in QUANTITIES {
        if cause == Cause::OverTemperature {
            // The warning would come before it.
            c.warning.trip = i32::MAX;
        }
        let protection = at_rest(&c);
        assert!(is_left_out(&protection, &c, &with(cause, within)), "{cause:?}");
        assert!(!is_left_out(&protection, &c, &with(cause, beyond)), "{cause:?}");
    }
}

#[test]
fn every_line_that_is_looked_at_stirs_it() {
    let c = limits(u32::MAX);
    let protection = at_rest(&c);
    for (line, seen) in [
        (Lines::DRIVER_FAULT, true),
        (Lines::EMERGENCY, true),
        (Lines::DSI1, true),
        // Not configured to shut down.
        (Lines::DSI2, false),
    ] {
        assert_eq!(is_left_out(&protection, &c, &Evidence { lines: line, ..healthy() }), !seen, "{line:?}");
    }
}

/// What has begun to qualify, or waits to clear, is looked at in every tick; then there is rest again.
#[test]
fn what_was_stirred_comes_to_rest() {
    let c = limits(0);
    let h = Evidence { driving: false, ..healthy() };
    let hall = |hall| Evidence { hall, ..healthy() };
    let mut cases: Vec<(String, Evidence)> =
        QUANTITIES.map(|(cause, _, beyond, ..)| (format!("{cause:?}"), with(cause, beyond))).to_vec();
    cases.extend([
        ("line".to_owned(), Evidence { lines: Lines::DSI1, ..h }),
        ("invalid".to_owned(), hall(HallEvents { invalid: true, ..HallEvents::default() })),
        ("jump".to_owned(), hall(HallEvents { jump: true, ..HallEvents::default() })),
        ("stall".to_owned(), Evidence { hall_stopped: true, ..healthy() }),
        (
            "store".to_owned(),
            Evidence { health: Health { store_faults: FaultWord::STORE_MISMATCH, ..Health::default() }, ..h },
        ),
    ]);
    for (what, evidence) in cases {
        let mut protection = at_rest(&c);
        assert!(protection.is_quiet(), "{what}");
        protection.step(&c, &evidence);
        assert!(!protection.is_quiet() && !protection.stays_quiet(0), "{what}");
        assert!(!protection.stays_quiet_at(&c, &healthy().slow), "{what}");
        // A jump weighs 13, one a millisecond is taken away.
        for _ in 0..140 {
            protection.step(&c, &healthy());
        }
        assert!(protection.is_quiet(), "{what}: at rest again");
        protection.wake();
        assert!(!protection.is_quiet(), "{what}: woken");
    }
}

/// An edge backward is remembered, and each forward makes up for a third of it.
#[test]
fn edges_backward_are_remembered() {
    let c = limits(u32::MAX);
    let mut protection = at_rest(&c);
    let mut turn = |sectors| {
        protection.step(&c, &Evidence { hall: HallEvents { sectors, ..HallEvents::default() }, ..healthy() });
        protection.goes_forward()
    };
    assert_eq!([0, 1, -1, 1, 1, 1, 0].map(&mut turn), [true, true, false, false, false, true, true]);
}

/// The overspeed threshold of an episode is the largest that it had: a limit that is lowered while the motor turns is for the set-point first.
#[test]
fn a_lowered_overspeed_waits_for_the_next_episode() {
    let c = limits(u32::MAX);
    let lower = ProtectionCoefficients {
        overspeed_hall: narx_core::motor::guard::protection::Limit {
            trip: 50 << 16,
            clear: 40 << 16,
            ticks: 1,
        },
        ..c
    };
    let mut protection = at_rest(&c);
    assert!(!protection.step(&lower, &healthy()), "100 rev/s");
    assert!(protection.stays_quiet(healthy().speed));
    protection.forget_episode();
    assert!(!protection.stays_quiet(1), "the next tick finds it anew");
    assert!(protection.step(&lower, &healthy()));
    assert_eq!(protection.code(), Cause::Overspeed as u16);
}
