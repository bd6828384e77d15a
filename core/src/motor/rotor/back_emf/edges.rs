//! Back-EMF comparators with capture: their edges take the place of samples.

use super::{BackEmf, BackEmfCoefficients, End, Observation, Passage, Watch};
use crate::motor::clock::Instant;
use crate::motor::commutate::pwm::PwmCommand;
use crate::motor::interval::TICK;
use crate::motor::sense::samples::{EdgeSource, Samples};

impl BackEmf {
    /// A crossing of the pattern that was left within the period that has ended: with two ticks a sector a
    /// commutation can be taken at the end of the very period in which the crossing before it came.
    pub(super) fn crossing_before_change(
        &mut self,
        c: &BackEmfCoefficients,
        now: Instant,
        samples: &Samples,
        applied: &PwmCommand,
    ) -> Option<End> {
        let mut changes = applied.commutations.iter().filter(|change| change.step != self.step);
        let change =
            if applied.step == self.step { changes.next().map(|change| change.instant)? } else { c.earliest };
        let watch = self.watch?;
        let mut end = None;
        let edges = samples.edges.iter().filter(|edge| edge.source == EdgeSource::Comparator);
        for edge in edges.filter(|edge| edge.instant < change) {
            // The step's age at the boundary before, and the time since.
            let since = self.age(now).saturating_sub(TICK).saturating_add(edge.instant.into());
            if self.edge(watch, edge.code, since >= self.blank, true) {
                let age = (TICK - u32::from(edge.instant)) as i32 + Self::delay(c, watch);
                end = Some(End::Crossing { sector: watch.sector, age });
            }
        }
        end
    }

    /// A comparator's edge: true if it is this step's crossing. The level stood until here: after blanking
    /// that makes the crossing healthy.
    fn edge(&mut self, watch: Watch, code: u8, settled: bool, own: bool) -> bool {
        let (was, is) = (watch.is_beyond(self.code), watch.is_beyond(code));
        if !was && own && settled && self.passage == Passage::Unseen {
            self.passage = Passage::Healthy;
        }
        self.code = code;
        let crosses = !was && is && own && self.passage == Passage::Healthy;
        if crosses {
            self.passage = Passage::Found;
        }
        crosses
    }

    /// The comparators' edges of the period that has ended, and the level after them.
    #[inline(never)]
    pub(super) fn look_at_edges(
        &mut self,
        c: &BackEmfCoefficients,
        now: Instant,
        samples: &Samples,
        watch: Watch,
    ) -> Observation {
        let since_beginning = self.age(now);
        let mut crossing = None;
        for edge in samples.edges.iter().filter(|edge| edge.source == EdgeSource::Comparator) {
            let age = TICK - u32::from(edge.instant);
            let since = since_beginning.saturating_sub(age);
            if self.edge(watch, edge.code, since >= self.blank, age <= since_beginning) {
                crossing = Some(age as i32);
            }
        }
        let level = self.level(since_beginning, watch);
        if self.is_found() {
            self.quiet.hidden = now.after(u32::MAX);
        }
        match crossing {
            Some(age) => {
                Observation::Crossing { age: age.saturating_add(Self::delay(c, watch)), threshold: 0 }
            }
            None => level,
        }
    }

    /// Reads the outputs at the end of the period. At rest they tell nothing of a late crossing.
    fn level(&mut self, since_beginning: u32, watch: Watch) -> Observation {
        if since_beginning < self.blank {
            return Observation::Nothing;
        }
        let beyond = watch.is_beyond(self.code);
        let stands = beyond && self.passage == Passage::Unseen;
        self.after_run = if stands { self.after_run.saturating_add(1) } else { 0 };
        if !beyond {
            if self.passage == Passage::Unseen {
                self.passage = Passage::Healthy;
            }
            Observation::Before
        } else if stands && self.after_run >= 2 && self.interval > 0 {
            self.passage = Passage::Found;
            Observation::Late
        } else {
            Observation::Nothing
        }
    }
}

impl Watch {
    /// The comparators' `code` is that beyond the crossing.
    pub(super) const fn is_beyond(self, code: u8) -> bool {
        ((code >> self.phase) & 1 == 1) == self.rises()
    }
}
