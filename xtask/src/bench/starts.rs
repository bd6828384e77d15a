//! The promises about starting: how often, and how soon.

use super::report::Row;
use super::start::Start;
use super::trial::Trial;
use narx_core::motor::State;
use narx_host::parallel::map;
use narx_sim::commissioning::{Mode, Nameplate};
use narx_sim::plant::PlantConfig;
use narx_sim::presets::{PRESETS, Preset};

/// Starts that succeed within Auto-restart, share.
const STARTED: f64 = 0.999;
/// Request to closed loop at nominal inertia and at any corner, s.
const SOON: (f64, f64) = (0.8, 3.0);
/// Peak phase current (Table 1: 12 A) and 5 % in the windings.
const PEAK: f64 = 12.6;

/// The seeds of a series.
pub(super) fn cases(seed: u64, runs: u64) -> Vec<u64> {
    (0..runs).map(|run| seed.wrapping_mul(1_000_000).wrapping_add(run)).collect()
}

/// From the starts of random plants.
pub(super) fn rows(starts: &[Start], asked: usize) -> Vec<Row> {
    let count = |holds: fn(&Start) -> bool| starts.iter().filter(|start| holds(start)).count();
    let (first, started) = (count(Start::started_at_once), count(Start::started));
    let accounted = count(Start::is_accounted_for);
    let share = |count: usize| count as f64 / starts.len().max(1) as f64;
    let list = |holds: &dyn Fn(&Start) -> bool| -> Vec<String> {
        let chosen = starts.iter().filter(|start| holds(start));
        chosen.map(|start| format!("{start}\n    cargo xtask bench --case {}", start.case)).collect()
    };
    let slowest = starts.iter().map(|start| start.to_closed_loop).fold(0.0, f64::max);
    let mut times: Vec<f64> = starts.iter().filter(|s| s.started()).map(|s| s.to_closed_loop).collect();
    times.sort_by(f64::total_cmp);
    let median = times.get(times.len() / 2).copied().unwrap_or(0.0);
    let peak = starts.iter().map(|start| start.peak_current).fold(0.0, f64::max);
    vec![
        Row {
            promise: "sensorless start, random plants",
            goal: ">= 99.9 % within Auto-restart",
            measured: format!(
                "{:.2} % ({started} of {}); first try {:.2} % ({first})",
                100.0 * share(started),
                starts.len(),
                100.0 * share(first)
            ),
            met: share(started) >= STARTED && starts.len() == asked,
            figures: vec![("first_try", share(first)), ("within_auto_restart", share(started))],
            failures: list(&|start| !start.started()),
        },
        Row {
            promise: "every other start",
            goal: "Standby or a named fault",
            measured: format!("{} of {} that did not start", accounted - started, starts.len() - started),
            met: accounted == starts.len(),
            figures: vec![("unaccounted", (starts.len() - accounted) as f64)],
            failures: list(&|start| !start.is_accounted_for()),
        },
        Row {
            promise: "request to closed loop, random plants",
            goal: "<= 3 s at any corner",
            measured: format!("{slowest:.2} s slowest, {median:.2} s median"),
            met: slowest <= SOON.1,
            figures: vec![("slowest_s", slowest), ("median_s", median)],
            failures: list(&|start| start.to_closed_loop > SOON.1),
        },
        Row {
            promise: "phase current, random plants",
            goal: "<= 12 A + 5 % peak",
            measured: format!("{peak:.1} A"),
            met: peak <= PEAK,
            figures: vec![("peak_a", peak)],
            failures: list(&|start| start.peak_current > PEAK),
        },
    ]
}

/// Every preset as its data sheet has it, at four supplies, each the slowest of eight angles.
pub(super) fn nominal(_: &[u64]) -> Vec<Row> {
    let mut points = Vec::new();
    for preset in &PRESETS {
        points.extend([18.0, 24.0, 48.0, 60.0].map(|supply| (preset, supply)));
    }
    let times = map(&points, |(preset, supply)| {
        let angles = (0..8).map(|eighth| 45.0 * f64::from(eighth));
        angles.map(|angle| to_closed_loop(preset, *supply, angle)).fold(0.0, f64::max)
    });
    let slowest = times.iter().copied().fold(0.0, f64::max);
    let late = points.iter().zip(&times).filter(|(_, time)| **time > SOON.0);
    let failures: Vec<String> =
        late.map(|((preset, supply), time)| format!("{} at {supply} V: {time:.2} s", preset.name)).collect();
    vec![Row {
        promise: "request to closed loop, presets",
        goal: "<= 0.8 s at nominal inertia",
        measured: format!("{slowest:.2} s slowest of {} from 8 angles each", points.len()),
        met: failures.is_empty(),
        figures: vec![("slowest_s", slowest), ("runs", 8.0 * points.len() as f64)],
        failures,
    }]
}

/// Seconds from the request to state 4; infinite if it takes more than 5 s, 0 for what commissioning refuses.
fn to_closed_loop(preset: &Preset, supply: f64, angle_deg: f64) -> f64 {
    let plate = Nameplate {
        motor: preset.motor,
        rated_current: preset.data.rated_current,
        supply,
        open_loop_speed: None,
    };
    let Ok(commissioning) = plate.commission(Mode::Sensorless) else { return 0.0 };
    let plant = PlantConfig { angle_deg, ..PlantConfig::new(preset.motor, supply) };
    let mut trial = Trial::new(&plant, &commissioning, "", false);
    trial.start((0.5 * (commissioning.speed_min + commissioning.speed_max)) as i32);
    trial.until(5.0, |trial| trial.state() == State::SensorlessClosedLoop).unwrap_or(f64::INFINITY)
}
