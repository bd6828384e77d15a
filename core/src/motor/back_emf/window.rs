//! The signal of a sample, and its mean over the last samples of a step.

use super::{BackEmf, BackEmfCoefficients, WINDOW};
use crate::motor::commutation::STEPS;
use crate::motor::interval::TICK;
use crate::motor::samples::Samples;

/// The mean that a sample makes, and what it leaves in the window.
#[derive(Clone, Copy)]
pub(super) struct Mean {
    pub(super) value: i32,
    signal: i32,
    sum: i32,
}

impl BackEmf {
    /// Mean of the last samples of this step and the present one's `signal`.
    #[inline]
    pub(super) fn mean(&self, signal: i32) -> Mean {
        if self.shift == 0 { Mean { value: signal, signal, sum: 0 } } else { self.average(signal) }
    }

    /// Slow steps: of the last 2, 4 or 8 samples.
    fn average(&self, signal: i32) -> Mean {
        // One spike must not outvote the window; but what the flank gives within it (a twelfth of the step at most, and the signal
        // spans 1.9 E in a step) must pass, or the crossing would move to the middle between two samples.
        let widest = (16 * self.noise).max(self.flank);
        let signal = signal.min(widest).max(-widest);
        let wide = 1_u8 << self.shift;
        let full = self.count >= wide;
        let oldest = usize::from(self.count.wrapping_sub(wide)) % WINDOW;
        let gone = if full { self.window.get(oldest).copied().unwrap_or(0) } else { 0 };
        let sum = self.sum - gone + signal;
        let count = self.count + 1;
        let value = if count >= wide { sum >> self.shift } else { sum / i32::from(count.max(1)) };
        Mean { value, signal, sum }
    }

    /// The sample counts.
    #[inline]
    pub(super) fn keep(&mut self, mean: Mean, sample_at: u16) {
        (self.previous, self.sampled_at) = (mean.value, sample_at);
        if self.shift > 0 {
            self.store(mean);
        }
    }

    fn store(&mut self, mean: Mean) {
        if let Some(slot) = self.window.get_mut(usize::from(self.count) % WINDOW) {
            *slot = mean.signal;
        }
        self.sum = mean.sum;
        // Wraps by whole windows, so that places stay.
        self.count = if self.count >= 4 * WINDOW as u8 { self.count - WINDOW as u8 } else { self.count } + 1;
    }

    /// A mean of n samples lies (n - 1) / 2 ticks back.
    pub(super) fn mean_delay(&self) -> i32 {
        let wide = i32::from((self.count + 1).min(1 << self.shift));
        (wide - 1) * (TICK as i32 / 2)
    }
}

/// What each terminal adds to the [`signal`] by sector, in a table that three bits cannot miss.
const WEIGHTS: [[i32; 3]; 8] = weights();

const fn weights() -> [[i32; 3]; 8] {
    let mut weights = [[0; 3]; 8];
    let mut sector = 0;
    while sector < STEPS.len() {
        // Torque the other way takes the step opposite, in which the same phase floats.
        if let Some(floating) = STEPS[sector].floating() {
            let sign = if sector & 1 == 1 { 1 } else { -1 };
            weights[sector] = [-sign; 3];
            weights[sector][floating as usize] = 2 * sign;
        }
        sector += 1;
    }
    weights
}

/// What one sample says, signed as it rises: `2 v_f - v_g - v_h`, three times the back-EMF of a sinusoidal motor, twice that of a trapezoidal
/// one, raw I16F16 V.
#[cfg_attr(not(target_arch = "wasm32"), inline(always))]
pub(super) fn signal(c: &BackEmfCoefficients, samples: &Samples, sector: u8) -> i32 {
    let [v_a, v_b, v_c] = samples.phase_voltage.map(i32::from);
    let [w_a, w_b, w_c] = WEIGHTS[usize::from(sector & 7)];
    c.terminal.convert_difference(w_a * v_a + w_b * v_b + w_c * v_c)
}
