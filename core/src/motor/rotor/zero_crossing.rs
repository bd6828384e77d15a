//! From zero crossings to angle and speed: interpolation, prediction with trend, plausibility, missed and
//! late crossings.
//!
//! Crossings lie at 60 + 60 s degrees, the middle of sector s. Between them the angle runs on with the
//! predicted speed, and the commutator finds its instants from it: crossing + 30 degrees - advance. A
//! crossing that does not come is thereby commutated blind half an interval after it was due. What a level
//! says for certain ("the rotor is not there yet") bounds the angle.

use crate::motor::clock::Instant;
use crate::motor::commutate::commutation::Direction;
use crate::motor::gain::Gain;
use crate::motor::interval::{SIXTH, TICK, TWELFTH, part_of, speed_of};
use serde::{Deserialize, Serialize};

/// Blind steps in a row that the duty fades over; then the rotor is lost.
pub const BLIND_MAX: u8 = 6;
/// Late crossings in a row that do the same.
pub const LATE_MAX: u8 = 24;
/// Consistent crossings, of both polarities, that make a hand-over (one electrical revolution).
pub const PREPARED: u8 = 6;

/// Outcome of the last step's crossing: the why-channel.
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

/// Blind or late steps in a row after which the places repeat: six, less the step that ends with the
/// crossing.
const REVOLUTION: u8 = 5;
/// Six of them fit 32 bits: 0.4 s at 10 kHz, longer than any crossing time-out.
const LONGEST: u32 = 1 << 28;

/// State of the estimator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ZeroCrossing {
    /// The boundary at which `angle`, `since` and `fresh` hold.
    at: Instant,
    /// u32 turn.
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
    /// Accepted crossings in a row without a blind or late one between, and their polarities (bit 0 falling,
    /// 1 rising).
    consistent: u8,
    polarities: u8,
    blind: u8,
    late: u8,
    /// Mean deviation of the interval from its prediction, 1/65 536 tick with 3 extra bits.
    deviation: u32,
    /// The last place was observed on the coasting motor.
    coasting: bool,
    why: Why,
    /// Distance of the last crossing behind its prediction, 65 536 a turn.
    margin: i16,
    accepted: u32,
}

impl ZeroCrossing {
    /// Brings angle and ages to the boundary `now`.
    #[inline]
    pub fn pass(&mut self, now: Instant) {
        let time = now.time_since(self.at);
        self.since = self.since.saturating_add(time);
        self.fresh = self.fresh.saturating_add(time);
        self.angle = self.angle(now);
        self.at = now;
    }

    /// Goes on from `now`; ages and angle stay, because nothing was observed meanwhile.
    pub const fn skip(&mut self, now: Instant) {
        self.at = now;
    }

    /// The tick in which no crossing for `timeout` (1/65 536 tick) is a rotor at rest.
    #[inline]
    pub const fn silent_at(&self, timeout: u32) -> Instant {
        self.at.after(timeout.saturating_sub(self.since).div_ceil(TICK))
    }

    /// The tick in which the rotor is thought to have reached the crossing of `sector`: it is held there if
    /// it has not.
    #[inline]
    pub fn overdue_at(&self, sector: u8) -> Instant {
        self.reaches(TWELFTH.wrapping_mul(place_of(sector).into()))
    }

    /// The tick in which the rotor is thought to be `beyond` (u32 turn) after its last crossing.
    pub fn passes(&self, beyond: i32) -> Instant {
        let place = TWELFTH.wrapping_mul(self.place.into());
        self.reaches(place.wrapping_add(beyond.wrapping_mul(self.direction.sign()) as u32))
    }

    /// The first tick in which the rotor is thought to be at `angle` (u32 turn) or beyond.
    #[inline]
    fn reaches(&self, angle: u32) -> Instant {
        let left = (angle.wrapping_sub(self.angle) as i32).wrapping_mul(self.direction.sign()).max(0) as u32;
        let speed = self.speed.unsigned_abs();
        self.at.after(left.saturating_add(speed.saturating_sub(1)).checked_div(speed).unwrap_or(u32::MAX))
    }

    /// Nothing is known but, perhaps, where the rotor rests.
    pub fn start(&mut self, now: Instant, angle: u32, direction: Direction) {
        let accepted = self.accepted;
        *self =
            Self { at: now, angle, direction, since: u32::MAX, fresh: u32::MAX, accepted, ..Self::default() };
    }

    /// The pattern has changed, and the step before had shown nothing of its crossing.
    pub fn step_blind(&mut self, now: Instant) {
        self.pass(now);
        self.coasting = false;
        if self.valid > 0 {
            self.blind = self.blind.saturating_add(1);
            self.consistent = 0;
            self.why = Why::Blind;
        }
    }

    /// A driven step has shown the crossing of `sector`, `age` (1/65 536 tick) before `now`, where the signal
    /// stood at `threshold` (raw I16F16 V). `starting`: the rotor is being brought to speed. False if the
    /// crossing was too early to be one.
    #[inline]
    pub fn cross(
        &mut self,
        now: Instant,
        sector: u8,
        (age, threshold): (i32, i32),
        back_emf: Gain,
        starting: bool,
    ) -> bool {
        self.pass(now);
        self.coasting = false;
        let place = place_of(sector);
        if starting && self.valid == 0 && self.since == u32::MAX {
            // The first sign of motion: how fast is not known, and the next step pulls as well.
            self.take_late(place, true);
            return true;
        }
        if !self.plausible(place, age) {
            self.why = Why::Filtered;
            return false;
        }
        // A crossing that is still to come counts as of now.
        let age = age.saturating_add(self.lateness(threshold, back_emf)).max(age.min(0));
        self.accept(place, age, Why::Accepted);
        if starting && self.consistent < 3 {
            // The interval may hold a rest: on to the next step, which pulls as well, until two have been
            // measured.
            self.skip_to_end(place);
        }
        self.polarities |= 1 << (sector & 1);
        true
    }

    /// A driven step has shown that the rotor is beyond the crossing of `sector`. A rotor that is `starting`
    /// is ahead then, so that the step is over; nothing is commutated by prediction yet.
    #[inline(never)]
    pub fn cross_late(&mut self, now: Instant, sector: u8, starting: bool) {
        self.pass(now);
        self.coasting = false;
        self.take_late(place_of(sector), starting);
    }

    /// A driven step shows that the rotor has not reached the crossing of `sector`. True if the angle is held
    /// back.
    #[inline]
    pub fn wait(&mut self, now: Instant, sector: u8, starting: bool) -> bool {
        self.pass(now);
        self.coasting = false;
        let angle = self.angle;
        self.hold(place_of(sector), starting);
        self.angle != angle
    }

    /// The bridge went off: fewer places show from now on, and the first takes a moment to appear.
    pub fn begin_coasting(&mut self, now: Instant) {
        if !self.coasting {
            self.pass(now);
            (self.coasting, self.fresh) = (true, 0);
        }
    }

    /// Until `now` no place could be seen, so that none was seen says nothing about the speed.
    pub fn see_nothing(&mut self, now: Instant) {
        self.pass(now);
        self.fresh = 0;
    }

    /// A crossing of two terminals of the coasting motor at `place` (twelfths of a turn, 0..=11), `age` ago,
    /// while it turns in `direction`.
    pub fn observe_coasting(&mut self, now: Instant, place: u8, age: i32, direction: Direction) {
        self.pass(now);
        if direction != self.direction {
            self.start(now, self.angle, direction);
        }
        self.polarities = 3;
        self.coasting = true;
        self.accept(place % 12, age, Why::Listened);
    }

    /// Earlier than half the expected interval is no crossing.
    fn plausible(&self, place: u8, age: i32) -> bool {
        let twelfths = u32::from(self.twelfths_to(place));
        let least = (self.interval / 4).saturating_mul(twelfths);
        self.valid < 2 || self.consistent < 2 || (twelfths > 0 && elapsed(self.since, age) >= least)
    }

    /// Twelfths from the last crossing to `place` in the direction of motion, 0..=11.
    fn twelfths_to(&self, place: u8) -> u8 {
        let (from, to) = match self.direction {
            Direction::Forward => (self.place, place),
            Direction::Reverse => (place, self.place),
        };
        if to >= from { to - from } else { to + 12 - from }
    }

    /// Time from the true crossing to the instant at which the signal stood at `threshold`, 1/65 536 tick; 0
    /// while the speed, or the back-EMF constant, is not known. With E the line-to-line back-EMF the signal's
    /// slope at its crossing is 1.85 E a radian, 11.6 E a turn, for both shapes within 3 %.
    fn lateness(&self, threshold: i32, back_emf: Gain) -> i32 {
        if threshold == 0 || back_emf == Gain::ZERO || !self.is_prepared() {
            return 0;
        }
        // 11.6 = 2969 / 256. At most 10 degrees.
        let volts = back_emf.apply32(self.speed_mean.saturating_abs()).max(1) as u32;
        let slope = (volts >> 4).saturating_mul(2969) >> 4;
        let share = ((threshold.unsigned_abs().min(0xFFFF) << 15) / slope.max(1)).min(910);
        // 32 768 are a turn, which has six intervals.
        let time = ((self.interval >> 8).saturating_mul(6 * share) >> 7) as i32;
        if threshold < 0 { -time } else { time }
    }

    /// The rotor was at `place` `age` ago.
    fn accept(&mut self, place: u8, age: i32, why: Why) {
        let mut twelfths = self.twelfths_to(place);
        // The same place again, more than half a revolution (three sectors) later, is a whole revolution:
        // with a phase open the coasting motor shows no other place.
        if twelfths == 0 && why == Why::Listened && self.since > self.interval.saturating_mul(3) {
            twelfths = 12;
        }
        // After a revolution without a crossing that was seen the places no longer tell how far it has
        // turned.
        if self.hidden() || self.blind.saturating_add(self.late) >= REVOLUTION {
            (self.intervals, self.valid, self.speed_mean) = ([0; 6], 0, self.speed);
            self.since = u32::MAX;
        }
        let known = self.since < u32::MAX / 2 && twelfths > 0;
        let each = elapsed(self.since, age).saturating_mul(2) / u32::from(twelfths.max(1));
        let miss = self.miss(place, age);
        if known {
            self.learn(each, (twelfths / 2).clamp(1, 2));
        }
        let prepared = self.consistent >= PREPARED;
        self.predict_by(self.valid);
        self.correct(place, miss, age, prepared);
        self.why = why;
    }

    /// This is the first place since the bridge went off, and until then the windings' current has hidden a
    /// revolution.
    fn hidden(&self) -> bool {
        let revolution = self.interval.saturating_mul(REVOLUTION.into());
        let first = self.coasting && self.why != Why::Listened;
        first && revolution > 0 && self.since >= revolution
    }

    /// Returns the rotor's angle `age` ago, and its distance from the estimated angle, u32 turn. Stores that
    /// distance as the margin.
    #[inline]
    fn miss(&mut self, place: u8, age: i32) -> (u32, i32) {
        let sign = self.direction.sign();
        let here = TWELFTH.wrapping_mul(place.into());
        let error = here.wrapping_sub(self.angle.wrapping_sub(part_of(self.speed, age))) as i32;
        self.margin = ((error.wrapping_mul(-sign)) >> 16) as i16;
        (here, error)
    }

    /// Takes `intervals` new intervals of the time `each`.
    #[inline]
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

    /// The rotor was `here` `age` ago: half of a small `error` of a `prepared` estimate is believed, else all
    /// of it.
    #[inline]
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

    /// Speed over a pair of intervals, in which rising and falling delays cancel, carried on with the trend
    /// from the pair before: the newest pair's middle lies one interval back, the one before three, the
    /// middle of the next interval half of one ahead: 1.5 intervals on, by a change over 2, which is 3/4 of
    /// it.
    #[inline]
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

    /// The crossing came no later than now. A rotor that is being started may be anywhere beyond it: on to
    /// the next step.
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
            // Behind the rotor: half way to the commutation, and a little faster, until the crossing shows
            // again.
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

    /// The rotor has certainly not reached `place`: no commutation by prediction yet, for two and a half
    /// intervals at most.
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

    /// Angle at the boundary `now`, u32 turn.
    #[inline]
    pub const fn angle(&self, now: Instant) -> u32 {
        self.angle.wrapping_add((self.speed as u32).wrapping_mul(now.since(self.at)))
    }

    /// Speed that interpolates, 2^-32 turn a tick, signed.
    pub const fn speed(&self) -> i32 {
        self.speed
    }

    /// Speed over up to a revolution, 2^-32 turn a tick, signed.
    #[inline]
    pub const fn speed_mean(&self) -> i32 {
        self.speed_mean
    }

    /// Speed over up to a revolution, but never more than the crossing that has not come by `now` allows.
    #[inline]
    pub fn speed_bounded(&self, now: Instant) -> i32 {
        let fresh = self.fresh.saturating_add(now.time_since(self.at));
        if self.valid == 0 || fresh <= self.patience() {
            return self.speed_mean;
        }
        let bound = speed_of(self.sixths(), fresh);
        self.speed_mean.min(bound).max(-bound)
    }

    /// Until the last evidence is this old no bound has to be looked for, 1/65 536 tick.
    fn patience(&self) -> u32 {
        self.interval.saturating_mul(self.sixths().into()).saturating_add(self.interval / 4)
    }

    /// A coasting motor shows three places a revolution, a driven one six; one that has just been caught has
    /// its first crossing before it.
    const fn sixths(&self) -> u8 {
        if self.coasting || matches!(self.why, Why::Listened) { 3 } else { 1 }
    }

    /// Expected time of a sector, 1/65 536 tick; 0 unknown.
    pub const fn expected(&self) -> u32 {
        self.interval
    }

    /// Time from the last accepted crossing to the boundary `now`, 1/65 536 tick.
    #[inline]
    pub const fn since(&self, now: Instant) -> u32 {
        self.since.saturating_add(now.time_since(self.at))
    }

    /// Which way it turns.
    pub const fn direction(&self) -> Direction {
        self.direction
    }

    /// At least [`PREPARED`] consistent crossings of both polarities.
    pub const fn is_prepared(&self) -> bool {
        self.consistent >= PREPARED && self.polarities == 3
    }

    /// The crossings of a revolution are known, and no more than two steps since were blind or late.
    pub const fn is_established(&self) -> bool {
        self.valid >= PREPARED && self.polarities == 3 && self.blind + self.late <= 2
    }

    /// The budget of blind or late steps is spent.
    pub const fn is_lost(&self) -> bool {
        self.blind > BLIND_MAX || self.late > LATE_MAX
    }

    /// Fading of the voltage for missed crossings, in 1/16.
    pub fn fade(&self) -> u8 {
        (self.blind.saturating_mul(2)).max(self.late / 2).min(14)
    }

    /// Neighbouring intervals differ by more than half: with a and b in turn the mean deviation from (a + b)
    /// / 2 is (a - b) / 2, which is a quarter of that mean at a = 1.67 b. A first-order mean over 8
    /// intervals.
    pub const fn is_irregular(&self) -> bool {
        self.valid == 6 && self.deviation >> 3 > self.interval / 4
    }

    /// Outcome of the last crossing, its distance behind the prediction (65 536 a turn), and the number of
    /// accepted ones.
    pub const fn why(&self) -> (Why, i16, u32) {
        (self.why, self.margin, self.accepted)
    }
}

/// Place of the crossing in `sector`, its middle, in twelfths of a turn.
const fn place_of(sector: u8) -> u8 {
    if sector >= 5 { 0 } else { 2 * sector + 2 }
}

/// `since - age`, 1/65 536 tick.
fn elapsed(since: u32, age: i32) -> u32 {
    if age < 0 { since.saturating_add(age.unsigned_abs()) } else { since.saturating_sub(age.unsigned_abs()) }
}
