//! The promise about load steps: from no load to rated torque at once, sensorless.

use super::Context;
use super::operating::Point;
use super::trial::Trial;
use narx_core::commissioning::Mode;
use narx_host::parallel::map;
use narx_report::figures::{Figure, Part};
use narx_sim::plant::LoadConfig;
use narx_sim::presets::PRESETS;
use std::f64::consts::TAU;

/// Longest time until the speed is within 1 % again, s.
pub(crate) const BACK: f64 = 0.5;

/// Measures every preset at four supplies where the limits allow rated torque.
pub(super) fn part(context: &Context<'_>) -> Part {
    let mut points = Vec::new();
    for preset in &PRESETS {
        points.extend([18.0, 24.0, 48.0, 60.0].map(|supply| Point {
            board: context.board,
            preset,
            mode: Mode::Sensorless,
            supply,
            load: 1.0,
            rpm: None,
        }));
    }
    points.retain(|point| point.plan().is_ok());
    let (light, points): (Vec<Point<'_>>, Vec<Point<'_>>) = points.into_iter().partition(stops_unseen);
    let results = map(&points, step);
    let failures: Vec<String> = points
        .iter()
        .zip(&results)
        .filter_map(|(point, result)| {
            let why = result.as_ref().err()?;
            Some(format!("{} at {} V: {why}", point.preset.name, point.supply))
        })
        .collect();
    let slowest = results.iter().flatten().copied().fold(0.0, f64::max);
    let of_light = map(&light, step);
    let lost: Vec<String> = light
        .iter()
        .zip(&of_light)
        .filter(|(_, result)| result.is_err())
        .map(|(point, _)| format!("{} at {} V", point.preset.name, point.supply))
        .collect();
    let held = results.len() - failures.len();
    let judged = format!("{held} of {} motors and supplies", results.len());
    let apart = format!("{} of {}; lost: {}", light.len() - lost.len(), light.len(), lost.join(", "));
    let share = |part: usize, of: usize| 100.0 * part as f64 / of.max(1) as f64;
    Part::new(
        vec![
            Figure::new("load step of 0 to 100 % of rated torque, within 1 % again", slowest, "s")
                .at_most(BACK),
            Figure::new("of these held without losing step", share(held, results.len()), "%")
                .at_least(100.0)
                .note(judged),
            Figure::new(
                "the same where the bare rotor stops within a sector",
                share(light.len() - lost.len(), light.len()),
                "%",
            )
            .note(apart),
        ],
        failures,
    )
}

/// Returns whether the load, without drive, stops the bare rotor within a sector, after `J w^2 / 2 T`
/// radians: no crossing can show the load in time. The voltage that is applied may hold the rotor all the
/// same, but that cannot be promised.
pub(crate) fn stops_unseen(point: &Point<'_>) -> bool {
    point.plan().is_ok_and(|plan| {
        let motor = &point.preset.motor;
        let speed = f64::from(plan.rpm) * TAU / 60.0;
        let sector = TAU / (6.0 * f64::from(motor.pole_pairs));
        motor.inertia * speed * speed / (2.0 * plan.torque) < sector
    })
}

/// Time until the speed, averaged over 10 ms, stays within 1 %, s.
pub(crate) fn step(point: &Point<'_>) -> Result<f64, String> {
    let plan = point.plan()?;
    let mut plant = point.plant();
    plant.angle_deg = 77.0;
    let mut trial = Trial::new(&plant, &plan.commissioning, "", false);
    let target = f64::from(plan.rpm);
    trial.start(plan.rpm);
    let running = point.running();
    let closed = |trial: &Trial| trial.state() == running;
    trial.until(8.0, closed).ok_or("no closed loop before the step")?;
    let reached = |trial: &Trial| (trial.seen().speed * 60.0 / TAU / target - 1.0).abs() < 0.01;
    trial.until(8.0, reached).ok_or("set-point not reached before the step")?;
    trial.run_while(0.5, |_| true);
    trial.bench.plant_mut().set_load(LoadConfig { constant: plan.torque, ..LoadConfig::default() });
    let mut back = 0.0;
    // 0.2 s longer than allowed, to check that the speed stays.
    for window in 1..=70 {
        let from = *trial.seen();
        if !trial.run_while(0.01, closed) {
            let status = trial.bench.status();
            return Err(format!(
                "left closed loop: {}, code {:#06x}",
                status.state.name(),
                status.extended_code
            ));
        }
        let rpm = (trial.seen().angle - from.angle) / (trial.seen().time - from.time) * 60.0 / TAU;
        if (rpm / target - 1.0).abs() > 0.01 {
            back = 0.01 * f64::from(window);
        }
    }
    if back > BACK {
        let rpm = trial.mean_rpm(0.1);
        let limiter = trial.bench.status().limiter;
        return Err(format!(
            "still off after {back:.2} s; {rpm:.0} of {target:.0} rpm after 0.8 s, bounded by {limiter:?}"
        ));
    }
    Ok(back)
}
