//! Speed range, sensorless: ratio of each preset's largest set-point to the slowest that it holds.

use super::Context;
use super::operating::Point;
use super::trial::Trial;
use narx_core::commissioning::{Commissioning, Mode};
use narx_core::dictionary::engineering;
use narx_core::dictionary::number;
use narx_core::motor::{Board, State};
use narx_host::parallel::map;
use narx_report::figures::{Figure, Part};
use narx_sim::plant::LoadConfig;
use narx_sim::presets::{PRESETS, Preset};
use std::f64::consts::TAU;

/// Ratio of largest to smallest speed that half of the presets must reach: at a PWM rate below 20 kHz, and
/// from there on.
const RANGE: [f64; 2] = [50.0, 100.0];
/// Least time without a crossing after which the rotor stands (the factory value of parameter 85), s; at the
/// slowest set-points a sector takes longer.
const TIME_OUT: f64 = 0.05;
/// Largest deviation of the mean speed over a second, share of the set-point.
const NEAR: f64 = 0.01;

/// Measures each preset at the best of four supplies.
pub(super) fn part(context: &Context<'_>) -> Part {
    let presets: Vec<&Preset> = PRESETS.iter().collect();
    let results = map(&presets, |preset| best(preset, context.board));
    let [low, high] = RANGE;
    let goal = if context.board.tick_rate < 20_000 { low } else { high };
    let reached = results.iter().filter(|(range, _)| *range >= goal).count();
    let each: Vec<String> = presets
        .iter()
        .zip(&results)
        .map(|(preset, (range, supply))| format!("{} 1:{range:.0} ({supply:.0} V)", preset.name))
        .collect();
    let share = 100.0 * reached as f64 / results.len().max(1) as f64;
    let name = format!("presets with a speed range of 1:{goal}, sensorless");
    let figure = Figure::new(name, share, "%").at_least(50.0);
    Part::new(vec![figure.note(each.join(", "))], Vec::new())
}

/// Largest range that is held, and its supply.
fn best(preset: &'static Preset, board: Board) -> (f64, f64) {
    let supplies = [18.0, 24.0, 48.0, 60.0];
    supplies
        .into_iter()
        .map(|supply| Point { board, preset, mode: Mode::Sensorless, supply, load: 0.0, rpm: None })
        .map(|point| (range(&point), point.supply))
        .fold((0.0, 0.0), |best, next| if next.0 > best.0 { next } else { best })
}

/// Ratio of the largest set-point to the slowest that is held within 1 %, without load.
fn range(point: &Point<'_>) -> f64 {
    let Ok(plan) = point.plan() else { return 0.0 };
    let top = plan.commissioning.speed_max.floor();
    if held(point, top, top).is_none() {
        return 0.0;
    }
    [100.0, 70.0, 50.0, 40.0, 30.0, 20.0, 10.0, 5.0, 2.0]
        .into_iter()
        .find(|share| held(point, top, (top / share).floor()).is_some())
        .unwrap_or(1.0)
}

/// Mean speed if it is held for a second within 1 %, with the smallest set-point lowered to it.
fn held(point: &Point<'_>, top: f64, rpm: f64) -> Option<f64> {
    let commissioning = commission(point, rpm.min(top))?;
    let mut plant = point.plant();
    plant.angle_deg = 77.0;
    plant.load = LoadConfig::default();
    let mut trial = Trial::new(&plant, &commissioning, "", false);
    trial.start(rpm as i32);
    let closed = |trial: &Trial| trial.state() == State::SensorlessClosedLoop;
    trial.until(5.0, closed)?;
    let near = |trial: &Trial| (trial.seen().speed * 60.0 / TAU / rpm - 1.0).abs() < 0.05;
    trial.until(8.0, near)?;
    trial.run_while(1.0, |_| true);
    let mean = trial.mean_rpm(1.0);
    (closed(&trial) && (mean / rpm - 1.0).abs() < NEAR).then_some(mean)
}

fn commission(point: &Point<'_>, least: f64) -> Option<Commissioning> {
    let mut commissioning = point.commission().ok()?;
    let mut set = |number, value| engineering::set(&mut commissioning.parameters, number, value).ok();
    if least < commissioning.speed_min {
        set(number::SPEED_MIN_SL, least)?;
        // In 100 us; six sectors are an electrical revolution.
        let sector = 10.0 / (least * f64::from(point.preset.motor.pole_pairs));
        set(number::ZC_PERIOD_MAX, TIME_OUT.max(2.0 * sector) * 10_000.0)?;
    }
    Some(commissioning)
}
