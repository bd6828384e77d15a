//! Hall sensors: codes and edges to sector, angle and speed.
//!
//! A neighbouring code in the direction of motion after a plausible interval is taken at once. Anything else
//! (too early, backwards, not a neighbour) must still be there one tick later: that is the debounce, and it costs a
//! healthy rotor nothing. 000 and 111 are never taken. Glitches are counted; faults come from counts, not from one.

use super::commutation::{Direction, SECTOR, sector_of};
use super::samples::{EdgeSource, Samples};
use crate::units::ElectricalAngle;
use serde::{Deserialize, Serialize};

/// How the three hall lines belong to the phases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct HallWiring {
    /// Which permutation of the lines, 0..=5; 0 is A, B, C.
    pub order: u8,
    /// Lines to invert: bit 0 = A, bit 1 = B, bit 2 = C, before the permutation.
    pub polarity: u8,
    /// How far the edges lie beyond their place, -32 768..=32 767 for half a turn either way.
    pub offset: i16,
}

/// One tick in the units of intervals: 1/65 536 tick.
pub const TICK: u32 = 1 << 16;
/// An edge that only the sampled level shows came half a tick ago, on average.
const SAMPLED_AGE: u32 = TICK / 2;
/// One sixth of a turn as a u32 angle.
const SIXTH: u32 = u32::MAX / 6;
/// No sector.
const INVALID: u8 = 0xFF;
/// Sector by code of correctly wired sensors; bit 0 = A. A is high from 330 to 150 degrees, B and C 120 later each.
const SECTOR_BY_CODE: [u8; 8] = [INVALID, 0, 2, 1, 4, 5, 3, INVALID];
/// The permutations by order number (parameter 262): which line is A, B, C.
const ORDERS: [[u8; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];

/// Coefficients of the hall station.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct HallCoefficients {
    /// Sector by raw code, 0xFF = invalid; built from the wiring.
    pub sectors: [u8; 8],
    /// How far the edges lie beyond 30 + 60 k degrees.
    pub offset: ElectricalAngle,
    /// No edge for this long, in 1/65 536 tick, means standstill (parameter 113).
    pub timeout: u32,
    /// Slowest speed that is interpolated between edges, in 2^-32 turn a tick.
    pub interpolation_min: u32,
    /// Edges come time-stamped; the level alone is a late witness.
    pub captured: bool,
}

/// Sector by raw code for a wiring; an order above 5 counts as 0.
pub fn sectors(wiring: HallWiring) -> [u8; 8] {
    let order = ORDERS.get(wiring.order as usize).copied().unwrap_or(ORDERS[0]);
    core::array::from_fn(|raw| {
        let lines = raw as u8 ^ (wiring.polarity & 7);
        let code =
            order.iter().enumerate().fold(0, |code, (phase, line)| code | ((lines >> line) & 1) << phase);
        SECTOR_BY_CODE[(code & 7) as usize]
    })
}

/// Counts that the fault logic and the user read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct HallDiagnostics {
    /// Ticks or edges with code 000 or 111, saturating.
    pub invalid: u16,
    /// Changes to a sector that is no neighbour, saturating.
    pub jumps: u16,
}

/// What happened to the sensors in one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct HallEvents {
    /// The level is 000 or 111 now.
    pub invalid: bool,
    /// A jump was seen.
    pub jump: bool,
    /// Sectors turned in this tick, signed.
    pub sectors: i8,
}

/// State of the hall station.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hall {
    /// Present sector; `None` until the first valid code.
    sector: Option<u8>,
    /// A change that waits for its confirmation: sector and its age at the last boundary.
    candidate: Option<(u8, u32)>,
    /// Since the last accepted edge, in 1/65 536 tick, saturating.
    since_edge: u32,
    /// The last six intervals, and how many of them are of the present run in one direction.
    intervals: [u32; 6],
    valid: u8,
    next: u8,
    /// Direction of the last edge.
    direction: Direction,
    /// Angle at the present boundary, u32 turn.
    angle: u32,
    /// Speed over up to one revolution, 2^-32 turn a tick, signed.
    speed: i32,
    /// Ticks in a row with the level 000 or 111, saturating.
    invalid_run: u8,
    /// The rotor seems to have jumped, or to have turned round at speed: the sensors are not believed.
    doubt: bool,
    diagnostics: HallDiagnostics,
}

/// Ticks of an invalid level after which the position is lost.
const INVALID_RUN_MAX: u8 = 3;
/// Intervals in one direction that remove a doubt.
const CONVINCING: u8 = 2;

impl Hall {
    /// One tick: takes the edges of the period that ended and the present level.
    pub fn step(&mut self, c: &HallCoefficients, samples: &Samples) -> HallEvents {
        let mut events = HallEvents::default();
        self.since_edge = self.since_edge.saturating_add(TICK);
        self.angle = self.angle.wrapping_add(self.speed as u32);
        let level = c.sectors[(samples.hall & 7) as usize];
        let waiting = self.candidate.take();
        let mut captured = false;
        for edge in samples.edges.iter().filter(|edge| edge.source == EdgeSource::Hall) {
            captured = true;
            self.observe(c, edge.code, TICK - edge.instant as u32, &mut events);
        }
        self.confirm(c, waiting, level, &mut events);
        // A level that no edge explained: without capture it *is* the edge; with capture its edge belongs to the
        // next tick, unless it was lost, and then the candidate is confirmed there.
        self.invalid_run = if level == INVALID { self.invalid_run.saturating_add(1) } else { 0 };
        if level == INVALID {
            events.invalid = true;
            self.diagnostics.invalid = self.diagnostics.invalid.saturating_add(1);
        } else if self.sector != Some(level) && !captured && self.candidate.is_none() {
            if c.captured && self.sector.is_some() {
                self.candidate = Some((level, 0));
            } else {
                self.observe_sector(c, level, SAMPLED_AGE, &mut events);
            }
        }
        self.clamp(c);
        if self.since_edge >= c.timeout {
            self.valid = 0;
            self.speed = 0;
            self.doubt = false;
        }
        events
    }

    /// Forgets position and speed; the counts stay.
    pub fn forget(&mut self) {
        *self = Self { diagnostics: self.diagnostics, ..Self::default() };
    }

    /// A candidate of the tick before that the level still shows is accepted, with the better time stamp if its edge
    /// has come since; one that has gone was a glitch.
    fn confirm(
        &mut self,
        c: &HallCoefficients,
        waiting: Option<(u8, u32)>,
        level: u8,
        events: &mut HallEvents,
    ) {
        let Some((sector, age)) = waiting else { return };
        if sector != level || self.sector == Some(level) {
            return;
        }
        let age = match self.candidate.take() {
            Some((newer, age)) if newer == sector => age,
            _ => age.saturating_add(TICK),
        };
        self.accept(c, sector, age, events);
    }

    fn observe(&mut self, c: &HallCoefficients, code: u8, age: u32, events: &mut HallEvents) {
        match c.sectors[(code & 7) as usize] {
            INVALID => {
                events.invalid = true;
                self.diagnostics.invalid = self.diagnostics.invalid.saturating_add(1);
            }
            sector => self.observe_sector(c, sector, age, events),
        }
    }

    fn observe_sector(&mut self, c: &HallCoefficients, sector: u8, age: u32, events: &mut HallEvents) {
        let Some(present) = self.sector else {
            self.sector = Some(sector);
            self.angle = self.centre(c, sector);
            // The rotor may turn already: what is left of this sector is no interval.
            self.since_edge = u32::MAX;
            return;
        };
        let direction = match (sector + 6 - present) % 6 {
            0 => {
                self.candidate = None;
                return;
            }
            1 => Direction::Forward,
            5 => Direction::Reverse,
            _ => {
                events.jump = true;
                self.diagnostics.jumps = self.diagnostics.jumps.saturating_add(1);
                self.candidate = Some((sector, age));
                return;
            }
        };
        let interval = self.since_edge.saturating_sub(age);
        let plausible = self.valid > 0 && direction == self.direction && interval >= self.newest() / 2;
        if plausible {
            self.accept(c, sector, age, events);
        } else {
            self.candidate = Some((sector, age));
        }
    }

    /// The rotor has entered `sector` `age` before this tick's boundary.
    fn accept(&mut self, c: &HallCoefficients, sector: u8, age: u32, events: &mut HallEvents) {
        let turned = match (sector + 6 - self.sector.unwrap_or(sector)) % 6 {
            0 => return,
            step @ 1..=3 => step as i8,
            step => step as i8 - 6,
        };
        let direction = if turned > 0 { Direction::Forward } else { Direction::Reverse };
        let interval = self.since_edge.saturating_sub(age);
        let moving = self.speed.unsigned_abs() >= c.interpolation_min.max(1);
        self.doubt |= turned.abs() > 1 || (moving && direction != self.direction);
        if turned.abs() > 1 || direction != self.direction || interval >= c.timeout {
            self.valid = 0;
        } else {
            self.intervals[(self.next % 6) as usize] = interval.max(1);
            self.next = (self.next + 1) % 6;
            self.valid = (self.valid + 1).min(6);
            self.doubt &= self.valid < CONVINCING;
        }
        self.direction = direction;
        self.since_edge = age;
        self.sector = Some(sector);
        events.sectors = events.sectors.saturating_add(turned);
        self.speed = self.measure();
        self.angle = self.entry(c, sector, direction).wrapping_add(fraction_of(self.speed, age));
    }

    /// `valid / 6` turns over the sum of the intervals: a whole revolution when it has one, so that misplaced
    /// sensors cancel.
    fn measure(&self) -> i32 {
        let sum: u64 = (0..self.valid).map(|back| self.interval(back) as u64).sum();
        if sum == 0 {
            return 0;
        }
        let turned = self.valid as u64 * (SIXTH as u64);
        let speed = ((turned << 16) / sum).min(i32::MAX as u64) as i32;
        speed * self.direction.sign()
    }

    fn interval(&self, back: u8) -> u32 {
        self.intervals[((self.next + 11 - back) % 6) as usize]
    }

    fn newest(&self) -> u32 {
        self.interval(0)
    }

    /// Interpolation stays between the edge behind and half a sector beyond the edge ahead; below the speed floor
    /// the middle of the sector stands for all of it.
    fn clamp(&mut self, c: &HallCoefficients) {
        let Some(sector) = self.sector else { return };
        let centre = self.centre(c, sector);
        if self.speed.unsigned_abs() < c.interpolation_min.max(1) {
            self.angle = centre;
            return;
        }
        let ahead = self.angle.wrapping_sub(centre) as i32;
        let (behind_max, ahead_max) = match self.direction {
            Direction::Forward => (SIXTH / 2, SIXTH),
            Direction::Reverse => (SIXTH, SIXTH / 2),
        };
        self.angle = centre.wrapping_add(ahead.clamp(-(behind_max as i32), ahead_max as i32) as u32);
    }

    fn centre(&self, c: &HallCoefficients, sector: u8) -> u32 {
        // 60 + 60 s degrees.
        SIXTH.wrapping_mul(sector as u32 + 1).wrapping_add((c.offset.0 as u32) << 16)
    }

    fn entry(&self, c: &HallCoefficients, sector: u8, direction: Direction) -> u32 {
        match direction {
            Direction::Forward => self.centre(c, sector).wrapping_sub(SIXTH / 2),
            Direction::Reverse => self.centre(c, sector).wrapping_add(SIXTH / 2),
        }
    }

    /// Angle at this tick's boundary, u32 turn.
    pub const fn angle(&self) -> u32 {
        self.angle
    }

    /// Speed that interpolates, 2^-32 turn a tick, signed.
    pub const fn speed(&self) -> i32 {
        self.speed
    }

    /// Speed for the speed loop: the measured one, but never more than the edge that has not come allows.
    pub fn speed_bounded(&self) -> i32 {
        if self.valid == 0 || self.since_edge <= self.newest() {
            return self.speed;
        }
        // Within the bound, by multiplication: the 64-bit division is for the edge that is overdue.
        let sixth = (SIXTH as u64) << 16;
        if self.speed.unsigned_abs() as u64 * self.since_edge as u64 <= sixth {
            return self.speed;
        }
        let bound = (sixth / self.since_edge as u64).min(i32::MAX as u64) as i32;
        self.speed.clamp(-bound, bound)
    }

    /// No edge for the time-out.
    pub const fn stopped(&self, c: &HallCoefficients) -> bool {
        self.since_edge >= c.timeout
    }

    /// The position is not to be believed: torque by it could be torque in any direction.
    pub const fn doubtful(&self) -> bool {
        self.doubt || self.invalid_run >= INVALID_RUN_MAX
    }

    /// Present sector, 0..=5; `None` until the first valid code.
    pub const fn sector(&self) -> Option<u8> {
        self.sector
    }

    /// The counts.
    pub const fn diagnostics(&self) -> HallDiagnostics {
        self.diagnostics
    }
}

/// `speed x age / tick`.
fn fraction_of(speed: i32, age: u32) -> u32 {
    ((speed as i64 * age as i64) >> 16) as u32
}

const _: () = assert!(SECTOR as u32 == SIXTH.div_ceil(1 << 16) && sector_of(ElectricalAngle(0)) == 5);
