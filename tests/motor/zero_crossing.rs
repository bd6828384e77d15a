//! Tests of the way from back-EMF samples, edges and levels to crossings, from crossings to angle and speed,
//! and from episodes to faults.

use crate::support;
use narx_core::dictionary::number;
use narx_core::motor::clock::Instant;
use narx_core::motor::commutate::pwm::Commutation;
use narx_core::motor::gain::Gain;
use narx_core::motor::guard::rails::{Rail, RailCoefficients, Rails};
use narx_core::motor::rotor::back_emf::{BackEmf, BackEmfCoefficients, End, Observation, OperatingPoint};
use narx_core::motor::rotor::listening::Listening;
use narx_core::motor::rotor::zero_crossing::{BLIND_MAX, PREPARED, Why, ZeroCrossing};
use narx_core::motor::sense::front_end::Channel;
use narx_core::motor::sense::measurement::ChannelScale;
use narx_core::motor::{Cause, Direction, Edge, EdgeSource, PwmCommand, SampleMode, Samples, Step};

const TICK: f64 = 65_536.0;
/// Noise threshold: 0.08 V in codes, which are millivolts.
const NOISE: i32 = 80;

/// Observation in one tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Seen {
    /// End of the previous step.
    end: End,
    /// Sector of the present step.
    sector: Option<u8>,
    /// Observation of the present step.
    pub(crate) observation: Observation,
    /// True if the present step's crossing was seen, or was late.
    found: bool,
}

impl Seen {
    /// Age of a healthy crossing of the present step, 1/65 536 tick.
    pub(crate) const fn crossing(&self) -> Option<i32> {
        match self.observation {
            Observation::Crossing { age, .. } => Some(age),
            Observation::Nothing | Observation::Before | Observation::Late => None,
        }
    }

    /// Returns whether the estimator must get it: the present step's crossing, or a previous step that ended
    /// without one.
    fn is_news(&self) -> bool {
        self.end != End::Seen || matches!(self.observation, Observation::Crossing { .. } | Observation::Late)
    }
}

/// A station with its clock, combined as in the drive. No crossing is ever overdue.
#[derive(Default)]
pub(crate) struct Station {
    back_emf: BackEmf,
    now: Instant,
}

impl Station {
    /// Runs the next tick; the station evaluates its sample.
    pub(crate) fn step(
        &mut self,
        c: &BackEmfCoefficients,
        samples: &Samples,
        bus_voltage: i32,
        applied: &PwmCommand,
        point: &OperatingPoint,
    ) -> Seen {
        let end = self.follow(c, samples, applied, point);
        self.look(c, samples, bus_voltage, applied, end)
    }

    /// Runs the next tick; the station evaluates its sample only if that may be new.
    fn step_or_rest(
        &mut self,
        c: &BackEmfCoefficients,
        samples: &Samples,
        bus_voltage: i32,
        applied: &PwmCommand,
        point: &OperatingPoint,
    ) -> Option<Seen> {
        let end = self.follow(c, samples, applied, point);
        let rests = self.back_emf.rests(self.now, samples, applied.sample_at) && samples.edges.is_empty();
        if rests && end == End::Seen { None } else { Some(self.look(c, samples, bus_voltage, applied, end)) }
    }

    fn follow(
        &mut self,
        c: &BackEmfCoefficients,
        samples: &Samples,
        applied: &PwmCommand,
        point: &OperatingPoint,
    ) -> End {
        self.now = self.now.next();
        if self.back_emf.goes_on(applied) {
            return End::Seen;
        }
        let end = self.back_emf.follow(c, self.now, samples, applied, point);
        self.back_emf.expect(None);
        end
    }

    fn look(
        &mut self,
        c: &BackEmfCoefficients,
        samples: &Samples,
        bus_voltage: i32,
        applied: &PwmCommand,
        end: End,
    ) -> Seen {
        let observation = self.back_emf.look(c, self.now, samples, bus_voltage, applied.sample_at);
        self.back_emf.expect(None);
        Seen { end, sector: self.back_emf.sector(), observation, found: self.back_emf.is_found() }
    }
}

fn coefficients() -> BackEmfCoefficients {
    // Codes are millivolts.
    let terminal = ChannelScale::new(Channel { zero: 0, micro_per_code: 1_000 }, 0);
    BackEmfCoefficients {
        terminal,
        noise: NOISE,
        silence: NOISE as u16,
        discard: 1 << 16,
        earliest: 8_192,
        ..Default::default()
    }
}

/// Operating point with a sector every `interval` (1/65 536 tick), and an unknown back-EMF.
fn forward(interval: u32) -> OperatingPoint {
    OperatingPoint { torque: Direction::Forward, interval, accelerates: false }
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

/// Runs step AB, whose crossing falls, for a back-EMF of `volts` per tick that is 0 at tick `crossing`;
/// returns the observations of all ticks.
fn fall(
    c: &BackEmfCoefficients,
    bus: f64,
    volts: f64,
    crossing: f64,
    mode: SampleMode,
    interval: u32,
) -> Vec<Seen> {
    fall_at(c, bus, volts, crossing, mode, &forward(interval))
}

/// Runs [`fall`] at an operating point.
fn fall_at(
    c: &BackEmfCoefficients,
    bus: f64,
    volts: f64,
    crossing: f64,
    mode: SampleMode,
    point: &OperatingPoint,
) -> Vec<Seen> {
    let mut station = Station::default();
    let applied = |step| PwmCommand { step, sample_mode: mode, ..PwmCommand::default() };
    // One tick of the previous step, so that AB begins at its first tick.
    station.step(c, &terminals(bus, 0.0, mode), raw(bus), &applied(Step::CB), point);
    (1..40)
        .map(|tick| {
            let emf = (crossing - f64::from(tick)) * volts;
            let samples = terminals(bus, emf, mode);
            station.step(c, &samples, raw(bus), &applied(Step::AB), point)
        })
        .collect()
}

/// Tick of the crossing that was seen.
fn crossing(ticks: &[Seen]) -> Option<f64> {
    let found: Vec<f64> = ticks
        .iter()
        .enumerate()
        .filter_map(|(k, seen)| seen.crossing().map(|age| (k + 1) as f64 - f64::from(age) / TICK))
        .collect();
    assert!(found.len() <= 1, "one crossing a step: {found:?}");
    found.first().copied()
}

/// In the on-time the signal is referred to half of the present bus voltage: the interpolated crossing
/// between two samples does not depend on the supply.
#[test]
fn on_time_crossing_is_interpolated_against_half_the_live_bus() {
    for bus in [18.0, 33.0, 60.0] {
        for place in [6.1, 6.5, 6.9, 11.3] {
            let ticks = fall(&coefficients(), bus, 0.4, place, SampleMode::OnTime, 12 << 16);
            let found = crossing(&ticks).unwrap();
            assert!((found - place).abs() < 0.02, "{bus} V: {found}, not {place}");
        }
    }
}

/// In the off-time, where a terminal below ground reads 0, the threshold is above zero, and the observation
/// reports this.
#[test]
fn off_time_threshold_is_told() {
    let ticks = fall(&coefficients(), 24.0, 0.4, 8.0, SampleMode::OffTime, 12 << 16);
    let told = ticks.iter().find_map(|seen| match seen.observation {
        Observation::Crossing { threshold, .. } => Some(threshold),
        _ => None,
    });
    assert_eq!(told, Some(coefficients().terminal.convert_difference(-2 * NOISE)));
    let found = crossing(&ticks).unwrap();
    // 2 noise thresholds of 3 x 0.4 V per tick.
    assert!((found - (8.0 - 0.16 / 1.2)).abs() < 0.06, "{found}");
    // With the slope known, the estimator corrects the angle to within a degree.
    assert!(ticks[2].observation == Observation::Before && !ticks[2].found, "{:?}", ticks[2]);
    assert!(ticks[20].observation == Observation::Nothing && ticks[20].found, "{:?}", ticks[20]);
    // After a crossing that came before the first sample every sample reads 0.
    let ticks = fall(&coefficients(), 24.0, 0.4, 0.5, SampleMode::OffTime, 12 << 16);
    assert!(
        ticks.iter().all(|seen| seen.observation == Observation::Nothing && !seen.found),
        "0 is no evidence"
    );
}

/// Slow steps are averaged over up to 8 samples: a single spike is no crossing, and the delay of the mean is
/// corrected.
#[test]
fn a_spike_does_not_outvote_the_window() {
    let c = coefficients();
    let mut station = Station::default();
    let applied = |step| PwmCommand { step, sample_mode: SampleMode::OnTime, ..PwmCommand::default() };
    let mut step = |step, emf| {
        let samples = terminals(24.0, emf, SampleMode::OnTime);
        station.step(&c, &samples, raw(24.0), &applied(step), &forward(100 << 16))
    };
    step(Step::CB, 0.0);
    let mut found = Vec::new();
    for tick in 1..80 {
        let emf = if tick == 30 { -9.0 } else { 0.03 * (50.3 - f64::from(tick)) };
        if let Some(age) = step(Step::AB, emf).crossing() {
            found.push(f64::from(tick) - f64::from(age) / TICK);
        }
    }
    assert_eq!(found.len(), 1, "{found:?}");
    assert!((found[0] - 50.3).abs() < 0.3, "{found:?}");
}

/// Samples are blanked for the longer of parameter 86 and an eighth of the step, but for no more than a
/// quarter of it.
#[test]
fn nothing_is_seen_while_blanked() {
    let first = |discard: i32, interval: u32| {
        let built = support::coefficients(&[(number::ZC_DISCARD, discard)]);
        let c = BackEmfCoefficients { discard: built.sensorless.back_emf.discard, ..coefficients() };
        let ticks = fall(&c, 24.0, 0.4, 30.0, SampleMode::OnTime, interval << 16);
        ticks.iter().position(|seen| seen.observation != Observation::Nothing).unwrap() + 1
    };
    // The step begins at `earliest`, an eighth of a period into tick 0.
    assert_eq!(first(0, 20), 3, "an eighth of 20 ticks");
    assert_eq!(first(4, 20), 5, "4 ticks");
    assert_eq!(first(9, 20), 6, "a quarter of 20 ticks");
}

/// The first step of a kick may have held a rest. What follows is blanked for no longer than a winding
/// carries current, so that the crossing of a rotor that has gained speed is seen.
#[test]
fn a_rotor_that_gains_speed_is_not_blanked_for_long() {
    let c = BackEmfCoefficients { settle: 8, ..coefficients() };
    let seen = |accelerates| {
        let point = OperatingPoint { accelerates, ..forward(240 << 16) };
        crossing(&fall_at(&c, 24.0, 0.4, 20.0, SampleMode::OnTime, &point))
    };
    assert_eq!(seen(false), None, "an eighth of 240 ticks is blanked");
    let found = seen(true).expect("the crossing");
    assert!((found - 20.0).abs() < 1.0, "{found}");
}

/// A level that is beyond the crossing from the start means demagnetisation or a late observation, never a
/// crossing.
#[test]
fn a_crossing_is_healthy_or_late() {
    let ticks = fall(&coefficients(), 24.0, 0.4, 0.5, SampleMode::OnTime, 12 << 16);
    assert_eq!(crossing(&ticks), None);
    assert_eq!(ticks.iter().filter(|seen| seen.observation == Observation::Late).count(), 1, "told once");
}

/// Samples without news may be left out, and hidden ones need no evaluation: a station that rests then gives
/// in every other tick the result of one that evaluates all of them, and has missed nothing.
#[test]
fn a_station_that_rests_is_one_that_looks() {
    let c = coefficients();
    let (mut rested, mut crossings) = (0, 0);
    for mode in [SampleMode::OnTime, SampleMode::OffTime] {
        for (interval, volts) in [(0, 0.4), (12, 0.4), (23, 0.2), (30, 0.2), (60, 0.1), (120, 0.05)] {
            for crossing in [-2.0, 5.4, 9.0, 17.3, 100.0] {
                let context = format!("{mode:?}, {interval} ticks a step, crossing at {crossing}");
                let (mut sleeps, mut looks) = (Station::default(), Station::default());
                for tick in 0..60 {
                    let step = match tick {
                        0 => Step::CB,
                        1..40 => Step::AB,
                        _ => Step::AC,
                    };
                    let samples = terminals(24.0, (crossing - f64::from(tick)) * volts, mode);
                    let applied = PwmCommand { step, sample_mode: mode, ..PwmCommand::default() };
                    let point = forward(interval << 16);
                    let expected = looks.step(&c, &samples, raw(24.0), &applied, &point);
                    if let Some(found) = sleeps.step_or_rest(&c, &samples, raw(24.0), &applied, &point) {
                        assert_eq!(found, expected, "{context}, tick {tick}");
                        crossings += u32::from(found.crossing().is_some());
                    } else {
                        assert!(!expected.is_news(), "{context}, tick {tick}: {expected:?}");
                        rested += 1;
                    }
                    let of = |station: &Station| (station.back_emf.sector(), station.back_emf.is_found());
                    assert_eq!(of(&sleeps), of(&looks), "{context}, tick {tick}");
                }
            }
        }
    }
    println!("{rested} ticks of {}, {crossings} crossings", 2 * 6 * 5 * 60);
    assert!(rested > 500 && crossings > 10, "{rested} ticks, {crossings} crossings");
}

/// A rotor that stops half way has not crossed: the signal must go as far beyond as it was before.
#[test]
fn a_rotor_that_stops_has_not_crossed() {
    let c = coefficients();
    let mut station = Station::default();
    for tick in 0..60 {
        let step = if tick == 0 { Step::CB } else { Step::AB };
        let applied = PwmCommand { step, sample_mode: SampleMode::OnTime, ..PwmCommand::default() };
        let emf = if tick < 20 { 0.2 } else { -0.01 };
        let samples = terminals(24.0, emf, SampleMode::OnTime);
        let seen = station.step(&c, &samples, raw(24.0), &applied, &forward(0));
        assert!(!seen.is_news() && !seen.found, "tick {tick}: {seen:?}");
    }
}

/// Comparator edges are exact to 1/65 536 tick, with separate delays for rising and falling ones, at sectors
/// of various lengths.
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
        let mut station = Station::default();
        let bit = 1 << phase;
        let edge = |instant, high: bool| Edge {
            instant,
            source: EdgeSource::Comparator,
            code: if high { bit } else { 0 },
        };
        let mut tick = |step, edges: &[Edge]| {
            let samples = Samples { edges: edges.iter().copied().collect(), ..Samples::default() };
            let applied = PwmCommand { step, ..PwmCommand::default() };
            station.step(&c, &samples, 0, &applied, &forward(2 << 16))
        };
        tick(before, &[]);
        // First demagnetisation, which shows the level beyond; then the level before; then the crossing.
        let seen = tick(step, &[edge(9_000, rising), edge(12_000, !rising)]);
        assert_eq!(
            (seen.end, seen.observation),
            (End::Seen, Observation::Before),
            "demagnetisation is no crossing"
        );
        let seen = tick(step, &[edge(40_000, rising)]);
        assert_eq!(seen.crossing(), Some(65_536 - 40_000 + delay), "{step:?}");
    }
}

/// A running motor crosses `sector` at 0, `age` before `now`. Returns false if that was too early.
fn cross(rotor: &mut ZeroCrossing, now: Instant, sector: u8, age: i32) -> bool {
    rotor.cross(now, sector, (age, 0), Gain::ZERO, false)
}

/// Gives crossings at these times (ticks), one sector each; returns the estimator and the boundary after the
/// last.
fn fed(times: &[f64]) -> (ZeroCrossing, Instant) {
    fed_in(Direction::Forward, times)
}

/// Gives crossings as [`fed`] does, for a rotor that turns in `direction`.
fn fed_in(direction: Direction, times: &[f64]) -> (ZeroCrossing, Instant) {
    let mut rotor = ZeroCrossing::default();
    let mut now = Instant::default();
    rotor.start(now, 0, direction);
    let (mut tick, mut sector) = (0_i32, 0_u8);
    for time in times {
        while f64::from(tick) < *time {
            now = now.next();
            tick += 1;
        }
        let age = ((f64::from(tick) - time) * TICK) as i32;
        assert!(cross(&mut rotor, now, sector, age), "plausible");
        sector = next_sector(direction, sector);
    }
    (rotor, now)
}

fn next_sector(direction: Direction, sector: u8) -> u8 {
    match direction {
        Direction::Forward => (sector + 1) % 6,
        Direction::Reverse => (sector + 5) % 6,
    }
}

fn steady(interval: f64, count: usize) -> Vec<f64> {
    (1..=count).map(|k| k as f64 * interval).collect()
}

#[test]
fn steady_crossings_give_angle_and_speed_to_a_fraction_of_a_tick() {
    for interval in [2.17, 4.6, 31.7, 300.3] {
        let times = steady(interval, 14);
        let (rotor, now) = fed(&times);
        let speed = f64::from(rotor.speed()) / 2_f64.powi(32) * 6.0 * interval;
        assert!((speed - 1.0).abs() < 1e-3, "{interval}: {speed}");
        // Crossing k is at 60 (k + 1) degrees; the last was number 13.
        let since = times[13].ceil() - times[13];
        let expected = (14.0 * 60.0 + since / interval * 60.0).rem_euclid(360.0);
        let angle = f64::from(rotor.angle(now)) / 2_f64.powi(32) * 360.0;
        assert!((angle - expected).abs() < 0.2, "{interval}: {angle}, not {expected}");
        assert!(rotor.is_prepared() && rotor.why().0 == Why::Accepted);
    }
}

/// In a spool-up that gains 4 % per sector, the trend predicts the next crossing within 2 degrees; the mean
/// of the last two intervals alone would be 3.5 degrees late.
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
    let (rotor, _) = fed(&times);
    let margin = f64::from(rotor.why().1) * 360.0 / TICK;
    assert!(margin.abs() < 2.0, "{margin} degrees");
    let expected = f64::from(rotor.expected()) / TICK;
    assert!((expected - interval).abs() < 0.02 * interval, "{expected}, not {interval}");
}

/// A crossing earlier than half of the expected interval is rejected.
#[test]
fn an_early_crossing_is_filtered() {
    let (mut rotor, mut now) = fed(&steady(20.0, 10));
    now = now.after(8);
    assert!(!cross(&mut rotor, now, 10 % 6, 0));
    assert_eq!(rotor.why().0, Why::Filtered);
    now = now.after(12);
    assert!(cross(&mut rotor, now, 10 % 6, 0));
    assert_eq!(rotor.why().0, Why::Accepted);
}

/// Missed crossings are commutated by prediction, named, never counted as crossings, and end in a lost rotor
/// after a limited number, over which the voltage fades.
#[test]
fn blind_steps_have_a_budget() {
    let (mut rotor, mut now) = fed(&steady(20.0, 10));
    let accepted = rotor.why().2;
    let before = rotor.angle(now);
    let mut fades = Vec::new();
    for step in 0..=BLIND_MAX {
        assert!(!rotor.is_lost(), "step {step}");
        // By prediction alone.
        let turned = f64::from(rotor.angle(now).wrapping_sub(before)) / 2_f64.powi(32) * 360.0;
        let off = (turned - 60.0 * f64::from(step) + 180.0).rem_euclid(360.0) - 180.0;
        assert!(off.abs() < 1.0, "step {step}: {turned}");
        now = now.after(20);
        rotor.step_blind(now);
        assert_eq!((rotor.why().0, rotor.why().2), (Why::Blind, accepted));
        fades.push(rotor.fade());
    }
    assert!(rotor.is_lost());
    assert!(fades.is_sorted() && fades[0] > 0 && fades[5] >= 12, "{fades:?}");
}

/// A late crossing is named, advances the angle, fades the voltage, and does not end the episode.
#[test]
fn demagnetisation_that_hides_the_crossing_is_no_restart() {
    let (mut rotor, mut now) = fed(&steady(20.0, 10));
    now = now.after(15);
    let before = rotor.angle(now);
    rotor.cross_late(now, 10 % 6, false);
    assert_eq!(rotor.why().0, Why::DemagLate);
    assert!(rotor.angle(now).wrapping_sub(before) < u32::MAX / 8 && rotor.angle(now) != before);
    assert!(!rotor.is_lost());
    rotor.cross_late(now, 10 % 6, false);
    assert!(rotor.fade() > 0);
}

/// A rotor three times as fast as estimated shows its crossings late for more than a revolution. The next one
/// in time belongs to another revolution: the time since the last one gives no speed.
#[test]
fn a_revolution_of_late_crossings_is_measured_anew() {
    const SLOW: f64 = 30.0;
    const FAST: u32 = 10;
    for late in 5..12 {
        let (mut rotor, mut now) = fed(&steady(SLOW, 12));
        let mut sector = 0;
        for _ in 0..late {
            now = now.after(FAST);
            rotor.cross_late(now, sector, false);
            sector = (sector + 1) % 6;
        }
        for _ in 0..4 {
            now = now.after(FAST);
            assert!(cross(&mut rotor, now, sector, 0), "{late} late");
            let turns = f64::from(rotor.speed_bounded(now)) * 6.0 * f64::from(FAST) / f64::from(u32::MAX);
            assert!(turns > 0.6 && turns < 1.5, "{late} late: {turns} of its speed");
            sector = (sector + 1) % 6;
        }
    }
}

/// A level that is certainly before the crossing holds the angle there.
#[test]
fn a_rotor_that_has_not_crossed_is_not_commutated() {
    let (mut rotor, mut now) = fed(&steady(20.0, 10));
    for _ in 0..35 {
        now = now.next();
        rotor.wait(now, 10 % 6, false);
    }
    let angle = f64::from(rotor.angle(now)) / 2_f64.powi(32) * 360.0;
    assert!((angle - 300.0).abs() < 0.1, "the middle of sector 4: {angle}");
}

/// From a rotor without a known speed, neither a level that comes too late nor a threshold that is not at 0
/// gives a speed.
#[test]
fn nothing_is_made_of_a_first_sign() {
    let back_emf = Gain::from_ratio(1 << 16, 1).unwrap_or(Gain::ZERO);
    for late in [true, false] {
        let mut rotor = ZeroCrossing::default();
        let now = Instant::default();
        rotor.start(now, 0, Direction::Forward);
        if late {
            rotor.cross_late(now.next(), 1, false);
        } else {
            assert!(rotor.cross(now.next(), 1, (0, 1 << 16), back_emf, false));
        }
        assert_eq!((rotor.speed(), rotor.is_prepared()), (0, false), "late {late}");
    }
}

/// An estimator that is not run is in every tick in the state of one that is run in each, for any time.
#[test]
fn time_passes_for_an_estimator_that_nobody_asks() {
    for (interval, direction) in [2.17, 20.0, 300.3]
        .into_iter()
        .flat_map(|interval| [Direction::Forward, Direction::Reverse].map(|direction| (interval, direction)))
    {
        let (rotor, mut now) = fed_in(direction, &steady(interval, 10));
        let (sleeps, mut looks) = (rotor, rotor);
        // Longer than the time since a crossing that can be represented.
        for tick in 0..70_000 {
            now = now.next();
            looks.pass(now);
            let of = |rotor: &ZeroCrossing| (rotor.angle(now), rotor.since(now), rotor.speed_bounded(now));
            assert_eq!(of(&sleeps), of(&looks), "{interval} {direction:?}, tick {tick}");
            if tick % 1_000 == 0 {
                let mut woken = sleeps;
                woken.pass(now);
                assert_eq!(woken, looks, "{interval} {direction:?}, tick {tick}");
            }
        }
    }
}

/// Until a crossing is overdue its absence means nothing, and until the time-out silence does not: the
/// deadlines are early, never late.
#[test]
fn what_does_not_come_is_told_in_its_tick() {
    for (interval, direction) in [4.6, 20.0, 300.3]
        .into_iter()
        .flat_map(|interval| [Direction::Forward, Direction::Reverse].map(|direction| (interval, direction)))
    {
        let (rotor, mut now) = fed_in(direction, &steady(interval, 10));
        let sector = (0..10).fold(0, |sector, _| next_sector(direction, sector));
        let (overdue, timeout) = (rotor.overdue_at(sector), (1.7 * interval * TICK) as u32);
        assert!(
            !overdue.is_due(now.after((0.8 * interval) as u32)),
            "{interval} {direction:?}: far too early"
        );
        let (mut held, mut silent) = (0, 0);
        for tick in 1..=(2.0 * interval) as u32 {
            now = now.next();
            let mut told = rotor;
            let says = told.wait(now, sector, false);
            let holds = told.angle(now) != rotor.angle(now);
            assert_eq!(says, holds, "{interval} {direction:?}, tick {tick}");
            assert!(overdue.is_due(now) || !holds, "{interval} {direction:?}, tick {tick}");
            held += u32::from(holds);
            let is_silent = rotor.since(now) >= timeout;
            assert_eq!(
                rotor.silent_at(timeout).is_due(now),
                is_silent,
                "{interval} {direction:?}, tick {tick}"
            );
            silent += u32::from(is_silent);
        }
        assert!(held > 0 && silent > 0, "{interval} {direction:?}: {held} {silent}");
    }
}

#[test]
fn hand_over_waits_for_six_crossings_of_both_polarities() {
    for count in 1..9 {
        let (rotor, _) = fed(&steady(20.0, count));
        assert_eq!(rotor.is_prepared(), count >= usize::from(PREPARED), "{count}");
    }
}

#[test]
fn intervals_that_jump_by_half_are_a_desynchronisation() {
    let mut times = steady(20.0, 12);
    assert!(!fed(&times).0.is_irregular());
    for k in 0..30 {
        let last = times.last().copied().unwrap_or(0.0);
        times.push(last + if k % 2 == 0 { 40.0 } else { 22.0 });
    }
    assert!(fed(&times).0.is_irregular());
}

/// The terminals of a coasting motor give angle and direction of the rotor, in both directions.
#[test]
fn a_coasting_motor_is_heard_both_ways() {
    for (sign, direction) in [(1.0, Direction::Forward), (-1.0, Direction::Reverse)] {
        let mut listening = Listening::default();
        let mut now = Instant::default();
        let per_tick = 2.3 * sign;
        let mut worst = 0.0_f64;
        let mut received = 0;
        for tick in 0..600 {
            let angle = 77.0 + per_tick * f64::from(tick);
            let emf = |phase: f64| sign * 2.0 * (angle - 120.0 * phase).to_radians().sin();
            let emfs = [emf(0.0), emf(1.0), emf(2.0)];
            let lowest = emfs.iter().copied().fold(0.0, f64::min);
            let neutral = (-0.8 - lowest).max(0.0);
            let codes = emfs.map(|emf| ((neutral + emf).max(0.0) * 1e3).round() as u16);
            now = now.next();
            if let Some(found) = listening.step(&coefficients(), now, &codes, 0) {
                assert_eq!(found.direction, direction);
                received += 1;
                let place = f64::from(found.place) * 30.0 + per_tick * f64::from(found.age) / TICK;
                worst = worst.max(((angle - place + 180.0).rem_euclid(360.0) - 180.0).abs());
            }
        }
        assert!(listening.is_turning() && listening.direction() == direction);
        assert!(received >= 10 && worst < 2.0, "{received} places, at most {worst} degrees off");
    }
}

/// Samples without news may be left out: a listener that rests then is in every tick in the state of one that
/// evaluates all of them.
#[test]
fn a_listener_that_rests_is_one_that_looks() {
    let (mut rested, mut received) = (0, 0);
    for sign in [1.0, -1.0] {
        let (mut sleeps, mut looks) = (Listening::default(), Listening::default());
        let mut now = Instant::default();
        for tick in 0..3_000 {
            // It coasts down until there is no signal, and if a terminal reads too much it is always the
            // highest.
            let fades = 1.0 - f64::from(tick) / 2_500.0;
            let angle = 77.0 + sign * 1_500.0 * (1.0 - fades * fades);
            let emf = |phase: f64| sign * 2.0 * fades.max(0.0) * (angle - 120.0 * phase).to_radians().sin();
            let emfs = [emf(0.0), emf(1.0), emf(2.0)];
            let lowest = emfs.iter().copied().fold(0.0, f64::min);
            let neutral = (-0.8 - lowest).max(0.0);
            let mut codes = emfs.map(|emf| ((neutral + emf).max(0.0) * 1e3).round() as u16);
            if tick > 2_800 {
                codes[1] += 900;
            }
            now = now.next();
            let sample_at = (tick % 3) as u16 * 20_000;
            let expected = looks.step(&coefficients(), now, &codes, sample_at);
            let found = if sleeps.rests(&coefficients(), now, &codes, sample_at) {
                rested += 1;
                None
            } else {
                sleeps.step(&coefficients(), now, &codes, sample_at)
            };
            received += u32::from(found.is_some());
            assert_eq!(found, expected, "{sign}, tick {tick}");
            assert_eq!(sleeps, looks, "{sign}, tick {tick}");
        }
    }
    assert!(rested > 5_000 && received > 15, "{rested} of 6000 ticks, {received} places");
}

#[test]
fn a_motor_at_rest_is_quiet() {
    let mut listening = Listening::default();
    let mut now = Instant::default();
    for _ in 0..100 {
        now = now.next();
        assert!(listening.step(&coefficients(), now, &[0, 20, 0], 0).is_none());
    }
    assert!(!listening.is_turning() && listening.quiet(now) >= 90);
}

/// An offset of the converter makes one terminal permanently the highest: that is a signal, but no rotation.
#[test]
fn an_offset_is_no_rotation() {
    let mut listening = Listening::default();
    let mut now = Instant::default();
    for _ in 0..100 {
        now = now.next();
        listening.step(&coefficients(), now, &[0, 900, 0], 0);
    }
    assert!(!listening.is_turning() && listening.quiet(now) == 0 && listening.still(now) >= 90);
}

/// At two ticks per sector the commutation was taken at the end of the period in whose beginning the crossing
/// before it came; that edge counts.
#[test]
fn an_edge_before_the_commutation_of_its_period_counts() {
    let c = BackEmfCoefficients { comparator: true, discard: 0, ..coefficients() };
    let mut station = Station::default();
    let edge = |instant, code| Edge { instant, source: EdgeSource::Comparator, code };
    let mut tick = |step, then: Option<Step>, edges: &[Edge]| {
        let samples = Samples { edges: edges.iter().copied().collect(), ..Samples::default() };
        let mut applied = PwmCommand { step, ..PwmCommand::default() };
        if let Some(step) = then {
            applied.commutations.push(Commutation { instant: 60_000, step });
        }
        station.step(&c, &samples, 0, &applied, &forward(2 << 16))
    };
    tick(Step::CB, None, &[]);
    // AB floats C, whose crossing falls.
    tick(Step::AB, None, &[edge(9_000, 0b100)]);
    let seen = tick(Step::AB, Some(Step::AC), &[edge(6_000, 0)]);
    let sector = Step::AB.sector().unwrap();
    assert_eq!(seen.end, End::Crossing { sector, age: 65_536 - 6_000 });
    // The new step's own crossing has not come yet.
    assert_eq!((seen.sector, seen.found), (Step::AC.sector(), false));
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

/// The applied voltage is compared with k omega: a lock at a wrong speed is found; a hot or cold motor under
/// load is not reported.
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
    // The voltage that a hot winding could take at a high current is allowed.
    assert!(judge(0.5, 0.1, 2.0, 100.0, 50.0), "half the speed is claimed");
}

/// A motor of which neither constant is known has no wrong lock, because its voltage contradicts nothing.
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
