//! Errors of the commutation instants against the true rotor.

use crate::bench::Bench;
use alloc::vec::Vec;
use narx_core::motor::Step;

/// Records the errors of the patterns that the bridge receives, tick by tick.
#[derive(Debug, Default)]
pub struct Commutations {
    step: Step,
    turns: f64,
    errors: Vec<f64>,
}

impl Commutations {
    /// Forgets the errors so far.
    pub fn clear(&mut self) {
        self.errors.clear();
    }

    /// Takes the changes of the period that has just passed: `step` at the board's `earliest`, the others at
    /// their instants. Must be called after every tick. A step belongs to 60 degrees (`Step`): commutation
    /// from another step is ideal on the edge at which the rotor enters them. A bridge that was off may be
    /// switched on anywhere within them, and may be switched off anywhere.
    pub fn watch(&mut self, bench: &Bench) {
        let before = core::mem::replace(&mut self.turns, bench.plant().observe().electrical_turns);
        let command = *bench.command();
        let earliest = bench.plant().config().board.earliest;
        let first = (earliest, command.step);
        let others = command.commutations.iter().map(|next| (next.instant.max(earliest), next.step));
        for (instant, step) in core::iter::once(first).chain(others) {
            let was = core::mem::replace(&mut self.step, step);
            let Some(sector) = step.sector().filter(|_| was != step) else { continue };
            let turned = self.turns - before;
            let degrees = 360.0 * (before + turned * f64::from(instant) / 65_536.0);
            // Torque acts in the direction of motion: backward, the step is that of the opposite sector.
            let middle = 60.0 * f64::from(sector + 1) + if turned < 0.0 { 180.0 } else { 0.0 };
            let beyond = within_a_turn((degrees - middle) * turned.signum() + 180.0) - 180.0;
            if was.sector().is_some() {
                self.errors.push(beyond + 30.0);
            } else if beyond.abs() > 30.0 {
                self.errors.push(beyond - 30.0_f64.copysign(beyond));
            }
        }
    }

    /// Errors since the last [`clear`](Self::clear), electrical degrees late; early is negative.
    pub fn errors(&self) -> &[f64] {
        &self.errors
    }

    /// Mean error, and standard deviation as a share of the 60 degrees of a step.
    pub fn mean_and_jitter(&self) -> (f64, f64) {
        let count = self.errors.len().max(1) as f64;
        let mean = self.errors.iter().sum::<f64>() / count;
        let variance = self.errors.iter().map(|error| (error - mean) * (error - mean)).sum::<f64>() / count;
        (mean, libm::sqrt(variance) / 60.0)
    }
}

/// Returns the angle within a turn, 0 to 360 degrees.
fn within_a_turn(degrees: f64) -> f64 {
    let rest = libm::fmod(degrees, 360.0);
    if rest < 0.0 { rest + 360.0 } else { rest }
}
