//! Tests of the ticks in which the fault logic need not run: in such a tick it would find nothing new.

use crate::protection::{Guard, QUANTITIES, healthy, limits, with};
use narx_core::motor::guard::protection::{Evidence, Health, Limit, ProtectionCoefficients};
use narx_core::motor::rotor::hall::HallEvents;
use narx_core::motor::{Cause, FaultWord, Lines};
use narx_core::units::{Amps, Celsius, Volts};
use proptest::prelude::*;

fn at_rest(c: &ProtectionCoefficients) -> Guard {
    let mut guard = Guard::default();
    assert!(guard.due().is_due(guard.now), "nothing was looked at yet");
    guard.step(c, &healthy());
    guard
}

/// Returns whether it may be left out of the next tick with this evidence.
fn is_left_out(guard: &Guard, c: &ProtectionCoefficients, evidence: &Evidence) -> bool {
    let asserted = guard.lines.intersection(c.lines());
    let (voltage, current) =
        (evidence.measured.bus_voltage.to_bits(), evidence.measured.bus_current.to_bits());
    !guard.due().is_due(guard.now.next())
        && evidence.speed <= guard.overspeed_trip()
        && guard.calm_voltages(c).contains(voltage)
        && c.bus_current().contains(current)
        && evidence.lines.intersection(c.lines()) == asserted
        && guard.stays_calm_at(c, &evidence.slow)
}

/// Every quantity lets the fault logic rest up to its threshold, and not a thousandth beyond it.
#[test]
fn every_quantity_stirs_it_at_its_threshold() {
    let mut c = limits(u32::MAX);
    for (cause, within, beyond, ..) in QUANTITIES {
        if cause == Cause::OverTemperature {
            // The temperature warning would come first.
            c.warning.trip = i32::MAX;
        }
        let guard = at_rest(&c);
        assert!(is_left_out(&guard, &c, &with(cause, within)), "{cause:?}");
        assert!(!is_left_out(&guard, &c, &with(cause, beyond)), "{cause:?}");
    }
}

#[test]
fn every_line_that_is_looked_at_stirs_it() {
    let c = limits(u32::MAX);
    let guard = at_rest(&c);
    for (line, seen) in [
        (Lines::DRIVER_FAULT, true),
        (Lines::EMERGENCY, true),
        (Lines::DSI1, true),
        // Not configured to shut down.
        (Lines::DSI2, false),
    ] {
        assert_eq!(is_left_out(&guard, &c, &Evidence { lines: line, ..healthy() }), !seen, "{line:?}");
    }
}

/// While a fault lasts the fault logic need not run: at most twice in half a minute.
#[test]
fn a_lasting_fault_is_left_out() {
    let c = limits(0);
    let lasting = |cause, milli| (cause, with(cause, milli));
    for (cause, evidence) in [
        lasting(Cause::OverVoltage, 61_500),
        lasting(Cause::UnderVoltage, 12_000),
        lasting(Cause::TemperatureWarning, 186_000),
        lasting(Cause::OverPressure, 3_400),
        (Cause::ShutdownLine, Evidence { lines: Lines::DSI1, ..healthy() }),
        (Cause::EmergencyLine, Evidence { lines: Lines::EMERGENCY, ..healthy() }),
        (
            Cause::StoreMismatch,
            Evidence {
                health: Health { store_faults: FaultWord::STORE_MISMATCH, ..Health::default() },
                ..healthy()
            },
        ),
    ] {
        let mut guard = at_rest(&c);
        guard.step(&c, &evidence);
        let mut looks = 0;
        for _ in 0..300_000 {
            if is_left_out(&guard, &c, &evidence) {
                guard.now = guard.now.next();
            } else {
                guard.step(&c, &evidence);
                looks += 1;
            }
        }
        assert!(guard.word().contains(cause.bit()), "{cause:?}");
        assert!(looks <= 2, "{cause:?}: {looks} looks");
    }
}

/// While an over-voltage qualifies, a volt above its threshold makes the fault logic run at once.
#[test]
fn a_rising_over_voltage_is_seen_at_once() {
    let c = limits(u32::MAX);
    let mut guard = at_rest(&c);
    assert!(!guard.step(&c, &with(Cause::OverVoltage, 61_500)));
    assert!(is_left_out(&guard, &c, &with(Cause::OverVoltage, 61_999)));
    assert!(!is_left_out(&guard, &c, &with(Cause::OverVoltage, 62_001)));
}

/// The counts of hall events decay with time, so the fault logic runs in every tick until they are 0 again.
#[test]
fn counts_of_the_sensors_come_to_rest() {
    let c = limits(0);
    let hall = |hall| Evidence { hall, ..healthy() };
    for (what, evidence) in [
        ("invalid", hall(HallEvents { invalid: true, ..HallEvents::default() })),
        ("jump", hall(HallEvents { jump: true, ..HallEvents::default() })),
        ("stall", Evidence { hall_stopped: true, ..healthy() }),
        ("overspeed", with(Cause::Overspeed, 350_000)),
    ] {
        let mut guard = at_rest(&c);
        guard.step(&c, &evidence);
        assert!(!is_left_out(&guard, &c, &healthy()), "{what}");
        // A jump weighs 13; one is taken away per millisecond.
        for _ in 0..140 {
            guard.step(&c, &healthy());
        }
        assert!(is_left_out(&guard, &c, &healthy()), "{what}: at rest again");
        let now = guard.now;
        guard.wake(now);
        assert!(!is_left_out(&guard, &c, &healthy()), "{what}: woken");
    }
}

proptest! {
    /// A fault logic that runs only when it must reports the same in every tick as one that runs in each.
    #[test]
    fn who_sleeps_finds_the_same(
        mask in any::<u32>(),
        course in prop::collection::vec(
            (
                // Values on both sides of trip, hysteresis and the voltage that qualifies at once.
                prop::sample::select(vec![15_500, 16_300, 48_000, 60_400, 60_800, 61_500, 62_500]),
                prop::sample::select(vec![0, 6_800, 7_100, -7_100]),
                prop::sample::select(vec![182_000, 184_000, 186_000, 189_000, 191_000]),
                prop::sample::select(vec![3_000, 3_200, 3_400]),
                prop::sample::select(vec![0, 0, 0, 1, 2, 4, 8]),
                prop_oneof![1..150_u32, 990..1_010_u32],
            ),
            1..60,
        ),
    ) {
        let c = limits(mask);
        let (mut looks, mut sleeps) = (Guard::default(), Guard::default());
        for (volts, amps, degrees, pressure, lines, ticks) in course {
            let mut evidence = healthy();
            evidence.measured.bus_voltage = Volts::from_milli(volts);
            evidence.measured.bus_current = Amps::from_milli(amps);
            evidence.slow.temperature = Celsius::from_milli(degrees);
            evidence.slow.pressure = Volts::from_milli(pressure);
            evidence.lines = Lines::from_bits_truncate(lines);
            for tick in 0..ticks {
                let found = looks.step(&c, &evidence);
                if is_left_out(&sleeps, &c, &evidence) {
                    sleeps.now = sleeps.now.next();
                } else {
                    sleeps.step(&c, &evidence);
                }
                let told = (sleeps.is_critical(), sleeps.word(), sleeps.critical(), sleeps.code());
                prop_assert_eq!(told, (found, looks.word(), looks.critical(), looks.code()), "tick {}", tick);
            }
        }
    }
}

/// An edge backward is remembered, and each edge forward makes up for a third of it.
#[test]
fn edges_backward_are_remembered() {
    let c = limits(u32::MAX);
    let mut guard = at_rest(&c);
    let mut turn = |sectors| {
        guard.step(&c, &Evidence { hall: HallEvents { sectors, ..HallEvents::default() }, ..healthy() });
        guard.goes_forward()
    };
    assert_eq!([0, 1, -1, 1, 1, 1, 0].map(&mut turn), [true, true, false, false, false, true, true]);
}

/// The overspeed threshold of an episode is the largest that it had: a limit that is lowered while the motor
/// turns at first acts on the set-point only.
#[test]
fn a_lowered_overspeed_waits_for_the_next_episode() {
    let c = limits(u32::MAX);
    let overspeed_hall = Limit { trip: 50 << 16, clear: 40 << 16, ticks: 1 };
    let lower = ProtectionCoefficients { overspeed_hall, ..c };
    let mut guard = at_rest(&c);
    assert!(!guard.step(&lower, &healthy()), "100 rev/s");
    assert!(is_left_out(&guard, &lower, &healthy()));
    guard.forget_episode();
    assert!(!is_left_out(&guard, &lower, &healthy()), "the next tick finds it anew");
    assert!(guard.step(&lower, &healthy()));
    assert_eq!(guard.code(), Cause::Overspeed as u16);
}
