//! Tests of events while the motor runs: parameters that change, sensors that are doubted for a moment,
//! faults that are masked.

use crate::bench::{Closed, MOTOR, Outcome, RPM};
use crate::rotor::ScriptedRotor;
use crate::scripted::Scripted;
use crate::support::coefficients;
use narx_core::dictionary::number;
use narx_core::motor::clock::Instant;
use narx_core::motor::machine::event::{HallCalibration, Limiter};
use narx_core::motor::rotor::open_loop::OpenLoop;
use narx_core::motor::{Cause, Direction, Event, Lines, RunRequest, State, Step};
use narx_core::units::Volts;
use narx_sim::plant::{Injection, MotorConfig, Phase, PlantConfig};

fn running(supply: f64) -> Closed {
    let mut closed = Closed::new(&PlantConfig::new(MOTOR, supply), &[]);
    closed.boot();
    closed.ask(RunRequest::Drive);
    assert_eq!(closed.run(20_000), Outcome::Running);
    closed
}

/// A fault that is masked at rest, but cannot be masked while driving, stops a start before any leg is
/// driven.
#[test]
fn a_forced_fault_stops_a_start_before_it_begins() {
    let changes = [(number::HALL_ENABLE, 1), (number::CRITICAL_FAULT_MASK, 0)];
    let mut script = Scripted::new(coefficients(&changes), ScriptedRotor::new(0.2, 0.0, true), 0);
    script.boot();
    let fault = |samples: &mut narx_core::motor::Samples| samples.lines = Lines::DRIVER_FAULT;
    for _ in 0..100 {
        script.tick(fault);
    }
    assert_eq!(script.drive.state(), State::Standby, "masked while nothing drives");
    script.ask(RunRequest::Drive);
    for _ in 0..3 {
        assert_eq!(script.tick(fault).step, Step::Coast);
        assert_eq!(script.drive.state(), State::Fault);
        assert_eq!(script.status.extended_code, Cause::DriverLine as u16);
    }
}

/// A lower speed limit, written live, slows the motor down; a speed that was allowed before does not become
/// an overspeed.
#[test]
fn a_lower_speed_limit_is_no_overspeed() {
    let mut closed = running(24.0);
    closed.configure(&[(number::SPEED_MAX_HES, 1_000), (number::SPEED_MIN_HES, 300)]);
    assert_eq!(closed.run(50_000), Outcome::Running);
    assert!((closed.rpm() - 1_000.0).abs() < 20.0, "{} rpm", closed.rpm());
}

/// While a motor that is too fast coasts, the report names the limit for as long as that lasts.
#[test]
fn coasting_down_has_a_name() {
    // Very little friction: the shaft keeps its speed for long.
    let mut config = PlantConfig::new(MotorConfig { static_friction: 2e-4, ..MOTOR }, 24.0);
    config.angle_deg = 40.0;
    let mut closed = Closed::new(&config, &[]);
    closed.boot();
    closed.ask(RunRequest::Drive);
    assert_eq!(closed.run(20_000), Outcome::Running);
    closed.configure(&[(number::SPEED_MAX_HES, RPM as i32 / 2), (number::SPEED_MIN_HES, 300)]);
    let mut named = 0;
    for _ in 0..5_000 {
        closed.tick();
        named += u32::from(closed.status.limiter == Limiter::Return);
    }
    assert!(named > 1_000, "{named} of 5000 ticks");
}

/// After sensors were wrong for a few milliseconds the motor goes on and reaches its speed. The current is
/// bounded, and in most cases none flows back into the bus; in the others the wrong code had braked the rotor
/// before it was doubted. The current depends on the position in a step at which the wrong code begins, so it
/// begins at several.
#[test]
fn a_doubt_that_passes_is_no_surge() {
    let (mut peaks, mut fed, mut doubts) = (Vec::new(), 0, 0);
    for (supply, place) in
        [24.0, 48.0].into_iter().flat_map(|supply| [0, 13, 26].map(|place| (supply, place)))
    {
        let mut running = running(supply);
        assert_eq!(running.run(place), Outcome::Running);
        let lies = Phase::ALL.into_iter().flat_map(|line| [(line, false), (line, true)]);
        for ((line, high), ticks) in lies.flat_map(|lie| [20, 50, 80].map(|ticks| (lie, ticks))) {
            let context = format!("{supply} V, {line:?} {high} for {ticks} ticks from {place}");
            let mut closed = running.clone();
            closed.plant.inject(Injection::HallStuck { line, high });
            assert_eq!(closed.run(ticks), Outcome::Running, "{context}");
            doubts += u32::from(closed.status.limiter == Limiter::Off);
            closed.plant.clear(Injection::HallStuck { line, high });
            (closed.peak, closed.bus_max) = (0.0, 0.0);
            assert_eq!(closed.run(10_000), Outcome::Running, "{context}");
            assert!((closed.rpm() - RPM).abs() < 0.02 * RPM, "{context}: {} rpm", closed.rpm());
            peaks.push(closed.peak);
            fed += u32::from(closed.bus_max > running.bus_max + 2.0);
        }
    }
    peaks.sort_by(f64::total_cmp);
    let (median, peak) = (peaks[peaks.len() / 2], peaks[peaks.len() - 1]);
    println!("{doubts} of 108 doubted; afterwards {median:.1} A, at most {peak:.1} A, {fed} fed the bus");
    assert!(doubts >= 36, "{doubts}");
    assert!(median <= 3.0, "{median:.1} A");
    // The limit of the phase current (Table 2).
    assert!(peak <= 12.0, "{peak:.1} A");
    assert!(fed <= 30, "{fed}");
}

/// Parameter 87 is the level of open loop even if rotor lock has a higher one, and a set-point of 0 written
/// live stops the field.
#[test]
fn open_loop_takes_its_own_level_and_stops_at_0() {
    let build = |rpm| {
        coefficients(&[
            (number::NOMINAL_SUPPLY, 48_000),
            (number::LOCK_DUTY, 800),
            (number::OPEN_LOOP_DUTY, 400),
            (number::OPEN_LOOP_SPEED, rpm),
        ])
        .open_loop
    };
    let (turning, stopping) = (build(500), build(0));
    let mut field = OpenLoop::default();
    let mut now = Instant::default();
    field.start(&turning, now, 0, Direction::Forward);
    let mut millisecond = |field: &mut OpenLoop, c: &_| {
        now = now.after(10);
        field.advance(c, now, Direction::Forward, true);
    };
    for _ in 0..1_000 {
        // 4 % of 48 V.
        assert_eq!(field.level(), Volts::from_milli(1_920).to_bits());
        millisecond(&mut field, &turning);
    }
    assert!(!field.stopped());
    for _ in 0..15_000 {
        millisecond(&mut field, &stopping);
    }
    assert!(field.stopped());
}

/// A request for the other direction ends a hall calibration at once, whatever open loop did before.
#[test]
fn a_reversal_ends_a_calibration() {
    let changes = [(number::OPEN_LOOP_ENABLE, 1), (number::LOCK_DURATION, 100)];
    let mut script = Scripted::new(coefficients(&changes), ScriptedRotor::new(0.2, 0.0, true), 0);
    script.boot();
    script.blocked_current = 1_000.0;
    let run = |script: &mut Scripted, request, ticks| {
        script.ask(request);
        for _ in 0..ticks {
            script.tick(|_| {});
        }
        script.drive.state()
    };
    assert_eq!(run(&mut script, RunRequest::Drive, 8_000), State::OpenLoop);
    assert_eq!(run(&mut script, RunRequest::Standby, 1), State::Standby);
    script.drive.handle_event(Event::CalibrateHall(true));
    assert_eq!(run(&mut script, RunRequest::Drive, 2_000), State::OpenLoop);
    assert_eq!(script.status.hall_calibration, HallCalibration::Running);
    assert_eq!(run(&mut script, RunRequest::Reverse, 1), State::Standby);
    assert_eq!(script.status.hall_calibration, HallCalibration::Failed);
}

/// Short pulses on the hall lines, twenty per second, hardly slow the rotor down.
#[test]
fn glitches_hardly_disturb_the_speed() {
    let mut closed = running(24.0);
    closed.plant.inject(Injection::HallGlitches(20.0));
    let mut slowest = f64::MAX;
    for _ in 0..50_000 {
        assert_eq!(closed.run(1), Outcome::Running);
        slowest = slowest.min(closed.rpm());
    }
    assert!(slowest > 0.97 * RPM, "{slowest:.0} rpm");
}
