//! One clock against another: counts of both over the same time.

/// By how much a clock may be off, per thousand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tolerance {
    /// Too slow; 1000 lets it stand still.
    pub slow: u16,
    /// Too fast.
    pub fast: u16,
}

/// Returns whether `counts` at a nominal `rate`, Hz, took as long as `other_counts` at `other_rate`: within
/// the tolerance, and a count more or less, which is the phase between the two.
pub fn agree(counts: u32, rate: u16, other_counts: u32, other_rate: u16, tolerance: Tolerance) -> bool {
    // 32 + 16 + 16 bits: no product of any of these leaves 64.
    let product =
        |counts: u32, rate: u16, factor: u16| u64::from(counts) * u64::from(rate) * u64::from(factor);
    let passed = product(counts, other_rate, 1000);
    let phase = product(1000, rate.max(other_rate), 1);
    let slowest = product(other_counts, rate, 1000_u16.saturating_sub(tolerance.slow));
    let fastest = product(other_counts, rate, tolerance.fast.saturating_add(1000));
    (slowest.saturating_sub(phase)..=fastest.saturating_add(phase)).contains(&passed)
}

/// Watches that control ticks come at their rate, by another clock.
#[derive(Clone, Copy, Debug)]
pub struct TickMonitor {
    rate: u16,
    other_rate: u16,
    tolerance: Tolerance,
    /// Counts of the other clock between two looks.
    window: u32,
    /// Modulo 2^32: two looks are seconds apart.
    ticks: u32,
    counts: u32,
    is_steady: bool,
}

impl TickMonitor {
    /// For `rate` ticks a second and a clock of `other_rate` counts a second, either up to 65 535, that wraps
    /// at 2^32, looked at every `window` counts, from this instant on.
    pub const fn new(rate: u16, other_rate: u16, tolerance: Tolerance, window: u32, counts: u32) -> Self {
        Self { rate, other_rate, tolerance, window, ticks: 0, counts, is_steady: true }
    }

    /// The control ticks since power-up and the other clock's counts. False once they have been apart for a
    /// window.
    pub fn step(&mut self, ticks: u64, counts: u32) -> bool {
        let passed = counts.wrapping_sub(self.counts);
        if passed >= self.window {
            let come = (ticks as u32).wrapping_sub(self.ticks);
            self.is_steady &= agree(come, self.rate, passed, self.other_rate, self.tolerance);
            (self.ticks, self.counts) = (ticks as u32, counts);
        }
        self.is_steady
    }
}
