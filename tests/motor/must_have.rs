//! Tests of tests/must-have.md: every item of good six-step control names its code, and the test that fails
//! without it. Both must exist. This file has the tests of items that no other file covers.

use crate::bench::{Closed, MOTOR};
use crate::steady::measure;
use crate::zero_crossing::Station;
use narx_core::dictionary::{Parameters, number};
use narx_core::motor::clock::Instant;
use narx_core::motor::control::Control;
use narx_core::motor::gain::Gain;
use narx_core::motor::rotor::back_emf::{BackEmfCoefficients, Observation, OperatingPoint};
use narx_core::motor::rotor::zero_crossing::{Why, ZeroCrossing};
use narx_core::motor::sense::front_end::Channel;
use narx_core::motor::sense::measurement::ChannelScale;
use narx_core::motor::{
    Board, Coefficients, Direction, Leg, PwmCommand, RunRequest, SampleMode, Samples, State, Step,
};
use narx_sim::plant::{LoadConfig, PlantConfig};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Rows of the table: item, code, test, seen to fail.
fn rows(table: &str) -> impl Iterator<Item = Vec<&str>> {
    let cells = |line: &str| line.starts_with("| ") && !line.starts_with("| item");
    table.lines().filter(move |line| cells(line)).map(|line| {
        let inner = line.trim().trim_start_matches('|').trim_end_matches('|');
        inner.split(" | ").map(str::trim).collect()
    })
}

/// Every file named in the table contains the name beside it, and every test is a function of the suite.
#[test]
fn every_row_names_code_and_test_that_exist() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let table = fs::read_to_string(root.join("tests/must-have.md")).unwrap();
    let mut wrong = Vec::new();
    let mut count = 0;
    for row in rows(&table) {
        let [item, places, tests, failure] = row.as_slice() else {
            wrong.push(format!("{row:?}: four columns"));
            continue;
        };
        count += 1;
        for place in places.split(", ") {
            let (file, name) = place.trim_matches('`').split_once(" ").unwrap_or((place, ""));
            let text = fs::read_to_string(root.join("core/src").join(file)).unwrap_or_default();
            if name.is_empty() || !text.contains(name) {
                wrong.push(format!("{item}: `{name}` is not in {file}"));
            }
        }
        for test in tests.split(", ") {
            let (module, function) = test.trim_matches('`').split_once("::").unwrap_or((test, ""));
            let text = fs::read_to_string(root.join(format!("tests/motor/{module}.rs"))).unwrap_or_default();
            if function.is_empty() || !text.contains(&format!("fn {function}(")) {
                wrong.push(format!("{item}: no test {test}"));
            }
        }
        if failure.is_empty() {
            wrong.push(format!("{item}: never seen to fail"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(count >= 50, "{count} rows");
}

fn config() -> PlantConfig {
    let mut config = PlantConfig::new(MOTOR, 24.0);
    config.angle_deg = 77.0;
    config
}

fn share(command: &PwmCommand) -> f64 {
    f64::from(command.duty.to_bits()) / 32_768.0
}

/// A drive at constant speed in state 4.
fn running(rpm: f64) -> Closed {
    let mut closed = Closed::sensorless(&config(), &[]);
    closed.set_point = rpm;
    closed.boot();
    closed.ask(RunRequest::Drive);
    closed.run(16_000);
    assert_eq!(closed.drive.state(), State::SensorlessClosedLoop);
    closed
}

/// Between the two duties at which the sampling instant changes, it keeps its earlier mode: late in the
/// period on the way up, in the pulse on the way down.
#[test]
fn sampling_mode_has_hysteresis() {
    let mut closed = Closed::new(&config(), &[]);
    closed.plant.set_load(LoadConfig { constant: 0.03, ..LoadConfig::default() });
    closed.boot();
    closed.set_point = 2500.0;
    closed.ask(RunRequest::Drive);
    let mut seen = BTreeSet::new();
    for rpm in [2500.0, 600.0] {
        closed.set_point = rpm;
        for _ in 0..15_000 {
            closed.tick();
            if closed.drive.state().is_driving() && (0.205..0.245).contains(&share(&closed.output)) {
                seen.insert((rpm as i32, closed.output.sample_mode == SampleMode::OnTime));
            }
        }
    }
    assert!(seen.contains(&(2500, false)) && seen.contains(&(600, true)), "{seen:?}");
    assert!(!seen.contains(&(2500, true)), "{seen:?}");
}

/// A winding that still demagnetises holds its terminal at the bus, far beyond the crossing. For half a step
/// this does not count as an observation; the crossing after it is healthy.
#[test]
fn demagnetisation_is_no_evidence() {
    // Codes are millivolts.
    let terminal = ChannelScale::new(Channel { zero: 0, micro_per_code: 1_000 }, 0);
    let c =
        BackEmfCoefficients { terminal, noise: 80, discard: 1 << 16, earliest: 8_192, ..Default::default() };
    let point = OperatingPoint { torque: Direction::Forward, interval: 24 << 16, accelerates: false };
    let mut station = Station::default();
    let mut crossings = Vec::new();
    for tick in 0..20 {
        // Step AC floats B, whose crossing rises: at tick 12.
        let step = if tick == 0 { Step::AB } else { Step::AC };
        let floating = if tick < 8 { 24.0 } else { 12.0 + 0.6 * (f64::from(tick) - 12.0) };
        let phase_voltage = [24.0, floating, 0.0].map(|volts| (volts * 1e3) as u16);
        let samples = Samples { phase_voltage, sample_mode: SampleMode::OnTime, ..Samples::default() };
        let applied = PwmCommand { step, sample_mode: SampleMode::OnTime, ..PwmCommand::default() };
        let seen = station.step(&c, &samples, 24 << 16, &applied, &point);
        assert!(seen.observation != Observation::Late, "tick {tick}");
        crossings.extend(seen.crossing().map(|age| f64::from(tick) - f64::from(age) / 65_536.0));
    }
    assert_eq!(crossings.len(), 1, "{crossings:?}");
    assert!((crossings[0] - 12.0).abs() < 0.1, "{crossings:?}");
}

/// After the floating phase has fallen silent the limit of blind steps ends the episode long before the
/// crossing time-out. If a level that always shows "before" prevents blind steps, the time-out ends it.
#[test]
fn a_rotor_that_is_no_longer_seen_is_lost() {
    let run = running(2000.0);
    // A sector at 2000 rpm and 4 pole pairs has 12.5 ticks. The level "before" holds for 2.5 of them before
    // the steps go on.
    for silent in [true, false] {
        let mut closed = run.clone();
        let left = (1..2_000).find(|_| {
            closed.tick_altered(|samples, applied| {
                let floats = |leg: &Leg| *leg == Leg::Floating;
                let Some(phase) = applied.step.legs().iter().position(floats) else { return };
                let sum: u16 = samples.phase_voltage.iter().sum();
                let reference = (sum - samples.phase_voltage[phase]) / 2;
                let before =
                    if applied.step.sector().is_some_and(|sector| sector & 1 == 1) { 0 } else { 4_095 };
                samples.phase_voltage[phase] = if silent { reference } else { before };
            });
            closed.drive.state() != State::SensorlessClosedLoop
        });
        println!("silent {silent}: {left:?} ticks");
        assert!(left.is_some_and(|ticks| ticks < 250), "{left:?} ticks");
    }
}

/// Two locks one after the other, with ramped levels, align the rotor from any angle, including the dead
/// point of either, at the angle to which the second pulls.
#[test]
fn two_ramped_locks_align_from_anywhere() {
    for degrees in (0..360).step_by(15) {
        let mut config = config();
        config.angle_deg = f64::from(degrees);
        let mut closed = Closed::sensorless(&config, &[]);
        closed.boot();
        closed.ask(RunRequest::Drive);
        let (mut patterns, mut duties) = (Vec::new(), Vec::new());
        let mut angle = 0.0;
        while closed.drive.state() != State::OpenLoop {
            closed.tick();
            if closed.output.step != Step::Coast {
                duties.push(share(&closed.output));
                patterns.push(closed.output.step);
                angle = closed.plant.observe().electrical_turns.rem_euclid(1.0) * 360.0;
            }
        }
        let of = |step: Step| patterns.iter().filter(|pattern| **pattern == step).count();
        assert!(of(Step::LockC) > 300 && of(Step::LockCA) > 300, "{} {}", of(Step::LockC), of(Step::LockCA));
        assert!((angle - 120.0).abs() < 12.0, "from {degrees} to {angle}");
        let last = duties.last().copied().unwrap_or(0.0);
        let half = duties.iter().position(|duty| *duty > last / 2.0).unwrap_or(0);
        assert!(half > 60, "half of the level after {half} ticks");
    }
}

/// The level that finds the rotor rises along a ramp of parameter 109, but at least 0.1 s and at most 0.2 s:
/// half of it is reached no earlier than at half of that time.
#[test]
fn the_kick_is_a_ramp() {
    let mut config = config();
    // Friction holds the rotor, so that only the level matters.
    config.load.constant = 1.0;
    for (ramp, half) in [(20, 450..750), (150, 700..1_150), (300, 900..1_500)] {
        let changes = [(number::OPEN_LOOP_RAMP, ramp), (number::OPEN_LOOP_DURATION, 1_000)];
        kick_rises(Closed::sensorless(&config, &changes), &half);
    }
}

fn kick_rises(mut closed: Closed, expected: &core::ops::Range<usize>) {
    closed.boot();
    closed.ask(RunRequest::Drive);
    while closed.drive.state() != State::OpenLoop {
        closed.tick();
    }
    let duties: Vec<f64> = (0..5_000)
        .map(|_| {
            closed.tick();
            share(&closed.output)
        })
        .collect();
    let most = duties.iter().copied().fold(0.0, f64::max);
    let half = duties.iter().position(|duty| *duty > most / 2.0).unwrap_or(0);
    assert!(most > 0.03 && expected.contains(&half), "{most} at most, half after {half} ticks");
}

/// Hand-over continues the set-point's ramp from the measured speed.
#[test]
fn hand_over_ramps_from_the_measured_speed() {
    let mut control = Control::default();
    control.hand_over(33 << 16, 0);
    assert_eq!(control.setpoint(), 33 << 16);
}

/// A rotor that does not turn yet when open loop ends (T34) has the time-out to show a crossing: speed 0 is
/// not judged at once.
#[test]
fn a_rotor_that_is_not_up_at_hand_over_is_no_stall() {
    let mut late = 0;
    for inertia in [0.0, 20.0] {
        let mut config = config();
        config.load.inertia = inertia * MOTOR.inertia;
        let mut closed =
            Closed::sensorless(&config, &[(number::OPEN_LOOP_RAMP, 20), (number::OPEN_LOOP_DURATION, 20)]);
        closed.boot();
        closed.ask(RunRequest::Drive);
        while closed.drive.state() != State::SensorlessClosedLoop {
            closed.tick();
        }
        if closed.status.speed_sensorless.to_bits() != 0 {
            continue;
        }
        late += 1;
        let held = (0..450).all(|_| {
            closed.tick();
            closed.drive.state() == State::SensorlessClosedLoop
        });
        assert!(held, "{inertia} rotors");
    }
    assert!(late > 0, "none was late");
}

/// The set-point moves at parameter 99: 2000 rpm/s are 13.3 electrical rev/s in 100 ms with 4 pole pairs.
#[test]
fn the_set_point_is_ramped() {
    let mut closed = Closed::sensorless(&config(), &[(number::SPEED_RATE, 2_000)]);
    closed.set_point = 1000.0;
    closed.boot();
    closed.ask(RunRequest::Drive);
    closed.run(20_000);
    closed.set_point = 3000.0;
    closed.ask(RunRequest::Drive);
    let setpoint = |closed: &Closed| f64::from(closed.status.setpoint.to_bits()) / 65_536.0;
    closed.run(1_000);
    let first = setpoint(&closed);
    closed.run(1_000);
    let moved = setpoint(&closed) - first;
    assert!((moved - 13.33).abs() < 0.5, "{moved} rev/s in 100 ms");
}

/// Set-points beyond parameters 101 and 102 are limited to these, 0 included.
#[test]
fn set_points_saturate() {
    let limits = [(number::SPEED_MAX_SL, 1_500), (number::SPEED_MIN_SL, 800)];
    let mut closed = Closed::sensorless(&config(), &limits);
    closed.set_point = 1000.0;
    closed.boot();
    closed.ask(RunRequest::Drive);
    closed.run(12_000);
    for (asked, given) in [(4000.0, 1500.0), (0.0, 800.0)] {
        closed.set_point = asked;
        closed.ask(RunRequest::Drive);
        closed.run(10_000);
        let setpoint = f64::from(closed.status.setpoint.to_bits()) / 65_536.0 * 15.0;
        assert!((setpoint - given).abs() < 1.0, "{asked} asked: {setpoint} rpm");
        assert!((closed.rpm() - given).abs() < 0.03 * given, "{asked} asked: {} rpm", closed.rpm());
    }
}

/// A reversal waits for standstill: the drive passes Standby at rest, both times.
#[test]
fn a_reversal_passes_standby_at_rest() {
    let mut closed = running(2000.0);
    for request in [RunRequest::Reverse, RunRequest::Drive] {
        closed.ask(request);
        let passed = (0..40_000).any(|_| {
            closed.tick();
            closed.drive.state() == State::Standby
        });
        assert!(passed && closed.rpm().abs() < 400.0, "{passed}: {} rpm", closed.rpm());
        closed.run(25_000);
        assert_eq!(closed.drive.state(), State::SensorlessClosedLoop);
    }
}

/// The duty never exceeds parameter 98, however high the requested speed.
#[test]
fn duty_has_a_maximum() {
    let mut closed = Closed::sensorless(&config(), &[(number::DUTY_MAX_SL, 4_000)]);
    closed.set_point = 4000.0;
    closed.boot();
    closed.ask(RunRequest::Drive);
    let most = (0..20_000).fold(0.0_f64, |most, _| {
        closed.tick();
        most.max(share(&closed.output))
    });
    assert!((0.39..=0.4001).contains(&most), "{most}");
}

/// A pulse is at least as long as parameter 272, or it is left out, and the mean is what the motor needs: at
/// 60 V that is 4 %, and the least pulse is 6 %.
#[test]
fn a_pulse_has_a_least_length() {
    let config = PlantConfig { angle_deg: 77.0, ..PlantConfig::new(MOTOR, 60.0) };
    let mut closed = Closed::sensorless(&config, &[(number::ON_TIME_MIN, 6_000)]);
    closed.set_point = 600.0;
    closed.boot();
    closed.ask(RunRequest::Drive);
    closed.run(10_000);
    let shares: Vec<f64> = (0..5_000)
        .map(|_| {
            closed.tick();
            share(&closed.output)
        })
        .collect();
    let pulses = shares.iter().filter(|share| (0.0595..0.0605).contains(*share)).count();
    let left_out = shares.iter().filter(|share| **share == 0.0).count();
    assert_eq!(pulses + left_out, shares.len());
    assert!(pulses > 2_000 && left_out > 1_000, "{pulses} pulses, {left_out} left out");
    let (mean, status) = (shares.iter().sum::<f64>() / 5_000.0, closed.status);
    let told = f64::from(status.duty.to_bits()) / 32_768.0;
    assert!((mean - told).abs() < 0.003, "{mean} given, {told} told");
    let rpm = closed.plant.observe().speed.to_degrees() / 6.0;
    assert!((rpm / 600.0 - 1.0).abs() < 0.02, "{rpm} rpm");
}

/// Below 33 electrical rev/s without sensors the set-point falls by 6 % in a revolution, whatever the ramp
/// is; one that is to reverse stops by the ramp.
#[test]
fn a_slow_set_point_falls_no_faster_than_crossings_show() {
    let changes = [(number::SPEED_MIN_SL, 100), (number::SPEED_RATE, 1_000_000)];
    let after = |request: RunRequest| {
        let mut closed = Closed::sensorless(&PlantConfig { angle_deg: 77.0, ..config() }, &changes);
        closed.set_point = 480.0;
        closed.boot();
        closed.ask(RunRequest::Drive);
        closed.run(20_000);
        let (before, turns) = (closed.status.setpoint, closed.plant.observe().electrical_turns);
        closed.set_point = 100.0;
        closed.ask(request);
        while closed.plant.observe().electrical_turns < turns + 1.0 && closed.drive.state().is_driving() {
            closed.tick();
        }
        f64::from(closed.status.setpoint.to_bits()) / f64::from(before.to_bits())
    };
    let (falls, stops) = (after(RunRequest::Drive), after(RunRequest::Reverse));
    assert!((0.92..0.97).contains(&falls), "{falls} of the set-point after a revolution");
    assert!(stops < 0.1, "{stops} of the set-point after a revolution");
}

/// The voltage that dead time takes from the pulse is added: the lock's level is its share of the nominal
/// supply, on the present bus voltage, plus 0.5 % for 500 ns.
#[test]
fn dead_time_is_given_back() {
    let mut closed = Closed::sensorless(&config(), &[(number::LOCK_DUTY, 800)]);
    closed.boot();
    closed.ask(RunRequest::Drive);
    closed.run(700);
    let wanted = 0.08 * 24.0 / closed.plant.observe().bus_voltage + 0.005;
    let found = share(&closed.output);
    assert!(closed.output.step == Step::LockCA && (found - wanted).abs() < 0.001, "{found}, not {wanted}");
}

/// The input current rating of Table 1 bounds parameter 106.
#[test]
fn input_current_is_rated() {
    let mut parameters = Parameters::new();
    // mA.
    assert!(parameters.set(number::HV_CURRENT_MAX, 7_001).is_err());
    parameters.set(number::HV_CURRENT_MAX, 7_000).unwrap();
    let built = Coefficients::build(&parameters, &Board::BENCH).unwrap();
    assert_eq!(built.control.limits.maximum, 7 << 16);
}

/// With misaligned sensors and the offset set accordingly, commutation is at its right angle.
#[test]
fn a_hall_offset_is_taken_off() {
    for offset in [-20.0, 20.0] {
        let mut config = config();
        config.hall.offset_deg = offset;
        let angle = (offset * 100.0) as i32;
        let changes = [(number::STANDARD_HALL_SEQUENCE, 0), (number::HALL_OFFSET_ANGLE, angle)];
        let mut closed = Closed::new(&config, &changes);
        closed.boot();
        closed.ask(RunRequest::Drive);
        closed.run(12_000);
        let steady = measure(&mut closed, 2_000);
        assert!(steady.mean.abs() < 2.0, "{offset}: {steady:?}");
    }
}

/// A crossing reports its margin: 2 ticks behind its prediction at 20 ticks per sector it is 6 degrees late.
#[test]
fn a_crossing_tells_its_margin() {
    let mut rotor = ZeroCrossing::default();
    let mut now = Instant::default();
    rotor.start(now, 0, Direction::Forward);
    for crossing in 0..14 {
        now = now.after(20 + 2 * u32::from(crossing == 13));
        assert!(rotor.cross(now, crossing % 6, (0, 0), Gain::ZERO, false));
    }
    let (why, margin, accepted) = rotor.why();
    let degrees = f64::from(margin) * 360.0 / 65_536.0;
    assert!(why == Why::Accepted && accepted == 14 && (degrees - 6.0).abs() < 0.3, "{degrees}");
}
