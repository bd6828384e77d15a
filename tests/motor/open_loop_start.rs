//! Tests of the open-loop phase of a start without sensors: its set-point rises to parameter 88 within
//! parameter 109, and at that speed it hands over.

use crate::bench::{Closed, MOTOR};
use narx_core::dictionary::{Parameters, number};
use narx_core::motor::{Board, BuildError, Coefficients, RunRequest, State};
use narx_sim::plant::PlantConfig;

/// Mechanical speeds of the open loop of a start, rpm, tick by tick.
fn open_loop(mut closed: Closed) -> Vec<f64> {
    closed.boot();
    closed.ask(RunRequest::Drive);
    let mut speeds = Vec::new();
    while closed.drive.state() != State::SensorlessClosedLoop {
        closed.tick();
        if closed.drive.state() == State::OpenLoop {
            speeds.push(closed.rpm());
        }
        assert!(speeds.len() < 20_000, "{:?}", closed.status);
    }
    speeds
}

/// The mean of the last 50 ms is parameter 88, however steep the ramp. The speed never rises beyond parameter
/// 88, or beyond the speed that the first crossings need, whichever is higher. The steepest level lets this
/// rotor without load leap beyond that by a third.
#[test]
fn open_loop_holds_its_speed_and_hands_over_there() {
    for rpm in [150, 300, 500, 1000, 2000] {
        for (rise, first) in [(50, 550), (400, 400)] {
            let changes = [
                (number::OPEN_LOOP_SPEED, rpm),
                (number::OPEN_LOOP_RAMP, rise),
                (number::OPEN_LOOP_DURATION, 1500),
            ];
            let speeds = open_loop(Closed::sensorless(&PlantConfig::new(MOTOR, 24.0), &changes));
            let end = &speeds[speeds.len() - 500..];
            let mean = end.iter().sum::<f64>() / end.len() as f64;
            let most = speeds.iter().copied().fold(0.0, f64::max);
            println!("{rpm} rpm in {rise} ms: {mean:.1} rpm at the end, {most:.0} at most");
            assert!((mean / f64::from(rpm) - 1.0).abs() < 0.01, "{rpm} rpm in {rise} ms: {mean}");
            assert!(most < 1.03 * f64::from(rpm.max(first)), "{rpm} rpm in {rise} ms: {most}");
        }
    }
}

/// A ramp of one second is at half of parameter 88 after half of it; the speed loop lags by 0.1 s at most.
#[test]
fn open_loop_rises_along_its_ramp() {
    let changes =
        [(number::OPEN_LOOP_SPEED, 2000), (number::OPEN_LOOP_RAMP, 1000), (number::OPEN_LOOP_DURATION, 1200)];
    let speeds = open_loop(Closed::sensorless(&PlantConfig::new(MOTOR, 24.0), &changes));
    for (tick, expected) in [(5_000, 1000.0), (7_500, 1500.0), (11_500, 2000.0)] {
        let speed = speeds[tick];
        assert!((expected - 200.0..expected + 20.0).contains(&speed), "{speed} rpm after {tick} ticks");
    }
}

/// Open loop may not hand over at a speed whose sectors last longer than half of parameter 85, nor at one
/// beyond parameter 101; both are refused with the range that is left.
#[test]
fn a_speed_that_open_loop_cannot_hand_over_at_is_refused() {
    let build = |rpm, sensorless| {
        let mut parameters = Parameters::new();
        parameters.set(number::SENSORLESS_ENABLE, sensorless).unwrap();
        parameters.set(number::OPEN_LOOP_SPEED, rpm).unwrap();
        Coefficients::build(&parameters, &Board::BENCH).err()
    };
    // 500 ticks of 4 pole pairs: 500 ticks per sector are 50 rpm.
    let refused = |raw| Some(BuildError { parameter: number::OPEN_LOOP_SPEED, raw, min: 100, max: 4000 });
    for (rpm, found) in [(99, refused(99)), (100, None), (4000, None), (4001, refused(4001))] {
        assert_eq!(build(rpm, 1), found, "{rpm} rpm");
        assert_eq!(build(rpm, 0), None, "{rpm} rpm where sensorless control is not enabled");
    }
}
