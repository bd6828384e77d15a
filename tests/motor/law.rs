//! Tests of the law of the deadlines: a deadline may be early, never late. A drive that runs its stations
//! only when a deadline is due therefore answers every tick as one that runs them in every tick.

use crate::bench::{Closed, MOTOR, Outcome};
use crate::rotor::ScriptedRotor;
use crate::scripted::{Scripted, current_code};
use crate::support::coefficients;
use narx_core::dictionary::number;
use narx_core::motor::{Cause, FaultWord, RunRequest, State, Step};
use narx_sim::plant::{ComparatorConfig, Injection, LoadConfig, Phase, PlantConfig};

fn watched(supply: f64) -> Closed {
    let mut config = PlantConfig::new(MOTOR, supply);
    config.angle_deg = 40.0;
    let mut closed = Closed::new(&config, &[]);
    closed.watch();
    closed.boot();
    closed
}

/// Drives with several set-points and loads, the first one from standstill for `start` ticks.
fn drive_around(closed: &mut Closed, start: u64) {
    for (set_point, load, ticks) in
        [(800.0, 0.0, start), (2_500.0, 0.02, 8_000), (1_200.0, 0.0, 8_000), (1_200.0, 0.05, 5_000)]
    {
        closed.set_point = set_point;
        closed.plant.set_load(LoadConfig { constant: load, ..LoadConfig::default() });
        closed.ask(RunRequest::Drive);
        assert_eq!(closed.run(ticks), Outcome::Running, "{set_point} rpm");
    }
}

fn turn_back(closed: &mut Closed) {
    closed.ask(RunRequest::Reverse);
    assert_eq!(closed.run(25_000), Outcome::Running);
    assert!(closed.rpm() < -1_000.0, "{} rpm", closed.rpm());
}

#[test]
fn a_motor_with_sensors_keeps_the_law() {
    for supply in [18.0, 24.0, 60.0] {
        let mut closed = watched(supply);
        drive_around(&mut closed, 6_000);
        turn_back(&mut closed);
        closed.plant.inject(Injection::HallGlitches(200.0));
        closed.run(5_000);
        closed.plant.clear(Injection::HallGlitches(200.0));
        closed.plant.inject(Injection::BlockedRotor);
        assert!(matches!(closed.run(10_000), Outcome::Fault { .. }));
    }
}

#[test]
fn a_motor_without_sensors_keeps_the_law() {
    for supply in [18.0, 24.0, 60.0] {
        let mut config = PlantConfig::new(MOTOR, supply);
        config.angle_deg = 40.0;
        if supply == 60.0 {
            config.comparator = Some(ComparatorConfig { delay: 2e-6, hysteresis: 0.1 });
            config.board.comparator_capture = true;
        }
        let mut closed = Closed::sensorless(&config, &[]);
        if supply == 18.0 {
            closed.plant.inject(Injection::HallSupplyLost);
        }
        closed.watch();
        closed.boot();
        drive_around(&mut closed, 12_000);
        closed.plant.set_load(LoadConfig::default());
        turn_back(&mut closed);
        // With a blocked rotor it gives up; every try is compared.
        closed.plant.inject(Injection::BlockedRotor);
        closed.run(40_000);
        assert!(closed.rpm().abs() < 1.0 && closed.status.state != State::SensorlessClosedLoop);
    }
}

/// A motor at constant speed, with its sensors or without, with comparison on.
fn running(sensors: bool) -> Closed {
    let mut config = PlantConfig::new(MOTOR, 24.0);
    config.angle_deg = 40.0;
    let mut closed = if sensors { Closed::new(&config, &[]) } else { Closed::sensorless(&config, &[]) };
    closed.watch();
    closed.boot();
    closed.set_point = 2_000.0;
    closed.ask(RunRequest::Drive);
    assert_eq!(closed.run(14_000), Outcome::Running);
    assert!(closed.rpm() > 1_900.0, "{} rpm", closed.rpm());
    closed
}

/// New measurements and commands take effect in the same tick.
#[test]
fn news_is_seen_in_its_tick() {
    for sensors in [true, false] {
        let mut closed = running(sensors);
        closed.plant.inject(Injection::Ambient(187.0));
        assert_eq!(closed.run(2_500), Outcome::Running);
        assert!(closed.status.faults.contains(FaultWord::TEMPERATURE_WARNING), "{:?}", closed.status);
        closed.plant.inject(Injection::Ambient(25.0));
        assert_eq!(closed.run(2_500), Outcome::Running);
        assert!(closed.status.faults.is_empty(), "{:?}", closed.status);
        for set_point in [2_500.0, 1_000.0, 2_000.0] {
            closed.set_point = set_point;
            closed.ask(RunRequest::Drive);
            // Friction alone takes 0.38 s from 2500 to 1000 rpm: the drive does not brake into the bus.
            assert_eq!(closed.run(4_500), Outcome::Running);
            assert!((closed.rpm() - set_point).abs() < 0.1 * set_point, "{} rpm", closed.rpm());
        }
        closed.plant.inject(Injection::Ambient(193.0));
        let code = Cause::OverTemperature as u16;
        assert!(matches!(closed.run(2_500), Outcome::Fault { code: found, .. } if found == code));
    }
}

/// The fault logic judges an edge or a crossing that shows too large a speed in the same tick.
#[test]
fn too_fast_an_edge_is_judged_in_its_tick() {
    for sensors in [true, false] {
        let mut closed = running(sensors);
        closed.plant.set_load(LoadConfig { constant: -0.1, ..LoadConfig::default() });
        let code = Cause::Overspeed as u16;
        let outcome = closed.run(20_000);
        assert!(matches!(outcome, Outcome::Fault { code: found, .. } if found == code), "{outcome:?}");
    }
}

/// The end of the short way of the control loop is noticed in the same tick. On the short way the controller
/// only divides by the bus voltage; it ends with another bus voltage, pulses too short for sampling, a
/// current beyond the ratings, a bus that must not be fed, or a duty beyond its slew.
#[test]
fn ease_ends_in_time() {
    for sensors in [true, false] {
        let mut closed = running(sensors);
        for supply in [28.0, 21.0, 24.0] {
            closed.plant.inject(Injection::Supply(supply));
            assert_eq!(closed.run(1_500), Outcome::Running, "{supply} V");
        }
        // To pulses that are too short for sampling, and back.
        for set_point in [600.0, 3_000.0] {
            closed.set_point = set_point;
            closed.ask(RunRequest::Drive);
            assert_eq!(closed.run(4_000), Outcome::Running, "{set_point} rpm");
        }
        // Ratings that limit, and later do not.
        for milliamperes in [300, 3_000] {
            closed.configure(&[
                (number::HV_CURRENT_SOFT_START, milliamperes),
                (number::HV_CURRENT_MAX, milliamperes),
            ]);
            closed.plant.set_load(LoadConfig { constant: 0.04, ..LoadConfig::default() });
            closed.run(1_500);
            closed.plant.set_load(LoadConfig::default());
            closed.run(1_500);
        }
        // Nearly every change of the duty is larger than this slew.
        closed.configure(&[(number::DUTY_SLEW, 50)]);
        closed.run(3_000);
        closed.configure(&[]);
        closed.set_point = 800.0;
        closed.ask(RunRequest::Drive);
        closed.run(4_000);
        assert_eq!(closed.status.faults, FaultWord::empty(), "{:?}", closed.status);
    }
}

/// A phase that opens under way is detected by steps without current, or by missing crossings, and is
/// reported in the tick in which it is detected.
#[test]
fn an_open_phase_is_told_in_its_tick() {
    for (sensors, phase) in
        [true, false].into_iter().flat_map(|sensors| Phase::ALL.map(|phase| (sensors, phase)))
    {
        let mut closed = running(sensors);
        closed.plant.set_load(LoadConfig { inertia: 50.0 * MOTOR.inertia, ..LoadConfig::default() });
        assert_eq!(closed.run(20_000), Outcome::Running);
        closed.plant.inject(Injection::OpenPhase(phase));
        let outcome = closed.run(20_000);
        if sensors {
            let code = Cause::OpenPhase as u16;
            assert!(matches!(outcome, Outcome::Fault { code: found, .. } if found == code), "{outcome:?}");
        } else {
            // Without sensors its crossings are lost first. Until this is detected the drive may follow
            // noise, and feed the bus from the heavy rotor: then that is the fault.
            let fed =
                matches!(outcome, Outcome::Fault { code: found, .. } if found == Cause::OverVoltage as u16);
            let lost = closed.drive.state() == State::SensorlessAutoRestart;
            assert!(fed || lost, "{phase:?} {outcome:x?}");
        }
    }
}

/// An open phase that an edge shows is reported in its tick. With an open phase current flows in only two of
/// the six steps. The rotor speeds up, so the drive detects the end of a step by its edge, and the open phase
/// with it.
#[test]
fn an_open_phase_that_an_edge_shows_is_told_in_its_tick() {
    for gain in [1.0005, 1.001, 1.002] {
        let c = coefficients(&[(number::HALL_ENABLE, 1), (number::SPEED_RATE, 10_000_000)]);
        let mut script = Scripted::new(c, ScriptedRotor::new(0.2, 60.0, true), 0);
        // A set-point that it never reaches.
        script.speed = 300;
        script.watch();
        script.boot();
        script.ask(RunRequest::Drive);
        let mut applied = Step::Coast;
        let mut turn = |script: &mut Scripted, has_open_phase: bool| {
            let carries = !has_open_phase || matches!(applied, Step::BC | Step::CB);
            let current = current_code(if carries { 0.1 } else { 0.0 });
            applied = script.tick(|samples| samples.bus_current = current).step;
        };
        (0..5_000).for_each(|_| turn(&mut script, false));
        for _ in 0..1_000 {
            assert_eq!(script.drive.state(), State::HallClosedLoop, "{:?}", script.status);
            script.rotor.speed *= gain;
            turn(&mut script, true);
            if script.drive.state() == State::Fault {
                break;
            }
        }
        assert_eq!(script.status.extended_code, Cause::OpenPhase as u16, "{gain}");
    }
}

/// A set-point that falls without a ramp takes away the speed loop's whole voltage in one turn; the drive
/// follows it.
#[test]
fn a_set_point_that_leaps_is_followed() {
    for sensors in [true, false] {
        let mut closed = running(sensors);
        closed.configure(&[(number::SPEED_RATE, 10_000_000)]);
        for set_point in [3_000.0, 700.0, 2_000.0, 900.0] {
            closed.set_point = set_point;
            closed.ask(RunRequest::Drive);
            assert_eq!(closed.run(6_000), Outcome::Running, "{set_point}");
            assert!((closed.rpm() - set_point).abs() < 0.1 * set_point, "{} rpm", closed.rpm());
        }
    }
}

/// At standstill, 100 ms of a third of the bus voltage without current is an open phase; with current it is
/// none.
#[test]
fn a_voltage_without_current_at_rest_is_an_open_phase() {
    let build = |duty| {
        let changes =
            [(number::OPEN_LOOP_ENABLE, 1), (number::LOCK_DUTY, duty), (number::OPEN_LOOP_DUTY, duty)];
        coefficients(&changes)
    };
    // 33 % of the bus, and 15 %, which need not drive a current.
    for (duty, amperes, is_open) in [(3_300, 0.0, true), (3_300, 0.1, false), (1_500, 0.0, false)] {
        let mut script = Scripted::new(build(duty), ScriptedRotor::new(0.2, 0.0, true), 0);
        script.watch();
        script.boot();
        script.ask(RunRequest::Drive);
        let stopped = (0..3_000).find(|_| {
            script.tick(|samples| samples.bus_current = current_code(amperes));
            script.drive.state() == State::Fault
        });
        let context = format!("{duty} {amperes} A: {stopped:?}");
        assert_eq!(stopped.is_some_and(|tick| (1_000..1_050).contains(&tick)), is_open, "{context}");
        assert_eq!(script.status.extended_code == Cause::OpenPhase as u16, is_open, "{context}");
    }
}
