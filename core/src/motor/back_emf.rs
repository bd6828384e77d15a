//! Back-EMF of the floating phase: what one sample, or one comparator edge, says of the rotor.
//!
//! The floating terminal is compared with the mean of the other two, which is the same point as the mean of all three. In the
//! on-time the other two are at bus and ground, so the reference is half of the bus as it is now; in the off-time both are
//! at ground; with the bridge off it is the neutral. The signal is twice the floating terminal less the other two, signed so that it
//! rises through 0 at the crossing:
//!
//! ```text
//!  x        hidden    Before        After
//!           |blank |            _____/
//!   0 ......|......|......_____/...........   crossing: the middle of the sector
//!           |     _|_____/
//!        commutation                     commutation
//! ```
//!
//! In the off-time a terminal below ground reads 0 (diode and converter end there): the threshold then lies a little above 0 and
//! the crossing is found where the flank, whose slope is known from the back-EMF constant, came from.

use super::commutation::{Direction, Leg, Step};
use super::gain::Gain;
use super::interval::{TICK, fraction};
use super::measurement::Measured;
use super::pwm::PwmCommand;
use super::samples::{EdgeSource, SampleMode, Samples};
use crate::units::Volts;
use serde::{Deserialize, Serialize};

/// Coefficients of the back-EMF station.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BackEmfCoefficients {
    /// Smallest level of one sample that is told from noise, raw I16F16 V.
    pub noise: i32,
    /// Least blanking after a commutation, 1/65 536 tick (parameter 86).
    pub discard: u32,
    /// First instant of a period at which a pattern changes, 1/65 536.
    pub earliest: u16,
    /// Back-EMF comparators with capture take the converter's place.
    pub comparator: bool,
    /// Delay of a rising crossing, 1/65 536 tick (parameter 100).
    pub delay_rising: i32,
    /// Delay of a falling crossing, 1/65 536 tick (parameters 100 and 286).
    pub delay_falling: i32,
    /// Volts of back-EMF per electrical rev/s (parameter 267), 0 unknown.
    pub back_emf: Gain,
}

/// What the last sample of this step showed, if it is certain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Level {
    /// Nothing: blanked, no phase floats, or too near to tell.
    #[default]
    Hidden,
    /// The rotor has not reached the middle of the sector.
    Before,
    /// It is beyond.
    After,
}

/// What one tick saw.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sight {
    /// The rotor sector whose crossing is watched; `None` when no single phase floats.
    pub sector: Option<u8>,
    /// Certain level.
    pub level: Level,
    /// A healthy crossing, this long before the present boundary (1/65 536 tick, negative is after it).
    pub crossing: Option<i32>,
    /// The signal's value at that crossing, signed as it rises, raw I16F16 V: off-time thresholds are not at 0.
    pub threshold: i32,
    /// The level beyond the crossing stands since the blanking ended: the crossing came earlier than it could be seen.
    pub late: bool,
    /// This step has shown either.
    pub passed: bool,
    /// The pattern changed since the last tick, and the step before had shown neither.
    pub missed: bool,
}

/// What is told from noise, times this, is a rotor on its way.
const FIRST_SIGN: i32 = 4;
/// Samples that the mean reaches back at most.
const WINDOW: usize = 8;

/// State of the station.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BackEmf {
    step: Step,
    /// It followed another step, so that its crossing is still to come.
    whole: bool,
    /// Age of the pattern at the present boundary, 1/65 536 tick.
    age: u32,
    window: [i32; WINDOW],
    sum: i32,
    /// Samples since the blanking, saturating at 255, and what the mean takes of them: 2^shift.
    count: u8,
    shift: u8,
    /// Mean of the tick before, and the age of that sample.
    previous: i32,
    previous_age: i32,
    /// The level before the crossing was seen: what follows is a crossing and no demagnetisation.
    healthy: bool,
    /// The signal has passed its threshold this long ago, and not yet gone far enough to be believed.
    crossed: Option<i32>,
    found: bool,
    after_run: u8,
    /// Comparator outputs as last captured.
    code: u8,
}

impl BackEmf {
    /// One tick. `interval` is the expected time of a sector, 1/65 536 tick; 0 unknown. `emf` is the line-to-line back-EMF at that
    /// speed, raw I16F16 V; 0 unknown.
    #[allow(clippy::too_many_arguments, reason = "one station, called from one place")]
    pub fn step(
        &mut self,
        c: &BackEmfCoefficients,
        samples: &Samples,
        measured: &Measured,
        applied: &PwmCommand,
        torque: Direction,
        interval: u32,
        emf: i32,
    ) -> Sight {
        let earlier = self.edges_before_change(c, samples, applied, torque, interval);
        let missed = self.follow(c, applied, interval);
        let mut sight = Sight { missed, ..Sight::default() };
        let Some((sector, phase)) = floating(self.step, torque) else { return earlier.unwrap_or(sight) };
        sight.sector = Some(sector);
        let rising = sector & 1 == 1;
        let blank = blanking(c, interval);
        if c.comparator {
            self.edges(samples, phase, rising, blank, &mut sight);
            // At rest a comparator's output says nothing.
            sight.late &= interval > 0;
        } else if self.age.saturating_add(applied.sample_at.into()) >= blank {
            if self.demagnetises(c, samples, measured, phase, rising, interval) {
                (self.count, self.sum) = (0, 0);
            } else {
                self.sample(
                    c,
                    samples,
                    measured,
                    phase,
                    rising,
                    applied.sample_at,
                    (interval, emf),
                    &mut sight,
                );
            }
        }
        let delay = if rising { c.delay_rising } else { c.delay_falling };
        sight.crossing = sight.crossing.map(|age| age.saturating_add(delay));
        self.found |= sight.crossing.is_some() || sight.late;
        sight.passed = self.found;
        earlier.unwrap_or(sight)
    }

    /// The crossing was too early to be one: it is looked for again.
    pub fn reject(&mut self) {
        (self.healthy, self.found, self.after_run, self.crossed) = (false, false, 0, None);
    }

    /// Ages the pattern by the period that has ended and takes over its changes. True if a step ended unseen.
    fn follow(&mut self, c: &BackEmfCoefficients, applied: &PwmCommand, interval: u32) -> bool {
        self.age = self.age.saturating_add(TICK);
        self.previous_age = self.previous_age.saturating_add(TICK as i32);
        self.crossed = self.crossed.map(|age| age.saturating_add(TICK as i32));
        let first = (applied.step, c.earliest);
        let later = applied.commutations.iter().map(|change| (change.step, change.instant));
        let mut missed = false;
        for (step, instant) in core::iter::once(first).chain(later) {
            if step == self.step {
                continue;
            }
            missed |= !self.found && self.whole && step.sector().is_some();
            let whole = self.step.sector().is_some();
            let code = self.code;
            *self = Self { step, whole, age: TICK - u32::from(instant), code, ..Self::default() };
            // The mean takes about an eighth of the step: one sample at 6 a step.
            self.shift = match interval >> 16 {
                0 if interval == 0 => 3,
                0..24 => 0,
                24..48 => 1,
                48..96 => 2,
                _ => 3,
            };
        }
        missed
    }

    #[allow(clippy::too_many_arguments, reason = "one station, called from one place")]
    fn sample(
        &mut self,
        c: &BackEmfCoefficients,
        samples: &Samples,
        measured: &Measured,
        phase: usize,
        rising: bool,
        sample_at: u16,
        (interval, emf): (u32, i32),
        sight: &mut Sight,
    ) {
        let off_time = samples.sample_mode == SampleMode::OffTime;
        // A mean of 8 samples has a third of the noise.
        let noise = if self.shift == 3 { c.noise / 2 } else { c.noise };
        // The first sign of motion moves the field on, and in the next step a rotor that hardly turns yet has half the torque: it must be
        // well on its way.
        let beyond = if interval == 0 { FIRST_SIGN * noise } else { noise };
        // Off-time: at 2 noises of the unsigned signal, from either side.
        let threshold = match (off_time, rising) {
            (false, _) => 0,
            (true, true) => 2 * noise,
            (true, false) => -2 * noise,
        };
        let signal = signal(&measured.phase_voltage, phase);
        let signal = if rising { signal } else { -signal };
        // One spike must not outvote the window; but what the flank gives within it (a twelfth of the step at most, and the signal
        // spans 1.9 E in a step) must pass, or the crossing would move to the middle between two samples.
        let widest = (16 * noise).max(emf / 4);
        let mean = self.average(if self.shift == 0 { signal } else { signal.clamp(-widest, widest) });
        let now = -i32::from(sample_at);
        if mean < threshold - noise {
            self.healthy |= !self.found;
            self.after_run = 0;
            if !off_time || !rising {
                sight.level = Level::Before;
            }
        } else if mean > threshold + beyond && (!off_time || rising) {
            self.after_run = self.after_run.saturating_add(1);
            sight.level = Level::After;
        }
        if mean < threshold {
            self.crossed = None;
        } else if self.healthy && !self.found && self.count > 1 {
            let age = self.crossed.unwrap_or_else(|| {
                let span = self.previous_age.saturating_sub(now);
                let part = fraction(threshold - self.previous, mean - self.previous);
                self.previous_age - ((i64::from(span) * i64::from(part)) >> 16) as i32 + self.mean_delay()
            });
            self.crossed = Some(age);
            // As far beyond as it was before: a rotor that stops half way has not crossed.
            if mean > threshold + beyond {
                sight.crossing = self.crossed.take();
                sight.threshold = threshold;
            }
        }
        sight.late = !self.healthy && !self.found && self.after_run > 2 + (1 << self.shift) / 2;
        (self.previous, self.previous_age) = (mean, now);
    }

    /// Its winding's current still holds the floating terminal at a rail: no evidence, for a rotor that nothing is known of however long it takes.
    /// One that turns may cross behind it, and from three eighths of the step on that is a late crossing.
    fn demagnetises(
        &self,
        c: &BackEmfCoefficients,
        samples: &Samples,
        measured: &Measured,
        phase: usize,
        rising: bool,
        interval: u32,
    ) -> bool {
        if self.healthy || self.found || (interval > 0 && self.age > interval / 8 * 3) {
            return false;
        }
        let terminal = measured.phase_voltage.get(phase).map_or(0, |voltage| voltage.to_bits());
        // Current into the terminal before a rising crossing, out of it before a falling one: on the far side of the crossing.
        if rising {
            terminal > measured.bus_voltage.to_bits() - c.noise
        } else {
            samples.sample_mode == SampleMode::OnTime && terminal < c.noise
        }
    }

    /// Mean of the last samples of this step.
    fn average(&mut self, signal: i32) -> i32 {
        let place = usize::from(self.count) % WINDOW;
        let wide = 1_u8 << self.shift;
        if self.count >= wide {
            let oldest = usize::from(self.count.wrapping_sub(wide)) % WINDOW;
            self.sum -= self.window.get(oldest).copied().unwrap_or(0);
        }
        if let Some(slot) = self.window.get_mut(place) {
            *slot = signal;
        }
        self.sum += signal;
        // Wraps by whole windows, so that places stay.
        self.count = if self.count == u8::MAX { u8::MAX - WINDOW as u8 + 1 } else { self.count + 1 };
        if self.count >= wide { self.sum >> self.shift } else { self.sum / i32::from(self.count.max(1)) }
    }

    /// A mean of n samples lies (n - 1) / 2 ticks back.
    fn mean_delay(&self) -> i32 {
        let wide = i32::from(self.count.min(1 << self.shift));
        (wide - 1) * (TICK as i32 / 2)
    }

    /// A crossing of the pattern that was left within the period that has ended: with two ticks a sector a commutation can be taken
    /// at the end of the very period in which the crossing before it came.
    fn edges_before_change(
        &mut self,
        c: &BackEmfCoefficients,
        samples: &Samples,
        applied: &PwmCommand,
        torque: Direction,
        interval: u32,
    ) -> Option<Sight> {
        if !c.comparator {
            return None;
        }
        let mut changes = applied.commutations.iter().filter(|change| change.step != self.step);
        let change =
            if applied.step == self.step { changes.next().map(|change| change.instant)? } else { c.earliest };
        let (sector, phase) = floating(self.step, torque)?;
        let rising = sector & 1 == 1;
        let blank = blanking(c, interval);
        let beyond = |code: u8| ((code >> phase) & 1 == 1) == rising;
        let mut crossing = None;
        let edges = samples.edges.iter().filter(|edge| edge.source == EdgeSource::Comparator);
        for edge in edges.filter(|edge| edge.instant < change) {
            let since = self.age.saturating_add(edge.instant.into());
            let (was, is) = (beyond(self.code), beyond(edge.code));
            self.healthy |= !was && since >= blank && !self.found;
            self.code = edge.code;
            if !was && is && self.healthy && !self.found {
                let delay = if rising { c.delay_rising } else { c.delay_falling };
                crossing = Some((TICK - u32::from(edge.instant)) as i32 + delay);
                self.found = true;
            }
        }
        crossing.map(|_| Sight { sector: Some(sector), crossing, passed: true, ..Sight::default() })
    }

    /// The comparators' edges of the period that has ended.
    fn edges(&mut self, samples: &Samples, phase: usize, rising: bool, blank: u32, sight: &mut Sight) {
        let beyond = |code: u8| ((code >> phase) & 1 == 1) == rising;
        for edge in samples.edges.iter().filter(|edge| edge.source == EdgeSource::Comparator) {
            let age = TICK - u32::from(edge.instant);
            let since = self.age.saturating_sub(age);
            let (was, is) = (beyond(self.code), beyond(edge.code));
            // The level stood until here: after blanking that makes the crossing healthy.
            self.healthy |= !was && age <= self.age && since >= blank && !self.found;
            self.code = edge.code;
            if !was && is && self.healthy && !self.found && age <= self.age {
                sight.crossing = Some(age as i32);
                self.found = true;
            }
        }
        if self.age < blank {
            return;
        }
        sight.level = if beyond(self.code) { Level::After } else { Level::Before };
        self.healthy |= sight.level == Level::Before && !self.found;
        let stands = sight.level == Level::After && !self.healthy && !self.found;
        self.after_run = if stands { self.after_run.saturating_add(1) } else { 0 };
        sight.late = stands && self.after_run >= 2;
    }
}

/// Blanking = max(time floor, an eighth of the step), but a sample before the crossing must be left: at most a quarter of
/// the step.
fn blanking(c: &BackEmfCoefficients, interval: u32) -> u32 {
    if interval == 0 { c.discard } else { c.discard.max(interval / 8).min(interval / 4) }
}

/// Rotor sector and floating phase of a step with torque in `torque`.
pub fn floating(step: Step, torque: Direction) -> Option<(u8, usize)> {
    let sector = step.sector()?;
    let sector = if torque == Direction::Forward { sector } else { (sector + 3) % 6 };
    let phase = step.legs().iter().position(|leg| *leg == Leg::Floating)?;
    Some((sector, phase))
}

/// `2 v_f - v_g - v_h`, raw I16F16 V: three times the back-EMF of a sinusoidal motor, twice that of a trapezoidal one.
fn signal(voltage: &[Volts; 3], phase: usize) -> i32 {
    let [a, b, c] = voltage.map(Volts::to_bits);
    let floating = [a, b, c].get(phase).copied().unwrap_or(0);
    3 * floating - a - b - c
}
