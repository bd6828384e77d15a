//! The signal of a sample, and its mean over the last samples of a step.

use super::{BackEmf, WINDOW, Watch};
use crate::motor::interval::TICK;
use crate::motor::sense::samples::Samples;

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
        // One spike must not outvote the window; but what the flank gives within it (a twelfth of the step at
        // most, and the signal spans 1.9 E in a step) must pass, or the crossing would move to the middle
        // between two samples.
        let widest = (16 * self.noise).max(self.flank).min(i16::MAX.into());
        let signal = signal.min(widest).max(-widest);
        let wide = 1_u8 << self.shift;
        let full = self.count >= wide;
        let oldest = usize::from(self.count.wrapping_sub(wide)) % WINDOW;
        let gone = if full { self.window.get(oldest).copied().unwrap_or(0).into() } else { 0 };
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
            *slot = mean.signal as i16;
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

/// The signal of one sample, signed as it rises: `2 v_f - v_g - v_h` in converter codes, less than 2^14;
/// three times the back-EMF of a sinusoidal motor, twice that of a trapezoidal one.
#[inline]
pub(super) fn signal(samples: &Samples, watch: Watch) -> i32 {
    let [a, b, c] = &samples.phase_voltage;
    let all = i32::from(*a) + i32::from(*b) + i32::from(*c);
    let signal = 3 * i32::from(samples.phase_voltage[usize::from(watch.phase.min(2))]) - all;
    if watch.rises() { signal } else { -signal }
}
