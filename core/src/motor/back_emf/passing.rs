//! The ordinary ticks of a running motor: a sample that says nothing new, a crossing, a change to another step. Each answers what [`step`](BackEmf::step)
//! would find, or leaves it to that.

use super::window::signal;
use super::{BackEmf, BackEmfCoefficients, Crossing, Level, OperatingPoint, Passage, Sight, blanking};
use crate::motor::band::Band;
use crate::motor::interval::TICK;
use crate::motor::pwm::PwmCommand;
use crate::motor::samples::{SampleMode, Samples};

impl BackEmf {
    /// The ordinary tick of a step that goes on: takes its sample and answers true, if that says nothing new to the estimator. Else
    /// nothing is taken, and [`step`](Self::step) is to look. `None` if there is more to find out.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub fn passes(
        &mut self,
        c: &BackEmfCoefficients,
        samples: &Samples,
        applied: &PwmCommand,
    ) -> Option<bool> {
        let (Some(watch), SampleMode::OnTime) = (self.watch, samples.sample_mode) else { return None };
        if self.stale.is_empty() {
            return None;
        }
        let signal = signal(c, samples, watch.sector);
        if !self.stale.contains(signal) {
            return Some(false);
        }
        (self.previous, self.sampled_at) = (signal, applied.sample_at);
        self.age = self.age.saturating_add(TICK as i32);
        Some(true)
    }

    /// Takes a tick in which the step may be blanked, slow or sampled in the off-time, and answers as [`passes`](Self::passes).
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub fn passes_at_all(
        &mut self,
        c: &BackEmfCoefficients,
        samples: &Samples,
        bus_voltage: i32,
        applied: &PwmCommand,
    ) -> bool {
        let Some(watch) = self.watch else { return false };
        if self.is_changed_by(applied) || self.passage == Passage::Crossing {
            return false;
        }
        let age = self.age.saturating_add(TICK as i32);
        if c.comparator {
            return self.edges_pass(samples, watch, age);
        }
        let hidden = age.saturating_add(applied.sample_at.into()) < self.blank
            || (self.passage == Passage::Unseen && self.demagnetises(c, samples, bus_voltage, age, watch));
        if !hidden {
            let (signal, threshold) = (signal(c, samples, watch.sector), self.threshold(samples, watch));
            let passes = if self.shift == 0 {
                self.mean_passes(signal, threshold, applied.sample_at)
            } else {
                self.sample_passes(signal, threshold, applied.sample_at)
            };
            if !passes {
                return false;
            }
        }
        self.age = age;
        true
    }

    /// This mean is no news; then it is the last one.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn mean_passes(&mut self, mean: i32, threshold: i32, sample_at: u16) -> bool {
        match self.passage {
            Passage::Found if mean >= threshold - self.noise => {}
            Passage::Healthy if mean < threshold => {}
            Passage::Unseen if mean < threshold - self.noise => {
                (self.passage, self.after_run) = (Passage::Healthy, 0);
            }
            _ => return false,
        }
        (self.previous, self.sampled_at) = (mean, sample_at);
        self.expect();
        true
    }

    /// Where a mean is one sample, and the crossing is still to come or gone, the next samples take one comparison.
    #[inline]
    const fn expect(&mut self) {
        self.stale = match self.passage {
            Passage::Healthy if self.shift == 0 => Band::new(i32::MIN, -1),
            Passage::Found if self.shift == 0 => Band::new(-self.noise, i32::MAX),
            _ => Band::EMPTY,
        };
    }

    /// Another step may have been applied.
    #[inline]
    pub const fn beware(&mut self) {
        self.stale = Band::EMPTY;
    }

    /// Takes a sample of a slow step, if the mean that it makes is no news.
    #[inline(never)]
    fn sample_passes(&mut self, signal: i32, threshold: i32, sample_at: u16) -> bool {
        let mean = self.mean(signal);
        let passes = self.mean_passes(mean.value, threshold, sample_at);
        if passes {
            self.keep(mean, sample_at);
        }
        passes
    }

    /// The ordinary crossing of a step that goes on: what [`step`](Self::step) would find. Nothing is taken yet.
    #[inline]
    pub fn crosses(
        &self,
        c: &BackEmfCoefficients,
        samples: &Samples,
        applied: &PwmCommand,
    ) -> Option<Crossing> {
        let watch = self.watch?;
        let age = self.age.saturating_add(TICK as i32);
        // Where the sample before took one comparison, the rest is known.
        if self.stale.is_empty() {
            let sees = age.saturating_add(applied.sample_at.into()) >= self.blank;
            if !sees || c.comparator || self.is_changed_by(applied) {
                return None;
            }
        }
        let threshold = self.threshold(samples, watch);
        let mean = self.mean(signal(c, samples, watch.sector));
        if mean.value <= threshold + self.beyond() {
            return None;
        }
        let ago = match self.passage {
            Passage::Healthy => self.crossed_at(mean.value, threshold, applied.sample_at),
            Passage::Crossing => self.crossed.saturating_add(TICK as i32),
            _ => return None,
        };
        let delay = if watch.rises() { c.delay_rising } else { c.delay_falling };
        Some(Crossing { sector: watch.sector, age: ago.saturating_add(delay), threshold, ago, mean })
    }

    /// Where one comparison was expected to do: the signal has not passed its threshold, or not yet gone far enough to be believed. What
    /// [`step`](Self::step) would find, and it is noted; else nothing is done.
    #[inline]
    pub fn nears(
        &mut self,
        c: &BackEmfCoefficients,
        samples: &Samples,
        applied: &PwmCommand,
    ) -> Option<Sight> {
        let watch = self.watch?;
        if self.stale.is_empty()
            || samples.sample_mode != SampleMode::OnTime
            || self.passage != Passage::Healthy
        {
            return None;
        }
        // In the on-time the threshold is 0.
        let mean = self.mean(signal(c, samples, watch.sector));
        if mean.value > self.beyond() {
            return None;
        }
        self.age = self.age.saturating_add(TICK as i32);
        if mean.value >= 0 {
            self.crossed = self.crossed_at(mean.value, 0, applied.sample_at);
            self.passage = Passage::Crossing;
            self.beware();
        }
        self.keep(mean, applied.sample_at);
        let level = if mean.value < -self.noise { Level::Before } else { Level::Hidden };
        Some(Sight { sector: Some(watch.sector), level, ..Sight::default() })
    }

    /// That was one.
    #[inline]
    pub fn take(&mut self, samples: &Samples, crossing: &Crossing, sample_at: u16) {
        self.age = self.age.saturating_add(TICK as i32);
        self.crossed = crossing.ago;
        if samples.sample_mode == SampleMode::OnTime || crossing.sector & 1 == 1 {
            self.after_run = self.after_run.saturating_add(1);
        }
        self.passage = Passage::Found;
        self.keep(crossing.mean, sample_at);
        self.expect();
    }

    /// The ordinary change to another step, whose crossing was found: true, and the tick is over. Else nothing is done.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub fn turns_over(
        &mut self,
        c: &BackEmfCoefficients,
        applied: &PwmCommand,
        point: &OperatingPoint,
    ) -> bool {
        let (step, instant) = match applied.commutations.last() {
            Some(last) => (last.step, last.instant),
            None => (applied.step, c.earliest),
        };
        let age = TICK as i32 - i32::from(instant) + i32::from(applied.sample_at);
        let plain = self.passage == Passage::Found && !c.comparator && step.sector().is_some();
        if !plain || age >= blanking(c, point.interval) {
            return false;
        }
        self.begin(c, step, instant, point);
        true
    }
}
