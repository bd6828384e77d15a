//! Tests of the effect of each parameter and each transition, from outside a drive with a motor: two values,
//! and the change that they make.

use crate::bench::{Closed, MOTOR, Outcome, RPM};
use narx_core::dictionary::number;
use narx_core::motor::machine::event::Health;
use narx_core::motor::{Cause, Event, RunRequest, State};
use narx_sim::plant::{Injection, LoadConfig, PlantConfig, SupplyConfig};
use std::f64::consts::TAU;

type Changes<'a> = &'a [(u16, i32)];
type Build = fn(&PlantConfig, Changes<'_>) -> Closed;

fn config() -> PlantConfig {
    PlantConfig::new(MOTOR, 24.0)
}

/// A drive after boot that is requested to drive.
fn started(build: Build, changes: Changes<'_>) -> Closed {
    let mut closed = build(&config(), changes);
    closed.boot();
    closed.ask(RunRequest::Drive);
    closed
}

/// A drive that has run for two seconds.
fn running(build: Build, changes: Changes<'_>) -> Closed {
    let mut closed = started(build, changes);
    assert_eq!(closed.run(20_000), Outcome::Running, "{changes:?}");
    closed
}

fn load(closed: &mut Closed, torque: f64) {
    closed.plant.set_load(LoadConfig { constant: torque, ..closed.plant.load() });
}

/// A drive that accelerates a flywheel as fast as its limits allow.
fn accelerating(changes: Changes<'_>) -> Closed {
    let mut closed = started(Closed::new, &[&[(number::SPEED_RATE, 1_000_000)], changes].concat());
    closed.plant.set_load(LoadConfig { inertia: 2e-4, ..closed.plant.load() });
    closed
}

/// Number of ticks until the drive is in `state`; panics if it takes another way, or longer than a few
/// seconds.
fn reaches(closed: &mut Closed, state: State) -> u32 {
    let before = closed.drive.state();
    for tick in 0..60_000 {
        if closed.drive.state() == state {
            return tick;
        }
        assert_eq!(closed.drive.state(), before, "on the way to {state:?}");
        closed.tick();
    }
    panic!("{before:?} stays, {state:?} was expected")
}

/// Number of ticks until each of these states, one after the other.
fn ways(closed: &mut Closed, states: &[State]) -> Vec<u32> {
    states.iter().map(|state| reaches(closed, *state)).collect()
}

/// Acknowledges a fault whose cause has gone: requests Standby, and waits for it.
fn acknowledge(closed: &mut Closed) {
    closed.silent = false;
    closed.ask(RunRequest::Standby);
    reaches(closed, State::Standby);
}

fn milliseconds(ticks: u32) -> f64 {
    f64::from(ticks) / 10.0
}

fn near(found: f64, expected: f64, what: &str) {
    assert!((found - expected).abs() <= 0.03 * expected + 0.3, "{what}: {found}, expected {expected}");
}

/// A drive in which only open loop is enabled.
fn open_loop(config: &PlantConfig, changes: Changes<'_>) -> Closed {
    let only = [(number::HALL_ENABLE, 0), (number::SENSORLESS_ENABLE, 0), (number::OPEN_LOOP_ENABLE, 1)];
    Closed::new(config, &[&only, changes].concat())
}

#[test]
fn a_drive_takes_the_transitions_of_hall_and_open_loop() {
    use State::{Fault, HallClosedLoop, Initialization, OpenLoop, Standby};
    let mut closed = Closed::new(&config(), &[]);
    assert_eq!(closed.drive.state(), Initialization);
    reaches(&mut closed, Standby);
    closed.plant.inject(Injection::Break);
    reaches(&mut closed, Fault);
    closed.plant.clear_all();
    acknowledge(&mut closed);
    closed.ask(RunRequest::Drive);
    reaches(&mut closed, HallClosedLoop);
    closed.ask(RunRequest::Standby);
    reaches(&mut closed, Standby);
    closed.ask(RunRequest::Drive);
    reaches(&mut closed, HallClosedLoop);
    closed.silent = true;
    reaches(&mut closed, Fault);
    let mut closed = Closed::new(&config(), &[]);
    closed.drive.handle_event(Event::Health(Health { self_test_failed: true, ..Health::default() }));
    reaches(&mut closed, Fault);
    let mut closed = started(open_loop, &[]);
    reaches(&mut closed, OpenLoop);
    closed.ask(RunRequest::Standby);
    reaches(&mut closed, Standby);
    closed.ask(RunRequest::Drive);
    reaches(&mut closed, OpenLoop);
    closed.silent = true;
    reaches(&mut closed, Fault);
}

#[test]
fn a_drive_takes_the_transitions_of_a_sensorless_start() {
    use State::{Fault, OpenLoop, RotorLock, SensorlessAutoRestart, SensorlessClosedLoop, Standby};
    let way = [RotorLock, OpenLoop, SensorlessClosedLoop, SensorlessAutoRestart];
    for length in 1..=way.len() {
        for silent in [false, true] {
            // Shorter than rotor lock.
            let mut closed =
                started(Closed::sensorless, &[(number::CAN_TIMEOUT, 100), (number::LOCK_DURATION, 150)]);
            ways(&mut closed, &way[..length.min(3)]);
            if length == 4 {
                closed.run(5_000);
                closed.plant.inject(Injection::BlockedRotor);
                reaches(&mut closed, SensorlessAutoRestart);
            }
            closed.silent = silent;
            if !silent {
                closed.ask(RunRequest::Standby);
            }
            reaches(&mut closed, if silent { Fault } else { Standby });
        }
    }
    // The shaft is free again: the rotor is caught, and runs.
    let mut closed = running(Closed::sensorless, &[]);
    closed.plant.inject(Injection::BlockedRotor);
    reaches(&mut closed, SensorlessAutoRestart);
    closed.plant.clear_all();
    reaches(&mut closed, SensorlessClosedLoop);
}

#[test]
fn times_of_states_are_their_parameters() {
    for value in [150, 400] {
        let mut closed = started(Closed::sensorless, &[(number::LOCK_DURATION, value)]);
        reaches(&mut closed, State::RotorLock);
        near(milliseconds(reaches(&mut closed, State::OpenLoop)), value.into(), "rotor lock");
    }
    for value in [100, 700] {
        let mut closed = Closed::new(&config(), &[(number::FAULT_WAIT, value)]);
        closed.boot();
        closed.plant.inject(Injection::Break);
        reaches(&mut closed, State::Fault);
        closed.plant.clear_all();
        closed.ask(RunRequest::Standby);
        near(milliseconds(reaches(&mut closed, State::Standby)), value.into(), "wait in Fault");
    }
    for value in [100, 400] {
        let mut closed = running(Closed::new, &[(number::CAN_TIMEOUT, value)]);
        closed.ask(RunRequest::Drive);
        closed.silent = true;
        near(milliseconds(reaches(&mut closed, State::Fault)), value.into(), "time-out");
        assert_eq!(closed.status.extended_code, Cause::CommandTimeout as u16);
    }
}

#[test]
fn times_of_a_still_rotor_are_their_parameters() {
    // A shaft that is held shows no edge: the speed is 0 after parameter 113, the fault comes parameter 265
    // after that.
    for (timeout, stall) in [(50, 300), (200, 1000)] {
        let changes = [(number::HALL_PERIOD_TIMEOUT, timeout), (number::HALL_STALL_TIME, stall)];
        let mut closed = running(Closed::new, &changes);
        closed.plant.inject(Injection::BlockedRotor);
        let mut still = None;
        for tick in 0..30_000 {
            closed.tick();
            if still.is_none() && closed.status.speed_hall.to_bits() == 0 {
                still = Some(tick);
            }
            if closed.drive.state() == State::Fault {
                assert_eq!(closed.status.extended_code, Cause::HallStall as u16);
                let still = still.expect("speed 0 before the fault");
                let after = milliseconds(still);
                assert!((after - f64::from(timeout)).abs() < 6.0, "{timeout}: {after}");
                let after = milliseconds(tick - still);
                assert!((after - f64::from(stall)).abs() < 6.0, "{stall}: {after}");
                break;
            }
        }
        assert_eq!(closed.drive.state(), State::Fault);
    }
    // Without sensors missing crossings show the same.
    let lost = |ticks: i32| {
        let mut closed = running(Closed::sensorless, &[(number::ZC_PERIOD_MAX, ticks)]);
        // So slow that the time-out ends before the limit of blind steps.
        closed.set_point = 600.0;
        closed.ask(RunRequest::Drive);
        closed.run(10_000);
        closed.plant.inject(Injection::BlockedRotor);
        reaches(&mut closed, State::SensorlessAutoRestart)
    };
    let (quick, slow) = (lost(150), lost(2_000));
    assert!(slow > quick + 10, "{quick} and {slow} ticks");
}

#[test]
fn thresholds_of_faults_are_their_parameters() {
    type Trouble = fn(&mut Closed);
    let rows: [(u16, i32, Trouble, Cause); 4] = [
        (number::OVER_TEMPERATURE, 900, |closed| closed.plant.set_ambient(95.0), Cause::OverTemperature),
        (number::OVER_VOLTAGE, 30_000, |closed| supply(closed, 32.0), Cause::OverVoltage),
        (number::UNDER_VOLTAGE, 23_000, |closed| supply(closed, 21.0), Cause::UnderVoltage),
        (number::OVER_PRESSURE, 1_500, |closed| closed.plant.set_pressure(1.6), Cause::OverPressure),
    ];
    for (number, raw, trouble, cause) in rows {
        for (changes, code) in
            [(vec![(number::TEMPERATURE_WARNING, 800), (number, raw)], cause as u16), (vec![], 0)]
        {
            // At its factory setting over-pressure is not critical.
            let critical = (number::CRITICAL_FAULT_MASK, 0xFC00_00FE_u32.cast_signed());
            let mut closed = Closed::new(&config(), &[changes.clone(), vec![critical]].concat());
            closed.boot();
            trouble(&mut closed);
            closed.run(3_000);
            assert_eq!(closed.status.extended_code, code, "{cause:?} with {changes:?}");
        }
    }
    // The smallest current that a loaded motor takes is above a threshold of 0.3 A.
    for (raw, faulty) in [(300, true), (7_000, false)] {
        let mut closed = started(Closed::new, &[(number::OVER_CURRENT, raw)]);
        load(&mut closed, 0.05);
        let outcome = closed.run(10_000);
        assert_eq!(outcome != Outcome::Running, faulty, "{raw} mA: {outcome:?}");
    }
    for (raw, warns) in [(600, true), (1_800, false)] {
        let mut closed = Closed::new(&config(), &[(number::TEMPERATURE_WARNING, raw)]);
        closed.boot();
        closed.plant.set_ambient(70.0);
        closed.run(3_000);
        assert_eq!(!closed.status.faults.is_empty(), warns, "{raw}");
    }
}

fn supply(closed: &mut Closed, voltage: f64) {
    closed.plant.set_supply(SupplyConfig { voltage, ..closed.plant.config().supply });
}

/// Mean of |set-point - speed| over the 0.2 s after a load step, rpm.
fn dip(build: Build, changes: Changes<'_>) -> f64 {
    let mut closed = running(build, changes);
    load(&mut closed, 0.03);
    (0..2_000)
        .map(|_| {
            closed.tick();
            (RPM - closed.rpm()).abs()
        })
        .sum::<f64>()
        / 2_000.0
}

#[test]
fn gains_of_the_speed_loops_are_their_parameters() {
    for (build, proportional, integral) in [
        (Closed::new as Build, number::SPEED_KP_HES, number::SPEED_KI_HES),
        (Closed::sensorless as Build, number::SPEED_KP_SL, number::SPEED_KI_SL),
    ] {
        // In V/rpm, or V s/rad.
        let high = if proportional == number::SPEED_KP_HES { 2_000_000 } else { 20_000 };
        // Almost without the integral gain, which would answer most of the step, and which alone would not
        // start a rotor.
        let start = (number::INITIAL_DUTY, 300);
        let [weak, strong] =
            [0, high].map(|gain| dip(build, &[start, (proportional, gain), (integral, 1_000)]));
        assert!(weak > 1.2 * strong, "{proportional}: {weak} and {strong} rpm");
        let (weak, strong) = (dip(build, &[(integral, 1_000)]), dip(build, &[]));
        assert!(weak > 1.2 * strong, "{integral}: {weak} and {strong} rpm");
    }
}

/// Mean and largest bus current of a start whose load demands all of it, A.
fn start_current(changes: Changes<'_>) -> (f64, f64) {
    let mut closed = accelerating(
        &[&[(number::HV_CURRENT_MAX, 1_000), (number::HV_CURRENT_SOFT_START, 1_000)], changes].concat(),
    );
    let (mut sum, mut most) = (0.0, 0.0_f64);
    for _ in 0..2_000 {
        closed.tick();
        let current = f64::from(closed.status.bus_current.to_bits()) / 65_536.0;
        sum += current;
        most = most.max(current);
    }
    (sum / 2_000.0, most)
}

#[test]
fn gains_of_the_current_limiter_are_their_parameters() {
    for (number, high) in [(number::HV_CURRENT_KP, 10_000_000), (number::HV_CURRENT_KI, 500_000)] {
        let (weak, strong) = (start_current(&[(number, 0)]), start_current(&[(number, high)]));
        let apart = (weak.0 - strong.0).abs() + (weak.1 - strong.1).abs();
        assert!(apart > 0.05, "{number}: {weak:?} and {strong:?} A");
    }
}

#[test]
fn limits_of_a_start_are_their_parameters() {
    let soft = [(number::HV_CURRENT_SOFT_START, 300), (number::HV_CURRENT_MAX, 6_000)];
    let ramped = |rate| {
        let mut closed = accelerating(&[&soft[..], &[(number::HV_CURRENT_RATE, rate)]].concat());
        closed.run(2_000);
        closed.rpm()
    };
    let (slow, fast) = (ramped(200), ramped(1_000_000));
    assert!(fast > 1.2 * slow, "current rate: {slow} and {fast} rpm");
    let slewed = |rate| {
        let mut closed = accelerating(&[(number::DUTY_SLEW, rate)]);
        closed.run(200);
        f64::from(closed.status.duty.to_bits())
    };
    let (slow, fast) = (slewed(10), slewed(10_000));
    assert!(fast > 1.2 * slow, "slew: {slow} and {fast}");
    let peak = |raw| {
        let mut closed = accelerating(&[(number::PHASE_CURRENT_MAX, raw)]);
        closed.run(2_000);
        closed.peak
    };
    let (low, high) = (peak(2_000), peak(12_000));
    assert!(high > 1.3 * low, "phase current: {low} and {high} A");
    for (build, number) in
        [(Closed::new as Build, number::DUTY_MAX), (Closed::sensorless, number::DUTY_MAX_SL)]
    {
        let closed = running(build, &[]);
        let free = f64::from(closed.status.duty.to_bits()) / 32_768.0;
        let mut closed = closed;
        let bound = (free * 0.8 * 10_000.0).round();
        closed.configure(&[(number, bound as i32)]);
        closed.run(5_000);
        let duty = f64::from(closed.status.duty.to_bits()) / 32_768.0;
        assert!(duty <= bound / 10_000.0 + 0.01, "{number}: {free}, then {duty}");
    }
}

#[test]
fn level_and_speed_of_open_loop_are_their_parameters() {
    let level = |raw| {
        let mut closed = started(open_loop, &[(number::OPEN_LOOP_DUTY, raw)]);
        closed.run(10_000);
        f64::from(closed.status.duty.to_bits())
    };
    let (low, high) = (level(300), level(600));
    assert!(high > 1.5 * low, "{low} and {high}");
    let turned = |raw| {
        let mut closed = started(open_loop, &[(number::OPEN_LOOP_SPEED, raw)]);
        closed.run(20_000);
        closed.mean_rpm(5_000, |_| {})
    };
    let (slow, fast) = (turned(200), turned(400));
    assert!((slow - 200.0).abs() < 20.0 && (fast - 400.0).abs() < 20.0, "{slow} and {fast}");
}

/// Mean electrical angle of the rotor within a sector at the changes of the pattern, degrees, for even and
/// odd sectors separately.
fn commutations(changes: Changes<'_>) -> [f64; 2] {
    let mut closed = running(Closed::sensorless, changes);
    let mut found = [Vec::new(), Vec::new()];
    let mut before = closed.output.step;
    for _ in 0..3_000 {
        let turns = closed.plant.observe().electrical_turns;
        closed.tick();
        if closed.output.step != before {
            before = closed.output.step;
            let sectors = turns * 6.0;
            let parity = (sectors.floor().rem_euclid(2.0)) as usize;
            found[parity].push((sectors - sectors.floor()) * 60.0);
        }
    }
    // Circular mean over 60 degrees.
    found.map(|angles| {
        assert!(angles.len() > 20, "{angles:?}");
        let sum = |of: fn(f64) -> f64| angles.iter().map(|angle| of(angle / 60.0 * TAU)).sum::<f64>();
        sum(f64::sin).atan2(sum(f64::cos)) / TAU * 60.0
    })
}

fn apart(a: f64, b: f64) -> f64 {
    ((a - b + 30.0).rem_euclid(60.0) - 30.0).abs()
}

/// Delays of the zero crossings move the commutation: at 2000 rpm a sector has 12.5 ticks, and 2 of them are
/// 9.6 degrees.
#[test]
fn delays_of_zero_crossings_move_the_commutation() {
    let plain = commutations(&[]);
    let both = commutations(&[(number::ZC_DELAY, 200)]);
    let falling = commutations(&[(number::ZC_DELAY_FALLING, 300)]);
    assert!((0..2).all(|parity| apart(plain[parity], both[parity]) > 3.0), "{plain:?} and {both:?}");
    assert!((0..2).any(|parity| apart(plain[parity], falling[parity]) > 3.0), "{plain:?} and {falling:?}");
}

/// Wrong constants of a motor contradict its measured voltage, and give the fault of a wrong lock.
#[test]
fn constants_of_the_motor_find_a_wrong_lock() {
    let commissioned = running(Closed::sensorless, &[]);
    let wrong = |changes: Changes<'_>, torque: f64| {
        let mut closed = commissioned.clone();
        load(&mut closed, torque);
        closed.run(3_000);
        closed.configure(changes);
        let _ = closed.run(60_000);
        closed.status.extended_code
    };
    let code = Cause::WrongLock as u16;
    assert_eq!(wrong(&[], 0.03), 0, "they fit");
    // Half of the back-EMF; twenty times the resistance.
    assert_eq!(wrong(&[(number::BACK_EMF_CONSTANT, 1_800)], 0.0), code, "back-EMF");
    // Under load it does not always start again, which gives the other cause.
    let codes = [code, Cause::SensorlessStall as u16];
    assert!(codes.contains(&wrong(&[(number::WINDING_RESISTANCE, 7_000)], 0.03)), "resistance");
    // A wrong inductance explains the voltage that half of the back-EMF leaves.
    let low = (number::BACK_EMF_CONSTANT, 1_800);
    assert!(codes.contains(&wrong(&[low], 0.03)), "back-EMF under load");
    assert_eq!(wrong(&[low, (number::WINDING_INDUCTANCE, 100_000)], 0.03), 0, "inductance");
}

/// Above its speed the angle is interpolated, so that it has many values in half a second; below, it has
/// those of the edges alone.
#[test]
fn the_angle_is_interpolated_above_its_speed() {
    let angles = |raw| {
        let mut closed = running(Closed::new, &[(number::HALL_INTERPOLATION_SPEED, raw)]);
        let mut seen = std::collections::BTreeSet::new();
        for _ in 0..5_000 {
            closed.tick();
            seen.insert(closed.status.angle.0);
        }
        seen.len()
    };
    let (interpolated, edges) = (angles(100), angles(60_000));
    assert!(interpolated > 50 && edges <= 12, "{interpolated} and {edges} angles");
}

/// A shaft that is held again and again gives a fault after the motor was caught a few times.
#[test]
fn a_motor_that_is_held_again_and_again_is_a_stall() {
    let mut closed = running(Closed::sensorless, &[]);
    for _ in 0..10 {
        closed.plant.inject(Injection::BlockedRotor);
        let held = closed.run(1_000);
        closed.plant.clear_all();
        if held != Outcome::Running || closed.run(15_000) != Outcome::Running {
            break;
        }
        closed.ask(RunRequest::Drive);
    }
    assert_eq!(closed.status.extended_code, Cause::SensorlessStall as u16, "{:?}", closed.drive.state());
}
