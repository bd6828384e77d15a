//! The promises about starting: share of successful starts, and time to closed loop.

use super::operating::Point;
use super::start::Start;
use super::trial::Trial;
use super::{Context, picture};
use crate::pwm_rate;
use narx_core::commissioning::Mode;
use narx_core::motor::{Board, State};
use narx_host::parallel::map;
use narx_report::figures::{Figure, Part};
use narx_sim::plant::PlantConfig;
use narx_sim::presets::{PRESETS, Preset};
use std::fs;

/// Share of starts that succeed within Auto-restart, %.
const STARTED: f64 = 99.9;
/// Longest time from the request to closed loop at nominal inertia and at any corner, s.
const SOON: (f64, f64) = (0.8, 3.0);
/// Largest peak phase current: 12 A (Table 1), and 5 % in the windings.
const PEAK: f64 = 12.6;

/// Seeds of a series.
pub(super) fn cases(seed: u64, runs: u64) -> Vec<u64> {
    (0..runs).map(|run| seed.wrapping_mul(1_000_000).wrapping_add(run)).collect()
}

/// Measures starts of random plants, and draws their picture.
pub(super) fn part(context: &Context<'_>) -> Part {
    let starts: Vec<Start> =
        map(&context.cases, |case| Start::run(*case, &context.board)).into_iter().flatten().collect();
    let mut part = judge(&starts, context);
    let drawn = picture::svg(&starts).and_then(|picture| {
        let path = pwm_rate::file(&context.out.join("starts.svg"), &context.board);
        fs::create_dir_all(context.out)
            .and_then(|()| fs::write(&path, picture))
            .map_err(|error| format!("{}: {error}", path.display()))
    });
    part.failures.extend(drawn.err());
    part
}

fn judge(starts: &[Start], context: &Context<'_>) -> Part {
    let count = |holds: fn(&Start) -> bool| starts.iter().filter(|start| holds(start)).count();
    let (first, started) = (count(Start::started_at_once), count(Start::started));
    let unaccounted = starts.len() - count(Start::is_accounted_for);
    let share = |count: usize| 100.0 * count as f64 / starts.len().max(1) as f64;
    let slowest = starts.iter().map(|start| start.to_closed_loop).fold(0.0, f64::max);
    let mut times: Vec<f64> = starts.iter().filter(|s| s.started()).map(|s| s.to_closed_loop).collect();
    times.sort_by(f64::total_cmp);
    let median = times.get(times.len() / 2).copied().unwrap_or(f64::INFINITY);
    let peak = starts.iter().map(|start| start.peak_current).fold(0.0, f64::max);
    let beyond =
        |start: &&Start| !start.started() || start.to_closed_loop > SOON.1 || start.peak_current > PEAK;
    let rate = pwm_rate::argument(&context.board);
    let failures = starts.iter().filter(beyond).map(|start| {
        let Start { case, to_closed_loop, peak_current, .. } = start;
        format!("{start}; closed loop after {to_closed_loop:.2} s, {peak_current:.1} A: cargo xtask bench --case {case}{rate}")
    });
    Part::new(
        vec![
            Figure::new("sensorless starts of random plants, within Auto-restart", share(started), "%")
                .at_least(STARTED)
                .note(format!("{started} of {}", starts.len())),
            Figure::new("of these at the first try", share(first), "%")
                .note(format!("{first} of {}", starts.len())),
            Figure::new("ends that are neither a start, Standby nor a named fault", unaccounted as f64, "")
                .at_most(0.0),
            Figure::new("seeds that draw no plant", (context.cases.len() - starts.len()) as f64, "")
                .at_most(0.0),
            Figure::new("request to closed loop, random plants, slowest", slowest, "s").at_most(SOON.1),
            Figure::new("request to closed loop, random plants, median", median, "s"),
            Figure::new("phase current, random plants, peak", peak, "A").at_most(PEAK).note("12 A and 5 %"),
        ],
        failures.collect(),
    )
}

/// Measures every preset with the values of its data sheet, at four supplies, each with the slowest of eight
/// angles.
pub(super) fn nominal(context: &Context<'_>) -> Part {
    let mut points = Vec::new();
    for preset in &PRESETS {
        points.extend([18.0, 24.0, 48.0, 60.0].map(|supply| (preset, supply)));
    }
    let times = map(&points, |(preset, supply)| {
        let angles = (0..8).map(|eighth| 45.0 * f64::from(eighth));
        angles.map(|angle| to_closed_loop(preset, *supply, angle, &context.board)).fold(0.0, f64::max)
    });
    let slowest = times.iter().copied().fold(0.0, f64::max);
    let late = points.iter().zip(&times).filter(|(_, time)| **time > SOON.0);
    let failures: Vec<String> =
        late.map(|((preset, supply), time)| format!("{} at {supply} V: {time:.2} s", preset.name)).collect();
    let figure = Figure::new("request to closed loop, presets, slowest", slowest, "s").at_most(SOON.0);
    Part::new(vec![figure.note(format!("{} motors and supplies, 8 angles each", points.len()))], failures)
}

/// Time from the request to state 4, s; infinite if it takes more than 5 s, 0 if commissioning refuses the
/// motor.
fn to_closed_loop(preset: &Preset, supply: f64, angle_deg: f64, board: &Board) -> f64 {
    let point = Point { board: *board, preset, mode: Mode::Sensorless, supply, load: 0.0, rpm: None };
    let Ok(commissioning) = point.commission() else { return 0.0 };
    let plant = PlantConfig { angle_deg, ..point.plant() };
    let mut trial = Trial::new(&plant, &commissioning, "", false);
    trial.start((0.5 * (commissioning.speed_min + commissioning.speed_max)) as i32);
    trial.until(5.0, |trial| trial.state() == State::SensorlessClosedLoop).unwrap_or(f64::INFINITY)
}
