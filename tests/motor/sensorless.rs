//! Tests of the sensorless drive on the plant: start, hand-over, load, flying start, rails.

use crate::bench::{Closed, MOTOR, Outcome, RPM};
use narx_core::dictionary::number;
use narx_core::motor::{Cause, RunRequest, State};
use narx_sim::plant::{ComparatorConfig, Injection, LoadConfig, PlantConfig};

/// Largest peak of any phase current: 12 A (Table 1) and 10 %.
const PEAK: f64 = 12.0 * 1.1;

fn config(supply: f64) -> PlantConfig {
    let mut config = PlantConfig::new(MOTOR, supply);
    config.angle_deg = 77.0;
    config
}

/// Runs until the state is reached; returns the number of ticks.
fn until(closed: &mut Closed, state: State, most: u64) -> Option<u64> {
    (1..=most).find(|_| {
        closed.tick();
        closed.drive.state() == state
    })
}

fn running(config: &PlantConfig, changes: &[(u16, i32)], request: RunRequest) -> Closed {
    let mut closed = Closed::sensorless(config, changes);
    closed.boot();
    closed.ask(request);
    assert!(until(&mut closed, State::SensorlessClosedLoop, 8_000).is_some(), "{:?}", closed.status);
    assert_eq!(closed.run(10_000), Outcome::Running);
    assert_eq!(closed.drive.state(), State::SensorlessClosedLoop, "{:?}", closed.status);
    closed
}

/// From any rest position, in both directions and at 18 to 60 V, the motor is in closed loop within 0.8 s and
/// at speed a second later, without over-current.
#[test]
fn starts_from_any_position_at_any_supply() {
    let mut peak = 0.0_f64;
    for (number, angle) in (0..360).step_by(20).enumerate() {
        let mut config = config([18.0, 24.0, 36.0, 48.0, 60.0][number % 5]);
        config.angle_deg = f64::from(angle);
        let (request, sign) =
            if number % 2 == 0 { (RunRequest::Drive, 1.0) } else { (RunRequest::Reverse, -1.0) };
        let closed = running(&config, &[], request);
        assert!((closed.rpm() - sign * RPM).abs() < 0.01 * RPM, "{angle} degrees: {} rpm", closed.rpm());
        let estimated = f64::from(closed.status.speed_sensorless.to_bits()) / 65_536.0 * 15.0;
        assert!((estimated - closed.rpm()).abs() < 0.01 * RPM, "{estimated} rpm");
        peak = peak.max(closed.peak);
    }
    println!("18 starts, peak {peak:.1} A");
    assert!(peak <= PEAK, "{peak:.1} A");
}

/// At the change from kick to speed loop, and from state 3 to 4, neither voltage nor speed jumps.
#[test]
fn hand_over_is_bumpless() {
    let mut closed = Closed::sensorless(&config(24.0), &[]);
    closed.boot();
    closed.ask(RunRequest::Drive);
    assert!(until(&mut closed, State::SensorlessClosedLoop, 8_000).is_some());
    let duty = f64::from(closed.status.duty.to_bits()) / 32_768.0;
    let speed = closed.rpm();
    for _ in 0..50 {
        closed.tick();
    }
    let after = f64::from(closed.status.duty.to_bits()) / 32_768.0;
    assert!((after - duty).abs() < 0.03, "duty {duty} to {after}");
    assert!((closed.rpm() - speed).abs() < 100.0, "{speed} to {} rpm", closed.rpm());
}

/// A step from no torque to the motor's rated torque, and back, causes no desynchronisation, and the speed is
/// back within 1 % in half a second.
#[test]
fn a_load_step_does_not_desynchronise() {
    let mut closed = running(&config(24.0), &[], RunRequest::Drive);
    for torque in [0.1, 0.0, 0.1] {
        closed.plant.set_load(LoadConfig { constant: torque, ..LoadConfig::default() });
        assert_eq!(closed.run(5_000), Outcome::Running);
        assert_eq!(closed.drive.state(), State::SensorlessClosedLoop, "{torque} N m: {:?}", closed.status);
        assert!((closed.rpm() - RPM).abs() < 0.01 * RPM, "{torque} N m: {} rpm", closed.rpm());
    }
    assert!(closed.peak <= PEAK, "{:.1} A", closed.peak);
}

/// A reversal comes to rest first, and starts in the other direction.
#[test]
fn reversal_comes_to_rest_first() {
    let mut closed = running(&config(24.0), &[], RunRequest::Drive);
    closed.ask(RunRequest::Reverse);
    assert_eq!(closed.run(40_000), Outcome::Running, "{:?}", closed.status);
    assert!((closed.rpm() + RPM).abs() < 0.02 * RPM, "{} rpm", closed.rpm());
    assert!(closed.peak <= PEAK && closed.bus_max < 61.0);
}

/// A held shaft leads to auto-restart (T47) for its two seconds, then to Standby (T71) or a named fault; a
/// shaft that is released in time runs again (T74).
#[test]
fn a_stall_belongs_to_auto_restart() {
    for held in [30_000, 3_000] {
        let mut closed = running(&config(24.0), &[], RunRequest::Drive);
        closed.plant.inject(Injection::BlockedRotor);
        assert!(until(&mut closed, State::SensorlessAutoRestart, 3_000).is_some(), "{:?}", closed.status);
        let outcome = closed.run(held);
        closed.plant.clear(Injection::BlockedRotor);
        if held > 20_000 {
            match outcome {
                Outcome::Fault { code, .. } => assert_eq!(code, Cause::SensorlessStall as u16),
                Outcome::Running => assert_eq!(closed.drive.state(), State::Standby),
            }
        } else {
            assert_eq!(closed.run(25_000), Outcome::Running, "{:?}", closed.status);
            assert_eq!(closed.drive.state(), State::SensorlessClosedLoop);
            assert!((closed.rpm() - RPM).abs() < 0.02 * RPM, "{} rpm", closed.rpm());
        }
    }
}

/// The count of ended episodes ends with the fault: a Standby request acknowledges it (T61), and the next
/// start begins like the first, with sensors and without.
#[test]
fn a_fault_without_sensors_is_acknowledged_and_the_next_start_is_a_first_one() {
    // The true number of pole pairs, without sensors; hall sensors instead; open loop only.
    let sensorless = [(number::MOTOR_POLE_PAIRS, 4)];
    let enables = |open_loop, closed, hall| {
        [
            (number::MOTOR_POLE_PAIRS, 4),
            (number::OPEN_LOOP_ENABLE, open_loop),
            (number::SENSORLESS_ENABLE, closed),
            (number::HALL_ENABLE, hall),
        ]
    };
    let mended: [(&[(u16, i32)], State); 3] = [
        (&sensorless, State::SensorlessClosedLoop),
        (&enables(0, 0, 1), State::HallClosedLoop),
        (&enables(1, 0, 0), State::OpenLoop),
    ];
    for (changes, running) in mended {
        let mut closed = Closed::sensorless(&config(24.0), &[(number::MOTOR_POLE_PAIRS, 8)]);
        closed.boot();
        closed.ask(RunRequest::Drive);
        assert!(matches!(closed.run(60_000), Outcome::Fault { .. }), "{:?}", closed.status);
        closed.ask(RunRequest::Standby);
        assert!(until(&mut closed, State::Standby, 6_000).is_some(), "{running:?}: {:?}", closed.status);
        closed.configure(changes);
        closed.run(2_000);
        closed.ask(RunRequest::Drive);
        assert_eq!(closed.run(20_000), Outcome::Running, "{running:?}: {:?}", closed.status);
        assert_eq!(closed.drive.state(), running, "{:?}", closed.status);
    }
}

/// With half or twice the true number of pole pairs speed and voltage do not fit together, and a fault names
/// this.
#[test]
fn a_wrong_number_of_pole_pairs_is_named() {
    for pole_pairs in [2, 8] {
        let mut closed = Closed::sensorless(&config(24.0), &[(number::MOTOR_POLE_PAIRS, pole_pairs)]);
        closed.boot();
        closed.ask(RunRequest::Drive);
        match closed.run(60_000) {
            Outcome::Fault { code, .. } => assert!(
                [Cause::WrongLock, Cause::SensorlessStall].map(|cause| cause as u16).contains(&code),
                "{pole_pairs}: {code:04x}"
            ),
            Outcome::Running => {
                panic!("{pole_pairs} pole pairs: {:?} at {} rpm", closed.drive.state(), closed.rpm())
            }
        }
    }
}

/// With captured comparator edges the same drive runs beyond the speed that samples can follow, at two ticks
/// per sector.
#[test]
fn comparator_edges_run_the_motor() {
    let mut config = config(24.0);
    config.comparator = Some(ComparatorConfig { delay: 2e-6, hysteresis: 0.1 });
    config.board.comparator_capture = true;
    let closed = running(&config, &[(number::ZC_DELAY, 2)], RunRequest::Drive);
    assert!((closed.rpm() - RPM).abs() < 0.01 * RPM, "{} rpm", closed.rpm());
    assert!(closed.peak <= PEAK, "{:.1} A", closed.peak);
}
