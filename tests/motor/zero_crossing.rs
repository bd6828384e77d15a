//! Back-EMF samples, edges and levels to crossings; crossings to angle and speed; episodes to faults.

use crate::support;
use narx_core::dictionary::number;
use narx_core::motor::back_emf::{BackEmf, BackEmfCoefficients, Level, OperatingPoint, Sight};
use narx_core::motor::front_end::Channel;
use narx_core::motor::gain::Gain;
use narx_core::motor::listening::Listening;
use narx_core::motor::measurement::ChannelScale;
use narx_core::motor::pwm::Commutation;
use narx_core::motor::rails::{Rail, RailCoefficients, Rails};
use narx_core::motor::zero_crossing::{BLIND_MAX, PREPARED, Why, ZeroCrossing};
use narx_core::motor::{Cause, Direction, Edge, EdgeSource, PwmCommand, SampleMode, Samples, Step};
use narx_core::units::Volts;

const TICK: f64 = 65_536.0;
/// 0.08 V, as four converter codes are.
const NOISE: i32 = 5_120;

fn coefficients() -> BackEmfCoefficients {
    // Codes are millivolts.
    let terminal = ChannelScale::new(Channel { zero: 0, micro_per_code: 1_000 }, 0);
    BackEmfCoefficients { terminal, noise: NOISE, discard: 1 << 16, earliest: 8_192, ..Default::default() }
}

/// A sector every `interval` (1/65 536 tick), with a back-EMF that is not known.
fn forward(interval: u32) -> OperatingPoint {
    OperatingPoint { torque: Direction::Forward, interval, emf: 0 }
}

fn raw(volts: f64) -> i32 {
    (volts * 65_536.0) as i32
}

/// Terminals in step AB: A switched, B low, C floating with back-EMF `emf`.
fn terminals(bus: f64, emf: f64, sample_mode: SampleMode) -> Samples {
    let (high, neutral) = match sample_mode {
        SampleMode::OnTime => (bus, bus / 2.0),
        SampleMode::OffTime => (0.0, 0.0),
    };
    let floating = (neutral + 1.5 * emf).clamp(0.0, bus);
    let phase_voltage = [high, 0.0, floating].map(|volts| (volts * 1e3).round() as u16);
    Samples { phase_voltage, sample_mode, ..Samples::default() }
}

/// Runs step AB, whose crossing falls, for a back-EMF `volts` a tick that is 0 at tick `crossing`; the sights of all ticks.
fn fall(
    c: &BackEmfCoefficients,
    bus: f64,
    volts: f64,
    crossing: f64,
    mode: SampleMode,
    interval: u32,
) -> Vec<Sight> {
    let mut back_emf = BackEmf::default();
    let applied = |step| PwmCommand { step, sample_mode: mode, ..PwmCommand::default() };
    // The step before, so that AB begins at its first tick.
    let point = forward(interval);
    back_emf.step(c, &terminals(bus, 0.0, mode), raw(bus), &applied(Step::CB), &point);
    (1..40)
        .map(|tick| {
            let emf = (crossing - f64::from(tick)) * volts;
            let samples = terminals(bus, emf, mode);
            back_emf.step(c, &samples, raw(bus), &applied(Step::AB), &point)
        })
        .collect()
}

/// Tick of the crossing that the sights tell.
fn crossing(sights: &[Sight]) -> Option<f64> {
    let found: Vec<f64> = sights
        .iter()
        .enumerate()
        .filter_map(|(k, sight)| sight.crossing.map(|age| (k + 1) as f64 - f64::from(age) / TICK))
        .collect();
    assert!(found.len() <= 1, "one crossing a step: {found:?}");
    found.first().copied()
}

/// On-time, referred to half of the bus as it is: where the crossing lies between two samples does not depend on the supply.
#[test]
fn on_time_crossing_is_interpolated_against_half_the_live_bus() {
    for bus in [18.0, 33.0, 60.0] {
        for place in [6.1, 6.5, 6.9, 11.3] {
            let sights = fall(&coefficients(), bus, 0.4, place, SampleMode::OnTime, 12 << 16);
            let found = crossing(&sights).unwrap();
            assert!((found - place).abs() < 0.02, "{bus} V: {found}, not {place}");
        }
    }
}

/// Off-time, where a terminal below ground reads 0: the threshold lies above it, and says so.
#[test]
fn off_time_threshold_is_told() {
    let sights = fall(&coefficients(), 24.0, 0.4, 8.0, SampleMode::OffTime, 12 << 16);
    let sight = sights.iter().find(|sight| sight.crossing.is_some()).unwrap();
    assert_eq!(sight.threshold, -2 * NOISE);
    let found = crossing(&sights).unwrap();
    // 2 noises of 3 x 0.4 V a tick.
    assert!((found - (8.0 - 0.16 / 1.2)).abs() < 0.06, "{found}");
    // With the slope known, the estimator puts the angle back to within a degree.
    assert!(sights[2].level == Level::Before && sights[20].level == Level::Hidden, "0 is no evidence");
}

/// Slow steps are averaged over up to 8 samples: one spike is no crossing, and the mean's delay is taken back.
#[test]
fn a_spike_does_not_outvote_the_window() {
    let c = coefficients();
    let mut back_emf = BackEmf::default();
    let applied = |step| PwmCommand { step, sample_mode: SampleMode::OnTime, ..PwmCommand::default() };
    let mut step = |step, emf| {
        let samples = terminals(24.0, emf, SampleMode::OnTime);
        back_emf.step(&c, &samples, raw(24.0), &applied(step), &forward(100 << 16))
    };
    step(Step::CB, 0.0);
    let mut found = Vec::new();
    for tick in 1..80 {
        let emf = if tick == 30 { -9.0 } else { 0.03 * (50.3 - f64::from(tick)) };
        if let Some(age) = step(Step::AB, emf).crossing {
            found.push(f64::from(tick) - f64::from(age) / TICK);
        }
    }
    assert_eq!(found.len(), 1, "{found:?}");
    assert!((found[0] - 50.3).abs() < 0.3, "{found:?}");
}

/// Blanking: max(parameter 86, an eighth of the step), but no more than a quarter.
#[test]
fn nothing_is_seen_while_blanked() {
    let first = |discard: i32, interval: u32| {
        let built = support::coefficients(&[(number::ZC_DISCARD, discard)]);
        let c = BackEmfCoefficients { discard: built.sensorless.back_emf.discard, ..coefficients() };
        let sights = fall(&c, 24.0, 0.4, 30.0, SampleMode::OnTime, interval << 16);
        sights.iter().position(|sight| sight.level != Level::Hidden).unwrap() + 1
    };
    // The step begins at `earliest`, an eighth of a period into tick 0.
    assert_eq!(first(0, 20), 3, "an eighth of 20 ticks");
    assert_eq!(first(4, 20), 5, "4 ticks");
    assert_eq!(first(9, 20), 6, "a quarter of 20 ticks");
}

/// A level that stands beyond the crossing from the start is demagnetisation or a late look, never a crossing.
#[test]
fn a_crossing_is_healthy_or_late() {
    let sights = fall(&coefficients(), 24.0, 0.4, 0.5, SampleMode::OnTime, 12 << 16);
    assert_eq!(crossing(&sights), None);
    assert_eq!(sights.iter().filter(|sight| sight.late).count(), 1, "told once");
}

/// A rotor that stops half way has not crossed: the signal must go as far beyond as it was before.
#[test]
fn a_rotor_that_stops_has_not_crossed() {
    let c = coefficients();
    let mut back_emf = BackEmf::default();
    for tick in 0..60 {
        let step = if tick == 0 { Step::CB } else { Step::AB };
        let applied = PwmCommand { step, sample_mode: SampleMode::OnTime, ..PwmCommand::default() };
        let emf = if tick < 20 { 0.2 } else { -0.01 };
        let samples = terminals(24.0, emf, SampleMode::OnTime);
        let sight = back_emf.step(&c, &samples, raw(24.0), &applied, &forward(0));
        assert!(sight.crossing.is_none() && !sight.late, "tick {tick}");
    }
}

/// Comparator edges: to 1/65 536 tick, rising and falling delays apart, two sectors' worth of ticks a sector.
#[test]
fn comparator_edges_with_their_delays() {
    let c = BackEmfCoefficients {
        comparator: true,
        discard: 0,
        delay_rising: 3_000,
        delay_falling: 5_000,
        ..coefficients()
    };
    for (before, step, phase, rising, delay) in
        [(Step::AB, Step::AC, 1, true, 3_000), (Step::CB, Step::AB, 2, false, 5_000)]
    {
        let mut back_emf = BackEmf::default();
        let bit = 1 << phase;
        let edge = |instant, high: bool| Edge {
            instant,
            source: EdgeSource::Comparator,
            code: if high { bit } else { 0 },
        };
        let mut tick = |step, edges: &[Edge]| {
            let samples = Samples { edges: edges.iter().copied().collect(), ..Samples::default() };
            let applied = PwmCommand { step, ..PwmCommand::default() };
            back_emf.step(&c, &samples, 0, &applied, &forward(2 << 16))
        };
        tick(before, &[]);
        // Demagnetisation looks like the level beyond, then the level before shows, then the crossing.
        let sight = tick(step, &[edge(9_000, rising), edge(12_000, !rising)]);
        assert_eq!(sight.crossing, None, "demagnetisation is no crossing");
        let sight = tick(step, &[edge(40_000, rising)]);
        assert_eq!(sight.crossing, Some(65_536 - 40_000 + delay), "{step:?}");
    }
}

fn crossed(sector: u8, age: i32) -> Sight {
    Sight { sector: Some(sector), crossing: Some(age), passed: true, ..Sight::default() }
}

/// Feeds crossings at the given times (ticks), one sector each, and returns the estimator at the boundary after the last.
fn fed(times: &[f64]) -> ZeroCrossing {
    let mut rotor = ZeroCrossing::default();
    rotor.start(0, Direction::Forward);
    let (mut tick, mut sector) = (0_i32, 0_u8);
    for time in times {
        while f64::from(tick) < *time {
            rotor.advance();
            tick += 1;
        }
        let age = ((f64::from(tick) - time) * TICK) as i32;
        assert!(rotor.observe(&crossed(sector, age), Gain::ZERO, false), "plausible");
        sector = (sector + 1) % 6;
    }
    rotor
}

fn steady(interval: f64, count: usize) -> Vec<f64> {
    (1..=count).map(|k| k as f64 * interval).collect()
}

#[test]
fn steady_crossings_give_angle_and_speed_to_a_fraction_of_a_tick() {
    for interval in [2.17, 4.6, 31.7, 300.3] {
        let times = steady(interval, 14);
        let rotor = fed(&times);
        let speed = f64::from(rotor.speed()) / 2_f64.powi(32) * 6.0 * interval;
        assert!((speed - 1.0).abs() < 1e-3, "{interval}: {speed}");
        // Crossing k lies at 60 (k + 1) degrees, the last was number 13.
        let since = times[13].ceil() - times[13];
        let expected = (14.0 * 60.0 + since / interval * 60.0).rem_euclid(360.0);
        let angle = f64::from(rotor.angle()) / 2_f64.powi(32) * 360.0;
        assert!((angle - expected).abs() < 0.2, "{interval}: {angle}, not {expected}");
        assert!(rotor.is_prepared() && rotor.why().0 == Why::Accepted);
    }
}

/// A spool-up that gains 4 % a sector: with the trend the next crossing comes within 2 degrees of its prediction; the mean of the last two
/// intervals alone would be 3.5 degrees late.
#[test]
fn the_next_interval_is_predicted_with_its_trend() {
    let (mut time, mut interval) = (0.0, 40.0);
    let times: Vec<f64> = (0..20)
        .map(|_| {
            time += interval;
            interval *= 0.96;
            time
        })
        .collect();
    let rotor = fed(&times);
    let margin = f64::from(rotor.why().1) * 360.0 / TICK;
    assert!(margin.abs() < 2.0, "{margin} degrees");
    let expected = f64::from(rotor.expected()) / TICK;
    assert!((expected - interval).abs() < 0.02 * interval, "{expected}, not {interval}");
}

/// No crossing earlier than half the expected interval.
#[test]
fn an_early_crossing_is_filtered() {
    let mut rotor = fed(&steady(20.0, 10));
    for _ in 0..8 {
        rotor.advance();
    }
    assert!(!rotor.observe(&crossed(10 % 6, 0), Gain::ZERO, false));
    assert_eq!(rotor.why().0, Why::Filtered);
    for _ in 0..12 {
        rotor.advance();
    }
    assert!(rotor.observe(&crossed(10 % 6, 0), Gain::ZERO, false));
    assert_eq!(rotor.why().0, Why::Accepted);
}

/// Missed crossings are commutated by prediction, named, never counted as crossings, and end in a lost rotor after a budget over which
/// the voltage fades.
#[test]
fn blind_steps_have_a_budget() {
    let mut rotor = fed(&steady(20.0, 10));
    let accepted = rotor.why().2;
    let before = rotor.angle();
    let mut fades = Vec::new();
    for step in 0..=BLIND_MAX {
        assert!(!rotor.is_lost(), "step {step}");
        // By prediction alone.
        let turned = f64::from(rotor.angle().wrapping_sub(before)) / 2_f64.powi(32) * 360.0;
        let off = (turned - 60.0 * f64::from(step) + 180.0).rem_euclid(360.0) - 180.0;
        assert!(off.abs() < 1.0, "step {step}: {turned}");
        for _ in 0..20 {
            rotor.advance();
        }
        rotor.observe(&Sight { sector: Some(step % 6), missed: true, ..Sight::default() }, Gain::ZERO, false);
        assert_eq!((rotor.why().0, rotor.why().2), (Why::Blind, accepted));
        fades.push(rotor.fade());
    }
    assert!(rotor.is_lost());
    assert!(fades.is_sorted() && fades[0] > 0 && fades[5] >= 12, "{fades:?}");
}

/// A late crossing is named, brings the angle forward and fades, and does not end the episode.
#[test]
fn demagnetisation_that_hides_the_crossing_is_no_restart() {
    let mut rotor = fed(&steady(20.0, 10));
    for _ in 0..15 {
        rotor.advance();
    }
    let late = Sight { sector: Some(10 % 6), late: true, passed: true, ..Sight::default() };
    let before = rotor.angle();
    rotor.observe(&late, Gain::ZERO, false);
    assert_eq!(rotor.why().0, Why::DemagLate);
    assert!(rotor.angle().wrapping_sub(before) < u32::MAX / 8 && rotor.angle() != before);
    assert!(!rotor.is_lost());
    rotor.observe(&late, Gain::ZERO, false);
    assert!(rotor.fade() > 0);
}

/// A level that is certainly before the crossing holds the angle there.
#[test]
fn a_rotor_that_has_not_crossed_is_not_commutated() {
    let mut rotor = fed(&steady(20.0, 10));
    let sight = Sight { sector: Some(10 % 6), level: Level::Before, ..Sight::default() };
    for _ in 0..35 {
        rotor.advance();
        rotor.observe(&sight, Gain::ZERO, false);
    }
    let angle = f64::from(rotor.angle()) / 2_f64.powi(32) * 360.0;
    assert!((angle - 300.0).abs() < 0.1, "the middle of sector 4: {angle}");
}

#[test]
fn hand_over_waits_for_six_crossings_of_both_polarities() {
    for count in 1..9 {
        let rotor = fed(&steady(20.0, count));
        assert_eq!(rotor.is_prepared(), count >= usize::from(PREPARED), "{count}");
    }
}

#[test]
fn intervals_that_jump_by_half_are_a_desynchronisation() {
    let mut times = steady(20.0, 12);
    assert!(!fed(&times).is_irregular());
    for k in 0..30 {
        let last = times.last().copied().unwrap_or(0.0);
        times.push(last + if k % 2 == 0 { 40.0 } else { 22.0 });
    }
    assert!(fed(&times).is_irregular());
}

/// A coasting motor's terminals: place and direction of the rotor, both ways.
#[test]
fn a_coasting_motor_is_heard_both_ways() {
    for (sign, direction) in [(1.0, Direction::Forward), (-1.0, Direction::Reverse)] {
        let mut listening = Listening::default();
        let per_tick = 2.3 * sign;
        let mut worst = 0.0_f64;
        let mut heard = 0;
        for tick in 0..600 {
            let angle = 77.0 + per_tick * f64::from(tick);
            let emf = |phase: f64| sign * 2.0 * (angle - 120.0 * phase).to_radians().sin();
            let emfs = [emf(0.0), emf(1.0), emf(2.0)];
            let lowest = emfs.iter().copied().fold(0.0, f64::min);
            let neutral = (-0.8 - lowest).max(0.0);
            let voltage = emfs.map(|emf| Volts::from_bits(raw((neutral + emf).max(0.0))));
            if let Some(found) = listening.step(&voltage, NOISE, 0) {
                assert_eq!(found.direction, direction);
                heard += 1;
                let place = f64::from(found.place) * 30.0 + per_tick * f64::from(found.age) / TICK;
                worst = worst.max(((angle - place + 180.0).rem_euclid(360.0) - 180.0).abs());
            }
        }
        assert!(listening.is_turning() && listening.direction() == direction);
        assert!(heard >= 10 && worst < 2.0, "{heard} places, at most {worst} degrees off");
    }
}

#[test]
fn a_motor_at_rest_is_quiet() {
    let mut listening = Listening::default();
    for _ in 0..100 {
        assert!(listening.step(&[0, 1_280, 0].map(Volts::from_bits), NOISE, 0).is_none());
    }
    assert!(!listening.is_turning() && listening.quiet() >= 90);
}

/// A converter's offset makes one terminal the highest for ever: that is loud, and still.
#[test]
fn an_offset_is_no_rotation() {
    let mut listening = Listening::default();
    for _ in 0..100 {
        listening.step(&[0, 60_000, 0].map(Volts::from_bits), NOISE, 0);
    }
    assert!(!listening.is_turning() && listening.quiet() == 0 && listening.still() >= 90);
}

/// Two ticks a sector: the commutation was taken at the end of the period in whose beginning the crossing before it came.
#[test]
fn an_edge_before_the_commutation_of_its_period_counts() {
    let c = BackEmfCoefficients { comparator: true, discard: 0, ..coefficients() };
    let mut back_emf = BackEmf::default();
    let edge = |instant, code| Edge { instant, source: EdgeSource::Comparator, code };
    let mut tick = |step, then: Option<Step>, edges: &[Edge]| {
        let samples = Samples { edges: edges.iter().copied().collect(), ..Samples::default() };
        let mut applied = PwmCommand { step, ..PwmCommand::default() };
        if let Some(step) = then {
            applied.commutations.push(Commutation { instant: 60_000, step });
        }
        back_emf.step(&c, &samples, 0, &applied, &forward(2 << 16))
    };
    tick(Step::CB, None, &[]);
    // AB floats C, whose crossing falls.
    tick(Step::AB, None, &[edge(9_000, 0b100)]);
    let sight = tick(Step::AB, Some(Step::AC), &[edge(6_000, 0)]);
    assert_eq!(sight.crossing, Some(65_536 - 6_000));
    assert!(!sight.missed);
    assert_eq!(sight.sector, Step::AB.sector());
}

/// Episodes fill a bucket that leaks; a full one names the fault.
#[test]
fn the_bucket_leaks() {
    let c = RailCoefficients { leak: 100, ..RailCoefficients::default() };
    let mut rails = Rails::default();
    for _ in 0..4 {
        rails.count(Rail::Desynchronised);
    }
    assert_eq!(rails.fault(), None);
    for _ in 0..100 {
        rails.leak(&c);
    }
    rails.count(Rail::Stall);
    assert_eq!(rails.fault(), None, "one has leaked");
    rails.count(Rail::WrongLock);
    assert_eq!(rails.fault(), Some(Cause::WrongLock));
}

/// Applied voltage against k omega: a motor that is believed at the wrong speed is found, a hot or cold one under load is not.
#[test]
fn a_stable_wrong_lock_is_found_by_its_voltage() {
    let one = |numerator, denominator| Gain::from_ratio(numerator, denominator).unwrap();
    // 0.5 ohm, 0.1 V per electrical rev/s.
    let c =
        RailCoefficients { resistance: one(1, 2), back_emf: one(1, 10), commutation: Gain::ZERO, leak: 1 };
    let judge = |resistance: f64, k: f64, current: f64, true_speed: f64, claimed: f64| {
        let voltage = resistance * current + k * true_speed;
        let mut rails = Rails::default();
        (0..400).any(|_| rails.is_wrong_lock(&c, raw(voltage), raw(current), raw(claimed)))
    };
    for current in [0.2, 3.0, 8.0] {
        for (resistance, k) in [(0.45, 0.105), (0.5, 0.1), (0.83, 0.08)] {
            assert!(!judge(resistance, k, current, 100.0, 100.0), "healthy: {resistance} {k} {current} A");
        }
        assert!(judge(0.5, 0.1, current, 50.0, 100.0), "twice the speed is claimed");
    }
    // What a hot winding could take at a high current is not held against the motor.
    assert!(judge(0.5, 0.1, 2.0, 100.0, 50.0), "half the speed is claimed");
}

/// A motor of which neither constant is known cannot be contradicted by its voltage.
#[test]
fn without_constants_no_lock_is_wrong() {
    let one = Gain::from_ratio(1, 10).unwrap();
    let known = RailCoefficients { resistance: one, back_emf: one, commutation: Gain::ZERO, leak: 1 };
    for (c, expected) in [
        (known, true),
        (RailCoefficients { resistance: Gain::ZERO, ..known }, false),
        (RailCoefficients { back_emf: Gain::ZERO, ..known }, false),
    ] {
        let mut rails = Rails::default();
        let found = (0..1000).any(|_| rails.is_wrong_lock(&c, raw(5.0), raw(1.0), raw(1000.0)));
        assert_eq!(found, expected, "{c:?}");
    }
}
