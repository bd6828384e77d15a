//! Efficiency at rated load against the manual's 90 % (Table 1), of the bridge and of the whole drive with its motor.

use super::operating::Point;
use super::report::Row;
use narx_host::parallel::map;
use narx_sim::commissioning::Mode;
use narx_sim::presets::PRESETS;

/// The manual's figure.
const GOAL: f64 = 0.9;

/// Every preset at its nominal supply, rated torque at the middle of its range or where the ratings leave it.
pub(super) fn rows(_: &[u64]) -> Vec<Row> {
    let points: Vec<Point> = PRESETS
        .iter()
        .map(|preset| Point {
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
    let least = |values: &[f64]| 100.0 * values.iter().copied().fold(1.0, f64::min);
    let most = |values: &[f64]| 100.0 * values.iter().copied().fold(0.0, f64::max);
    vec![Row {
        promise: "efficiency at rated load, presets",
        goal: ">= 90 % (Table 1), bridge",
        measured: format!(
            "bridge {:.1} to {:.1} %; with the motor, supply to shaft, {:.1} to {:.1} %; {} presets",
            least(&stage),
            most(&stage),
            least(&drive),
            most(&drive),
            stage.len()
        ),
        met: failures.is_empty() && !stage.is_empty(),
        figures: vec![("bridge_least", least(&stage)), ("drive_least", least(&drive))],
        failures,
    }]
}
