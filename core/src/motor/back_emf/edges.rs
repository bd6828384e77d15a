//! Back-EMF comparators with capture: their edges take the place of samples.

use super::{BackEmf, BackEmfCoefficients, Level, Passage, Sight, Watch};
use crate::motor::interval::TICK;
use crate::motor::pwm::PwmCommand;
use crate::motor::samples::{EdgeSource, Samples};

impl BackEmf {
    /// [`passes`](Self::passes) on a board with comparators: no edge, and the level is the expected one. The step is `age` old now.
    #[inline(never)]
    pub(super) fn edges_pass(&mut self, samples: &Samples, watch: Watch, age: i32) -> bool {
        if !samples.edges.is_empty() {
            return false;
        }
        if age >= self.blank {
            match (self.passage, watch.is_beyond(self.code)) {
                (Passage::Found, true) => {}
                (Passage::Unseen | Passage::Healthy, false) => self.passage = Passage::Healthy,
                _ => return false,
            }
        }
        self.age = age;
        true
    }

    /// A crossing of the pattern that was left within the period that has ended: with two ticks a sector a commutation can be taken
    /// at the end of the very period in which the crossing before it came.
    pub(super) fn edges_before_change(
        &mut self,
        c: &BackEmfCoefficients,
        samples: &Samples,
        applied: &PwmCommand,
    ) -> Option<Sight> {
        let mut changes = applied.commutations.iter().filter(|change| change.step != self.step);
        let change =
            if applied.step == self.step { changes.next().map(|change| change.instant)? } else { c.earliest };
        let watch = self.watch?;
        let mut crossing = None;
        let edges = samples.edges.iter().filter(|edge| edge.source == EdgeSource::Comparator);
        for edge in edges.filter(|edge| edge.instant < change) {
            let since = self.age.saturating_add(edge.instant.into());
            if self.edge(watch, edge.code, since >= self.blank, true) {
                let delay = if watch.rises() { c.delay_rising } else { c.delay_falling };
                crossing = Some((TICK - u32::from(edge.instant)) as i32 + delay);
            }
        }
        let sector = Some(watch.sector);
        crossing.map(|_| Sight { sector, crossing, passed: true, ..Sight::default() })
    }

    /// A comparator's edge: true if it is this step's crossing. The level stood until here: after blanking that makes the crossing healthy.
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

    /// The comparators' edges of the period that has ended.
    pub(super) fn edges(&mut self, samples: &Samples, watch: Watch, sight: &mut Sight) {
        for edge in samples.edges.iter().filter(|edge| edge.source == EdgeSource::Comparator) {
            let age = (TICK - u32::from(edge.instant)) as i32;
            let since = self.age.saturating_sub(age);
            if self.edge(watch, edge.code, since >= self.blank, age <= self.age) {
                sight.crossing = Some(age);
            }
        }
        if self.age < self.blank {
            return;
        }
        let beyond = watch.is_beyond(self.code);
        sight.level = if beyond { Level::After } else { Level::Before };
        if !beyond && self.passage == Passage::Unseen {
            self.passage = Passage::Healthy;
        }
        let stands = beyond && self.passage == Passage::Unseen;
        self.after_run = if stands { self.after_run.saturating_add(1) } else { 0 };
        sight.late = stands && self.after_run >= 2;
    }
}

impl Watch {
    /// The comparators' `code` is that beyond the crossing.
    pub(super) const fn is_beyond(self, code: u8) -> bool {
        ((code >> self.phase) & 1 == 1) == self.rises()
    }
}
