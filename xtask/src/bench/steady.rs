//! The promises about steady running: speed, jitter, angle of commutation.

use super::operating::{Figures, Point, measure};
use super::report::Row;
use super::trial::Trial;
use narx_host::parallel::map;
use narx_sim::commissioning::Mode;
use narx_sim::presets::PRESETS;
use narx_sim::random_plant::{RandomPlant, Spread};

/// 500 to 4000 rpm with 4 pole pairs, electrical rpm.
const ELECTRICAL_RPM: [f64; 4] = [2_000.0, 4_000.0, 8_000.0, 16_000.0];
/// Random plants: one of so many of the series, and at most so many.
const EVERY: usize = 20;
const PLANTS_MAX: usize = 500;

/// A figure with the run it is of.
type Named = (String, Figures);

/// Presets at the four speeds, without and with rated load, and some of the random plants.
pub(super) fn rows(cases: &[u64]) -> Vec<Row> {
    let mut points = Vec::new();
    for preset in &PRESETS {
        let supply = preset.data.nominal_voltage.clamp(18.0, 60.0);
        for electrical in ELECTRICAL_RPM {
            let rpm = Some((electrical / f64::from(preset.motor.pole_pairs)).ceil());
            points.extend([0.0, 1.0].map(|load| Point { preset, mode: Mode::Sensorless, supply, load, rpm }));
        }
    }
    let allowed: Vec<Point> = points.into_iter().filter(|point| point.plan().is_ok()).collect();
    let of_presets = map(&allowed, |point| (name(point), point.run()));
    let chosen: Vec<u64> = cases.iter().copied().step_by(EVERY).take(PLANTS_MAX).collect();
    let of_plants: Vec<(String, Result<Figures, String>)> =
        map(&chosen, |case| random(*case)).into_iter().flatten().collect();
    let mut rows = judge("presets", PRESET_ROWS, of_presets);
    rows.extend(judge("random plants", PLANT_ROWS, of_plants));
    rows
}

fn name(point: &Point) -> String {
    let (preset, rpm) = (point.preset.name, point.rpm.unwrap_or(0.0));
    format!("{preset} at {} V, {rpm:.0} rpm, {:.0} % load", point.supply, 100.0 * point.load)
}

/// A random plant at its own set-point where that is within the promised speeds.
fn random(case: u64) -> Option<(String, Result<Figures, String>)> {
    let drawn = RandomPlant::new(case, &Spread::PROMISED)?;
    let electrical = f64::from(drawn.rpm.abs()) * f64::from(drawn.preset.motor.pole_pairs);
    if electrical > ELECTRICAL_RPM[3] {
        return None;
    }
    let mut trial = Trial::new(&drawn.plant, &drawn.commissioning, "", false);
    let figures = measure(&mut trial, drawn.rpm, Mode::Sensorless);
    // What cannot reach its set-point is held back by torque or supply: only steady running is judged here.
    let limited = figures.as_ref().map_or_else(|why| why.starts_with("set-point"), |f| !f.unlimited);
    let name = format!("{} at {} rpm, cargo xtask bench --case {case}", drawn.preset.name, drawn.rpm);
    (!limited).then_some((name, figures))
}

const PRESET_ROWS: [&str; 4] = [
    "steady speed error, presets",
    "crossing jitter, presets",
    "commutation angle, mean, presets",
    "commutation angle, worst, presets",
];
const PLANT_ROWS: [&str; 4] = [
    "steady speed error, random plants",
    "crossing jitter, random plants",
    "commutation angle, mean, random plants",
    "commutation angle, worst, random plants",
];

fn judge(what: &str, names: [&'static str; 4], results: Vec<(String, Result<Figures, String>)>) -> Vec<Row> {
    let mut lost = Vec::new();
    let mut figures: Vec<Named> = Vec::new();
    for (name, result) in results {
        match result {
            Ok(reached) => figures.push((name, reached)),
            Err(why) => lost.push(format!("{name}: {why}")),
        }
    }
    let row = |promise, goal, limit: f64, unit: &str, of: fn(&Figures) -> f64| {
        let worst = figures.iter().map(|(_, f)| of(f).abs()).fold(0.0, f64::max);
        let beyond = figures.iter().filter(|(_, f)| of(f).abs() > limit);
        let mut failures: Vec<String> =
            beyond.map(|(name, f)| format!("{name}: {:.2} {unit}", of(f))).collect();
        let outside = failures.len();
        failures.extend(lost.iter().cloned());
        Row {
            promise,
            goal,
            measured: format!(
                "{worst:.2} {unit} worst of {} {what}; {outside} outside, {} not run",
                figures.len(),
                lost.len()
            ),
            met: failures.is_empty() && !figures.is_empty(),
            figures: vec![("worst", worst), ("runs", figures.len() as f64), ("outside", outside as f64)],
            failures,
        }
    };
    let [error, jitter, mean, worst] = names;
    vec![
        row(error, "<= 0.5 % mean", 0.5, "%", |f| 100.0 * f.error),
        row(jitter, "<= 2 % of a period, rms", 2.0, "%", |f| 100.0 * f.jitter),
        row(mean, "<= 2 degrees electrical", 2.0, "deg", |f| f.angle_mean),
        row(worst, "<= 5 degrees electrical", 5.0, "deg", |f| f.angle_worst),
    ]
}
