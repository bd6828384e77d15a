//! Tests of starts without sensors: 200 random plants, every preset at every supply.

use crate::bench::{Closed, MOTOR};
use narx_core::commissioning::{Mode, SpeedLimit};
use narx_core::dictionary::number;
use narx_core::motor::{Board, RunRequest, State};
use narx_lab::promises::{Point, Start, map};
use narx_sim::plant::PlantConfig;
use narx_sim::presets::PRESETS;
use std::fmt::Write as _;

/// Of two hundred of the bench's ten thousand plants none may fail, at most a twentieth may need
/// Auto-restart, and none may end without a name.
#[test]
fn two_hundred_random_plants_start() {
    let cases: Vec<u64> = (0..200).collect();
    let starts: Vec<Start> =
        map(&cases, |case| Start::run(*case, &Board::BENCH)).into_iter().flatten().collect();
    assert_eq!(starts.len(), cases.len(), "every seed draws a plant");
    let list = |holds: &dyn Fn(&&Start) -> bool| -> String {
        starts.iter().filter(holds).fold(String::new(), |mut text, start| {
            let _ = writeln!(text, "{start}\n    cargo xtask bench --case {}", start.case);
            text
        })
    };
    let first = starts.iter().filter(|start| start.started_at_once()).count();
    let started = starts.iter().filter(|start| start.started()).count();
    println!("{first} at the first try, {started} within Auto-restart");
    assert_eq!(list(&|start| !start.started()), "", "did not start");
    assert!(first >= 190, "{first} at the first try; not:\n{}", list(&|start| !start.started_at_once()));
    assert_eq!(list(&|start| !start.is_accounted_for()), "");
    assert_eq!(list(&|start| start.to_closed_loop > 3.0), "");
}

/// Two plants at 20 kHz that coast onto their set-point. For the first 0.8 ms the drive does not look at the
/// terminals, because the windings may carry current; the rotor may turn by a revolution meanwhile. That no
/// place was seen does not mean that the rotor is slow (case 408 ended in over-voltage), and the first place
/// that is seen does not tell how far the rotor has turned (case 29).
#[test]
fn a_rotor_that_coasts_for_a_revolution_unseen_is_led_on() {
    let board = Board::BENCH.at_rate(20_000).unwrap();
    for case in [29, 408] {
        let start = Start::run(case, &board).unwrap();
        assert!(start.started(), "{start}");
    }
}

/// On a high supply at a high PWM rate the first steps need less duty than the shortest pulse. Every preset
/// starts at once: the few pulses are sampled in their middle.
#[test]
fn presets_start_by_pulses_longer_than_was_asked_for() {
    for rate in [40_000, 50_000] {
        let board = Board::BENCH.at_rate(rate).unwrap();
        let late = map(&PRESETS.iter().collect::<Vec<_>>(), |preset| {
            let point = Point { board, preset, mode: Mode::Sensorless, supply: 57.0, load: 0.0, rpm: None };
            let run = point.run().map_or_else(|why| why, |run| format!("{:.3}", run.to_closed_loop));
            let soon = run.parse().is_ok_and(|seconds: f64| seconds < 0.25);
            (!soon).then(|| format!("{} at {rate} Hz: {run}", preset.name))
        });
        assert_eq!(late.into_iter().flatten().collect::<Vec<_>>(), Vec::<String>::new());
    }
}

/// Parameter 84 is in per cent of the nominal voltage: a motor that was brought up without sensors goes on in
/// closed loop from that voltage, and with 0 from its present voltage. In both cases it reaches its
/// set-point.
#[test]
fn closed_loop_begins_with_its_initial_voltage() {
    let begins = |initial: i32| {
        let mut closed =
            Closed::sensorless(&PlantConfig::new(MOTOR, 24.0), &[(number::INITIAL_DUTY, initial)]);
        closed.boot();
        closed.ask(RunRequest::Drive);
        let voltage = |closed: &Closed| f64::from(closed.output.duty.to_bits()) / 32_768.0 * 24.0;
        let mut before = 0.0;
        while closed.drive.state() != State::SensorlessClosedLoop {
            before = voltage(&closed);
            closed.tick();
        }
        // The slew limit takes some ticks, then the speed loop goes on.
        (0..5).for_each(|_| closed.tick());
        let after = voltage(&closed);
        (0..20_000).for_each(|_| closed.tick());
        assert_eq!(closed.drive.state(), State::SensorlessClosedLoop);
        assert!((closed.rpm() / crate::bench::RPM - 1.0).abs() < 0.02, "{} rpm", closed.rpm());
        (before, after)
    };
    for (initial, change) in [(0, -0.1..0.1), (300, -9.0..-0.3), (2500, 1.0..9.0)] {
        let (before, after) = begins(initial);
        assert!(change.contains(&(after - before)), "{initial}: {before:.2} V, then {after:.2} V");
    }
}

/// One line of a table, rounded so that only visible differences change it.
fn row(point: &Point) -> String {
    let load = if point.load > 0.0 { "rated" } else { "none" };
    let place = format!("{:<22} {:>4} V  {load:<5}", point.preset.name, point.supply);
    match point.run() {
        Err(why) => format!("{place}  {why}"),
        Ok(f) => format!(
            "{place}  {:>6}  {:>6.1} s  {:>6.1} s  {:>6.1} %  {:>5.0} %  {:>5.0}  {:>5.0} A",
            f.rpm,
            f.to_closed_loop,
            f.to_speed,
            // Rounded half up, without negative zero.
            (1000.0 * f.error).round() / 10.0 + 0.0,
            100.0 * f.jitter,
            f.angle_mean.abs(),
            f.peak_current,
        ),
    }
}

fn table(mode: Mode) -> String {
    let mut points = Vec::new();
    for preset in &PRESETS {
        for supply in [18.0, 24.0, 48.0, 60.0] {
            points.extend([0.0, 1.0].map(|load| {
                let board = Board::BENCH;
                Point { board, preset, mode, supply, load, rpm: None }
            }));
        }
    }
    let mut text = format!(
        "{:<22} {:>6}  {:<5}  {:>6}  {:>8}  {:>8}  {:>8}  {:>7}  {:>5}  {:>7}\n",
        "motor", "supply", "load", "rpm", "locked", "at speed", "error", "jitter", "angle", "current"
    );
    for row in map(&points, row) {
        text.push_str(&row);
        text.push('\n');
    }
    text
}

/// The table of presets with hall sensors is unchanged: time from the Drive request to closed loop and to
/// within 1 % of the set-point, steady error, jitter of commutation (rms, of 60 degrees), its mean angle
/// (degrees), peak phase current. The set-point is the middle of the motor's range, or less for the output
/// power.
#[test]
fn presets_with_hall_sensors() {
    insta::assert_snapshot!(table(Mode::Hall));
}

/// The table of presets without sensors is unchanged.
#[test]
fn presets_without_sensors() {
    insta::assert_snapshot!(table(Mode::Sensorless));
}

/// Motors that four samples of back-EMF a sector limit at 10 kHz, on their nominal supply: rated speed of the
/// data sheet, the largest set-point at 10 and at 20 kHz and what limits it there, and the speed that is held
/// at that set-point without load.
#[test]
fn presets_that_samples_limit_are_faster_at_20_khz() {
    let fast = Board::BENCH.at_rate(20_000).unwrap();
    let mut text = format!(
        "{:<22} {:>6}  {:>6}  {:>6}  {:>6}  {:<12}  {:>6}\n",
        "motor", "supply", "rated", "10 kHz", "20 kHz", "limit", "held"
    );
    for preset in &PRESETS {
        let supply = preset.data.nominal_voltage.clamp(18.0, 60.0);
        let point = |board| Point { board, preset, mode: Mode::Sensorless, supply, load: 0.0, rpm: None };
        let [slow, quick] = [Board::BENCH, fast].map(|board| point(board).commission().unwrap());
        if slow.speed_limit != SpeedLimit::Samples {
            continue;
        }
        let rpm = quick.speed_max.floor();
        let point = Point { rpm: Some(rpm), ..point(fast) };
        let held = point.run().map(|figures| rpm * (1.0 + figures.error));
        let held = held.map_or_else(|why| why.to_string(), |rpm| format!("{rpm:.0}"));
        let (rated, limit) = (preset.data.rated_speed.unwrap_or(0.0), quick.speed_limit.name());
        let _ = writeln!(
            text,
            "{:<22} {supply:>4} V  {rated:>6.0}  {:>6.0}  {rpm:>6.0}  {limit:<12}  {held:>6}",
            preset.name, slow.speed_max
        );
    }
    insta::assert_snapshot!(text);
}
