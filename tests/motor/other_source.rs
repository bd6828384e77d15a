//! Tests of a closed loop that goes on by the other one's source (parameter 308).

use crate::bench::{Closed, MOTOR, Outcome, RPM};
use narx_core::commissioning::Mode;
use narx_core::dictionary::number;
use narx_core::motor::{Board, Cause, RunRequest, State};
use narx_sim::plant::{Injection, LoadConfig, Phase, PlantConfig};
use narx_sim::presets::PRESETS;

/// Torque of the load, N m: half of what the motor gives with 4 A.
const TORQUE: f64 = 0.07;

/// A motor in the hall loop at [`RPM`], with both closed loops enabled, and this change.
fn running(rate: u32, change: (u16, i32)) -> Closed {
    let mut config = PlantConfig::new(MOTOR, 24.0);
    config.board = Board::BENCH.at_rate(rate).unwrap();
    config.load = LoadConfig { constant: TORQUE, ..LoadConfig::default() };
    let changes = [(number::SENSORLESS_ENABLE, 1), change];
    let mut closed = Closed::new(&config, &changes);
    for _ in 0..u64::from(rate) * 51 / 100 {
        closed.tick();
    }
    closed.ask(RunRequest::Drive);
    assert_eq!(closed.run(2 * u64::from(rate)), Outcome::Running);
    assert_eq!(closed.drive.state(), State::HallClosedLoop);
    closed
}

fn lies() -> Vec<Injection> {
    let stuck =
        Phase::ALL.into_iter().flat_map(|line| [true, false].map(|high| Injection::HallStuck { line, high }));
    let swapped = Phase::ALL.into_iter().map(Injection::HallSwapped);
    stuck.chain(swapped).chain([Injection::HallSupplyLost]).collect()
}

/// However the hall sensors fail, wherever the rotor is: the motor goes on without them at once. Its speed
/// hardly changes, no current peaks, the bus is not fed, and the reason is told.
#[test]
fn a_motor_goes_on_without_its_hall_sensors() {
    for rate in [10_000, 20_000] {
        let (mut slowest, mut peak, mut latest) = (RPM, 0.0_f64, 0);
        for lie in lies() {
            for place in [0, 7, 16, 29] {
                let mut closed = running(rate, (number::OTHER_SOURCE, 1));
                closed.run(place);
                (closed.peak, closed.bus_max) = (0.0, 0.0);
                closed.plant.inject(lie);
                let context = format!("{rate} Hz, {lie:?} from {place}");
                let mut changed = None;
                for tick in 0..u64::from(rate) {
                    closed.tick();
                    slowest = slowest.min(closed.rpm());
                    changed = changed.or((closed.drive.state() != State::HallClosedLoop).then_some(tick));
                }
                assert_eq!(closed.drive.state(), State::SensorlessClosedLoop, "{context}");
                assert_eq!(closed.status.extended_code, Cause::HallsGivenUp as u16, "{context}");
                assert!(closed.status.faults.is_empty(), "{context}: {:?}", closed.status.faults);
                assert!((closed.rpm() - RPM).abs() < 0.01 * RPM, "{context}: {} rpm", closed.rpm());
                peak = peak.max(closed.peak);
                latest = latest.max(changed.unwrap_or(u64::MAX) * 1_000_000 / u64::from(rate));
                assert!(closed.bus_max < 25.5, "{context}: {} V", closed.bus_max);
            }
        }
        println!("{rate} Hz: at least {slowest:.0} rpm, at most {peak:.1} A, changed within {latest} us");
        assert!(slowest > 0.95 * RPM, "{slowest:.0} rpm");
        assert!(peak < 8.0, "{peak:.1} A");
        // Less than an electrical revolution.
        assert!(latest < 7_500, "{latest} us");
    }
}

/// The factory value: hall sensors that fail are a fault.
#[test]
fn without_leave_hall_sensors_that_fail_are_a_fault() {
    let mut closed = running(10_000, (number::OTHER_SOURCE, 0));
    closed.plant.inject(Injection::HallSupplyLost);
    assert_eq!(closed.run(1_000), Outcome::Fault { ticks: 70, code: Cause::HallInvalid as u16 });
}

/// Glitches are no failure: the hall loop goes on.
#[test]
fn a_single_glitch_changes_nothing() {
    for place in [0, 9, 21] {
        let mut closed = running(10_000, (number::OTHER_SOURCE, 1));
        closed.run(place);
        closed.tick_altered(|samples, _| samples.hall = 7);
        assert_eq!(closed.run(2_000), Outcome::Running);
        assert_eq!((closed.drive.state(), closed.status.extended_code), (State::HallClosedLoop, 0));
    }
}

/// Hall sensors that are misplaced by as much as sensors are, 10 degrees, are none that fail, whatever the
/// load and the set-point do.
#[test]
fn sensors_that_are_a_little_off_are_kept() {
    for offset in [-10.0, 10.0] {
        let mut config = PlantConfig::new(MOTOR, 24.0);
        config.hall.offset_deg = offset;
        config.load = LoadConfig { constant: TORQUE, ..LoadConfig::default() };
        let changes = [(number::SENSORLESS_ENABLE, 1), (number::OTHER_SOURCE, 1)];
        let mut closed = Closed::new(&config, &changes);
        closed.boot();
        closed.ask(RunRequest::Drive);
        for rpm in [1_000.0, 3_500.0, 800.0, 2_500.0] {
            closed.set_point = rpm;
            assert_eq!(closed.run(8_000), Outcome::Running);
            assert_eq!(closed.drive.state(), State::HallClosedLoop, "{offset} degrees, {rpm} rpm");
        }
    }
}

/// Hall sensors that work are kept through steps of the load between none and 80 % of the rated torque, with
/// every motor, forward and in reverse.
#[test]
fn sensors_that_work_are_kept_through_steps_of_the_load() {
    for preset in &PRESETS {
        for request in [RunRequest::Drive, RunRequest::Reverse] {
            let supply = preset.data.nominal_voltage.clamp(18.0, 60.0);
            let config = PlantConfig::new(preset.motor, supply);
            let changes = [(number::SENSORLESS_ENABLE, 1), (number::OTHER_SOURCE, 1)];
            let mut closed = Closed::rated(&config, &changes, Mode::Hall, preset.data.rated_current);
            closed.boot();
            closed.ask(request);
            let torque = 0.8 * preset.data.rated_current.unwrap_or(1.0) * preset.motor.torque_constant;
            for step in 0..6 {
                // A light rotor that is let go of may overspeed, which is another matter.
                closed.run(5_000);
                assert!(
                    closed.drive.state() != State::SensorlessClosedLoop,
                    "{} {request:?} {step}",
                    preset.name
                );
                let constant = if step % 2 == 0 { torque } else { 0.0 };
                closed.plant.set_load(LoadConfig { constant, ..LoadConfig::default() });
            }
        }
    }
}

/// Hall sensors that work again go on where the back-EMF is lost.
#[test]
fn hall_sensors_that_work_again_take_over_from_the_terminals() {
    let mut closed = running(10_000, (number::OTHER_SOURCE, 1));
    closed.plant.inject(Injection::HallSupplyLost);
    assert_eq!(closed.run(1_000), Outcome::Running);
    assert_eq!(closed.drive.state(), State::SensorlessClosedLoop);
    closed.plant.clear(Injection::HallSupplyLost);
    assert_eq!(closed.run(1_000), Outcome::Running);
    // No terminal shows anything more.
    for _ in 0..5_000 {
        closed.tick_altered(|samples, _| samples.phase_voltage = [0; 3]);
    }
    assert_eq!(closed.drive.state(), State::HallClosedLoop);
    assert_eq!(closed.status.extended_code, Cause::BackEmfGivenUp as u16);
    assert!((closed.rpm() - RPM).abs() < 0.02 * RPM, "{} rpm", closed.rpm());
}
