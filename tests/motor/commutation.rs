//! Tests of sectors, the commutation table against back-EMF, and the instants of the commutator against a
//! rotor in floating point.

use narx_core::motor::clock::Instant;
use narx_core::motor::commutate::commutation::{LOCKS, STEPS, sector_of};
use narx_core::motor::commutate::commutator::{Commutator, CommutatorCoefficients};
use narx_core::motor::commutate::pwm::Commutations;
use narx_core::motor::{Direction, Leg, Step};
use narx_core::units::ElectricalAngle;
use proptest::prelude::*;
use std::f64::consts::TAU;

const EARLIEST: u16 = 8_192;
const PERIOD: f64 = 65_536.0;

/// Ideal trapezoid, 120 degrees flat; 0 at 0 degrees, rising.
fn trapezoid(degrees: f64) -> f64 {
    let x = degrees.rem_euclid(360.0);
    match x {
        x if x < 30.0 => x / 30.0,
        x if x < 150.0 => 1.0,
        x if x < 210.0 => 1.0 - (x - 150.0) / 30.0,
        x if x < 330.0 => -1.0,
        x => (x - 360.0) / 30.0,
    }
}

/// Torque of a step at an angle, for one ampere: sum of back-EMF shape x phase current.
fn torque(step: Step, degrees: f64, shape: impl Fn(f64) -> f64) -> f64 {
    let legs = step.legs();
    let share = |kind| 1.0 / legs.iter().filter(|leg| **leg == kind).count().max(1) as f64;
    legs.iter()
        .enumerate()
        .map(|(phase, leg)| {
            let current = match leg {
                Leg::Floating => 0.0,
                Leg::Switched => share(Leg::Switched),
                Leg::Low => -share(Leg::Low),
            };
            current * shape(degrees - 120.0 * phase as f64)
        })
        .sum()
}

#[test]
fn every_angle_has_its_sector() {
    for angle in 0..=u16::MAX {
        let degrees = angle as f64 * 360.0 / 65_536.0;
        let expected = ((degrees - 30.0).rem_euclid(360.0) / 60.0).floor() as u8 % 6;
        let found = sector_of(ElectricalAngle(angle));
        let edge = (degrees - 30.0).rem_euclid(60.0);
        assert!(found == expected || !(0.01..59.99).contains(&edge), "{degrees}: {found}");
    }
}

#[test]
fn steps_give_full_torque_in_their_sector() {
    for tenth in 0..3600 {
        let degrees = tenth as f64 / 10.0;
        let sector = sector_of(ElectricalAngle((degrees / 360.0 * 65_536.0) as u16));
        let forward = Step::for_sector(sector, Direction::Forward);
        let reverse = Step::for_sector(sector, Direction::Reverse);
        let within = (degrees - 30.0).rem_euclid(60.0);
        if (0.1..59.9).contains(&within) {
            assert!((torque(forward, degrees, trapezoid) - 2.0).abs() < 1e-9, "{degrees} {forward:?}");
            assert!((torque(reverse, degrees, trapezoid) + 2.0).abs() < 1e-9, "{degrees} {reverse:?}");
            let sine = |x: f64| (x / 360.0 * TAU).sin();
            let best = STEPS.iter().map(|step| torque(*step, degrees, sine)).fold(f64::MIN, f64::max);
            assert!(torque(forward, degrees, sine) >= best - 1e-9, "the best step at {degrees}");
        }
    }
}

#[test]
fn no_step_has_a_leg_switched_and_low_and_locks_pull_where_they_say() {
    for step in Step::ALL {
        let legs = step.legs();
        let driven = legs.iter().filter(|leg| **leg != Leg::Floating).count();
        assert!(if step == Step::Coast { driven == 0 } else { driven >= 2 });
        if step != Step::Coast {
            assert!(legs.contains(&Leg::Switched) && legs.contains(&Leg::Low), "{step:?}");
        }
    }
    let sine = |x: f64| (x / 360.0 * TAU).sin();
    let stable = |step, at: f64| {
        torque(step, at, sine).abs() < 1e-9
            && torque(step, at - 5.0, sine) > 0.0
            && torque(step, at + 5.0, sine) < 0.0
    };
    for (k, lock) in LOCKS.into_iter().enumerate() {
        assert!(stable(lock, 60.0 * k as f64), "{lock:?}");
    }
    for (s, step) in STEPS.into_iter().enumerate() {
        assert!(stable(step, 150.0 + 60.0 * s as f64), "{step:?}");
        assert_eq!(step.sector(), Some(s as u8));
        assert_eq!(Step::for_sector(s as u8, Direction::Reverse), STEPS[(s + 3) % 6]);
    }
}

/// A rotor in 2^-32 turn with exact arithmetic, beside the commutator.
struct Run {
    angle: u64,
    commutator: Commutator,
    step: Option<Step>,
    changes: u64,
    /// Largest |instant - exact| in periods, of changes that are forced neither to `earliest` nor to the
    /// period's end.
    error: f64,
    /// Largest distance of a forced change from its exact instant, periods.
    forced: f64,
}

impl Run {
    fn new(angle: u32) -> Self {
        Self {
            angle: angle as u64,
            commutator: Commutator::default(),
            step: None,
            changes: 0,
            error: 0.0,
            forced: 0.0,
        }
    }

    /// Runs one period: checks every change of pattern against its boundary.
    fn tick(&mut self, speed: i32, torque: Direction) {
        let c = CommutatorCoefficients { earliest: EARLIEST, advance: 0 };
        let (first, commutations) = self.commutator.step(&c, self.angle as u32, speed, torque);
        let mut changes = vec![(EARLIEST, first)];
        changes.extend(commutations.iter().map(|change| (change.instant, change.step)));
        let mut last = EARLIEST;
        for (instant, step) in changes {
            assert!(instant >= last, "instants in order, none before earliest");
            last = instant;
            if let Some(before) = self.step.filter(|before| *before != step) {
                self.changed(before, step, instant, speed, torque);
            }
            self.step = Some(step);
        }
        self.angle = self.angle.wrapping_add_signed(speed as i64);
    }

    fn changed(&mut self, before: Step, step: Step, instant: u16, speed: i32, torque: Direction) {
        self.changes += 1;
        let sector = |step: Step| match torque {
            Direction::Forward => step.sector().unwrap(),
            Direction::Reverse => (step.sector().unwrap() + 3) % 6,
        };
        let turned = if speed >= 0 { 1 } else { 5 };
        assert_eq!((sector(before) + turned) % 6, sector(step), "no boundary lost or doubled");
        // The boundary between the two that is nearest to the rotor.
        let entered = if speed >= 0 { sector(step) } else { sector(before) };
        let boundary = (30.0 + 60.0 * entered as f64) / 360.0;
        let angle = (self.angle as u32) as f64 / 4_294_967_296.0;
        let distance = (boundary - angle + 0.5).rem_euclid(1.0) - 0.5;
        let exact = distance * 4_294_967_296.0 / speed as f64;
        let found = instant as f64 / PERIOD;
        if instant == EARLIEST || instant == u16::MAX {
            self.forced = self.forced.max((found - exact).abs());
        } else {
            self.error = self.error.max((found - exact).abs());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// At constant speed in both directions, up to two ticks per sector and from any angle, no boundary is
    /// lost or doubled in 20 000 ticks.
    #[test]
    fn constant_speed(angle: u32, speed in 20_000..357_000_000_i32, back: bool, plug: bool) {
        let speed = if back { -speed } else { speed };
        let torque = if back == plug { Direction::Forward } else { Direction::Reverse };
        let mut run = Run::new(angle);
        for _ in 0..20_000 {
            run.tick(speed, torque);
        }
        prop_assert!(run.error <= 1e-3, "{} periods off", run.error);
        // Moved to the nearer of the period's end and `earliest`: at most half of the blind start, and
        // rounding.
        prop_assert!(run.forced <= EARLIEST as f64 / PERIOD / 2.0 + 1e-3, "{}", run.forced);
        let sectors = 20_000.0 * speed.unsigned_abs() as f64 / 4_294_967_296.0 * 6.0;
        // One boundary at either end, and those passed in the first period before `earliest`, which are not
        // yet distinguished.
        let blind = EARLIEST as f64 / PERIOD * sectors / 20_000.0;
        prop_assert!((run.changes as f64 - sectors).abs() <= 1.0 + blind + 1e-3, "{} of {sectors}", run.changes);
    }

    /// With slowly varying speed and an angle that starts just before it wraps, no boundary is lost or
    /// doubled.
    #[test]
    fn slowly_varying_speed(
        before_wrap in 0..5000_u32,
        walk in prop::collection::vec(-1.0..1.0_f64, 40),
        start in 1e6..3e8_f64,
        back: bool,
    ) {
        let mut run = Run::new(u32::MAX - before_wrap);
        let mut speed = start;
        let mut travelled = 0.0;
        for slope in walk {
            for _ in 0..250 {
                // At most 0.1 % per tick.
                speed = (speed * (1.0 + slope * 1e-3)).clamp(1e6, 3.57e8);
                let signed = if back { -(speed as i32) } else { speed as i32 };
                run.tick(signed, if back { Direction::Reverse } else { Direction::Forward });
                travelled += speed.trunc();
            }
        }
        prop_assert!(run.error <= 1e-3, "{} periods off", run.error);
        prop_assert!((run.changes as f64 - travelled / 4_294_967_296.0 * 6.0).abs() <= 1.01);
    }

    /// For any angle and any speed the instants are in range and in order.
    #[test]
    fn arbitrary_input(
        rotor in prop::collection::vec((any::<u32>(), any::<i32>()), 1..20),
        earliest: u16,
        advance: u32,
    ) {
        let c = CommutatorCoefficients { earliest, advance };
        let mut commutator = Commutator::default();
        for (angle, speed) in rotor {
            let (first, commutations) = commutator.step(&c, angle, speed, Direction::Forward);
            prop_assert!(first.sector().is_some());
            let mut last = earliest;
            for change in commutations.iter() {
                prop_assert!(change.instant >= last);
                last = change.instant;
            }
        }
    }
}

proptest! {
    /// A rotor that turns on as before, after any leap, changes nothing until the tick in which the
    /// commutator must run again.
    #[test]
    fn nothing_changes_while_the_commutator_rests(
        earliest in 0..40_000_u16, advance in 0..1_u32 << 28, torque in prop::bool::ANY,
        rotor in prop::collection::vec((any::<u32>(), prop_oneof![-(1 << 27)..1 << 27, any::<i32>()]), 1..20),
    ) {
        let c = CommutatorCoefficients { earliest, advance };
        let torque = if torque { Direction::Forward } else { Direction::Reverse };
        let mut commutator = Commutator::default();
        for (start, speed) in rotor {
            let (first, changes) = commutator.step(&c, start, speed, torque);
            let present = changes.last().map_or(first, |change| change.step);
            let (mut on, mut angle) = (commutator, start);
            prop_assert!(commutator.ticks_left() > 0, "never before the next tick");
            for tick in 1..commutator.ticks_left().min(51) {
                angle = angle.wrapping_add_signed(speed);
                let (first, changes) = on.step(&c, angle, speed, torque);
                prop_assert_eq!((first, changes.is_empty()), (present, true), "tick {}", tick);
            }
        }
    }

    /// A commutator that runs only when its rest is over, or when speed or torque has changed, gives in every
    /// tick the pattern of one that runs in every tick.
    #[test]
    fn a_commutator_that_is_asked_when_due_is_one_that_looks(
        earliest in 0..40_000_u16, advance in 0..1_u32 << 28, start: u32,
        rotor in prop::collection::vec((prop_oneof![-(1 << 27)..1 << 27, any::<i32>()], prop::bool::ANY, 1..200_u32), 1..10),
    ) {
        let c = CommutatorCoefficients { earliest, advance };
        let (mut sleeps, mut looks) = (Commutator::default(), Commutator::default());
        let (mut now, mut angle) = (Instant::default(), start);
        for (speed, torque, ticks) in rotor {
            let torque = if torque { Direction::Forward } else { Direction::Reverse };
            let mut due = now;
            for tick in 0..ticks {
                now = now.next();
                angle = angle.wrapping_add_signed(speed);
                let expected = looks.step(&c, angle, speed, torque);
                let found = if due.is_due(now) {
                    let found = sleeps.step(&c, angle, speed, torque);
                    due = now.after(sleeps.ticks_left());
                    found
                } else {
                    (sleeps.present(), Commutations::NONE)
                };
                prop_assert_eq!(found, expected, "speed {}, tick {}", speed, tick);
            }
        }
    }
}

#[test]
fn a_rotor_at_rest_does_not_commutate() {
    let c = CommutatorCoefficients { earliest: EARLIEST, advance: 0 };
    for angle in (0..=u32::MAX).step_by(1 << 20) {
        let mut commutator = Commutator::default();
        let (first, commutations) = commutator.step(&c, angle, 0, Direction::Forward);
        assert_eq!(commutations.iter().count(), 0);
        assert_eq!(first, STEPS[sector_of(ElectricalAngle((angle >> 16) as u16)) as usize]);
    }
}

/// An advance of 15 degrees commutates 15 degrees earlier, in either direction.
#[test]
fn advance_looks_ahead() {
    let c = CommutatorCoefficients { earliest: EARLIEST, advance: ((15_u64 << 32) / 360) as u32 };
    let at = |degrees: f64| (degrees / 360.0 * 4_294_967_296.0) as u32;
    let speed = at(1.0) as i32;
    let step =
        |degrees: f64, speed: i32| Commutator::default().step(&c, at(degrees), speed, Direction::Forward).0;
    assert_eq!(step(74.0, speed), Step::AB);
    assert_eq!(step(75.5, speed), Step::AC);
    assert_eq!(step(46.0, -speed), Step::AB);
    assert_eq!(step(44.5, -speed), Step::CB);
}
