//! Tests of the hall station alone: sequences, accuracy, glitches, standstill.

use crate::rotor::{ScriptedRotor, code_at, error_degrees, sector_at};
use crate::support::coefficients_on;
use narx_core::dictionary::number;
use narx_core::motor::clock::Instant;
use narx_core::motor::commutate::commutator::Commutator;
use narx_core::motor::rotor::hall::{Hall, HallCoefficients, HallEvents};
use narx_core::motor::{Board, Coefficients, Direction, Edge, EdgeSource, Samples, Step};

/// Factory values, except a time-out of 1 s and interpolation from 10 rpm, so that 1 rev/s can be measured.
fn coefficients(capture: bool) -> Coefficients {
    let board = Board { hall_capture: capture, ..Board::BENCH };
    coefficients_on(&board, &[(number::HALL_PERIOD_TIMEOUT, 1000), (number::HALL_INTERPOLATION_SPEED, 10)])
}

/// A station with its clock.
#[derive(Clone, Copy, Default)]
struct Station {
    hall: Hall,
    now: Instant,
}

impl Station {
    /// Runs the next tick.
    fn next(&mut self, c: &HallCoefficients, samples: &Samples) -> HallEvents {
        self.now = self.now.next();
        self.hall.step(c, self.now, samples)
    }

    fn angle(&self) -> u32 {
        self.hall.angle(self.now)
    }

    fn speed_bounded(&self) -> i32 {
        self.hall.speed_bounded(self.now)
    }
}

/// A station that has seen `turns` revolutions.
fn running(c: &HallCoefficients, rotor: &mut ScriptedRotor, turns: f64) -> Station {
    let mut station = Station::default();
    let mut samples = Samples::default();
    for _ in 0..(turns / rotor.speed.abs()) as u64 {
        rotor.advance(&mut samples);
        station.next(c, &samples);
    }
    station
}

fn level(hall: u8) -> Samples {
    Samples { hall, ..Samples::default() }
}

/// After every sequence of four codes, from every sector and direction, with and without capture, three right
/// samples give the right sector.
#[test]
fn all_sequences_of_four_codes() {
    let mut checked = 0;
    let mut most = 0;
    for (capture, sector, back) in
        [false, true].iter().flat_map(|c| (0..6).flat_map(move |s| [false, true].map(|b| (*c, s, b))))
    {
        let c = coefficients(capture).hall;
        // 20 ticks per sector; ends in the middle of `sector`.
        let frequency = 10_000.0 / 120.0 * if back { -1.0 } else { 1.0 };
        let angle = (sector as f64 + 1.0) / 6.0;
        let mut rotor = ScriptedRotor::new(angle, frequency, capture);
        let start = running(&c, &mut rotor, 3.0);
        assert_eq!(start.hall.sector(), Some(sector), "prepared");
        let here = code_at(angle);
        for sequence in 0..8_u32.pow(4) {
            let codes = [0, 3, 6, 9].map(|shift| (sequence >> shift & 7) as u8);
            let mut station = start;
            let mut turned = 0;
            for code in codes.into_iter().chain([here; 3]) {
                let events = station.next(&c, &level(code));
                turned += events.sectors.unsigned_abs();
                assert!(station.hall.sector().is_some_and(|sector| sector < 6));
                assert_eq!(events.invalid, code == 0 || code == 7);
            }
            // After any sequence three right samples restore the sector.
            assert_eq!(station.hall.sector(), Some(sector), "{codes:?} from sector {sector}");
            let glitches = codes.iter().filter(|code| **code != here).count();
            if glitches == 1 {
                // A sequence moves the sector by two at most: in and out again.
                assert!(turned <= 2, "{codes:?} from sector {sector}: {turned} sectors");
                most = most.max(turned);
            }
            checked += 1;
        }
    }
    println!("{checked} sequences; a single-sample glitch moved at most {most} sectors in all (in and out)");
    assert_eq!(checked, 2 * 12 * 4096);
}

struct Accuracy {
    speed: f64,
    angle_mean: f64,
    angle_worst: f64,
}

fn accuracy(frequency: f64, capture: bool, start: f64) -> Accuracy {
    let c = coefficients(capture);
    let mut rotor = ScriptedRotor::new(start, frequency, capture);
    let mut station = running(&c.hall, &mut rotor, 3.0);
    let mut samples = Samples::default();
    let (mut speed, mut sum, mut worst, mut ticks) = (0.0_f64, 0.0, 0.0_f64, 0);
    for _ in 0..(2.0 / rotor.speed.abs()) as u64 + 50 {
        rotor.advance(&mut samples);
        station.next(&c.hall, &samples);
        let found = c.speed_of_turns.apply32(station.speed_bounded()) as f64 / 65_536.0;
        speed = speed.max((found / frequency - 1.0).abs());
        // Positive: ahead in the direction of motion.
        let error = error_degrees(station.angle(), rotor.angle) * frequency.signum();
        sum += error;
        worst = worst.max(error.abs());
        ticks += 1;
    }
    Accuracy { speed, angle_mean: sum / ticks as f64, angle_worst: worst }
}

/// At 1 to 833 rev/s in both directions, captured edges give the speed within 0.1 % and the angle within 0.1
/// degrees. Levels sampled once a tick give them within half a tick of motion, and the effect of sampling on
/// the length of a sector.
#[test]
fn steady_rotation() {
    println!("rev/s capture: speed error, angle error mean / worst; sampled: the same");
    for frequency in [1.0, 1.7, 5.0, 13.3, 33.3, 70.0, 133.0, 266.7, 400.0, 555.0, 700.0, 833.0] {
        for sign in [1.0, -1.0] {
            let captured = accuracy(frequency * sign, true, 0.9999);
            let sampled = accuracy(frequency * sign, false, 0.0001);
            println!(
                "{:8.1}  {:.4} %  {:7.3} / {:6.3} deg   {:8.3} %  {:7.3} / {:6.3} deg",
                frequency * sign,
                captured.speed * 100.0,
                captured.angle_mean,
                captured.angle_worst,
                sampled.speed * 100.0,
                sampled.angle_mean,
                sampled.angle_worst
            );
            assert!(captured.speed < 1e-3, "{} %", captured.speed * 100.0);
            assert!(captured.angle_worst < 0.1, "{} degrees", captured.angle_worst);
            // A tick of motion. The speed dips by half a tick in a sector while an edge that has happened is
            // not yet seen.
            let tick = 360.0 * frequency / 10_000.0;
            assert!(sampled.angle_mean.abs() < 0.6 * tick + 0.1, "{} degrees", sampled.angle_mean);
            assert!(sampled.angle_worst < 0.8 * tick + 0.3, "{} degrees", sampled.angle_worst);
            assert!(sampled.speed < 3.1 * frequency / 10_000.0 + 1e-3, "{} %", sampled.speed * 100.0);
        }
    }
}

/// Kind of a glitch.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Glitch {
    /// One sample of the level.
    Level,
    /// A pulse that the capture sees: two edges within the period.
    Pulse,
}

/// Number of ticks in which the pattern differs from that of an undisturbed run after one glitch, in all and
/// in a row.
fn disturbed(c: &Coefficients, rotor: &ScriptedRotor, start: Station, code: u8, kind: Glitch) -> (u32, u32) {
    let torque = if rotor.speed > 0.0 { Direction::Forward } else { Direction::Reverse };
    let mut rotor = rotor.clone();
    let (mut clean, mut dirty) = (start, start);
    let mut commutators = [Commutator::default(); 2];
    let (mut wrong, mut longest, mut run) = (0, 0, 0);
    for tick in 0..(2.0 / rotor.speed.abs()) as u32 {
        let mut samples = Samples::default();
        rotor.advance(&mut samples);
        clean.next(&c.hall, &samples);
        if tick == 3 {
            let truth = code_at(rotor.angle);
            match kind {
                Glitch::Level => samples.hall = code,
                Glitch::Pulse => {
                    samples.edges.clear();
                    for (instant, code) in [(30_000, code), (31_000, truth)] {
                        samples.edges.push(Edge { instant, source: EdgeSource::Hall, code }).unwrap();
                    }
                }
            }
        }
        dirty.next(&c.hall, &samples);
        let mut step = |which: usize, station: &Station| -> Step {
            commutators[which].step(&c.commutator, station.angle(), station.hall.speed(), torque).0
        };
        if step(0, &clean) == step(1, &dirty) {
            run = 0;
        } else {
            (wrong, run) = (wrong + 1, run + 1);
        }
        longest = longest.max(run);
    }
    (wrong, longest)
}

/// After a single glitch of any code at any phase of a revolution, the pattern is wrong for 3 ticks at most
/// with captured edges, 5 with sampled levels, counted after the glitch and at the boundaries of the two
/// revolutions that follow.
#[test]
fn glitches_hardly_disturb_the_pattern() {
    let mut results = Vec::new();
    for (kind, capture) in [(Glitch::Level, true), (Glitch::Pulse, true), (Glitch::Level, false)] {
        for ticks_a_sector in [6.25, 20.0, 50.0] {
            let c = coefficients(capture);
            let (mut wrong, mut longest) = (0, 0);
            for back in [false, true] {
                let frequency = 10_000.0 / (6.0 * ticks_a_sector) * if back { -1.0 } else { 1.0 };
                let mut rotor = ScriptedRotor::new(0.123, frequency, capture);
                let mut station = running(&c.hall, &mut rotor, 3.0);
                for _ in 0..(6.0 * ticks_a_sector) as u32 {
                    for code in 0..8 {
                        let found = disturbed(&c, &rotor, station, code, kind);
                        (wrong, longest) = (wrong.max(found.0), longest.max(found.1));
                    }
                    let mut samples = Samples::default();
                    rotor.advance(&mut samples);
                    station.next(&c.hall, &samples);
                }
            }
            println!(
                "{kind:?}, capture {capture}, {ticks_a_sector} ticks a sector: pattern wrong for at most {wrong} ticks, \
                 {longest} in a row"
            );
            results.push((wrong, if capture { 3 } else { 5 }));
        }
    }
    assert!(results.iter().all(|(wrong, allowed)| wrong <= allowed), "{results:?}");
}

/// A motor that stands for longer than an interval can count (6.5 s) has speed 0, and its next edge does not
/// count as a fast one.
#[test]
fn standstill_does_not_alias() {
    let c = coefficients(true);
    for rest in [9_000_u32, 65_500, 65_535, 65_536, 65_537, 70_000, 131_072, 140_000] {
        let mut rotor = ScriptedRotor::new(0.3, 50.0, true);
        let mut station = running(&c.hall, &mut rotor, 2.0);
        rotor.speed = 0.0;
        let mut samples = Samples::default();
        for tick in 0..rest {
            rotor.advance(&mut samples);
            station.next(&c.hall, &samples);
            if tick > 10_000 {
                assert!(station.hall.stopped() && station.speed_bounded() == 0, "after {tick} ticks");
            }
        }
        rotor.speed = 20.0 / 10_000.0;
        for _ in 0..1200 {
            rotor.advance(&mut samples);
            station.next(&c.hall, &samples);
            let speed = c.speed_of_turns.apply32(station.speed_bounded()) as f64 / 65_536.0;
            assert!(speed < 20.1, "{speed} rev/s after a rest of {rest} ticks");
        }
        let speed = c.speed_of_turns.apply32(station.speed_bounded()) as f64 / 65_536.0;
        assert!((speed - 20.0).abs() < 0.05, "{speed}");
        assert_eq!(station.hall.sector(), Some(sector_at(rotor.angle)));
    }
}

/// After a power-up with a turning rotor the first, incomplete sector does not count as a short one.
#[test]
fn power_up_while_turning() {
    for capture in [false, true] {
        let c = coefficients(capture);
        for phase in 0..60 {
            let mut rotor = ScriptedRotor::new(phase as f64 / 60.0, 50.0, capture);
            let mut station = Station::default();
            let mut samples = Samples::default();
            for _ in 0..400 {
                rotor.advance(&mut samples);
                station.next(&c.hall, &samples);
                let speed = c.speed_of_turns.apply32(station.speed_bounded()) as f64 / 65_536.0;
                assert!(speed < 52.0, "{speed} rev/s at phase {phase}, capture {capture}");
            }
        }
    }
}

/// Sensors that lose their code count once, whether they are evaluated in every tick or only when it is due.
#[test]
fn an_invalid_code_counts_once_however_seldom_it_is_looked_at() {
    let c = coefficients(false).hall;
    let mut rotor = ScriptedRotor::new(0.1, 20.0, false);
    let mut mute = running(&c, &mut rotor, 2.0);
    for _ in 0..3 {
        mute.next(&c, &level(7));
    }
    assert!(mute.hall.is_mute());
    for ticks in [1, 254, 255, 300] {
        let (mut sleeps, mut looks) = (mute.hall, mute);
        for tick in 1..=ticks {
            looks.next(&c, &level(7));
            if tick == ticks || sleeps.due().is_due(looks.now) {
                sleeps.step(&c, looks.now, &level(7));
            }
        }
        assert_eq!(sleeps, looks.hall, "{ticks} ticks");
    }
    assert_eq!(mute.hall.diagnostics().invalid, 1);
    // They count again each time that the code comes and goes, up to the largest count.
    for _ in 0..70_000 {
        for code in [1, 1, 7] {
            mute.next(&c, &level(code));
        }
    }
    assert_eq!(mute.hall.diagnostics().invalid, u16::MAX);
}

/// Lines without sensors never had a code that could be lost: nothing is counted.
#[test]
fn a_drive_without_sensors_counts_no_invalid_codes() {
    let c = coefficients(false).hall;
    for code in [0, 7] {
        let mut none = Station::default();
        for _ in 0..100_000 {
            assert!(none.next(&c, &level(code)).invalid);
        }
        assert_eq!(none.hall.diagnostics().invalid, 0);
    }
}

/// Samples of a rotor with every event that moves a deadline: it turns at any speed, creeps, stands for
/// longer than the time-out, reverses, and its code is disturbed or lost.
fn anything(capture: bool) -> impl Iterator<Item = Samples> {
    let turns = [(800.0, 0), (33.3, 0), (-20.0, 0), (-1.5, 0), (0.0, 12_000), (-4.0, 0), (0.3, 0), (90.0, 0)];
    let mut rotor = ScriptedRotor::new(0.3, 0.0, capture);
    let mut samples = Samples::default();
    let mut tick = 0_u32;
    turns.into_iter().flat_map(|(frequency, ticks)| std::iter::repeat_n(frequency, ticks.max(9_000))).map(
        move |frequency| {
            rotor.speed = frequency / 10_000.0;
            rotor.advance(&mut samples);
            tick += 1;
            let mut seen = samples.clone();
            match tick % 4_001 {
                // A glitch of one sample, and a jump of three.
                1_000 => seen.hall ^= 1,
                1_500..1_503 => seen.hall ^= 7,
                // The supply of the sensors fails.
                2_000..2_300 => seen.hall = 7,
                _ => {}
            }
            seen
        },
    )
}

/// A station that runs only when it is due, or when code or edges are new, has in every tick the state of one
/// that evaluates every tick.
#[test]
fn a_station_that_is_stepped_when_due_is_one_that_looks_in_every_tick() {
    for capture in [false, true] {
        let c = coefficients(capture).hall;
        let (mut sleeps, mut looks) = (Hall::default(), Hall::default());
        let (mut now, mut told) = (Instant::default(), u8::MAX);
        let (mut stepped, mut timed, mut ticks) = (0, 0, 0);
        for samples in anything(capture) {
            now = now.next();
            looks.wake(now);
            let expected = looks.step(&c, now, &samples);
            let (news, due) = (samples.hall != told || !samples.edges.is_empty(), sleeps.due().is_due(now));
            let found = if news || due {
                told = samples.hall;
                stepped += 1;
                timed += u32::from(!news);
                sleeps.step(&c, now, &samples)
            } else {
                // A lost code is reported again in every tick.
                HallEvents { invalid: sleeps.is_mute(), ..HallEvents::default() }
            };
            ticks += 1;
            assert_eq!(found, expected, "capture {capture}, tick {ticks}");
            assert_eq!(sleeps, looks, "capture {capture}, tick {ticks}");
        }
        println!(
            "capture {capture}: stepped in {stepped} of {ticks} ticks, in {timed} by the deadline alone"
        );
        assert!(
            timed > 10 && stepped < ticks / 2,
            "{stepped} of {ticks} ticks, {timed} by the deadline alone"
        );
    }
}

/// Sensors that show nothing, or the same code for days, need no look: not even after the farthest deadline,
/// 2^30 ticks.
#[test]
fn sensors_that_stand_are_asked_once_in_30_hours() {
    let c = coefficients(false).hall;
    for code in [0b000, 0b001] {
        let (mut station, samples) = (Station::default(), level(code));
        for _ in 0..100_000 {
            station.next(&c, &samples);
        }
        for _ in 0..5 {
            assert!(!station.hall.due().is_due(station.now.after(1_000_000_000)), "code {code:03b}");
            station.now = station.now.after(u32::MAX);
            station.next(&c, &samples);
        }
    }
}
