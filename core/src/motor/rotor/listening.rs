//! Listening to a coasting motor: with the bridge off its terminals show the back-EMF.
//!
//! The divider pulls the star point to ground and the body diodes hold the lowest terminal there, so what is
//! certain is which terminal is the highest. It changes three times a revolution, where two back-EMFs cross
//! above the third:
//!
//! ```text
//!  forward   A from 30 to 150, B to 270, C to 30           A -> B at 150, B -> C at 270, C -> A at  30
//!  reverse   (back-EMF inverted) A from 330 down to 210     A -> C at 210, C -> B at  90, B -> A at 330
//! ```

use super::back_emf::BackEmfCoefficients;
use super::zero_crossing::ZeroCrossing;
use crate::motor::clock::Instant;
use crate::motor::commutate::commutation::Direction;
use crate::motor::interval::TICK;
use serde::{Deserialize, Serialize};

/// The highest terminal changed: the rotor was there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Passage {
    /// In twelfths of a turn.
    pub place: u8,
    /// Before the present boundary, 1/65 536 tick; negative is after it.
    pub age: i32,
    /// Which way it turns.
    pub direction: Direction,
}

/// State of the listener.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Listening {
    /// The highest terminal, 0 to 2, once one is.
    highest: Option<u8>,
    /// Terminals of the tick before, converter codes, and where in its period they were sampled, 1/65 536.
    previous: [u16; 3],
    sampled_at: u16,
    /// The last tick in which the bridge was on.
    began: Instant,
    /// The last tick in which a terminal was above the noise.
    loud: Instant,
    /// The last tick in which another terminal became the highest.
    changed: Instant,
    /// The windings carry no more current.
    settled: bool,
    /// Changes in a row in one direction.
    run: u8,
    direction: Direction,
}

/// Changes in one direction, in time, that prove a turning rotor: more than a revolution.
const CONVINCING: u8 = 4;

impl Listening {
    /// The bridge is on: the terminals show nothing.
    #[inline]
    pub fn reset(&mut self, now: Instant) {
        *self = Self { began: now, loud: now, changed: now, ..Self::default() };
    }

    /// True if the samples of a tick with the bridge off say nothing new. Then they are taken.
    #[inline]
    pub fn rests(&mut self, c: &BackEmfCoefficients, now: Instant, codes: &[u16; 3], sample_at: u16) -> bool {
        if !self.settled {
            return false;
        }
        let [a, b, c_] = *codes;
        let top = a.max(b).max(c_);
        let is_loud = top >= c.silence;
        if is_loud {
            let Some(highest) = self.highest else { return false };
            let last = match highest {
                0 => a,
                1 => b,
                _ => c_,
            };
            if i32::from(top) - i32::from(last) >= c.noise {
                return false;
            }
            self.loud = now;
        }
        (self.previous, self.sampled_at) = (*codes, sample_at);
        true
    }

    /// One tick with the bridge off, and what it tells the estimator. True if the estimate has changed.
    pub fn inform(
        &mut self,
        estimator: &mut ZeroCrossing,
        c: &BackEmfCoefficients,
        now: Instant,
        codes: &[u16; 3],
        sample_at: u16,
    ) -> bool {
        let passage = self.step(c, now, codes, sample_at);
        if !self.settled {
            estimator.see_nothing(now);
        }
        match passage {
            Some(passage) if passage.direction == estimator.direction() || self.agrees() => {
                estimator.observe_coasting(now, passage.place, passage.age, passage.direction);
                true
            }
            _ => false,
        }
    }

    /// One tick with the bridge off.
    pub fn step(
        &mut self,
        c: &BackEmfCoefficients,
        now: Instant,
        codes: &[u16; 3],
        sample_at: u16,
    ) -> Option<Passage> {
        let age = -i32::from(sample_at);
        let before = core::mem::replace(&mut self.previous, *codes);
        let before_age = TICK as i32 - i32::from(core::mem::replace(&mut self.sampled_at, sample_at));
        self.settled = self.settled || now.since(self.began) >= u32::from(c.settle);
        if !self.settled {
            (self.loud, self.changed) = (now, now);
            return None;
        }
        let [on_a, on_b, on_c] = *codes;
        let top = if on_a >= on_b && on_a >= on_c {
            0
        } else if on_b >= on_c {
            1
        } else {
            2_u8
        };
        let level = |codes: &[u16; 3], phase: u8| i32::from(codes[usize::from(phase.min(2))]);
        // Neither is rest disproved here, nor is rotation: an offset about as high as the noise is seen in
        // some ticks and not in others.
        if level(codes, top) < i32::from(c.silence) {
            return None;
        }
        self.loud = now;
        let Some(last) = self.highest else {
            self.highest = Some(top);
            return None;
        };
        // By more than the noise, or two that are equal would change places for ever.
        let lead = level(codes, top) - level(codes, last);
        if top == last || lead < c.noise {
            return None;
        }
        let direction = if top == (last + 1) % 3 { Direction::Forward } else { Direction::Reverse };
        self.run = if direction == self.direction { self.run.saturating_add(1) } else { 1 };
        (self.highest, self.direction, self.changed) = (Some(top), direction, now);
        // Where the two were equal, between the two samples.
        let lag = (level(&before, last) - level(&before, top)).clamp(0, 0x3FFF);
        let span = before_age - age;
        // 14 bits, and a span of at most two periods 17.
        let part = span * lag / (lag + lead).max(1);
        let place = match direction {
            Direction::Forward => (4 * top + 1) % 12,
            Direction::Reverse => (4 * last + 7) % 12,
        };
        Some(Passage { place, age: before_age - part, direction })
    }

    /// Keeps the distance of its instants below the clock's range.
    pub fn renew(&mut self, now: Instant) {
        for instant in [&mut self.began, &mut self.loud, &mut self.changed] {
            *instant = instant.within_reach(now);
        }
    }

    /// Time from which a rotor without further signals counts as at rest: `rest` ticks after the last signal,
    /// or `still` ticks after `began` with the same highest terminal.
    pub fn settles(&self, rest: u32, began: Instant, still: u32) -> Instant {
        // The later of the two.
        let last = if self.changed.is_due(began) { began } else { self.changed };
        self.loud.after(rest).earlier(last.after(still))
    }

    /// The rotor turns: more than a revolution in one direction.
    #[inline]
    pub const fn is_turning(&self) -> bool {
        self.run >= CONVINCING
    }

    /// The last two changes agree.
    pub const fn agrees(&self) -> bool {
        self.run >= 2
    }

    /// Which way.
    pub const fn direction(&self) -> Direction {
        self.direction
    }

    /// Ticks for which the same terminal was the highest: a converter's offset is no rotation.
    pub const fn still(&self, now: Instant) -> u32 {
        now.since(self.changed)
    }

    /// Ticks for which the terminals were silent.
    pub const fn quiet(&self, now: Instant) -> u32 {
        now.since(self.loud)
    }
}
