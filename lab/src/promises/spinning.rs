//! The promise about a rotor that turns already when the motor is requested to run: forward it is caught,
//! backward it is braked and started.

use super::Context;
use super::operating::Point;
use super::trial::Trial;
use narx_core::commissioning::Mode;
use narx_core::motor::Board;
use narx_core::motor::control::limits::Limiter;
use narx_host::parallel::map;
use narx_report::figures::{Figure, Part};
use narx_sim::plant::{LoadConfig, PlantConfig};
use narx_sim::presets::{PRESETS, Preset};
use std::f64::consts::TAU;

/// Longest time from the request until the motor is led, s.
const SOON: f64 = 0.5;
/// Speeds of the rotor, shares of the set-point.
const SHARES: [f64; 3] = [0.1, 0.3, 1.0];

/// Measures every preset at its nominal supply, turned by a machine until the request.
pub(super) fn part(context: &Context<'_>) -> Part {
    let mut part = Part::default();
    for (sign, way) in [(1.0, "forward"), (-1.0, "backward")] {
        let points: Vec<(&Preset, f64)> =
            PRESETS.iter().flat_map(|preset| SHARES.map(|share| (preset, sign * share))).collect();
        let times = map(&points, |(preset, share)| until_led(preset, *share, &context.board));
        let slowest = times.iter().copied().fold(0.0, f64::max);
        let late: Vec<String> = points
            .iter()
            .zip(&times)
            .filter(|(_, time)| **time > SOON)
            .map(|((preset, share), time)| {
                format!("{} at {:.0} % {time:.2} s", preset.name, 100.0 * share.abs())
            })
            .collect();
        let soon = 100.0 * (points.len() - late.len()) as f64 / points.len() as f64;
        let name = format!("rotor that turns {way}, led within {SOON} s of the request, presets");
        part.figures.push(Figure::new(&name, soon, "%").note(late.join(", ")));
        let name = format!("rotor that turns {way}, request until it is led, presets, slowest");
        let figure = Figure::new(&name, slowest, "s");
        part.figures.push(figure.note("at 10, 30 and 100 % of the middle of the range, nominal supply"));
    }
    part
}

/// Time from the request until the bridge leads a rotor in the direction of the request, at the slowest speed
/// of its closed loop or faster, s; the rotor turns with `share` of the set-point at the request. Infinite if
/// it takes more than 5 s, or commissioning refuses the motor.
fn until_led(preset: &Preset, share: f64, board: &Board) -> f64 {
    let supply = preset.data.nominal_voltage.clamp(18.0, 60.0);
    let point = Point { board: *board, preset, mode: Mode::Sensorless, supply, load: 0.0, rpm: None };
    let Ok(commissioning) = point.commission() else { return f64::INFINITY };
    let rpm = (0.5 * (commissioning.speed_min + commissioning.speed_max)) as i32;
    let speed = share * f64::from(rpm) / 60.0 * TAU;
    // The machine overcomes the friction at this speed, and lets go of the shaft with the request.
    let friction = preset.motor.static_friction + preset.motor.viscous_friction * speed.abs();
    let load = LoadConfig { machine: -friction * speed.signum(), ..LoadConfig::default() };
    let plant = PlantConfig { speed, load, ..point.plant() };
    let mut trial = Trial::new(&plant, &commissioning, "", false);
    trial.bench.plant_mut().set_load(LoadConfig::default());
    trial.start(rpm);
    let least = commissioning.speed_min / 60.0 * TAU;
    let led = |trial: &Trial| trial.bench.status().limiter != Limiter::Off && trial.seen().speed >= least;
    trial.until(5.0, led).unwrap_or(f64::INFINITY)
}
