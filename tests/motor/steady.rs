//! Commutation at the shaft: the true rotor angle at each change of the pattern, and the regularity of the
//! changes.

use crate::bench::Closed;

/// Figures of a stretch of running.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Steady {
    /// Mean of (rotor - ideal boundary) in electrical degrees, positive is late.
    pub mean: f64,
    /// Largest deviation from the ideal boundary.
    pub worst: f64,
    /// Standard deviation of the time between commutations, as a share of its mean.
    pub jitter: f64,
    /// Mean mechanical speed, rpm.
    pub rpm: f64,
    /// Number of commutations.
    pub count: usize,
}

/// Runs `ticks` periods of a motor that turns forward, and measures.
pub(crate) fn measure(closed: &mut Closed, ticks: u64) -> Steady {
    let (mut errors, mut instants) = (Vec::new(), Vec::new());
    let begin = closed.plant.observe();
    let mut step = closed.output.step;
    step = closed.output.commutations.iter().last().map_or(step, |last| last.step);
    for _ in 0..ticks {
        let before = closed.plant.observe().electrical_turns;
        let tick = closed.plant.tick();
        closed.tick();
        let after = closed.plant.observe().electrical_turns;
        let earliest = closed.plant.config().board.earliest;
        let first = (closed.output.step, earliest);
        let later = closed.output.commutations.iter().map(|change| (change.step, change.instant));
        for (next, instant) in core::iter::once(first).chain(later) {
            if next == step {
                continue;
            }
            step = next;
            let Some(sector) = next.sector() else { continue };
            let part = f64::from(instant) / 65_536.0;
            let angle = 360.0 * (before + part * (after - before));
            // Sector s begins at 30 + 60 s degrees.
            let entry = 30.0 + 60.0 * f64::from(sector);
            errors.push((angle - entry + 180.0).rem_euclid(360.0) - 180.0);
            instants.push(tick as f64 + part);
        }
    }
    let end = closed.plant.observe();
    let intervals: Vec<f64> = instants.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    let interval = mean(&intervals);
    let spread: Vec<f64> = intervals.iter().map(|each| (each - interval).powi(2)).collect();
    Steady {
        mean: mean(&errors),
        worst: errors.iter().fold(0.0, |worst, error| error.abs().max(worst)),
        jitter: mean(&spread).sqrt() / interval,
        rpm: (end.angle - begin.angle) / (end.time - begin.time) * 60.0 / core::f64::consts::TAU,
        count: errors.len(),
    }
}
