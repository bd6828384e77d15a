//! The short ways of the stations, which a running motor takes in most ticks: each does what the long way does, or refuses and changes nothing.

use crate::support::coefficients;
use narx_core::motor::back_emf::{BackEmf, BackEmfCoefficients, Crossing, OperatingPoint, Sight};
use narx_core::motor::commutator::{Commutator, CommutatorCoefficients};
use narx_core::motor::front_end::Channel;
use narx_core::motor::gain::Gain;
use narx_core::motor::measurement::ChannelScale;
use narx_core::motor::sensorless::{Sensorless, SensorlessCoefficients};
use narx_core::motor::zero_crossing::{PREPARED, Why, ZeroCrossing};
use narx_core::motor::{Direction, PwmCommand, SampleMode, Samples, Step};
use proptest::prelude::*;

const TICK: u32 = 1 << 16;

fn direction() -> impl Strategy<Value = Direction> {
    prop_oneof![4 => Just(Direction::Forward), 1 => Just(Direction::Reverse)]
}

/// The same rotor again for so many ticks: the commutator is at rest.
fn assert_goes_on(
    mut commutator: Commutator,
    c: &CommutatorCoefficients,
    rotor: (u32, i32, Direction),
    ticks: u32,
) {
    let (mut angle, speed, torque) = rotor;
    let present = commutator.present();
    for tick in 1..=ticks.min(50) {
        angle = angle.wrapping_add(speed as u32);
        let (first, changes) = commutator.step(c, angle, speed, torque);
        assert_eq!((first, changes.is_empty()), (present, true), "tick {tick} of {ticks}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// A rotor that turns, leaps, and changes its speed, and a torque that turns round: whoever knows where the boundary is need not look for it.
    #[test]
    fn a_commutator_that_passes_or_follows_is_one_that_looks(
        start: u32, earliest in 0..40_000_u16, advance in 0..1_u32 << 28,
        rotor in prop::collection::vec(
            (0..3_u8, prop_oneof![3 => Just(0_i32), 1 => -(1 << 26)..1 << 26, 1 => any::<i32>()], prop::option::weighted(0.2, -(1_i32 << 27)..1 << 30), direction()),
            1..80,
        ),
    ) {
        let c = CommutatorCoefficients { earliest, advance };
        let (mut commutator, mut angle, mut speed) = (Commutator::default(), start, 1 << 26);
        for (way, leap, other, torque) in rotor {
            speed = other.unwrap_or(speed);
            angle = angle.wrapping_add(speed as u32).wrapping_add(leap as u32);
            let before = commutator;
            let mut is_taken = true;
            let mut long = before;
            let (first, changes) = long.step(&c, angle, speed, torque);
            match way {
                0 => match commutator.pass(&c, angle, speed, torque) {
                    None => {
                        prop_assert_eq!(commutator, before);
                        is_taken = false;
                    }
                    Some((change, ticks)) => {
                        prop_assert_eq!(first, before.present());
                        prop_assert_eq!(changes.last(), Some(change));
                        prop_assert_eq!(commutator, long);
                        assert_goes_on(commutator, &c, (angle, speed, torque), ticks);
                    }
                },
                1 => match commutator.follow(&c, angle, speed, torque) {
                    None => {
                        prop_assert_eq!(commutator, before);
                        is_taken = false;
                    }
                    Some(ticks) => {
                        prop_assert_eq!((first, changes.is_empty()), (before.present(), true));
                        prop_assert_eq!(commutator, long);
                        assert_goes_on(commutator, &c, (angle, speed, torque), ticks);
                    }
                },
                _ => commutator = long,
            }
            if is_taken {
                assert_goes_on(commutator, &c, (angle, speed, torque), commutator.calm(angle, speed));
            }
            prop_assert_eq!(commutator.calm(angle, speed ^ 1), 0, "at another speed nothing is known");
        }
    }
}

/// Codes are millivolts.
fn back_emf_coefficients() -> BackEmfCoefficients {
    let terminal = ChannelScale::new(Channel { zero: 0, micro_per_code: 1_000 }, 0);
    BackEmfCoefficients { terminal, noise: 5_120, discard: TICK, earliest: 8_192, ..Default::default() }
}

/// Step AB on 24 V, whose floating phase C falls through half of it at tick 6.
fn falling(tick: u32, sample_mode: SampleMode) -> Samples {
    let floating = 12_000 + 300 * (6 - i64::from(tick));
    Samples { phase_voltage: [24_000, 0, floating as u16], sample_mode, ..Samples::default() }
}

const BUS: i32 = 24 << 16;

fn applied(step: Step) -> PwmCommand {
    PwmCommand { step, ..PwmCommand::default() }
}

/// Every tick of a step up to its crossing, with the station before it; and the crossing.
fn step_of_a_running_motor() -> (Vec<(u32, BackEmf)>, Crossing) {
    let c = back_emf_coefficients();
    let point = OperatingPoint { torque: Direction::Forward, interval: 12 * TICK, emf: 0 };
    let mut back_emf = BackEmf::default();
    back_emf.step(&c, &falling(0, SampleMode::OnTime), BUS, &applied(Step::CB), &point);
    let mut ticks = Vec::new();
    for tick in 1..20 {
        let samples = falling(tick, SampleMode::OnTime);
        if let Some(crossing) = back_emf.crosses(&c, &samples, &applied(Step::AB)) {
            return (ticks, crossing);
        }
        ticks.push((tick, back_emf));
        // As a running motor takes it: where one comparison does, by that.
        let is_taken = back_emf.passes(&c, &samples, &applied(Step::AB)) == Some(true)
            || back_emf.nears(&c, &samples, &applied(Step::AB)).is_some();
        if !is_taken && !back_emf.passes_at_all(&c, &samples, BUS, &applied(Step::AB)) {
            back_emf.step(&c, &samples, BUS, &applied(Step::AB), &point);
        }
    }
    panic!("no crossing");
}

/// Whatever the back-EMF station takes by a short way is no news to the long one; another step and another instant of sampling are for that alone.
#[test]
fn a_sample_that_passes_is_no_news() {
    let c = back_emf_coefficients();
    let point = OperatingPoint { torque: Direction::Forward, interval: 12 * TICK, emf: 0 };
    let (ticks, _) = step_of_a_running_motor();
    let (mut passed, mut near) = (0, 0);
    for (tick, before) in ticks {
        let samples = falling(tick, SampleMode::OnTime);
        let mut long = before;
        let sight = long.step(&c, &samples, BUS, &applied(Step::AB), &point);
        let mut short = before;
        if short.passes_at_all(&c, &samples, BUS, &applied(Step::AB)) {
            passed += 1;
            assert_eq!((sight.crossing, sight.late, sight.missed), (None, false, false), "{tick}");
        } else {
            assert_eq!(short, before, "{tick}");
        }
        let mut short = before;
        if let Some(seen) = short.nears(&c, &samples, &applied(Step::AB)) {
            near += 1;
            assert_eq!((seen.crossing, seen.level), (sight.crossing, sight.level), "{tick}");
        }
        // What is for the long way alone.
        let mut other = before;
        assert!(tick == 1 || !other.passes_at_all(&c, &samples, BUS, &applied(Step::CB)), "{tick}");
        assert!(other.nears(&c, &falling(tick, SampleMode::OffTime), &applied(Step::AB)).is_none(), "{tick}");
        assert_eq!(other, before, "{tick}");
    }
    assert!(passed > 3 && near > 0, "{passed} passed, {near} were near");
}

/// An estimator that runs for so many sectors of 20 ticks each, up to the one before that of step AB.
fn running(crossings: u8, sector: u8) -> ZeroCrossing {
    let mut rotor = ZeroCrossing::default();
    rotor.start(0, Direction::Forward);
    for number in 1..=crossings {
        (0..20).for_each(|_| rotor.advance());
        let seen = (sector + 60 - crossings + number - 1) % 6;
        let sight = Sight { sector: Some(seen), crossing: Some(0), passed: true, ..Sight::default() };
        assert!(rotor.observe(&sight, Gain::ZERO, false));
    }
    rotor
}

/// The ordinary crossing of a running rotor, at its time and in its order: the estimator is where observing takes it. Whatever is wrong with it, it is left alone.
#[test]
fn an_ordinary_crossing_is_one_that_is_observed() {
    let (_, crossing) = step_of_a_running_motor();
    let Crossing { sector, age, threshold, .. } = crossing;
    let sight =
        Sight { sector: Some(sector), crossing: Some(age), threshold, passed: true, ..Sight::default() };
    for (crossings, offset, ticks, is_taken, what) in [
        (12, 0, 20, true, "ordinary"),
        (12, 0, 25, true, "late"),
        (12, 0, 5, false, "far too early"),
        (12, 0, 1 << 13, false, "after so long that its time has no room"),
        (12, 1, 20, false, "of another sector"),
        (5, 0, 20, false, "of a rotor that has not shown a revolution"),
        (PREPARED - 1, 0, 20, false, "one too few"),
    ] {
        let before = running(crossings, sector + offset);
        let mut short = before;
        assert_eq!(short.crosses(&crossing, Gain::ZERO, ticks), is_taken, "{what}");
        if is_taken {
            let mut long = before;
            (0..ticks).for_each(|_| long.advance());
            assert!(long.observe(&sight, Gain::ZERO, false), "{what}");
            assert_eq!(short, long, "{what}");
            assert_eq!(short.why().0, Why::Accepted);
        } else {
            assert_eq!(short, before, "{what}");
        }
    }
}

/// A rotor of which nothing is known yet shows a level that comes too late, or a threshold that is not at 0: neither makes a speed.
#[test]
fn nothing_is_made_of_a_first_sign() {
    let back_emf = Gain::from_ratio(1 << 16, 1).unwrap_or(Gain::ZERO);
    for sight in [
        Sight { sector: Some(1), late: true, passed: true, ..Sight::default() },
        Sight { sector: Some(1), crossing: Some(0), threshold: 1 << 16, passed: true, ..Sight::default() },
    ] {
        let mut rotor = ZeroCrossing::default();
        rotor.start(0, Direction::Forward);
        rotor.advance();
        assert!(rotor.observe(&sight, back_emf, false));
        assert_eq!((rotor.speed(), rotor.is_prepared()), (0, false));
    }
}

/// A sequence that is not in closed loop has no ordinary ticks.
#[test]
fn a_motor_that_does_not_run_has_no_short_ways() {
    let c = coefficients(&[]).sensorless;
    let before = Sensorless::default();
    let mut sensorless = before;
    let samples = falling(30, SampleMode::OnTime);
    assert!(!sensorless.crosses(&c, &samples, &applied(Step::AB), 1));
    assert_eq!(sensorless.calm(&c, Step::AB, Direction::Forward), 0);
    // Nothing has been heard of the rotor for longer than it may be silent.
    assert!(!sensorless.runs_on(&SensorlessCoefficients { timeout: 0, ..c }));
    assert_eq!(sensorless, before);
}
