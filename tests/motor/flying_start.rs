//! Tests of starts with a rotor that already turns: forward it is caught, backward it is braked within the
//! bus limit first.

use crate::bench::{Closed, MOTOR, RPM};
use narx_core::motor::{RunRequest, State, Step};
use narx_sim::plant::{Injection, LoadConfig, Plant, PlantConfig};

/// Result of a start with a turning rotor.
struct Flight {
    closed: Closed,
    /// Slowest speed, rpm.
    slowest: f64,
    peak: f64,
    bus_max: f64,
    /// Time from the request until it turns at half of the set-point, s.
    up: f64,
}

/// Boots, lets the rotor turn with `rpm`, and requests Drive for three seconds. `inertia` is the load's, in
/// multiples of the rotor's.
fn fly(supply: f64, rpm: f64, inertia: f64) -> Flight {
    let mut config = PlantConfig::new(MOTOR, supply);
    config.load = LoadConfig { inertia: inertia * MOTOR.inertia, ..LoadConfig::default() };
    config.angle_deg = 77.0;
    let mut closed = Closed::sensorless(&config, &[]);
    closed.boot();
    config.speed = rpm / 60.0 * core::f64::consts::TAU;
    closed.plant = Plant::new(&config);
    for _ in 0..60 {
        closed.tick();
    }
    closed.ask(RunRequest::Drive);
    let (mut slowest, mut peak, mut bus_max) = (f64::INFINITY, 0.0_f64, 0.0_f64);
    let mut up = f64::INFINITY;
    for tick in 0..30_000 {
        closed.tick();
        if closed.rpm() > RPM / 2.0 {
            up = up.min(1e-4 * f64::from(tick));
        }
        let seen = closed.plant.observe();
        slowest = slowest.min(closed.rpm());
        (peak, bus_max) = (peak.max(seen.peak_current), bus_max.max(seen.bus_voltage));
    }
    Flight { closed, slowest, peak, bus_max, up }
}

/// A rotor that turns forward is caught at its speed and led to the set-point, neither to rest nor to the
/// open-loop speed first. A faster one falls to the set-point by itself, because the bus must not be fed.
#[test]
fn a_rotor_that_turns_forward_is_caught() {
    for supply in [18.0, 24.0, 48.0, 60.0] {
        for (rpm, inertia) in [(2800.0, 0.0), (1500.0, 0.0), (500.0, 20.0), (1000.0, 20.0), (2500.0, 5.0)] {
            let flight = fly(supply, rpm, inertia);
            let name = format!("{supply} V, {rpm} rpm, {inertia} rotors");
            assert_eq!(flight.closed.drive.state(), State::SensorlessClosedLoop, "{name}");
            // It coasts during rotor lock (T23): 0.15 s of friction.
            let friction = MOTOR.static_friction / (MOTOR.inertia * (1.0 + inertia));
            let coasted = rpm - 0.2 * friction * 60.0 / core::f64::consts::TAU;
            assert!(flight.slowest > 0.9 * coasted.min(RPM), "{name}: {:.0} rpm", flight.slowest);
            let error = (flight.closed.rpm() / RPM - 1.0).abs();
            assert!(error < 0.02, "{name}: {:.0} rpm", flight.closed.rpm());
            assert!(flight.peak <= 12.6 && flight.bus_max < 61.0, "{name}: {:.1} A", flight.peak);
        }
    }
}

/// A rotor that turns backward is braked by a short circuit if the windings can carry that, else left to
/// coast; then it is started. The bus stays below its threshold, the phase current within 12 A and 5 %.
#[test]
fn a_rotor_that_turns_backward_is_braked_first() {
    for supply in [18.0, 24.0, 60.0] {
        for (rpm, inertia) in [(-200.0, 0.0), (-900.0, 0.0), (-2800.0, 0.0), (-300.0, 20.0), (-900.0, 20.0)] {
            let flight = fly(supply, rpm, inertia);
            let name = format!("{supply} V, {rpm} rpm, {inertia} rotors");
            assert_eq!(flight.closed.drive.state(), State::SensorlessClosedLoop, "{name}");
            assert!(flight.closed.rpm() > 0.9 * RPM, "{name}: {:.0} rpm", flight.closed.rpm());
            assert!(flight.bus_max < 61.0, "{name}: {:.1} V", flight.bus_max);
            assert!(flight.peak <= 12.6, "{name}: {:.1} A", flight.peak);
        }
    }
}

/// The kick of a rotor that was braked begins late. It has its time all the same, and brings the rotor up.
#[test]
fn a_rotor_that_was_braked_is_started_by_its_first_kick() {
    for supply in [18.0, 24.0, 36.0, 48.0] {
        for inertia in [0.0, 1.0, 2.0] {
            for rpm in [-200.0, -500.0, -900.0] {
                let up = fly(supply, rpm, inertia).up;
                assert!(up < 0.45, "{supply} V, {rpm} rpm, {inertia} rotors: {up:.3} s");
            }
        }
    }
}

/// A rotor that turns fast backward with high inertia is left to coast, because its windings would carry more
/// than 12 A as a brake, and the bus must not be fed. The drive gives up in Standby (T71), with the bridge
/// off throughout.
#[test]
fn a_rotor_that_cannot_be_braked_is_left_alone() {
    let flight = fly(24.0, -2500.0, 40.0);
    assert_eq!(flight.closed.drive.state(), State::Standby);
    assert!(flight.peak < 0.1 && flight.bus_max < 24.1, "{:.2} A", flight.peak);
}

/// If the other direction is requested while the rotor is still being brought up, the bridge is switched off
/// at once, and the start begins anew in that direction.
#[test]
fn a_start_that_is_reversed_begins_anew() {
    for (state, ticks) in [
        (State::RotorLock, 0),
        (State::RotorLock, 900),
        (State::OpenLoop, 0),
        (State::OpenLoop, 10),
        (State::OpenLoop, 30),
        (State::OpenLoop, 80),
    ] {
        let mut closed = Closed::sensorless(&PlantConfig::new(MOTOR, 24.0), &[]);
        closed.watch();
        closed.boot();
        closed.ask(RunRequest::Drive);
        while closed.drive.state() != state {
            closed.tick();
        }
        (0..ticks).for_each(|_| closed.tick());
        closed.ask(RunRequest::Reverse);
        closed.tick();
        assert_eq!(closed.output.step, Step::Coast, "{ticks} ticks of {state:?}");
        (0..40_000).for_each(|_| closed.tick());
        assert_eq!(closed.drive.state(), State::SensorlessClosedLoop);
        assert!((closed.rpm() / -RPM - 1.0).abs() < 0.02, "{} rpm", closed.rpm());
    }
}

/// If the other direction is requested while a blocked rotor is still being pulled after the end of open
/// loop, the bridge is switched off before the time-out has passed.
#[test]
fn a_rotor_that_cannot_be_brought_up_is_let_go_of() {
    let mut closed = Closed::sensorless(&PlantConfig::new(MOTOR, 24.0), &[]);
    closed.plant.inject(Injection::BlockedRotor);
    closed.watch();
    closed.boot();
    closed.ask(RunRequest::Drive);
    while closed.drive.state() != State::SensorlessClosedLoop {
        closed.tick();
    }
    while closed.output.step == Step::Coast {
        closed.tick();
    }
    closed.ask(RunRequest::Reverse);
    let mut ticks = 0;
    while closed.drive.state() == State::SensorlessClosedLoop {
        closed.tick();
        assert_eq!(closed.output.step, Step::Coast, "{ticks}");
        ticks += 1;
    }
    assert!(
        ticks > 10 && closed.drive.state() == State::Standby,
        "{ticks} ticks, {:?}",
        closed.drive.state()
    );
}
