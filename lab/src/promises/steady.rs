//! The promises about steady running: speed, jitter, angle of commutation.

use super::Context;
use super::operating::{Figures, Point, SETTLE, measure};
use super::trial::Trial;
use crate::pwm_rate;
use narx_core::commissioning::Mode;
use narx_core::motor::{Board, State};
use narx_host::parallel::map;
use narx_report::figures::{Figure, Part};
use narx_sim::presets::PRESETS;
use narx_sim::random_plant::{RandomPlant, Spread};

/// Electrical speeds: 500 to 4000 rpm with 4 pole pairs, rpm.
const ELECTRICAL_RPM: [f64; 4] = [2_000.0, 4_000.0, 8_000.0, 16_000.0];
/// Random plants: every 20th of the series, and at most this many.
const EVERY: usize = 20;
const PLANTS_MAX: usize = 500;

/// Name of a run, and its figures.
type Named = (String, Figures);

/// Measures presets at the four speeds, without and with rated load, and some of the random plants.
pub(super) fn part(context: &Context<'_>) -> Part {
    let mut points = Vec::new();
    for preset in &PRESETS {
        let supply = preset.data.nominal_voltage.clamp(18.0, 60.0);
        for electrical in ELECTRICAL_RPM {
            let rpm = Some((electrical / f64::from(preset.motor.pole_pairs)).ceil());
            points.extend([0.0, 1.0].map(|load| Point {
                board: context.board,
                preset,
                mode: Mode::Sensorless,
                supply,
                load,
                rpm,
            }));
        }
    }
    let allowed: Vec<Point<'_>> = points.into_iter().filter(|point| point.plan().is_ok()).collect();
    let of_presets = map(&allowed, |point| (name(point), point.run()));
    let chosen: Vec<u64> = context.cases.iter().copied().step_by(EVERY).take(PLANTS_MAX).collect();
    let of_plants: Vec<(String, Result<Figures, String>)> =
        map(&chosen, |case| random(*case, &context.board)).into_iter().flatten().collect();
    let mut part = judge("presets", of_presets);
    part.join(judge("random plants", of_plants));
    part
}

fn name(point: &Point<'_>) -> String {
    let (preset, rpm) = (point.preset.name, point.rpm.unwrap_or(0.0));
    format!("{preset} at {} V, {rpm:.0} rpm, {:.0} % load", point.supply, 100.0 * point.load)
}

/// Runs a random plant at its own set-point if that is within the promised speeds.
fn random(case: u64, board: &Board) -> Option<(String, Result<Figures, String>)> {
    let drawn = RandomPlant::new(case, &Spread::PROMISED, board)?;
    let electrical = f64::from(drawn.rpm.abs()) * f64::from(drawn.preset.motor.pole_pairs);
    if electrical > ELECTRICAL_RPM[3] {
        return None;
    }
    let mut trial = Trial::new(&drawn.plant, &drawn.commissioning, "", false);
    let figures = measure(&mut trial, drawn.rpm, State::SensorlessClosedLoop, SETTLE);
    // A plant that cannot reach its set-point is limited by torque or supply: only steady running is
    // judged here.
    let limited = figures.as_ref().map_or_else(|why| why.starts_with("set-point"), |f| !f.unlimited);
    let rate = pwm_rate::argument(board);
    let name = format!("{} at {} rpm, cargo xtask bench --case {case}{rate}", drawn.preset.name, drawn.rpm);
    (!limited).then_some((name, figures))
}

fn judge(what: &str, results: Vec<(String, Result<Figures, String>)>) -> Part {
    let mut failures = Vec::new();
    let mut figures: Vec<Named> = Vec::new();
    for (name, result) in results {
        match result {
            Ok(reached) => figures.push((name, reached)),
            Err(why) => failures.push(format!("{name}: {why}")),
        }
    }
    let lost = failures.len();
    let mut row = |name: &str, limit: f64, unit: &str, of: fn(&Figures) -> f64| {
        let worst = figures.iter().map(|(_, f)| of(f).abs()).reduce(f64::max).unwrap_or(f64::NAN);
        let beyond = figures.iter().filter(|(_, f)| of(f).abs() > limit);
        let beyond: Vec<String> =
            beyond.map(|(run, f)| format!("{run}: {name} {:.2} {unit}", of(f))).collect();
        let note = format!("{} runs, {} outside", figures.len(), beyond.len());
        failures.extend(beyond);
        Figure::new(format!("{name}, {what}, worst"), worst, unit).at_most(limit).note(note)
    };
    let mut rows = vec![
        row("steady speed error", 0.5, "%", |f| 100.0 * f.error),
        row("jitter of commutation, rms of a period", 2.0, "%", |f| 100.0 * f.jitter),
        row("commutation angle, mean", 2.0, "deg", |f| f.angle_mean),
        row("commutation angle, furthest", 5.0, "deg", |f| f.angle_worst),
    ];
    rows.push(
        Figure::new(format!("steady runs that did not come about, {what}"), lost as f64, "").at_most(0.0),
    );
    Part::new(rows, failures)
}
