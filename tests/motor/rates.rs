//! Tests of the PWM rate: at any rate the drive behaves alike in seconds.

use crate::bench::{Closed, MOTOR, Outcome, RPM};
use narx_core::dictionary::{Parameters, number};
use narx_core::motor::sense::measurement::Measurement;
use narx_core::motor::{Board, Cause, Coefficients, RunRequest, Samples, State};
use narx_sim::plant::{Injection, PlantConfig};

/// PWM rates, Hz; in the last but one a millisecond is no whole number of ticks.
const RATES: [u32; 7] = [8_000, 10_000, 12_500, 16_000, 20_000, 40_500, 50_000];

fn config(rate: u32) -> PlantConfig {
    let mut config = PlantConfig::new(MOTOR, 24.0);
    config.board = Board::BENCH.at_rate(rate).unwrap();
    config
}

fn standby(mut closed: Closed, rate: u32) -> Closed {
    for _ in 0..u64::from(rate) * 51 / 100 {
        closed.tick();
    }
    assert_eq!(closed.drive.state(), State::Standby);
    closed
}

/// Seconds until `done`, within 5 s.
fn seconds(closed: &mut Closed, rate: u32, done: impl Fn(&Closed) -> bool) -> f64 {
    let ticks = (0..5 * rate).find(|_| {
        closed.tick();
        done(closed)
    });
    f64::from(ticks.expect("within 5 s")) / f64::from(rate)
}

/// A start without sensors goes through its states at the same times, and so does the ramp of the set-point.
#[test]
fn a_start_takes_the_same_time() {
    let runs = RATES.map(|rate| {
        let mut closed = standby(Closed::sensorless(&config(rate), &[]), rate);
        closed.ask(RunRequest::Drive);
        let states = [State::OpenLoop, State::SensorlessClosedLoop]
            .map(|state| seconds(&mut closed, rate, |closed| closed.drive.state() == state));
        let half = seconds(&mut closed, rate, |closed| closed.rpm() >= 0.9 * RPM);
        (rate, states, half)
    });
    let (_, states, ramp) = runs[1];
    for (rate, found, half) in runs {
        println!("{rate} Hz: {found:?} s, then {half:.4} s to 90 % of the set-point");
        for (found, expected) in found.iter().zip(states) {
            assert!((found - expected).abs() < 0.000_3, "{rate} Hz: {found} s");
        }
        assert!((half - ramp).abs() < 0.03, "{rate} Hz: {half} s, {ramp} s at 10 kHz");
    }
}

/// The ramp of the set-point with hall sensors.
#[test]
fn ramps_rise_alike() {
    let runs = RATES.map(|rate| {
        let mut closed = standby(Closed::new(&config(rate), &[(number::SPEED_RATE, 4_000)]), rate);
        closed.ask(RunRequest::Drive);
        let half = seconds(&mut closed, rate, |closed| closed.rpm() >= 0.5 * RPM);
        [half, half + seconds(&mut closed, rate, |closed| closed.rpm() >= 0.9 * RPM)]
    });
    for (rate, found) in RATES.into_iter().zip(runs) {
        println!("{rate} Hz: {found:?} s");
        // At 4000 rpm/s, and the speed loop lags.
        let ramp = [0.5, 0.9].map(|part| part * RPM / 4_000.0);
        assert!(
            found.iter().zip(ramp).all(|(found, ramp)| (0.0..0.05).contains(&(found - ramp))),
            "{rate} Hz: {found:?} s"
        );
        assert!(found.iter().zip(runs[1]).all(|(found, at_10)| (found - at_10).abs() < 0.02), "{rate} Hz");
    }
}

/// Hall sensors that lose their supply are a fault after the same time, and a command that does not come.
#[test]
fn faults_qualify_in_the_same_time() {
    for rate in RATES {
        let mut closed = standby(Closed::new(&config(rate), &[]), rate);
        closed.ask(RunRequest::Drive);
        assert_eq!(closed.run(u64::from(rate)), Outcome::Running);
        let mut silent = closed.clone();
        closed.plant.inject(Injection::HallSupplyLost);
        let lost = seconds(&mut closed, rate, |closed| closed.drive.state() == State::Fault);
        silent.silent = true;
        let timed_out = seconds(&mut silent, rate, |closed| closed.drive.state() == State::Fault);
        println!("{rate} Hz: {lost} s, {timed_out} s");
        assert_eq!(closed.status.extended_code, Cause::HallInvalid as u16);
        assert!((lost - 0.0071).abs() < 0.000_3, "{rate} Hz: {lost} s");
        assert_eq!(silent.status.extended_code, Cause::CommandTimeout as u16);
        // Parameter 114 is 0.25 s, and the last command is up to 500 ticks old.
        let age = 500.0 / f64::from(rate);
        assert!(timed_out >= 0.2499 - age && timed_out <= 0.25, "{rate} Hz: {timed_out} s");
    }
}

/// The bus current's filter has 6.4 ms.
#[test]
fn the_filter_takes_the_same_time() {
    for rate in RATES {
        let built = Coefficients::build(&Parameters::new(), &Board::BENCH.at_rate(rate).unwrap()).unwrap();
        let mut measurement = Measurement::default();
        let samples = Samples { bus_current: 3_000, ..Samples::default() };
        let all = measurement.step(&built.measurement, &samples).to_bits();
        let mut ticks = 1;
        while f64::from(measurement.bus_current()) < f64::from(all) * (1.0 - (-1.0_f64).exp()) {
            measurement.step(&built.measurement, &samples);
            ticks += 1;
        }
        let time = f64::from(ticks) / f64::from(rate);
        assert!((time - 0.0064).abs() < 0.000_2, "{rate} Hz: {time} s");
    }
}

/// Parameters in ticks are in ticks of 100 us, so that a set means the same at every rate.
#[test]
fn ticks_of_parameters_are_100_us() {
    let mut parameters = Parameters::new();
    for (number, raw) in [
        (number::SENSORLESS_ENABLE, 1),
        (number::ZC_PERIOD_MAX, 400),
        (number::ZC_DISCARD, 3),
        (number::ZC_DELAY, 250),
    ] {
        parameters.set(number, raw).unwrap();
    }
    for rate in RATES {
        let c = Coefficients::build(&parameters, &Board::BENCH.at_rate(rate).unwrap()).unwrap().sensorless;
        let seconds = |fine: f64| fine / 65_536.0 / f64::from(rate);
        let near = |fine: f64, expected: f64| (seconds(fine) / expected - 1.0).abs() < 1e-4;
        assert!(near(f64::from(c.timeout), 0.04), "{rate} Hz: {} s", seconds(f64::from(c.timeout)));
        assert!(near(f64::from(c.back_emf.discard), 300e-6), "{rate} Hz");
        assert!(near(f64::from(c.back_emf.delay_rising), 250e-6), "{rate} Hz");
        let rest = f64::from(c.rest) / f64::from(rate);
        assert!((rest - 0.005).abs() < 1.0 / f64::from(rate), "{rate} Hz: {rest} s");
    }
}

/// A rate that cannot hold a parameter's value refuses it, by name and range.
#[test]
fn a_rate_refuses_the_parameters_that_it_cannot_do() {
    let cases = [
        (50_000, number::ZC_PERIOD_MAX, 6_554),
        (50_000, number::ON_TIME_MIN, 10_001),
        (50_000, number::HALL_PERIOD_TIMEOUT, 1_311),
    ];
    for (rate, number, raw) in cases {
        let mut parameters = Parameters::new();
        for (number, raw) in [(number::SENSORLESS_ENABLE, 1), (number::HALL_ENABLE, 1), (number, raw)] {
            parameters.set(number, raw).unwrap();
        }
        assert!(Coefficients::build(&parameters, &Board::BENCH).is_ok(), "parameter {number} at 10 kHz");
        let refused = Coefficients::build(&parameters, &Board::BENCH.at_rate(rate).unwrap()).unwrap_err();
        println!("{refused}");
        assert_eq!((refused.parameter, refused.raw), (number, raw));
        assert!(refused.max < i64::from(raw));
    }
}
