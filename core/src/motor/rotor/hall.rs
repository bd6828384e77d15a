//! Hall sensors: codes and edges to sector, angle and speed.
//!
//! A neighbouring code in the direction of motion after a plausible interval is taken at once. Anything else
//! (too early, backwards, not a neighbour) must still be there one tick later: that is the debounce, and it
//! costs a healthy rotor nothing. 000 and 111 are never taken. Glitches are counted; faults come from counts,
//! not from one.

use crate::motor::clock::Instant;
use crate::motor::commutate::commutation::{Direction, SECTOR, sector_of};
use crate::motor::interval::{SIXTH, TICK, part_of, speed_of};
use crate::motor::sense::samples::{EdgeSource, Samples};
use crate::units::ElectricalAngle;
use serde::{Deserialize, Serialize};

/// Assignment of the three hall lines to the phases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct HallWiring {
    /// Which permutation of the lines, 0..=5; 0 is A, B, C.
    pub order: u8,
    /// Lines to invert: bit 0 = A, bit 1 = B, bit 2 = C, before the permutation.
    pub polarity: u8,
    /// Angle by which the edges lie beyond their place, -32 768..=32 767 for half a turn either way.
    pub offset: i16,
}

/// An edge that only the sampled level shows came half a tick ago, on average.
const SAMPLED_AGE: u32 = TICK / 2;
/// Up to here six intervals fit 32 bits: 0.4 s at 10 kHz. A longer one stands alone.
const LONGEST: u32 = 1 << 28;
/// No sector.
const INVALID: u8 = 0xFF;
/// Sector by code of correctly wired sensors; bit 0 = A. A is high from 330 to 150 degrees, B and C 120 later
/// each.
const SECTOR_BY_CODE: [u8; 8] = [INVALID, 0, 2, 1, 4, 5, 3, INVALID];
/// The permutations by order number (parameter 262): which line is A, B, C.
const ORDERS: [[u8; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];

/// Coefficients of the hall station.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(C)]
pub struct HallCoefficients {
    /// Sector by raw code, 0xFF = invalid; built from the wiring.
    pub sectors: [u8; 8],
    /// Angle by which the edges lie beyond 30 + 60 k degrees.
    pub offset: ElectricalAngle,
    /// No edge for this long, in 1/65 536 tick, means standstill (parameter 113).
    pub timeout: u32,
    /// Slowest speed that is interpolated between edges, in 2^-32 turn a tick.
    pub interpolation_min: u32,
    /// Edges come time-stamped; the level alone is a late witness.
    pub captured: bool,
    /// Ticks of an invalid level after which the position is lost.
    pub lost_after: u8,
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
    /// Times that the sensors lost their code (000 or 111), saturating.
    pub invalid: u16,
    /// Changes to a sector that is no neighbour, saturating.
    pub jumps: u16,
}

/// Events of the sensors in one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct HallEvents {
    /// The level is 000 or 111 now.
    pub invalid: bool,
    /// A jump was seen.
    pub jump: bool,
    /// Sectors turned in this tick, signed.
    pub sectors: i8,
}

impl HallEvents {
    /// Any of these events has happened.
    #[inline]
    pub const fn happened(self) -> bool {
        self.sectors != 0 || self.invalid || self.jump
    }
}

/// State of the hall station.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hall {
    /// Present sector, [`INVALID`] until the first valid code.
    sector: u8,
    /// Nothing waits for its confirmation, and the last level was this sector's.
    settled: bool,
    /// Nothing waits, and the last level was 000 or 111: no sensors, or none with a supply.
    mute: bool,
    /// A change that waits for its confirmation: sector and its age at the last boundary.
    candidate: Option<(u8, u32)>,
    /// The boundary at which the last edge was accepted, and the edge's age then, 1/65 536 tick.
    entered: Instant,
    age: u32,
    /// No edge for the time-out, or none at all yet.
    still: bool,
    /// The intervals of the present run in one direction, newest first, 0 where there is none; and how many
    /// there are.
    intervals: [u32; 6],
    valid: u8,
    /// Direction of the last edge.
    direction: Direction,
    /// Angle at `entered`, u32 turn, and its change in a tick from then on, 2^-32 turn.
    angle: u32,
    interpolated: i32,
    /// Interpolation stays from here to so far beyond, u32 turn.
    from: u32,
    span: u32,
    /// Speed over up to one revolution, 2^-32 turn a tick, signed.
    speed: i32,
    /// Time at which time alone changes something, if the code stays.
    due: Instant,
    /// Ticks in a row with the level 000 or 111; counted to `lost_after`.
    invalid_run: u8,
    /// The rotor seems to have jumped, or to have turned round at speed: the sensors are not believed.
    doubt: bool,
    diagnostics: HallDiagnostics,
}

impl Default for Hall {
    fn default() -> Self {
        Self {
            sector: INVALID,
            settled: false,
            mute: false,
            candidate: None,
            entered: Instant::default(),
            age: 0,
            still: false,
            intervals: [0; 6],
            valid: 0,
            direction: Direction::default(),
            angle: 0,
            interpolated: 0,
            from: 0,
            span: u32::MAX,
            speed: 0,
            due: Instant::default(),
            invalid_run: 0,
            doubt: false,
            diagnostics: HallDiagnostics::default(),
        }
    }
}

/// Intervals in one direction that remove a doubt.
const CONVINCING: u8 = 2;

impl Hall {
    /// One tick: takes the edges of the period that ended and the present level. Between deadlines a tick
    /// with the level of the last one and no edge changes nothing. Mute sensors answer `invalid` in every
    /// tick, so whoever counts that asks in every tick.
    #[inline]
    pub fn step(&mut self, c: &HallCoefficients, now: Instant, samples: &Samples) -> HallEvents {
        let level = c.sectors[(samples.hall & 7) as usize];
        let same = (self.settled && level == self.sector) || (self.mute && level == INVALID);
        let events = if same && samples.edges.is_empty() {
            self.invalid_run = (self.invalid_run + u8::from(self.mute)).min(c.lost_after);
            HallEvents { invalid: self.mute, ..HallEvents::default() }
        } else if let Some(age) = self.moves_on(c, now, samples, level) {
            self.count(self.since_edge(now).saturating_sub(age));
            self.enter(c, now, level, age);
            HallEvents { sectors: self.direction.sign() as i8, ..HallEvents::default() }
        } else {
            self.attend(c, now, samples, level)
        };
        if self.due.is_due(now) {
            self.expire(c, now);
        }
        events
    }

    /// Time at which [`step`](Self::step) must be called even if the level stays.
    #[inline]
    pub const fn due(&self) -> Instant {
        self.due
    }

    /// The next tick looks at everything.
    pub const fn wake(&mut self, now: Instant) {
        self.due = now;
    }

    /// Changes that time alone brings: standstill, and the end of the span in which the angle is
    /// interpolated.
    #[inline(never)]
    fn expire(&mut self, c: &HallCoefficients, now: Instant) {
        if !self.still && self.since_edge(now) >= c.timeout {
            (self.still, self.valid, self.speed, self.doubt) = (true, 0, 0, false);
            self.intervals = [0; 6];
            self.stand(c);
        } else if self.angle(now).wrapping_sub(self.from) > self.span {
            self.clamp(now);
        }
        self.due = self.deadline(c, now);
    }

    #[inline]
    fn deadline(&self, c: &HallCoefficients, now: Instant) -> Instant {
        let counts = self.mute && self.invalid_run < c.lost_after;
        if counts || !(self.settled || self.mute) {
            return now.next();
        }
        let standstill =
            if self.still { u32::MAX } else { c.timeout.saturating_sub(self.age).div_ceil(TICK) };
        let passed = self.angle.wrapping_sub(self.from);
        let room = if self.interpolated < 0 { passed } else { self.span.saturating_sub(passed) };
        let clamped =
            room.checked_div(self.interpolated.unsigned_abs()).unwrap_or(u32::MAX).saturating_add(1);
        match standstill.min(clamped) {
            // Nothing is left to expire. Counted from the last edge the farthest deadline would come, and
            // stay.
            u32::MAX => now.after(u32::MAX),
            left => self.entered.after(left),
        }
    }

    /// Time since the last edge, 1/65 536 tick, saturating.
    #[inline]
    const fn since_edge(&self, now: Instant) -> u32 {
        if self.still { u32::MAX } else { self.age.saturating_add(now.time_since(self.entered)) }
    }

    /// The edge that a turning rotor shows: one, to the next sector in the direction of motion, after a
    /// plausible interval, and the level agrees. Its age.
    #[inline]
    fn moves_on(&self, c: &HallCoefficients, now: Instant, samples: &Samples, level: u8) -> Option<u32> {
        let [edge] = samples.edges.as_slice() else { return None };
        let age = TICK - edge.instant as u32;
        let forward = edge.source == EdgeSource::Hall
            && level == after(self.sector, self.direction)
            && c.sectors[(edge.code & 7) as usize] == level;
        let settled = self.settled && !self.doubt && self.valid > 0;
        let interval = self.since_edge(now).saturating_sub(age);
        (forward && settled && interval >= self.newest() / 2 && interval < c.timeout.min(LONGEST))
            .then_some(age)
    }

    /// Something has changed, or waits.
    #[inline(never)]
    fn attend(&mut self, c: &HallCoefficients, now: Instant, samples: &Samples, level: u8) -> HallEvents {
        let mut events = HallEvents::default();
        // Lines without sensors never had a code that they could lose.
        let has_code = self.invalid_run == 0 && self.sector != INVALID;
        let waiting = self.candidate.take();
        let mut captured = false;
        for edge in samples.edges.iter().filter(|edge| edge.source == EdgeSource::Hall) {
            captured = true;
            self.observe(c, now, edge.code, TICK - edge.instant as u32, &mut events);
        }
        self.confirm(c, now, waiting, level, &mut events);
        // A level that no edge explained: without capture it *is* the edge; with capture its edge belongs to
        // the next tick, unless it was lost, and then the candidate is confirmed there.
        self.invalid_run = if level == INVALID { (self.invalid_run + 1).min(c.lost_after) } else { 0 };
        if level == INVALID {
            events.invalid = true;
        } else if self.sector != level && !captured && self.candidate.is_none() {
            if c.captured && self.sector != INVALID {
                self.candidate = Some((level, 0));
            } else {
                self.observe_sector(c, now, level, SAMPLED_AGE, &mut events);
            }
        }
        self.due = now;
        self.settled = self.candidate.is_none() && self.sector == level && level != INVALID;
        self.mute = self.candidate.is_none() && level == INVALID;
        if events.invalid && has_code {
            self.diagnostics.invalid = self.diagnostics.invalid.saturating_add(1);
        }
        events
    }

    /// Forgets position and speed; the counts stay.
    pub fn forget(&mut self, now: Instant) {
        *self = Self { diagnostics: self.diagnostics, entered: now, due: now, ..Self::default() };
    }

    /// A candidate of the tick before that the level still shows is accepted, with the better time stamp if
    /// its edge has come since; one that has gone was a glitch.
    fn confirm(
        &mut self,
        c: &HallCoefficients,
        now: Instant,
        waiting: Option<(u8, u32)>,
        level: u8,
        events: &mut HallEvents,
    ) {
        let Some((sector, age)) = waiting else { return };
        if sector != level || self.sector == level {
            return;
        }
        let age = match self.candidate.take() {
            Some((newer, age)) if newer == sector => age,
            _ => age.saturating_add(TICK),
        };
        self.accept(c, now, sector, age, events);
    }

    fn observe(&mut self, c: &HallCoefficients, now: Instant, code: u8, age: u32, events: &mut HallEvents) {
        match c.sectors[(code & 7) as usize] {
            INVALID => events.invalid = true,
            sector => self.observe_sector(c, now, sector, age, events),
        }
    }

    fn observe_sector(
        &mut self,
        c: &HallCoefficients,
        now: Instant,
        sector: u8,
        age: u32,
        events: &mut HallEvents,
    ) {
        if self.sector == INVALID {
            // The rotor may turn already: what is left of this sector is no interval.
            (self.sector, self.still) = (sector, true);
            self.stand(c);
            return;
        }
        let direction = match (sector + 6 - self.sector) % 6 {
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
        let interval = self.since_edge(now).saturating_sub(age);
        let plausible = self.valid > 0 && direction == self.direction && interval >= self.newest() / 2;
        if plausible {
            self.accept(c, now, sector, age, events);
        } else {
            self.candidate = Some((sector, age));
        }
    }

    /// The rotor has entered `sector` `age` before this tick's boundary.
    fn accept(&mut self, c: &HallCoefficients, now: Instant, sector: u8, age: u32, events: &mut HallEvents) {
        let turned = match (sector + 6 - self.sector) % 6 {
            0 => return,
            step @ 1..=3 => step as i8,
            step => step as i8 - 6,
        };
        let direction = if turned > 0 { Direction::Forward } else { Direction::Reverse };
        let interval = self.since_edge(now).saturating_sub(age);
        let moving = self.speed.unsigned_abs() >= c.interpolation_min.max(1);
        self.doubt |= turned.abs() > 1 || (moving && direction != self.direction);
        if turned.abs() > 1 || direction != self.direction || interval >= c.timeout {
            (self.intervals, self.valid) = ([0; 6], 0);
        } else {
            self.count(interval);
            self.doubt &= self.valid < CONVINCING;
        }
        self.direction = direction;
        events.sectors = events.sectors.saturating_add(turned);
        self.enter(c, now, sector, age);
    }

    /// One more interval of the present run.
    #[inline]
    fn count(&mut self, interval: u32) {
        let [a, b, c, d, e, _] = self.intervals;
        if interval.max(a) > LONGEST {
            (self.intervals, self.valid) = ([interval, 0, 0, 0, 0, 0], 1);
        } else {
            self.intervals = [interval.max(1), a, b, c, d, e];
            self.valid = (self.valid + 1).min(6);
        }
    }

    /// Angle and speed at the beginning of `sector`, which was `age` ago.
    #[inline]
    fn enter(&mut self, c: &HallCoefficients, now: Instant, sector: u8, age: u32) {
        let direction = self.direction;
        (self.entered, self.age, self.still, self.sector) = (now, age, false, sector);
        self.speed = self.measure();
        if self.speed.unsigned_abs() < c.interpolation_min.max(1) {
            self.stand(c);
        } else {
            self.angle = entry(c, sector, direction).wrapping_add(part_of(self.speed, age as i32));
            self.interpolated = self.speed;
            // From the edge behind to half a sector beyond the edge ahead.
            self.span = SIXTH / 2 + SIXTH;
            let behind = if direction == Direction::Forward { SIXTH / 2 } else { SIXTH };
            self.from = centre(c, sector).wrapping_sub(behind);
        }
        self.due = self.deadline(c, now);
    }

    /// Below the speed floor the middle of the sector stands for all of it.
    fn stand(&mut self, c: &HallCoefficients) {
        if self.sector != INVALID {
            self.angle = centre(c, self.sector);
            (self.from, self.span, self.interpolated) = (self.angle, 0, 0);
        }
    }

    /// `valid / 6` turns over the sum of the intervals: a whole revolution when it has one, so that misplaced
    /// sensors cancel.
    fn measure(&self) -> i32 {
        let [a, b, c, d, e, f] = self.intervals;
        let sum = a + b + c + d + e + f;
        if sum == 0 { 0 } else { speed_of(self.valid, sum) * self.direction.sign() }
    }

    const fn newest(&self) -> u32 {
        let [newest, ..] = self.intervals;
        newest
    }

    /// To the nearer end of the span, where it stays.
    fn clamp(&mut self, now: Instant) {
        let beyond = self.angle(now).wrapping_sub(self.from).wrapping_sub(self.span);
        let ahead = beyond < (u32::MAX - self.span) / 2;
        self.angle = if ahead { self.from.wrapping_add(self.span) } else { self.from };
        self.interpolated = 0;
    }

    /// Angle at the boundary `now`, u32 turn.
    #[inline]
    pub const fn angle(&self, now: Instant) -> u32 {
        self.angle.wrapping_add((self.interpolated as u32).wrapping_mul(now.since(self.entered)))
    }

    /// Speed since the last edge, 2^-32 turn a tick, signed.
    #[inline]
    pub const fn speed(&self) -> i32 {
        self.speed
    }

    /// Speed for the speed loop: the measured one, but never more than the edge that has not come by `now`
    /// allows.
    #[inline]
    pub fn speed_bounded(&self, now: Instant) -> i32 {
        let since = self.since_edge(now);
        if self.valid == 0 || since <= self.newest() {
            return self.speed;
        }
        let bound = speed_of(1, since);
        self.speed.min(bound).max(-bound)
    }

    /// No edge for the time-out.
    #[inline]
    pub const fn stopped(&self) -> bool {
        self.still
    }

    /// The position is not to be believed: torque by it could be torque in any direction.
    #[inline]
    pub const fn doubtful(&self, c: &HallCoefficients) -> bool {
        self.doubt || self.invalid_run >= c.lost_after
    }

    /// The code is 000 or 111.
    pub const fn is_mute(&self) -> bool {
        self.mute
    }

    /// Present sector, 0..=5; `None` until the first valid code.
    pub const fn sector(&self) -> Option<u8> {
        if self.sector == INVALID { None } else { Some(self.sector) }
    }

    /// The counts.
    pub const fn diagnostics(&self) -> HallDiagnostics {
        self.diagnostics
    }
}

/// The sector after this one.
#[inline]
const fn after(sector: u8, direction: Direction) -> u8 {
    match (direction, sector) {
        (Direction::Forward, 5) => 0,
        (Direction::Forward, _) => sector.wrapping_add(1),
        (Direction::Reverse, 0) => 5,
        (Direction::Reverse, _) => sector.wrapping_sub(1),
    }
}

/// The middle of `sector`: 60 + 60 s degrees.
fn centre(c: &HallCoefficients, sector: u8) -> u32 {
    SIXTH.wrapping_mul(sector as u32 + 1).wrapping_add((c.offset.0 as u32) << 16)
}

fn entry(c: &HallCoefficients, sector: u8, direction: Direction) -> u32 {
    match direction {
        Direction::Forward => centre(c, sector).wrapping_sub(SIXTH / 2),
        Direction::Reverse => centre(c, sector).wrapping_add(SIXTH / 2),
    }
}

const _: () = assert!(SECTOR as u32 == SIXTH.div_ceil(1 << 16) && sector_of(ElectricalAngle(0)) == 5);
