//! The channel of the bus current: its reading without a current, and its noise.

use super::winding::Lock;
use libm::{fabs, fmin};

/// Standard deviation of the zero that the drive has found for a run, A.
pub(super) const ZERO: f64 = 0.7e-3;
/// A zero this far from the others, in standard deviations of one reading, is none: those of two levels
/// differ by a tenth.
const ASTRAY: f64 = 0.25;

/// Reading of the current channel without a current, and its standard deviation in one period, A.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Channel {
    pub(super) zero: f64,
    pub(super) noise: f64,
}

impl Channel {
    /// The channel as all levels show it. A drive that looks for its zero while a winding's current returns
    /// may take some of it for an offset: that level's reading after the stop is off by several mA, and the
    /// median takes its place.
    pub(super) fn of(locks: &mut [Lock]) -> Self {
        let noise = locks.iter().map(|lock| lock.noise).fold(f64::MAX, fmin);
        let zeros = || locks.iter().map(|lock| lock.zero);
        let below = |zero: f64| zeros().filter(|other| *other < zero).count();
        let median = zeros().min_by_key(|zero| below(*zero).abs_diff(locks.len() / 2)).unwrap_or(0.0);
        for lock in locks.iter_mut().filter(|lock| fabs(lock.zero - median) > ASTRAY * noise) {
            lock.current += lock.zero - median;
            lock.zero = median;
        }
        Self { zero: locks.iter().map(|lock| lock.zero).sum::<f64>() / locks.len() as f64, noise }
    }
}
