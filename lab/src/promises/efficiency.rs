//! Efficiency at rated load against the manual's 90 % (Table 1), of the bridge and of the whole drive with
//! its motor.

use super::Context;
use super::operating::Point;
use narx_core::commissioning::Mode;
use narx_host::parallel::map;
use narx_report::figures::{Figure, Part};
use narx_sim::presets::PRESETS;

/// The manual's figure.
const GOAL: f64 = 0.9;

/// Measures every preset at its nominal supply, at rated torque in the middle of its speed range or at the
/// speed that the ratings allow.
pub(super) fn part(context: &Context<'_>) -> Part {
    let points: Vec<Point<'_>> = PRESETS
        .iter()
        .map(|preset| Point {
            board: context.board,
            preset,
            mode: Mode::Sensorless,
            supply: preset.data.nominal_voltage.clamp(18.0, 60.0),
            load: 1.0,
            rpm: None,
        })
        .filter(|point| point.plan().is_ok())
        .collect();
    let results = map(&points, Point::run);
    let named = || points.iter().zip(&results);
    let stage: Vec<f64> = results.iter().flatten().map(|figures| figures.stage_efficiency).collect();
    let drive: Vec<f64> = results.iter().flatten().map(|figures| figures.drive_efficiency).collect();
    let failures: Vec<String> = named()
        .filter_map(|(point, result)| match result {
            Ok(figures) if figures.stage_efficiency >= GOAL => None,
            Ok(figures) => Some(format!("{}: {:.1} %", point.preset.name, 100.0 * figures.stage_efficiency)),
            Err(why) => Some(format!("{}: {why}", point.preset.name)),
        })
        .collect();
    let least = |values: &[f64]| 100.0 * values.iter().copied().reduce(f64::min).unwrap_or(f64::NAN);
    let most = |values: &[f64]| 100.0 * values.iter().copied().reduce(f64::max).unwrap_or(f64::NAN);
    let note = format!(
        "{} presets of {}, the others' ratings leave no rated load; Table 1 says 90 %",
        stage.len(),
        PRESETS.len()
    );
    Part::new(
        vec![
            Figure::new("efficiency of the bridge at rated load, least", least(&stage), "%")
                .at_least(100.0 * GOAL)
                .note(note),
            Figure::new("efficiency of the bridge at rated load, most", most(&stage), "%"),
            Figure::new("efficiency from supply to shaft at rated load, least", least(&drive), "%"),
            Figure::new("efficiency from supply to shaft at rated load, most", most(&drive), "%"),
        ],
        failures,
    )
}
