//! Tests of the blocks, each alone, as a student or the owner of another driver links them.

use crate::rotor::{ScriptedRotor, error_degrees, sector_at};
use narx_core::blocks::{
    Commutation, CommutationSettings, Fault, FaultSettings, Hall, HallSettings, Pi, PiSettings, Position,
    Ramp, RampSettings, StateMachine, StateSettings, ZeroCrossing, ZeroCrossingSettings,
};
use narx_core::motor::gain::Gain;
use narx_core::motor::guard::protection::Evidence;
use narx_core::motor::guard::rails::Rail;
use narx_core::motor::machine::event::{Command, Health};
use narx_core::motor::machine::state::TRANSITIONS;
use narx_core::motor::machine::{Change, Inputs};
use narx_core::motor::rotor::zero_crossing::Why;
use narx_core::motor::sense::front_end::Channel;
use narx_core::motor::{
    Cause, Direction, FaultWord, Leg, PwmCommand, RunRequest, SampleMode, Samples, State, Step,
};
use narx_core::units::{Amps, ElectricalSpeed, Volts};
use proptest::prelude::*;

const ONE: i32 = 1 << 16;

/// Settings of a PI: Kp = 2, Ki = 10 per second, 1 kHz, -5 to 5.
fn pi() -> PiSettings {
    let gain = |numerator| Gain::from_ratio(numerator, 1).unwrap();
    PiSettings {
        proportional: gain(2),
        integral: gain(10),
        step_rate: 1000,
        minimum: -5 * ONE,
        maximum: 5 * ONE,
    }
}

fn real(raw: i32) -> f64 {
    f64::from(raw) / 65_536.0
}

#[test]
fn pi_is_its_equation() {
    let mut pi = Pi::build(&pi()).unwrap();
    for n in 1..=150 {
        // u = Kp e + Ki e t
        let expected = 2.0 + 10.0 * f64::from(n) / 1000.0;
        assert!((real(pi.step(ONE)) - expected).abs() < 2e-5, "step {n}");
    }
    // The integrator is at 1.5: the output without an error begins there.
    assert!((real(pi.step(0)) - 1.5).abs() < 2e-5);
    pi.hold(-3 * ONE);
    assert_eq!(pi.step(0), -3 * ONE);
}

/// Ten seconds at the limit wind nothing up: the first error of opposite sign leaves the limit.
#[test]
fn pi_leaves_its_limit_at_once() {
    let mut pi = Pi::build(&pi()).unwrap();
    for _ in 0..10_000 {
        assert!(pi.step(ONE) <= 5 * ONE);
    }
    assert_eq!(pi.step(ONE), 5 * ONE);
    assert!(pi.step(-ONE / 10) < 5 * ONE);
    // Something else has decided 1: the controller goes on from there.
    for _ in 0..200 {
        pi.track(ONE, 0);
    }
    assert!((pi.step(0) - ONE).abs() <= 1);
}

#[test]
fn ramp_takes_its_time() {
    let mut ramp = Ramp::build(&RampSettings { rate: 10 * ONE, step_rate: 1000 }).unwrap();
    for n in 1..=200 {
        let expected = f64::from(n.min(100)) / 100.0;
        assert!((real(ramp.step(ONE)) - expected).abs() < 2e-5, "step {n}");
    }
    assert_eq!(ramp.value(), ONE);
    ramp.set(-ONE);
    assert!((real(ramp.step(ONE)) + 0.99).abs() < 2e-5);
}

proptest! {
    #[test]
    fn no_input_leaves_the_limits(
        errors in prop::collection::vec(any::<i32>(), 1..200), low in any::<i32>(), high in any::<i32>(),
    ) {
        let (minimum, maximum) = (low.min(high), low.max(high));
        let mut pi = Pi::build(&PiSettings { minimum, maximum, ..pi() }).unwrap();
        for error in errors {
            prop_assert!((minimum..=maximum).contains(&pi.step(error)));
        }
    }

    #[test]
    fn a_ramp_never_steps_further_than_its_rate(
        targets in prop::collection::vec(any::<i32>(), 1..50), rate in 1..i32::MAX, step_rate in 1..=65_536_u32,
    ) {
        let mut ramp = Ramp::build(&RampSettings { rate, step_rate }).unwrap();
        for target in targets {
            let before = i64::from(ramp.value());
            let after = i64::from(ramp.step(target));
            prop_assert!((after - before).abs() <= i64::from(rate) / i64::from(step_rate) + 1);
            prop_assert!(after.abs_diff(target.into()) <= before.abs_diff(target.into()));
        }
    }
}

fn position(turns: f64, frequency: f64) -> Position {
    const TURN: f64 = 4_294_967_296.0;
    Position {
        angle: (turns.rem_euclid(1.0) * TURN) as u32,
        speed: (frequency / 10_000.0 * TURN) as i64 as i32,
    }
}

/// In a turn at 40 rev/s in either direction every sector gets its step, and the change is where the rotor is
/// 30 degrees (less the advance) from the sector's middle.
#[test]
fn commutation_changes_where_the_sectors_do() {
    for (frequency, torque, advance) in [
        (40.0, Direction::Forward, 0),
        (40.0, Direction::Forward, 1500),
        (-40.0, Direction::Reverse, 0),
        (-40.0, Direction::Reverse, 700),
        (40.0, Direction::Reverse, 0),
    ] {
        let settings = CommutationSettings { advance_cdeg: advance, earliest: 8192 };
        let mut commutation = Commutation::build(&settings).unwrap();
        let (mut angle, mut present, mut changes) = (0.2, Step::Coast, 0);
        for _ in 0..250 {
            let (step, commutations) = commutation.step(position(angle, frequency), torque);
            let first = (step != present && present != Step::Coast).then_some((settings.earliest, step));
            let later = commutations.iter().map(|change| (change.instant, change.step));
            present = step;
            for (instant, step) in first.into_iter().chain(later) {
                let here = angle + frequency / 10_000.0 * f64::from(instant) / 65_536.0;
                let ahead = here + f64::from(advance) / 36_000.0 * frequency.signum();
                // Just beyond the boundary, within the tolerance that 1/65 536 of a period and the blind
                // start allow.
                let nudge = 0.003 * frequency.signum();
                assert_eq!(step, Step::for_sector(sector_at(ahead + nudge), torque));
                assert_ne!(step, Step::for_sector(sector_at(ahead - nudge), torque));
                (present, changes) = (step, changes + 1);
            }
            let legs = present.legs();
            let count = |leg| legs.iter().filter(|other| **other == leg).count();
            assert_eq!([Leg::Switched, Leg::Low, Leg::Floating].map(count), [1, 1, 1]);
            assert_eq!(present.floating().map(|phase| legs[phase as usize]), Some(Leg::Floating));
            angle += frequency / 10_000.0;
        }
        assert_eq!(changes, 6, "{frequency} rev/s");
        // A rotor at the same position with the opposite torque has the opposite step at once.
        let other = if torque == Direction::Forward { Direction::Reverse } else { Direction::Forward };
        let sector = sector_at(angle + f64::from(advance) / 36_000.0 * frequency.signum());
        let mut here = |torque| commutation.step(position(angle, frequency), torque).0;
        assert_eq!(
            [here(torque), here(other)],
            [torque, other].map(|torque| Step::for_sector(sector, torque))
        );
    }
}

#[test]
fn hall_measures_angle_and_speed() {
    // Without capture an edge is known to a tick, 5.4 degrees.
    for (frequency, captured, limit, off) in
        [(150.0, true, 0.1, 1e-3), (-150.0, true, 0.1, 1e-3), (150.0, false, 6.0, 0.05)]
    {
        let settings = HallSettings { captured, timeout_ms: 50, ..HallSettings::default() };
        let mut hall = Hall::build(&settings).unwrap();
        let mut rotor = ScriptedRotor::new(0.3, frequency, captured);
        let mut samples = Samples::default();
        for tick in 0..600 {
            rotor.advance(&mut samples);
            let reading = hall.step(samples.hall, &samples.edges);
            if tick > 200 {
                let speed = real(reading.speed.to_bits());
                assert!((speed / frequency - 1.0).abs() < off, "{speed} rev/s, not {frequency}");
                assert!(error_degrees(reading.position.angle, rotor.angle).abs() < limit);
                assert!(!reading.stopped && !reading.doubtful);
            }
        }
        // The rotor stops at once: standstill is detected after 50 ms, and the speed falls before.
        let before = hall.step(samples.hall, &[]).speed.abs();
        let after = (0..400).map(|_| hall.step(samples.hall, &[])).last().unwrap();
        assert!(after.speed.abs() < before && !after.stopped);
        let stopped = (0..101).map(|_| hall.step(samples.hall, &[])).last().unwrap();
        assert!(stopped.stopped && stopped.speed == ElectricalSpeed::ZERO);
        for _ in 0..3 {
            assert!(hall.step(7, &[]).events.invalid);
        }
        assert!(hall.step(7, &[]).doubtful);
        assert_eq!(hall.diagnostics().invalid, 1, "lost once, however long");
    }
}

/// With a rotor at constant speed, whose terminals follow the pattern that the two blocks apply, the blocks
/// find the crossings and commutate 30 degrees later.
#[test]
fn zero_crossing_and_commutation_follow_a_motor() {
    for (frequency, torque) in [(120.0, Direction::Forward), (-120.0, Direction::Reverse)] {
        // Codes are millivolts.
        let scale = Channel { zero: 0, micro_per_code: 1000 };
        let settings = ZeroCrossingSettings {
            terminal: scale,
            bus_voltage: scale,
            noise_codes: 40,
            timeout_ticks: 300,
            ..ZeroCrossingSettings::default()
        };
        let mut crossings = ZeroCrossing::build(&settings).unwrap();
        let mut commutation = Commutation::build(&settings.commutation).unwrap();
        let mut angle: f64 = 1.0 / 3.0;
        crossings.start(position(angle, 0.0).angle, torque);
        let mut applied = PwmCommand { sample_mode: SampleMode::OnTime, ..PwmCommand::default() };
        let (mut worst, mut predicted) = (0.0_f64, None);
        for tick in 0..2000 {
            angle += frequency / 10_000.0;
            let step = applied.commutations.last().map_or(applied.step, |last| last.step);
            let samples = terminals(step, angle, 24.0, 6.0 * frequency.signum());
            let reading = crossings.step(&samples, &applied, torque);
            let (step, commutations) = commutation.step(reading.position, torque);
            (applied.step, applied.commutations) = (step, commutations);
            assert_eq!(reading.lost, Rail::None);
            if tick < 300 {
                continue;
            }
            assert!(reading.running && reading.why == Why::Accepted, "tick {tick}");
            assert!((real(reading.speed.to_bits()) / frequency - 1.0).abs() < 0.02);
            worst = worst.max(error_degrees(reading.position.angle, angle).abs());
            // The announced commutation happens, in this tick or later.
            let announced = f64::from(tick) + f64::from(reading.commutation.unwrap()) / 65_536.0;
            if let (Some(change), Some(predicted)) = (commutations.last(), predicted) {
                let done = f64::from(tick) + f64::from(change.instant) / 65_536.0;
                let off: f64 = done - predicted;
                assert!(off.abs() < 0.25, "commutated {off} ticks beside its announcement");
            }
            predicted = Some(announced);
        }
        assert!(worst < 3.0, "{worst} degrees");
        // The rotor is gone: the terminals show nothing for the time-out.
        let still = Samples { bus_voltage: 24_000, sample_mode: SampleMode::OnTime, ..Samples::default() };
        let lost =
            (0..400).map(|_| crossings.step(&still, &applied, torque).lost).find(|lost| *lost != Rail::None);
        assert_eq!(lost, Some(Rail::Stall));
        assert!(!crossings.step(&still, &applied, torque).running);
    }
}

/// Terminals with a sinusoidal back-EMF of `peak` volts behind a pattern in the on-time.
fn terminals(step: Step, turns: f64, bus: f64, peak: f64) -> Samples {
    let emf = |phase: usize| peak * ((turns - phase as f64 / 3.0) * core::f64::consts::TAU).sin();
    let legs = step.legs();
    let phase_voltage = core::array::from_fn(|phase| {
        let volts = match legs[phase] {
            Leg::Low => 0.0,
            Leg::Switched => bus,
            Leg::Floating => bus / 2.0 + 1.5 * emf(phase),
        };
        (volts.clamp(0.0, bus) * 1000.0) as u16
    });
    Samples {
        phase_voltage,
        bus_voltage: (bus * 1000.0) as u16,
        sample_mode: SampleMode::OnTime,
        ..Samples::default()
    }
}

fn healthy() -> Evidence {
    let mut evidence = Evidence { driving: true, ..Evidence::default() };
    evidence.measured.bus_voltage = Volts::from_milli(48_000);
    evidence
}

/// Function that makes a condition true.
type Spoil = fn(&mut Evidence);

/// A condition qualifies after its published time, latches, and is acknowledged once it has gone.
#[test]
fn fault_qualifies_latches_and_is_acknowledged() {
    let cases: [(Cause, Spoil); 4] = [
        (Cause::UnderVoltage, |e| e.measured.bus_voltage = Volts::from_milli(10_000)),
        (Cause::OverCurrent, |e| e.measured.bus_current = Amps::from_milli(-9_000)),
        (Cause::OverVoltage, |e| e.measured.bus_voltage = Volts::from_milli(61_500)),
        (Cause::DriverLine, |e| e.lines = narx_core::motor::Lines::DRIVER_FAULT),
    ];
    for (cause, spoil) in cases {
        let mut fault = Fault::build(&FaultSettings::default()).unwrap();
        let mut bad = healthy();
        spoil(&mut bad);
        // 100 us a tick.
        let ticks = cause.qualification().div_ceil(100).max(1);
        for tick in 1..=ticks {
            assert_eq!(fault.step(&bad), tick == ticks, "{cause:?} at tick {tick}");
        }
        assert_eq!((fault.word(), fault.code()), (cause.bit(), cause as u16));
        assert!(!fault.acknowledge(), "{cause:?} is still there");
        assert!(!fault.step(&healthy()));
        assert_eq!(fault.critical(), cause.bit(), "latched");
        assert!(fault.acknowledge());
        assert_eq!((fault.word(), fault.code()), (FaultWord::empty(), 0));
    }
}

/// The fault block follows the state machine beside it: a time-out and a failed boot latch, leaving Fault
/// acknowledges, and events of the hall sensors count within a driven episode only.
#[test]
fn fault_follows_the_state_machine() {
    let built = || Fault::build(&FaultSettings { hall_stall_ms: 10, ..FaultSettings::default() }).unwrap();
    let change = |name, timed_out| {
        let row = TRANSITIONS.iter().find(|row| row.to_string() == name).unwrap();
        Change { row, timed_out }
    };
    let failed = Health { self_test_failed: true, ..Health::default() };
    let unhealthy = Evidence { health: failed, ..healthy() };
    let nothing = FaultWord::empty();
    for (name, timed_out, latched) in [
        ("T56", true, Cause::CommandTimeout.bit()),
        ("T56", false, nothing),
        ("T06", false, Cause::SelfTest.bit()),
        ("T16", false, nothing),
    ] {
        let mut fault = built();
        fault.handle_change(&change(name, timed_out), &unhealthy);
        assert_eq!(fault.critical(), latched, "{name}");
    }
    for (name, left) in [("T61", nothing), ("T51", Cause::CommandTimeout.bit())] {
        let mut fault = built();
        fault.handle_change(&change("T56", true), &healthy());
        fault.handle_change(&change(name, false), &healthy());
        assert_eq!(fault.critical(), left, "{name}");
    }
    // A tick before the stall qualifies: either both halves drive, or one of them does not.
    let still = Evidence { hall_driving: true, hall_stopped: true, torque: true, ..healthy() };
    for (name, stalls) in [("T23", true), ("T15", false), ("T51", false)] {
        let mut fault = built();
        for _ in 0..99 {
            fault.step(&still);
        }
        assert_eq!(fault.word(), nothing);
        fault.handle_change(&change(name, false), &still);
        fault.step(&still);
        assert_eq!(fault.word().contains(Cause::HallStall.bit()), stalls, "{name}");
    }
}

/// Power-up, a start, a stop, a silent master and an acknowledgement follow the rows of Table 7 in order.
#[test]
fn state_machine_goes_through_its_table() {
    let mut machine = StateMachine::build(&StateSettings::default()).unwrap();
    let well = Inputs {
        critical: false,
        unhealthy: false,
        causes_gone: true,
        stopped: true,
        calibrated: false,
        parameters_fit: true,
    };
    let mut rows = Vec::new();
    // Milliseconds, request (repeated every 100 ms), expected state.
    for (time, request, state) in [
        (501, Some(RunRequest::Standby), State::Standby),
        (200, Some(RunRequest::Drive), State::HallClosedLoop),
        (200, Some(RunRequest::Standby), State::Standby),
        (200, Some(RunRequest::Reverse), State::HallClosedLoop),
        (149, None, State::HallClosedLoop),
        (2, None, State::Fault),
        (600, None, State::Fault),
        (100, Some(RunRequest::Standby), State::Standby),
    ] {
        for tick in 0..time * 10 {
            if let Some(request) = request.filter(|_| tick % 1000 == 0) {
                machine.handle_command(Command { request, speed: ElectricalSpeed::ZERO });
            }
            rows.extend(machine.step(&well).map(|change| change.row.to_string()));
        }
        assert_eq!(machine.state(), state, "after {request:?} for {time} ms");
    }
    assert_eq!(rows, ["T01", "T15", "T51", "T15", "T56", "T61"]);
    assert_eq!(machine.direction(), Direction::Reverse);
}

/// Each message names the setting, its value and its range.
#[test]
fn settings_out_of_range_are_named() {
    let pi_of = |change: fn(&mut PiSettings)| {
        let mut settings = pi();
        change(&mut settings);
        Pi::build(&settings).unwrap_err().to_string()
    };
    let hall = |settings: HallSettings| Hall::build(&settings).unwrap_err().to_string();
    let crossing = |settings: ZeroCrossingSettings| ZeroCrossing::build(&settings).unwrap_err().to_string();
    let advance = CommutationSettings { advance_cdeg: 3001, earliest: 0 };
    let messages = [
        pi_of(|s| s.step_rate = 0),
        pi_of(|s| s.minimum = 6 * ONE),
        pi_of(|s| s.integral = Gain::new(3, 62).unwrap()),
        Ramp::build(&RampSettings { rate: 0, step_rate: 100_000 }).unwrap_err().to_string(),
        Commutation::build(&advance).unwrap_err().to_string(),
        hall(HallSettings { tick_rate: 999, ..HallSettings::default() }),
        hall(HallSettings { order: 6, ..HallSettings::default() }),
        hall(HallSettings { timeout_ms: 7000, ..HallSettings::default() }),
        hall(HallSettings {
            interpolation_min: ElectricalSpeed::from_milli(-500),
            ..HallSettings::default()
        }),
        crossing(ZeroCrossingSettings { noise_codes: 0, ..ZeroCrossingSettings::default() }),
        crossing(ZeroCrossingSettings { commutation: advance, ..ZeroCrossingSettings::default() }),
        Fault::build(&FaultSettings { under_voltage: Volts::from_milli(60_500), ..FaultSettings::default() })
            .unwrap_err()
            .to_string(),
        StateMachine::build(&StateSettings { lock_ms: 3_600_001, ..StateSettings::default() })
            .unwrap_err()
            .to_string(),
    ];
    insta::assert_snapshot!(messages.join("\n"));
}
