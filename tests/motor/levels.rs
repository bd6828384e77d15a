//! Tests of levels and bounds of the duty: parameters 84, 87 and 89 with and without a nominal supply (266),
//! 98 and 107 each in its modes.

use crate::bench::{Closed, MOTOR};
use narx_core::dictionary::{Parameters, number};
use narx_core::motor::machine::event::Limiter;
use narx_core::motor::{Board, BuildError, Coefficients, RunRequest, State};
use narx_sim::plant::PlantConfig;

/// Duty at the end of `state`, per cent, less the compensation of the dead time (0.5 % at 10 kHz).
fn duty_at_the_end_of(state: State, closed: &mut Closed) -> f64 {
    closed.boot();
    closed.ask(RunRequest::Drive);
    let mut last = 0.0;
    let mut ticks = 0;
    while closed.drive.state() != State::SensorlessClosedLoop && ticks < 20_000 {
        closed.tick();
        ticks += 1;
        if closed.drive.state() == state && closed.output.duty.to_bits() > 0 {
            last = f64::from(closed.output.duty.to_bits()) / 327.68 - 0.5;
        }
    }
    last
}

/// Without a nominal supply parameter 89 is a duty, as in Table 11; with one it is a share of that voltage,
/// at three supplies.
#[test]
fn levels_are_duties_unless_there_is_a_nominal_supply() {
    for supply in [20.0, 24.0, 30.0] {
        let lock = |nominal| {
            let changes = [(number::NOMINAL_SUPPLY, nominal), (number::LOCK_DUTY, 500)];
            let mut closed = Closed::sensorless(&PlantConfig::new(MOTOR, supply), &changes);
            duty_at_the_end_of(State::RotorLock, &mut closed)
        };
        let (printed, scaled) = (lock(0), lock(24_000));
        assert!((printed - 5.0).abs() < 0.1, "{supply} V: {printed} %");
        assert!((scaled - 5.0 * 24.0 / supply).abs() < 0.1, "{supply} V: {scaled} %");
    }
}

/// Open loop and the first duty of hall closed loop follow the same rule.
#[test]
fn open_loop_and_the_first_duty_are_levels_too() {
    let changes = [
        (number::NOMINAL_SUPPLY, 0),
        (number::SENSORLESS_ENABLE, 0),
        (number::OPEN_LOOP_ENABLE, 1),
        (number::OPEN_LOOP_DUTY, 600),
    ];
    for supply in [20.0, 30.0] {
        let mut closed = Closed::sensorless(&PlantConfig::new(MOTOR, supply), &changes);
        let duty = duty_at_the_end_of(State::OpenLoop, &mut closed);
        assert!((duty - 6.0).abs() < 0.1, "{supply} V: {duty} %");
        let changes = [(number::NOMINAL_SUPPLY, 0), (number::INITIAL_DUTY, 800)];
        let mut hall = Closed::new(&PlantConfig::new(MOTOR, supply), &changes);
        hall.boot();
        hall.ask(RunRequest::Drive);
        hall.run(10);
        let first = f64::from(hall.output.duty.to_bits()) / 327.68 - 0.5;
        assert!((first - 8.0).abs() < 0.4, "{supply} V: {first} %");
    }
}

/// Parameter 107 bounds hall closed loop and nothing else: with 3 % a motor without sensors starts and runs.
#[test]
fn the_bound_with_halls_is_no_bound_without() {
    let mut closed = Closed::sensorless(&PlantConfig::new(MOTOR, 24.0), &[(number::DUTY_MAX, 300)]);
    closed.boot();
    closed.ask(RunRequest::Drive);
    closed.run(30_000);
    assert_eq!(closed.drive.state(), State::SensorlessClosedLoop);
    assert!((closed.rpm() / crate::bench::RPM - 1.0).abs() < 0.01, "{} rpm", closed.rpm());

    let mut hall =
        Closed::new(&PlantConfig::new(MOTOR, 24.0), &[(number::DUTY_MAX, 1500), (number::DUTY_MAX_SL, 300)]);
    hall.boot();
    hall.ask(RunRequest::Drive);
    hall.run(30_000);
    let duty = f64::from(hall.output.duty.to_bits()) / 327.68;
    assert!((duty - 15.0).abs() < 0.1 && hall.status.limiter == Limiter::Duty, "{duty} %");
}

/// Parameter 98 bounds every other state, also rotor lock and open loop, where a level beyond it does not
/// build.
#[test]
fn the_bound_without_halls_holds_in_lock_and_open_loop() {
    for (level, parameter) in [(number::LOCK_DUTY, "89"), (number::OPEN_LOOP_DUTY, "87")] {
        for mode in [number::SENSORLESS_ENABLE, number::OPEN_LOOP_ENABLE] {
            let mut parameters = Parameters::new();
            parameters.set(mode, 1).unwrap();
            parameters.set(number::DUTY_MAX, 100).unwrap();
            parameters.set(number::DUTY_MAX_SL, 600).unwrap();
            parameters.set(level, 601).unwrap();
            let refused = BuildError { parameter: level, raw: 601, min: 0, max: 600 };
            assert_eq!(Coefficients::build(&parameters, &Board::BENCH), Err(refused), "{parameter}");
            parameters.set(level, 600).unwrap();
            assert!(Coefficients::build(&parameters, &Board::BENCH).is_ok(), "{parameter}");
        }
    }
}

/// A rule between parameters binds only if a mode that needs it is enabled.
#[test]
fn rules_bind_where_their_mode_is_enabled() {
    let (open_loop, sensorless, hall) =
        (number::OPEN_LOOP_ENABLE, number::SENSORLESS_ENABLE, number::HALL_ENABLE);
    let rules: [(u16, i32, &[u16]); 11] = [
        (number::SPEED_MAX_HES, 0, &[hall]),
        (number::SPEED_MIN_HES, 4001, &[hall]),
        (number::SPEED_MIN_HES, 0, &[hall]),
        (number::SPEED_MAX_SL, 0, &[sensorless]),
        (number::SPEED_MIN_SL, 4001, &[sensorless]),
        (number::OPEN_LOOP_SPEED, 50_000, &[sensorless, open_loop]),
        (number::OPEN_LOOP_SPEED, 0, &[sensorless]),
        (number::OPEN_LOOP_RAMP, 10_000, &[sensorless]),
        (number::OPEN_LOOP_DUTY, 9_600, &[sensorless, open_loop]),
        (number::LOCK_DUTY, 9_600, &[sensorless, open_loop]),
        (number::UNDER_VOLTAGE, 60_000, &[sensorless, open_loop, hall, 0]),
    ];
    for (parameter, raw, modes) in rules {
        for mode in [open_loop, sensorless, hall, 0] {
            let mut parameters = Parameters::new();
            if mode != 0 {
                parameters.set(mode, 1).unwrap();
            }
            parameters.set(parameter, raw).unwrap();
            let built = Coefficients::build(&parameters, &Board::BENCH);
            assert_eq!(
                built.is_err(),
                modes.contains(&mode),
                "{parameter} = {raw}, mode {mode}: {:?}",
                built.err()
            );
        }
    }
}

/// The tick uses every value that the dictionary accepts: no range ends beyond the tick's.
#[test]
fn ranges_and_rules_agree() {
    let with = |number, raw| {
        let mut parameters = Parameters::new();
        parameters.set(number::HALL_ENABLE, 1).unwrap();
        parameters.set(number::SENSORLESS_ENABLE, 1).unwrap();
        parameters.set(number, raw).unwrap();
        Coefficients::build(&parameters, &Board::BENCH).unwrap()
    };
    assert_eq!(with(number::HALL_PERIOD_TIMEOUT, 6_000).hall.timeout >> 16, 60_000);
    assert_eq!(with(number::ZC_PERIOD_MAX, 32_767).sensorless.timeout >> 16, 32_767);
    for (number, beyond) in [(number::HALL_PERIOD_TIMEOUT, 6_001), (number::ZC_PERIOD_MAX, 32_768)] {
        assert!(Parameters::new().set(number, beyond).is_err(), "{number}");
    }
}

/// Limits of the set-point that were never written are those of Table 2 at any number of pole pairs: 500 and
/// 4000 rpm with four.
#[test]
fn factory_speed_limits_follow_the_pole_pairs() {
    for (pole_pairs, least, most) in
        [(1, 2000, 16_000), (2, 1000, 8000), (4, 500, 4000), (8, 250, 2000), (50, 40, 320)]
    {
        let mut parameters = Parameters::new();
        parameters.set(number::MOTOR_POLE_PAIRS, pole_pairs).unwrap();
        for (number, expected) in [
            (number::SPEED_MAX_SL, most),
            (number::SPEED_MIN_SL, least),
            (number::SPEED_MAX_HES, most),
            (number::SPEED_MIN_HES, least),
        ] {
            assert_eq!(parameters.speed_limit(number), expected, "{pole_pairs}");
        }
        let built = Coefficients::build(&parameters, &Board::BENCH).unwrap();
        let rpm = |speed: i32| (f64::from(speed) / 65_536.0 * 60.0 / f64::from(pole_pairs)).round() as i32;
        for mode in [built.hall_mode, built.sensorless_mode] {
            assert_eq!((rpm(mode.speed_min), rpm(mode.speed_max)), (least, most), "{pole_pairs}");
        }
        parameters.set(number::SPEED_MAX_SL, 3999).unwrap();
        assert_eq!(parameters.speed_limit(number::SPEED_MAX_SL), 3999, "what is set holds as it is");
    }
}
