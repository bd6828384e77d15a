//! Tests of the bench's sensors on a shaft, against figures worked by hand.

use crate::bench::{mm, node};
use narx_core::bus::eddycan::{Channels, Position};
use narx_core::eddycan::{Entry, Sample, TxDriver, Variant};
use narx_sim::random::Random;
use narx_sim::sensor::{
    AxialPlay, EddyCurrent, EddyCurrentConfig, Encoder, Harmonic, SensorError, Shaft, Target,
};
use narx_sim::tx_driver::{SAMPLE_RATE, TxDriverConfig};

/// Step of a position, 2^-27 mm.
const STEP: f64 = 1.0 / 134_217_728.0;

fn quiet(range: f64, target: Target) -> EddyCurrent {
    EddyCurrent::new(EddyCurrentConfig { noise: 0.0, ..EddyCurrentConfig::new(range, target) }).unwrap()
}

fn at(turns: f64) -> Shaft {
    Shaft { turns, speed: 0.0 }
}

fn millimetres(position: Position) -> f64 {
    f64::from(position.raw()) * STEP
}

#[test]
fn a_position_is_the_nearest_step_within_the_range() {
    for (rest, raw) in [
        (0.0, 0),
        (1.0, 1 << 27),
        (0.5 * STEP, 1),
        (0.49 * STEP, 0),
        (1.25, 5 << 25),
        // Beyond either end the reading is the end.
        (-0.3, 0),
        (2.0, 2 << 27),
        (2.7, 2 << 27),
    ] {
        let position = quiet(2.0, Target::still(rest)).sample(&at(0.0), 0.0);
        assert_eq!(position.raw(), raw, "{rest} mm");
    }
    // Noise does not lead out of the range, either.
    let loud = EddyCurrentConfig { noise: 0.1, ..EddyCurrentConfig::new(2.0, Target::still(1.95)) };
    assert_eq!(EddyCurrent::new(loud).unwrap().sample(&at(0.0), 5.0), mm(2));
}

/// Run-out is amplitude cos(order angle + phase) with the shaft's angle, after any number of revolutions in
/// any direction.
#[test]
fn run_out_repeats_with_the_revolution() {
    let harmonic = |order, amplitude, phase_deg| Harmonic { order, amplitude, phase_deg };
    let run_out = [harmonic(1, 0.02, 30.0), harmonic(3, 0.004, -90.0)];
    let sensor = quiet(2.0, Target { run_out, ..Target::still(1.0) });
    for revolutions in [0.0, 1.0, -1.0, 12_345.0] {
        // By hand: cos 30, cos 120 = -1/2, cos 210, cos 300; cos(3 angle - 90) = sin(3 angle) = 0, -1, 0, 1.
        let half_of_root_3 = 0.75_f64.sqrt();
        for (quarter, first, third) in
            [(0.0, half_of_root_3, 0.0), (0.25, -0.5, -1.0), (0.5, -half_of_root_3, 0.0), (0.75, 0.5, 1.0)]
        {
            let found = millimetres(sensor.sample(&at(revolutions + quarter), 0.0));
            let expected = 1.0 + 0.02 * first + 0.004 * third;
            assert!((found - expected).abs() < 2.0 * STEP, "{revolutions} + {quarter}: {found}, {expected}");
        }
    }
}

/// A sensor a quarter of a turn further around sees a bend a quarter of a revolution later, and an oval with
/// the opposite sign.
#[test]
fn two_sensors_around_one_shaft() {
    let [first, second] = [0.0, 90.0].map(|bearing| quiet(2.0, Target::surface(1.0, bearing)));
    for turns in [0.0, 0.1, 0.37, 0.8] {
        let (now, then) = (first.sample(&at(turns), 0.0), second.sample(&at(turns + 0.25), 0.0));
        assert!((now.raw() - then.raw()).abs() <= 1, "{turns}");
        assert!((now.raw() - second.sample(&at(turns), 0.0).raw()).abs() > 1000, "{turns}");
    }
}

/// Thrust grows with the square of the speed up to the end of the play, and has the opposite direction in
/// reverse.
#[test]
fn axial_play_follows_the_thrust() {
    let play = AxialPlay { length: 0.1, end_speed: 400.0 };
    let sensor = quiet(2.0, Target { play, ..Target::still(1.0) });
    for (speed, way) in [
        (0.0, 0.0),
        (100.0, 0.05 / 16.0),
        (200.0, 0.05 / 4.0),
        (400.0, 0.05),
        (800.0, 0.05),
        (-200.0, -0.05 / 4.0),
        (-900.0, -0.05),
    ] {
        let found = millimetres(sensor.sample(&Shaft { turns: 0.0, speed }, 0.0));
        assert!((found - 1.0 - way).abs() < STEP, "{speed} rad/s: {found}");
    }
}

#[test]
fn a_nut_on_a_screw_runs_to_the_end_of_the_range() {
    let sensor = quiet(4.0, Target::nut(1.0, 0.5));
    for (turns, way) in [(0.0, 1.0), (1.5, 1.75), (-1.0, 0.5), (-2.5, 0.0), (6.0, 4.0), (60.0, 4.0)] {
        assert_eq!(millimetres(sensor.sample(&at(turns), 0.0)), way, "{turns}");
    }
}

/// Samples of a target at rest have the expected mean and deviation after each of the device's filters: white
/// noise of s rms leaves a first-order low-pass with s sqrt(a / (2 - a)), where a is its coefficient.
#[test]
fn noise_is_white_and_gaussian() {
    let mut random = Random::new(7);
    let sensor = EddyCurrent::new(EddyCurrentConfig::new(2.0, Target::still(1.0))).unwrap();
    let noise = sensor.config().noise;
    assert!((noise - 1e-4).abs() < 1e-12, "50 ppm of 2 mm");
    for (index, edge) in [(0, f64::INFINITY), (2, 100.0), (3, 1000.0), (4, 10_000.0)] {
        let mut config = TxDriverConfig::new(node(1));
        config.configuration.set(Entry::Filter1, index).unwrap();
        config.configuration.set(Entry::CanConfig, 1).unwrap();
        let variant = Variant {
            channels: Channels::Single,
            ranges: [sensor.measuring_range(); 2],
            sample_rate: SAMPLE_RATE,
            firmware: 0,
        };
        let mut driver = TxDriver::new(variant, config.configuration);
        let (samples, mut sum, mut squares, mut beyond) = (400_000, 0.0, 0.0, 0);
        let a = 1.0 - (-std::f64::consts::TAU * edge / f64::from(SAMPLE_RATE)).exp();
        let expected = noise * (a / (2.0 - a)).sqrt();
        // The filter begins with one unfiltered sample.
        let settle = 4000;
        for sample in 0..samples + settle {
            let position = sensor.sample(&at(0.0), random.gaussian());
            driver.handle_sample(Sample { positions: [position; 2], counter: 0 });
            driver.handle_frame(&crate::bench::frame(0x80, &[]), 0);
            let sent = std::iter::from_fn(|| driver.poll_frame()).last().unwrap();
            if sample >= settle {
                let bytes = sent.payload().try_into().unwrap();
                let off = f64::from(i32::from_le_bytes(bytes)) * STEP - 1.0;
                (sum, squares) = (sum + off, squares + off * off);
                beyond += u32::from(off.abs() > 2.0 * expected);
            }
        }
        let count = f64::from(samples);
        let found = (squares / count).sqrt();
        // Slow noise has fewer independent samples.
        let independent = count * a;
        assert!((sum / count).abs() < 5.0 * noise / count.sqrt(), "{edge} Hz: mean {}", sum / count);
        assert!(
            (found / expected - 1.0).abs() < 5.0 / (2.0 * independent).sqrt(),
            "{edge} Hz: {found}, {expected}"
        );
        // 4.55 % of a Gaussian lie beyond two deviations.
        let share = f64::from(beyond) / count;
        assert!((share - 0.0455).abs() < 5.0 * (0.0455 / independent).sqrt(), "{edge} Hz: {share}");
    }
}

#[test]
fn encoders_count_edges_in_both_directions() {
    let rotary = Encoder::Rotary { counts: 4096 };
    let linear = Encoder::Linear { lead: 2.0, resolution: 100 };
    for (encoder, turns, counter) in [
        (rotary, 0.0, 0),
        (rotary, 0.25, 1024),
        (rotary, 1.0, 4096),
        (rotary, 15.999, 65_531),
        (rotary, 16.0, 0),
        // Just below an edge the count is the one before.
        (rotary, 1.0 - 1e-9, 4095),
        (rotary, -1e-9, 65_535),
        (rotary, -0.25, 64_512),
        // 2 mm in steps of 100 nm: 20 000.
        (linear, 1.0, 20_000),
        (linear, -0.5, 55_536),
        (linear, 4.0, 14_464),
    ] {
        assert_eq!(encoder.counter(&at(turns)), counter, "{encoder:?} at {turns}");
    }
}

/// Every refusal names the value and the range.
#[test]
fn sensors_that_cannot_be() {
    let sensor = EddyCurrentConfig::new(2.0, Target::still(1.0));
    for (config, error, text) in [
        (
            EddyCurrentConfig { range: 0.0, ..sensor },
            SensorError::Range(0.0),
            "measuring range 0 mm: must be from 0.01 to 15.9 mm",
        ),
        (
            EddyCurrentConfig { range: 16.0, ..sensor },
            SensorError::Range(16.0),
            "measuring range 16 mm: must be from 0.01 to 15.9 mm",
        ),
        (
            EddyCurrentConfig { noise: -1.0, ..sensor },
            SensorError::Noise(-1.0),
            "noise -1 mm rms: must be from 0 to 1 mm rms",
        ),
        (
            EddyCurrentConfig { target: Target::still(f64::INFINITY), ..sensor },
            SensorError::Target,
            "the target's place is not a number",
        ),
        (
            EddyCurrentConfig { target: Target::nut(1.0, f64::NAN), ..sensor },
            SensorError::Target,
            "the target's place is not a number",
        ),
    ] {
        assert_eq!(EddyCurrent::new(config), Err(error));
        assert_eq!(error.to_string(), text);
    }
    assert!(matches!(
        EddyCurrent::new(EddyCurrentConfig { range: f64::NAN, ..sensor }),
        Err(SensorError::Range(_))
    ));
}
