//! Listening to a coasting motor: with the bridge off its terminals show the back-EMF.
//!
//! The divider pulls the star point to ground and the body diodes hold the lowest terminal there, so what is certain is
//! which terminal is the highest. It changes three times a revolution, where two back-EMFs cross above the third:
//!
//! ```text
//!  forward   A from 30 to 150, B to 270, C to 30           A -> B at 150, B -> C at 270, C -> A at  30
//!  reverse   (back-EMF inverted) A from 330 down to 210     A -> C at 210, C -> B at  90, B -> A at 330
//! ```

use super::commutation::Direction;
use super::interval::TICK;
use crate::units::{Volts, quotient};
use serde::{Deserialize, Serialize};

/// The highest terminal changed: the rotor was there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Heard {
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
    previous: [i32; 3],
    previous_age: i32,
    /// Ticks of listening, saturating.
    ticks: u32,
    /// Ticks since a terminal was above the noise, saturating.
    quiet: u32,
    /// Ticks since the highest terminal changed, saturating.
    still: u32,
    /// Changes in a row in one direction.
    run: u8,
    direction: Direction,
}

/// Ticks after which the windings carry no more current.
const SETTLED: u32 = 8;
/// Changes in one direction, in time, that prove a turning rotor: more than a revolution.
const CONVINCING: u8 = 4;

impl Listening {
    /// The bridge is on: nothing can be heard.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// One tick with the bridge off.
    pub fn step(&mut self, voltage: &[Volts; 3], noise: i32, sample_at: u16) -> Option<Heard> {
        let now = voltage.map(Volts::to_bits);
        let age = -i32::from(sample_at);
        let before = core::mem::replace(&mut self.previous, now);
        let before_age = core::mem::replace(&mut self.previous_age, age).saturating_add(TICK as i32);
        self.ticks = self.ticks.saturating_add(1);
        self.quiet = self.quiet.saturating_add(1);
        self.still = self.still.saturating_add(1);
        if self.ticks < SETTLED {
            (self.quiet, self.still) = (0, 0);
            return None;
        }
        let [a, b, c] = now;
        let top = if a >= b && a >= c {
            0
        } else if b >= c {
            1
        } else {
            2_u8
        };
        let level = |values: &[i32; 3], phase: u8| values.get(usize::from(phase)).copied().unwrap_or(0);
        // Neither is rest disproved here, nor is rotation: an offset about as high as the noise is heard in some ticks and not in others.
        if level(&now, top) < noise {
            return None;
        }
        self.quiet = 0;
        let Some(last) = self.highest else {
            self.highest = Some(top);
            return None;
        };
        // By more than the noise, or two that are equal would change places for ever.
        let lead = level(&now, top) - level(&now, last);
        if top == last || lead < noise {
            return None;
        }
        let direction = if top == (last + 1) % 3 { Direction::Forward } else { Direction::Reverse };
        self.run = if direction == self.direction { self.run.saturating_add(1) } else { 1 };
        (self.highest, self.direction, self.still) = (Some(top), direction, 0);
        // Where the two were equal, between the two samples.
        let lag = (level(&before, last) - level(&before, top)).max(0);
        let whole = (lag + lead).max(1);
        let span = before_age - age;
        let part = quotient(i64::from(span) * i64::from(lag), whole.into()) as i32;
        let place = match direction {
            Direction::Forward => (4 * top + 1) % 12,
            Direction::Reverse => (4 * last + 7) % 12,
        };
        Some(Heard { place, age: before_age - part, direction })
    }

    /// The rotor turns: more than a revolution in one direction.
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
    pub const fn still(&self) -> u32 {
        self.still
    }

    /// Ticks for which nothing was heard.
    pub const fn quiet(&self) -> u32 {
        self.quiet
    }
}
