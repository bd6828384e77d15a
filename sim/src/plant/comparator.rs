//! Back-EMF comparators: a floating phase's terminal against the mean of the three, with hysteresis and
//! delay.

use super::config::ComparatorConfig;
use super::hall::Capture;
use heapless::Deque;
use narx_core::motor::EdgeSource;

/// Edges on their way through the delay.
const PENDING_MAX: usize = 8;

/// Three comparators. The output of a phase that does not float stays as it is.
#[derive(Clone, Debug)]
pub(crate) struct Comparators {
    config: ComparatorConfig,
    /// Outputs before the delay: bit 0 = A, bit 1 = B, bit 2 = C.
    code: u8,
    /// Instant at the output, s from the start of the period, and the code then.
    pending: Deque<(f64, u8), PENDING_MAX>,
    lost: u8,
}

impl Comparators {
    pub(crate) fn new(config: ComparatorConfig) -> Self {
        Self { config, code: 0, pending: Deque::new(), lost: 0 }
    }

    /// Looks at an interval: terminal less mean of all terminals at both ends (V), straight between them, for
    /// the part `from..to` (s) of the period.
    pub(crate) fn follow(
        &mut self,
        floating: &[bool; 3],
        start: &[f64; 3],
        end: &[f64; 3],
        from: f64,
        to: f64,
    ) {
        // Who does not cross comes last.
        let mut crossings = [(f64::INFINITY, 0u8); 3];
        for x in 0..3 {
            let bit = 1 << x;
            let (high, half) = (self.code & bit != 0, 0.5 * self.config.hysteresis);
            let edge = if high { -half } else { half };
            let beyond = |value: f64| if high { value < edge } else { value > edge };
            if !floating[x] || !(beyond(start[x]) || beyond(end[x])) {
                continue;
            }
            // A jump at the start of the interval switches at once; it may even switch back before the end,
            // which the next interval will tell.
            let part = if beyond(start[x]) { 0.0 } else { (edge - start[x]) / (end[x] - start[x]) };
            crossings[x] = (from + part * (to - from), bit);
        }
        into_order(&mut crossings, |a, b| a.0 > b.0);
        for (at, bit) in crossings.into_iter().filter(|(_, bit)| *bit != 0) {
            self.code ^= bit;
            if self.pending.push_back((at + self.config.delay, self.code)).is_err() {
                self.lost = self.lost.saturating_add(1);
            }
        }
    }

    /// At the end of a period of `period` seconds: hands over the edges that came out in it.
    pub(crate) fn end_period(&mut self, period: f64, capture: &mut Capture) {
        capture.lost = capture.lost.saturating_add(core::mem::take(&mut self.lost));
        let mut later = Deque::new();
        for &(at, code) in &self.pending {
            if at < period {
                capture.push((at / period * 65_536.0) as u16, EdgeSource::Comparator, code);
            } else if later.push_back((at - period, code)).is_err() {
                capture.lost = capture.lost.saturating_add(1);
            }
        }
        self.pending = later;
        // Hall edges came first: into the order of time.
        into_order(&mut capture.edges, |a, b| a.instant > b.instant);
    }
}

/// Three or four items: the library's sorting is made for more, and costs the browser 3 KB.
fn into_order<T>(items: &mut [T], is_later: impl Fn(&T, &T) -> bool) {
    for end in 2..=items.len() {
        let mut sorted = items.get_mut(..end).unwrap_or_default();
        while let Some((item, before)) = sorted.split_last_mut()
            && let Some(other) = before.last_mut()
            && is_later(other, item)
        {
            core::mem::swap(other, item);
            sorted = before;
        }
    }
}
