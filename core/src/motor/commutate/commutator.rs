//! Electrical angle and speed to the step now and the commutation instants inside this period.

use super::commutation::{Direction, Step, sector_of};
use super::pwm::{Commutation, Commutations};
use crate::motor::interval::{SIXTH, part_of};
use crate::units::ElectricalAngle;
use serde::{Deserialize, Serialize};

/// A rotor that appears to have fallen back behind a boundary by less than this does not commutate back.
const HYSTERESIS: i32 = (SIXTH / 4) as i32;

/// Coefficients of the commutator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(C)]
pub struct CommutatorCoefficients {
    /// First instant of a period at which a pattern can change, in 1/65 536.
    pub earliest: u16,
    /// Timing advance, u32 turn (parameter 273).
    pub advance: u32,
}

/// State of the commutator: the sector it last commutated to, and where the rotor leaves that.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Commutator {
    sector: Option<u8>,
    step: Step,
    torque: Direction,
    backward: bool,
    /// Advance included, u32 turn.
    boundary: u32,
    /// Ticks from the last step to the next that changes something, if the rotor keeps its speed.
    left: u32,
}

impl Commutator {
    /// Forgets the sector: the next call commutates to wherever the rotor is.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// The step at `earliest`, and the changes later in this period, for a rotor at `angle` (at the period's
    /// boundary) turning by `speed` a tick, with torque in `torque`.
    #[inline]
    pub fn step(
        &mut self,
        c: &CommutatorCoefficients,
        angle: u32,
        speed: i32,
        torque: Direction,
    ) -> (Step, Commutations) {
        let (first, backward) = (self.step, speed < 0);
        let known = torque == self.torque && backward == self.backward;
        let (Some(sector), true) = (self.sector, known) else { return self.change(c, angle, speed, torque) };
        let (per_tick, ahead) = (speed.unsigned_abs(), distance(angle, self.boundary, speed));
        let blind = part_of(per_tick as i32, c.earliest.into());
        let seen = per_tick.saturating_add(blind / 2);
        // Within the sector that it was, before its end at the first instant that counts, and no second one
        // in view.
        let plain = per_tick > 0 && seen < SIXTH && ahead > blind && ahead < INSIDE;
        if !plain {
            self.change(c, angle, speed, torque)
        } else if ahead >= seen {
            self.left = (ahead - seen).checked_div(per_tick).unwrap_or(0) + 1;
            (first, Commutations::NONE)
        } else {
            let instant = instant_of(c, ahead, per_tick);
            self.go_on(c, neighbour(sector, backward), (angle, speed, seen), torque);
            (first, Commutations::one(Commutation { instant, step: self.step }))
        }
    }

    /// `sector` goes on, for a rotor that sees so far ahead.
    #[inline]
    fn go_on(
        &mut self,
        c: &CommutatorCoefficients,
        sector: u8,
        (angle, speed, seen): (u32, i32, u32),
        torque: Direction,
    ) {
        let backward = speed < 0;
        let boundary = before(entry(neighbour(sector, backward), speed), c.advance, speed);
        let ahead = distance(angle, boundary, speed);
        // Beyond half a turn ahead is behind.
        let room = if ahead > u32::MAX / 2 || seen >= SIXTH { 0 } else { ahead.saturating_sub(seen) };
        let left = room.checked_div(speed.unsigned_abs());
        *self = Self {
            sector: Some(sector),
            step: Step::for_sector(sector, torque),
            torque,
            backward,
            boundary,
            left: left.map_or(u32::MAX, |ticks| ticks.saturating_add(1)),
        };
    }

    /// The step at the end of the period.
    #[inline]
    pub const fn present(&self) -> Step {
        self.step
    }

    /// In how many ticks it has to be asked again if the rotor keeps its speed.
    #[inline]
    pub const fn ticks_left(&self) -> u32 {
        self.left
    }

    /// The sector that it last commutated to; `None` while it has not.
    #[inline]
    pub const fn sector(&self) -> Option<u8> {
        self.sector
    }

    #[inline(never)]
    fn change(
        &mut self,
        c: &CommutatorCoefficients,
        angle: u32,
        speed: i32,
        torque: Direction,
    ) -> (Step, Commutations) {
        // Advance looks ahead in the direction of motion.
        let advanced = if speed < 0 { angle.wrapping_sub(c.advance) } else { angle.wrapping_add(c.advance) };
        let at_earliest = advanced.wrapping_add(part_of(speed, c.earliest.into()));
        let mut sector = self.settle(at_earliest, speed);
        let first = Step::for_sector(sector, torque);
        let mut commutations = Commutations::default();
        // A rotor that seems to pass a sector within the blind start would be due before `earliest`.
        let mut last = c.earliest;
        for _ in 0..2 {
            let Some(instant) = instant_of_next(c, advanced, speed, sector) else { break };
            sector = neighbour(sector, speed < 0);
            last = last.max(instant);
            commutations.push(Commutation { instant: last, step: Step::for_sector(sector, torque) });
        }
        let seen = window(c, speed).min(SIXTH);
        self.go_on(c, sector, (angle, speed, seen), torque);
        (first, commutations)
    }

    /// The sector of `angle`, or the sector before it was left if the rotor seems to have moved back a
    /// little.
    fn settle(&self, angle: u32, speed: i32) -> u8 {
        let now = sector_of(ElectricalAngle((angle >> 16) as u16));
        let Some(last) = self.sector else { return now };
        let behind = if speed < 0 { (now + 5) % 6 == last } else { (now + 1) % 6 == last };
        if !behind || speed == 0 {
            return now;
        }
        // Distance back to the boundary between `now` and `last`.
        let boundary = entry(last, speed);
        let distance = boundary.wrapping_sub(angle) as i32;
        if distance.wrapping_abs() < HYSTERESIS { last } else { now }
    }
}

/// Time for which a rotor at `angle` (u32 turn) that turns by `speed` (2^-32 turn a tick) stays within
/// `sector`, less the advance, 1/65 536 tick: 0 if it has left it, `None` if it stands within.
pub fn time_in(
    c: &CommutatorCoefficients,
    sector: u8,
    angle: u32,
    speed: i32,
    torque: Direction,
) -> Option<u32> {
    // At rest the torque says where it is to go.
    let heading = if speed == 0 { torque.sign() } else { speed };
    let boundary = entry(neighbour(sector.min(5), heading < 0), heading);
    let ahead = distance(angle, boundary, heading).wrapping_sub(c.advance);
    if ahead > u32::MAX / 2 {
        return Some(0);
    }
    if speed == 0 {
        return None;
    }
    Some(time_to(ahead, speed.unsigned_abs()))
}

/// `ahead / per_tick`, 16 fraction bits, saturating: bit by bit, because dividing 64 bits takes more flash.
const fn time_to(ahead: u32, per_tick: u32) -> u32 {
    let (Some(mut time), Some(mut rest)) = (ahead.checked_div(per_tick), ahead.checked_rem(per_tick)) else {
        return u32::MAX;
    };
    if time > 0xFFFF {
        return u32::MAX;
    }
    let mut bits = 0;
    while bits < 16 {
        (time, rest, bits) = (time << 1, rest << 1, bits + 1);
        if rest >= per_tick {
            (time, rest) = (time | 1, rest - per_tick);
        }
    }
    time
}

/// The angle at which a rotor turning with `speed` enters `sector`.
fn entry(sector: u8, speed: i32) -> u32 {
    let start = SIXTH.wrapping_mul(sector as u32).wrapping_add(SIXTH / 2);
    if speed < 0 { start.wrapping_add(SIXTH) } else { start }
}

/// From `angle` to `place` in the direction of motion, u32 turn.
#[inline]
const fn distance(angle: u32, place: u32, speed: i32) -> u32 {
    if speed < 0 { angle.wrapping_sub(place) } else { place.wrapping_sub(angle) }
}

/// Angle that lies `before` a boundary, against the motion.
#[inline]
const fn before(boundary: u32, before: u32, speed: i32) -> u32 {
    if speed < 0 { boundary.wrapping_add(before) } else { boundary.wrapping_sub(before) }
}

/// The sector after this one, in the direction of motion.
const fn neighbour(sector: u8, backward: bool) -> u8 {
    match (sector, backward) {
        (0, true) => 5,
        (_, true) => sector - 1,
        (5.., false) => 0,
        (_, false) => sector + 1,
    }
}

/// A sector, less what the sector of an angle is rounded by.
const INSIDE: u32 = SIXTH - (1 << 17);

/// The angle, u32 turn, within which a sector boundary is commutated in this period: the rotor's way until
/// the middle of the next period's blind start.
fn window(c: &CommutatorCoefficients, speed: i32) -> u32 {
    let per_tick = speed.saturating_abs();
    (per_tick as u32).saturating_add(part_of(per_tick, c.earliest.into()) / 2)
}

/// Returns the instant within this period at which the rotor leaves `sector`. A boundary that falls between
/// the period's end and the middle of the next period's blind start (before `earliest`) is taken at the end
/// of this period: that is nearer.
fn instant_of_next(c: &CommutatorCoefficients, angle: u32, speed: i32, sector: u8) -> Option<u16> {
    if speed == 0 {
        return None;
    }
    let boundary = entry(neighbour(sector, speed < 0), speed);
    let ahead = distance(angle, boundary, speed);
    // More than half a turn ahead is behind: due at once.
    let ahead = if ahead > u32::MAX / 2 { 0 } else { ahead };
    (ahead < window(c, speed)).then(|| instant_of(c, ahead, speed.unsigned_abs()))
}

/// Returns the instant within this period at which a boundary that lies `ahead` is taken; a boundary that
/// this period does not reach is taken at its end.
fn instant_of(c: &CommutatorCoefficients, ahead: u32, per_tick: u32) -> u16 {
    if ahead >= per_tick { u16::MAX } else { part(ahead, per_tick).max(c.earliest) }
}

/// `ahead / per_tick` of a period in 1/65 536, in 32 bits: both scaled until the divisor has 16. `ahead` is
/// less than `per_tick`.
fn part(ahead: u32, per_tick: u32) -> u16 {
    let scale = 16_u32.saturating_sub(per_tick.leading_zeros());
    let instant = ((ahead >> scale) << 16) / (per_tick >> scale).max(1);
    instant.min(u16::MAX as u32) as u16
}
