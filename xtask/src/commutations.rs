//! Where the pattern changes really lie, against the true rotor.

use narx_core::motor::Step;
use narx_sim::bench::Bench;

/// Watches the patterns that the bridge gets, tick by tick.
#[derive(Debug, Default)]
pub struct Commutations {
    step: Step,
    turns: f64,
    errors: Vec<f64>,
}

impl Commutations {
    /// Starts to watch: what came before is forgotten.
    pub fn clear(&mut self) {
        self.errors.clear();
    }

    /// Call after every tick: the changes of the period that has just passed, `step` at the board's `earliest`, the others at their
    /// instants. A step belongs to the 60 degrees between two multiples of 60 after 30 (`Step`): commutation is ideal on their edges.
    pub fn watch(&mut self, bench: &Bench) {
        let before = core::mem::replace(&mut self.turns, bench.plant().observe().electrical_turns);
        let command = *bench.command();
        let earliest = bench.plant().config().board.earliest;
        let first = (earliest, command.step);
        let others = command.commutations.iter().map(|next| (next.instant.max(earliest), next.step));
        for (instant, step) in core::iter::once(first).chain(others) {
            if core::mem::replace(&mut self.step, step) != step {
                let turned = self.turns - before;
                let degrees = 360.0 * (before + turned * f64::from(instant) / 65_536.0);
                self.errors.push((degrees.rem_euclid(60.0) - 30.0) * turned.signum());
            }
        }
    }

    /// Their errors since, electrical degrees late; early is negative.
    pub fn errors(&self) -> &[f64] {
        &self.errors
    }

    /// Mean error, and standard deviation as a share of the 60 degrees of a step.
    pub fn mean_and_jitter(&self) -> (f64, f64) {
        let count = self.errors.len().max(1) as f64;
        let mean = self.errors.iter().sum::<f64>() / count;
        let variance = self.errors.iter().map(|error| (error - mean) * (error - mean)).sum::<f64>() / count;
        (mean, variance.sqrt() / 60.0)
    }
}
