//! One clock against another: counts of both over the same time.

/// By how much a clock may be off, per thousand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tolerance {
    /// Too slow; 1000 lets it stand still.
    pub slow: u32,
    /// Too fast.
    pub fast: u32,
}

/// Whether `counts` at a nominal `rate` took as long as `other_counts` at `other_rate`: within the tolerance, and a count more or less, which is the
/// phase between the two.
pub fn agree(counts: u64, rate: u32, other_counts: u64, other_rate: u32, tolerance: Tolerance) -> bool {
    let counts = u128::from(counts) * u128::from(other_rate);
    let expected = u128::from(other_counts) * u128::from(rate);
    let phase = u128::from(rate.max(other_rate));
    let slowest = expected * u128::from(1000_u32.saturating_sub(tolerance.slow)) / 1000;
    let fastest = expected * u128::from(1000 + tolerance.fast) / 1000;
    (slowest.saturating_sub(phase)..=fastest + phase).contains(&counts)
}

/// Watches that control ticks come at their rate, by another clock.
#[derive(Clone, Copy, Debug)]
pub struct TickMonitor {
    rate: u32,
    other_rate: u32,
    tolerance: Tolerance,
    /// Counts of the other clock between two looks.
    window: u32,
    ticks: u64,
    counts: u32,
    is_steady: bool,
}

impl TickMonitor {
    /// For `rate` ticks a second and a clock of `other_rate` counts a second that wraps at 2^32, looked at every `window` counts, from this instant on.
    pub const fn new(rate: u32, other_rate: u32, tolerance: Tolerance, window: u32, counts: u32) -> Self {
        Self { rate, other_rate, tolerance, window, ticks: 0, counts, is_steady: true }
    }

    /// The control ticks since power-up and the other clock's counts. False once they have been apart for a window.
    pub fn step(&mut self, ticks: u64, counts: u32) -> bool {
        let passed = counts.wrapping_sub(self.counts);
        if passed >= self.window {
            let come = ticks.saturating_sub(self.ticks);
            self.is_steady &= agree(come, self.rate, passed.into(), self.other_rate, self.tolerance);
            (self.ticks, self.counts) = (ticks, counts);
        }
        self.is_steady
    }
}
