//! Scaling of a sweep with threads: the short run of `narx.sweep`, on one thread and on all.

use super::Context;
use narx_core::commissioning::Mode;
use narx_core::motor::Board;
use narx_host::parallel::{for_each, threads};
use narx_report::figures::{Figure, Part};
use narx_sim::experiment::Experiment;
use narx_sim::presets::{PRESETS, Preset};
use narx_sim::session::SessionConfig;
use std::time::Instant;

/// Runs of each, in turns; the fastest counts.
const ROUNDS: usize = 3;
/// Promised share of ideal scaling.
const SHARE_MIN: f64 = 0.8;
/// Simulated time of a run, s.
const SECONDS: f64 = 1.5;

/// Runs every preset with hall sensors at its nominal supply, twice.
pub(super) fn part(context: &Context<'_>) -> Part {
    let runs: Vec<Experiment> =
        PRESETS.iter().chain(&PRESETS).map(|preset| experiment(preset, context.board)).collect();
    let most = threads();
    let mut best = [0.0_f64; 2];
    for _ in 0..ROUNDS {
        for (best, threads) in best.iter_mut().zip([1, most]) {
            *best = best.max(rate(&runs, threads));
        }
    }
    let [one, all] = best;
    let scaling = all / one / most as f64;
    Part::new(
        vec![
            Figure::new("sweep of starts, one thread", one, "runs/s")
                .note(format!("{} runs of {SECONDS} s", runs.len())),
            Figure::new("sweep of starts, every thread", all, "runs/s").note(format!("{most} threads")),
            Figure::new("of ideal scaling", scaling, "").at_least(SHARE_MIN),
        ],
        Vec::new(),
    )
}

fn experiment(preset: &Preset, board: Board) -> Experiment {
    let session = SessionConfig {
        rated_current: preset.data.rated_current,
        board,
        trace: false,
        ..SessionConfig::new(preset.motor, preset.data.nominal_voltage.clamp(18.0, 60.0), Mode::Hall)
    };
    Experiment { session, rpm: None, seconds: SECONDS, fault: None }
}

/// Number of runs per second.
fn rate(runs: &[Experiment], threads: usize) -> f64 {
    let begun = Instant::now();
    let mut done = 0;
    for_each(
        runs,
        threads,
        |run, _| run.run(|| true).is_ok(),
        |result| {
            done += usize::from(matches!(result, Some((_, true))));
            true
        },
    );
    done as f64 / begun.elapsed().as_secs_f64()
}
