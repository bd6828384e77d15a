//! Simulated time in step with the clock on the wall: no drift, and after a stall neither a burst of frames
//! nor a jump of time.

use std::time::Duration;

/// Speed of simulated time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Speed {
    /// This many times as fast as the clock.
    Times(f64),
    /// As fast as it can.
    Unbound,
}

impl Speed {
    /// Smallest factor.
    pub const MIN: f64 = 0.01;
    /// Largest factor.
    pub const MAX: f64 = 100.0;
}

/// Catching up is this much faster than the speed asked for. A master that commands every 50 ms is then
/// received every 100 ms of the drive's time, well within its time-out of 250 ms.
const CATCH_UP: f64 = 2.0;
/// Time that may be saved for a later burst, ns of real time.
const SAVED: f64 = 5e6;
/// Further behind than this nobody waits for, ns of real time: a notebook that slept.
const BEHIND_MAX: f64 = 10e9;

/// Limits up to which the simulation may go now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Limits {
    /// Simulated time, ns.
    pub(super) time: u64,
    /// Time that the simulated bus was busy, ns: what frames may have taken in all.
    pub(super) busy: u64,
}

/// Compares simulated with real time. All in ns of simulated time, which began with the clock.
pub(super) struct Pace {
    speed: Speed,
    /// Real time of the last look.
    looked: Duration,
    /// Simulated time that should be reached by now.
    target: f64,
    /// Simulated time up to which catching up may go.
    allowed: f64,
    /// Time that the bus may have been busy: never more than the bus of a real drive could have been.
    busy: f64,
}

impl Pace {
    pub(super) const fn new(speed: Speed) -> Self {
        Self { speed, looked: Duration::ZERO, target: 0.0, allowed: 0.0, busy: 0.0 }
    }

    /// At `clock` since the start, with the simulation at `time` and its bus busy for `busy`, ns.
    pub(super) fn limits(&mut self, clock: Duration, time: u64, busy: u64) -> Limits {
        let Speed::Times(speed) = self.speed else { return Limits { time: u64::MAX, busy: u64::MAX } };
        let passed = clock.saturating_sub(self.looked).as_nanos() as f64 * speed;
        self.looked = clock;
        let saved = SAVED * speed;
        self.target = (self.target + passed).min(time as f64 + BEHIND_MAX * speed);
        self.allowed = (self.allowed + CATCH_UP * passed).min(time as f64 + CATCH_UP * saved);
        self.busy = (self.busy + passed).min(busy as f64 + saved);
        Limits { time: self.target.min(self.allowed) as u64, busy: self.busy as u64 }
    }

    /// Returns how far simulated time is behind its target, ns.
    pub(super) fn behind_ns(&self, time: u64) -> u64 {
        (self.target - time as f64).max(0.0) as u64
    }
}
