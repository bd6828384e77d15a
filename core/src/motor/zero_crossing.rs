//! From zero crossings to angle and speed: interpolation, prediction with trend, plausibility, missed and late crossings.
//!
//! Crossings lie at 60 + 60 s degrees, the middle of sector s. Between them the angle runs on with the predicted speed, and the
//! commutator finds its instants from it: crossing + 30 degrees - advance. A crossing that does not come is thereby commutated blind
//! half an interval after it was due. What a level says for certain ("the rotor is not there yet") bounds the angle.

use super::back_emf::{Crossing, Level, Sight};
use super::commutation::Direction;
use super::gain::Gain;
use super::interval::{SIXTH, TICK, TWELFTH, part_of, speed_of};
use serde::{Deserialize, Serialize};

/// Blind steps in a row that the duty fades over; then the rotor is lost.
pub const BLIND_MAX: u8 = 6;
/// Late crossings in a row that do the same.
pub const LATE_MAX: u8 = 24;
/// Consistent crossings, of both polarities, that make a hand-over (one electrical revolution).
pub const PREPARED: u8 = 6;

/// What became of the last step's crossing: the why-channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum Why {
    /// There has been none.
    #[default]
    None = 0,
    /// Seen where it was expected.
    Accepted = 1,
    /// Earlier than half the expected interval: ignored.
    Filtered = 2,
    /// Not seen: commutated by prediction.
    Blind = 3,
    /// Hidden by demagnetisation, or earlier than the blanking ended.
    DemagLate = 4,
    /// Taken from the coasting motor's terminals.
    Listened = 5,
}

/// Six of them fit 32 bits: 0.4 s at 10 kHz, longer than any crossing time-out.
const LONGEST: u32 = 1 << 28;

/// State of the estimator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ZeroCrossing {
    /// At the present boundary, u32 turn.
    angle: u32,
    /// Predicted for the next interval, 2^-32 turn a tick, signed.
    speed: i32,
    /// Over up to one revolution, the same unit.
    speed_mean: i32,
    /// Since the last accepted crossing, 1/65 536 tick, saturating.
    since: u32,
    /// Since the last evidence of rotation (crossing, or a level beyond one), 1/65 536 tick, saturating.
    fresh: u32,
    /// Place of the last accepted crossing, in twelfths of a turn.
    place: u8,
    /// Expected time of a sector, 1/65 536 tick; 0 unknown.
    interval: u32,
    /// Newest first, 1/65 536 tick; 0 where there is none.
    intervals: [u32; 6],
    valid: u8,
    direction: Direction,
    /// Accepted crossings in a row without a blind or late one between, and their polarities (bit 0 falling, 1 rising).
    consistent: u8,
    polarities: u8,
    blind: u8,
    late: u8,
    /// Mean deviation of the interval from its prediction, 1/65 536 tick with 3 extra bits.
    deviation: u32,
    /// The last place was heard from the coasting motor.
    coasting: bool,
    why: Why,
    /// How far the last crossing lay behind its prediction, 65 536 a turn.
    margin: i16,
    accepted: u32,
}

impl ZeroCrossing {
    /// Time passes: call first in every tick.
    pub fn advance(&mut self) {
        self.since = self.since.saturating_add(TICK);
        self.fresh = self.fresh.saturating_add(TICK);
        self.angle = self.angle.wrapping_add(self.speed as u32);
    }

    /// So many ticks have passed in which there was nothing to [`observe`](Self::observe).
    #[inline]
    pub const fn sleep(&mut self, ticks: u32) {
        let time = ticks.saturating_mul(TICK);
        self.since = self.since.saturating_add(time);
        self.fresh = self.fresh.saturating_add(time);
        self.angle = self.angle.wrapping_add((self.speed as u32).wrapping_mul(ticks));
    }

    /// For how many ticks from now only time would pass, if nothing new is seen: until no crossing for `timeout` (1/65 536 tick) is a rotor at rest, until
    /// the one that has not come bounds the speed, and until the rotor stands where it cannot be before the crossing of `expected` is seen.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub fn calm(&self, timeout: u32, expected: Option<u8>) -> u32 {
        let until = |age: u32, end: u32| end.saturating_sub(age) / TICK;
        let bounded = if self.valid == 0 { u32::MAX } else { until(self.fresh, self.patience()) };
        let held = expected.map_or(u32::MAX, |sector| self.held(sector, self.angle));
        until(self.since, timeout.saturating_sub(1)).min(bounded).min(held)
    }

    /// For how many ticks from now a rotor at `angle` (u32 turn) has not reached the crossing of `sector`.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub fn held(&self, sector: u8, angle: u32) -> u32 {
        let left = (crossing_of(sector).wrapping_sub(angle) as i32).wrapping_mul(self.direction.sign());
        (left.max(0) as u32).checked_div(self.speed.unsigned_abs()).unwrap_or(u32::MAX)
    }

    /// Nothing is known but, perhaps, where the rotor rests.
    pub fn start(&mut self, angle: u32, direction: Direction) {
        let accepted = self.accepted;
        *self = Self { angle, direction, since: u32::MAX, fresh: u32::MAX, accepted, ..Self::default() };
    }

    /// What a driven step showed. `starting`: the rotor is being brought to speed, and a level that stands beyond the crossing
    /// means that it is ahead, so that the step is over; nothing is commutated by prediction yet. False if the crossing was too early to
    /// be one.
    pub fn observe(&mut self, sight: &Sight, back_emf: Gain, starting: bool) -> bool {
        if sight.missed && self.valid > 0 {
            self.blind = self.blind.saturating_add(1);
            self.consistent = 0;
            self.why = Why::Blind;
        }
        let Some(sector) = sight.sector else { return true };
        self.coasting = false;
        let place = 2 * ((sector + 1) % 6);
        if let Some(age) = sight.crossing {
            let offset = self.threshold_angle(sight.threshold, back_emf);
            if starting && self.valid == 0 && self.since == u32::MAX {
                // The first sign of motion: how fast is not known, and the next step pulls as well.
                self.take_late(place, true);
            } else if self.plausible(place, age) {
                self.accept(place, offset, age, Why::Accepted);
                if starting && self.consistent < 3 {
                    // The interval may hold a rest: on to the next step, which pulls as well, until two have been measured.
                    self.skip_to_end(place);
                }
                self.polarities |= 1 << (sector & 1);
            } else {
                self.why = Why::Filtered;
                return false;
            }
        } else if sight.late {
            self.take_late(place, starting);
        } else if sight.level == Level::Before || (starting && !sight.passed) {
            self.hold(place, starting);
        }
        true
    }

    /// The ordinary crossing of a running motor, in the sector after the last one's, `ticks` after the last that was told: true. Else nothing is done.
    #[inline]
    pub fn crosses(&mut self, crossing: &Crossing, back_emf: Gain, ticks: u32) -> bool {
        let sector = crossing.sector;
        let place = if sector >= 5 { 0 } else { 2 * sector + 2 };
        let next = match self.direction {
            Direction::Forward => (self.place, place),
            Direction::Reverse => (place, self.place),
        };
        let follows = next.0 + 2 == next.1 || (next.0, next.1) == (10, 0);
        let since = self.since.saturating_add(ticks.saturating_mul(TICK));
        let each = elapsed(since, crossing.age);
        let plausible = each >= 2 * (self.interval / 4) && each <= LONGEST && since <= LONGEST;
        if !follows || !plausible || self.valid < 6 || self.consistent < PREPARED {
            return false;
        }
        self.sleep(ticks);
        self.coasting = false;
        let offset = self.threshold_angle(crossing.threshold, back_emf);
        let (here, error) = self.miss(place, offset, crossing.age);
        self.learn(each, 1);
        self.predict_by(6);
        self.correct(place, (here, error), crossing.age, true);
        self.why = Why::Accepted;
        self.polarities |= 1 << (sector & 1);
        true
    }

    /// The bridge went off: fewer places show from now on, and the first takes a moment to be heard.
    pub fn begin_coasting(&mut self) {
        if !self.coasting {
            (self.coasting, self.fresh) = (true, 0);
        }
    }

    /// A crossing of two terminals of the coasting motor at `place` (twelfths of a turn, 0..=11), `age` ago, while it turns in
    /// `direction`.
    pub fn observe_coasting(&mut self, place: u8, age: i32, direction: Direction) {
        if direction != self.direction {
            let angle = self.angle;
            self.start(angle, direction);
        }
        self.polarities = 3;
        self.coasting = true;
        self.accept(place % 12, 0, age, Why::Listened);
    }

    /// Earlier than half the expected interval is no crossing.
    fn plausible(&self, place: u8, age: i32) -> bool {
        let twelfths = u32::from(self.twelfths_to(place));
        let least = (self.interval / 4).saturating_mul(twelfths);
        self.valid < 2 || self.consistent < 2 || (twelfths > 0 && elapsed(self.since, age) >= least)
    }

    /// Twelfths from the last crossing to `place` in the direction of motion, 0..=11.
    fn twelfths_to(&self, place: u8) -> u8 {
        match self.direction {
            Direction::Forward => (place + 12 - self.place) % 12,
            Direction::Reverse => (self.place + 12 - place) % 12,
        }
    }

    /// How far beyond the true crossing the threshold lay, in the direction of motion, u32 turn. With E the line-to-line back-EMF the
    /// signal's slope at its crossing is 1.85 E a radian, 11.6 E a turn, for both shapes within 3 %.
    fn threshold_angle(&self, threshold: i32, back_emf: Gain) -> i32 {
        if threshold == 0 || self.speed_mean == 0 {
            return 0;
        }
        // 11.6 = 2969 / 256. At most 10 degrees.
        let volts = back_emf.apply32(self.speed_mean.saturating_abs()).max(1) as u32;
        let slope = (volts >> 4).saturating_mul(2969) >> 4;
        let share = (threshold.unsigned_abs().min(0xFFFF) << 15) / slope.max(1);
        let turn = (share.min(910) << 17) as i32;
        if threshold < 0 { -turn } else { turn }
    }

    /// The rotor was `offset` beyond `place` (in the direction of motion) `age` ago.
    fn accept(&mut self, place: u8, offset: i32, age: i32, why: Why) {
        let twelfths = self.twelfths_to(place);
        let known = self.since < u32::MAX / 2 && twelfths > 0;
        let each = elapsed(self.since, age).saturating_mul(2) / u32::from(twelfths.max(1));
        let miss = self.miss(place, offset, age);
        if known {
            self.learn(each, (twelfths / 2).clamp(1, 2));
        }
        let prepared = self.consistent >= PREPARED;
        self.predict_by(self.valid);
        self.correct(place, miss, age, prepared);
        self.why = why;
    }

    /// Where the rotor was `age` ago, and how far that is from where it was thought to be, u32 turn: the margin.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn miss(&mut self, place: u8, offset: i32, age: i32) -> (u32, i32) {
        let sign = self.direction.sign();
        let here = TWELFTH.wrapping_mul(place.into()).wrapping_add((offset.wrapping_mul(sign)) as u32);
        let error = here.wrapping_sub(self.angle.wrapping_sub(part_of(self.speed, age))) as i32;
        self.margin = ((error.wrapping_mul(-sign)) >> 16) as i16;
        (here, error)
    }

    /// So many intervals took this time `each`.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn learn(&mut self, each: u32, intervals: u8) {
        let off = each.abs_diff(self.interval);
        if self.consistent < PREPARED {
            self.deviation = 0;
        } else {
            self.deviation = self.deviation - (self.deviation >> 3) + off.min(self.interval);
        }
        for _ in 0..intervals {
            self.push(each.clamp(1, LONGEST));
        }
    }

    /// The rotor was `here` `age` ago: half of a small `error` of a `prepared` estimate is believed, else all of it.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn correct(&mut self, place: u8, (here, error): (u32, i32), age: i32, prepared: bool) {
        let smooth = prepared && (error.saturating_abs() as u32) < SIXTH / 4;
        let corrected = if smooth { here.wrapping_sub((error / 2) as u32) } else { here };
        self.angle = corrected.wrapping_add(part_of(self.speed, age));
        (self.since, self.fresh, self.place) = (age.max(0) as u32, age.max(0) as u32, place);
        self.consistent = self.consistent.saturating_add(1);
        (self.blind, self.late) = (0, 0);
        self.accepted = self.accepted.wrapping_add(1);
    }

    fn push(&mut self, interval: u32) {
        let [a, b, c, d, e, _] = self.intervals;
        self.intervals = [interval, a, b, c, d, e];
        self.valid = (self.valid + 1).min(6);
    }

    /// Speed over a pair of intervals, in which rising and falling delays cancel, carried on with the trend from the pair before: the
    /// newest pair's middle lies one interval back, the one before three, the middle of the next interval half of one ahead.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn predict_by(&mut self, valid: u8) {
        let [a, b, c, d, e, f] = self.intervals;
        if valid == 0 {
            return;
        }
        let (new, old) = (a + b, c + d);
        let mean = speed_of(valid, new + old + e + f);
        let fast = speed_of(2, new);
        // A revolution back is too far while the speed changes by more than an eighth within it.
        let changes = valid > 2 && mean.abs_diff(fast) > mean.unsigned_abs() / 8;
        let (speed, interval) = match valid {
            1 => (mean, a),
            2 | 3 => (fast, new / 2),
            _ => {
                let trend = (fast - speed_of(2, old)) / 4 * 3;
                let bound = fast / 4;
                let speed = fast + trend.min(bound).max(-bound);
                let shrink = (new as i32).wrapping_sub(old as i32) / 8 * 3;
                let bound = (new / 8) as i32;
                (speed, (new / 2).saturating_add_signed(shrink.min(bound).max(-bound)))
            }
        };
        let mean = if changes { fast } else { mean };
        let sign = self.direction.sign();
        (self.speed, self.speed_mean, self.interval) = (speed * sign, mean * sign, interval.max(1));
    }

    /// The crossing came no later than now. A rotor that is being started may be anywhere beyond it: on to the next step.
    fn take_late(&mut self, place: u8, starting: bool) {
        self.late = self.late.saturating_add(1);
        self.consistent = 0;
        self.why = Why::DemagLate;
        let sign = self.direction.sign();
        if starting {
            self.skip_to_end(place);
            // It is faster than was thought, and by how much the next crossing tells.
            if self.interval > 0 {
                self.interval = (self.interval / 4 * 3).max(4 * TICK);
                self.speed = speed_of(1, self.interval) * sign;
            }
            (self.since, self.place, self.valid) = (0, place, 0);
            self.intervals = [0; 6];
        } else if self.valid > 0 {
            // Behind the rotor: half way to the commutation, and a little faster, until the crossing shows again.
            self.bring_to(place, TWELFTH / 2);
            self.interval = (self.interval - self.interval / 8).max(TICK);
            self.speed = speed_of(1, self.interval) * sign;
        }
        self.fresh = 0;
    }

    /// On to the next step.
    fn skip_to_end(&mut self, place: u8) {
        self.bring_to(place, TWELFTH + SIXTH / 64);
    }

    /// At least `beyond` after `place`.
    fn bring_to(&mut self, place: u8, beyond: u32) {
        let sign = self.direction.sign();
        let least = TWELFTH.wrapping_mul(place.into()).wrapping_add((beyond as i32 * sign) as u32);
        if (least.wrapping_sub(self.angle) as i32).wrapping_mul(sign) > 0 {
            self.angle = least;
        }
    }

    /// The rotor has certainly not reached `place`: no commutation by prediction yet, for two and a half intervals at most.
    fn hold(&mut self, place: u8, starting: bool) {
        let sign = self.direction.sign();
        let here = TWELFTH.wrapping_mul(place.into());
        let ahead = (self.angle.wrapping_sub(here) as i32).wrapping_mul(sign);
        let patience = self.interval.saturating_mul(5) / 2;
        if (0..(SIXTH as i32)).contains(&ahead) && (self.since < patience || starting) {
            self.angle = here;
        }
    }

    /// On to the next step without any evidence.
    pub fn force_step(&mut self) {
        let step = SIXTH as i32 * self.direction.sign();
        self.angle = self.angle.wrapping_add(step as u32);
    }

    /// Angle at this tick's boundary, u32 turn.
    pub const fn angle(&self) -> u32 {
        self.angle
    }

    /// Speed that interpolates, 2^-32 turn a tick, signed.
    pub const fn speed(&self) -> i32 {
        self.speed
    }

    /// Speed over up to a revolution, but never more than the crossing that has not come allows.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub fn speed_bounded(&self) -> i32 {
        if self.valid == 0 || self.fresh <= self.patience() {
            return self.speed_mean;
        }
        let bound = speed_of(self.sixths(), self.fresh);
        self.speed_mean.min(bound).max(-bound)
    }

    /// Until the last evidence is this old no bound has to be looked for, 1/65 536 tick.
    fn patience(&self) -> u32 {
        self.interval.saturating_mul(self.sixths().into()).saturating_add(self.interval / 4)
    }

    /// A coasting motor shows three places a revolution, a driven one six; one that has just been caught has its first crossing before it.
    const fn sixths(&self) -> u8 {
        if self.coasting || matches!(self.why, Why::Listened) { 3 } else { 1 }
    }

    /// Expected time of a sector, 1/65 536 tick; 0 unknown.
    pub const fn expected(&self) -> u32 {
        self.interval
    }

    /// Since the last accepted crossing, 1/65 536 tick.
    pub const fn since(&self) -> u32 {
        self.since
    }

    /// Which way it turns.
    pub const fn direction(&self) -> Direction {
        self.direction
    }

    /// At least [`PREPARED`] consistent crossings of both polarities.
    pub const fn is_prepared(&self) -> bool {
        self.consistent >= PREPARED && self.polarities == 3
    }

    /// The budget of blind or late steps is spent.
    pub const fn is_lost(&self) -> bool {
        self.blind > BLIND_MAX || self.late > LATE_MAX
    }

    /// How far the voltage fades for missed crossings, in 1/16.
    pub fn fade(&self) -> u8 {
        (self.blind.saturating_mul(2)).max(self.late / 2).min(14)
    }

    /// Neighbouring intervals differ by more than half: with a and b in turn the mean deviation from (a + b) / 2 is
    /// (a - b) / 2, which is a quarter of that mean at a = 1.67 b. A first-order mean over 8 intervals.
    pub const fn is_irregular(&self) -> bool {
        self.valid == 6 && self.deviation >> 3 > self.interval / 4
    }

    /// What became of the last crossing, how far it lay behind its prediction (65 536 a turn), and how many were accepted.
    pub const fn why(&self) -> (Why, i16, u32) {
        (self.why, self.margin, self.accepted)
    }
}

/// Angle of the crossing in `sector`, u32 turn: its middle.
fn crossing_of(sector: u8) -> u32 {
    TWELFTH.wrapping_mul(2 * u32::from(sector) + 2)
}

/// `since - age`, 1/65 536 tick.
fn elapsed(since: u32, age: i32) -> u32 {
    if age < 0 { since.saturating_add(age.unsigned_abs()) } else { since.saturating_sub(age.unsigned_abs()) }
}
