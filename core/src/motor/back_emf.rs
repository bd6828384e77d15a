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

mod edges;
mod passing;
mod window;

use super::band::Band;
use super::commutation::{Direction, Step};
use super::gain::Gain;
use super::interval::{TICK, fraction};
use super::measurement::ChannelScale;
use super::pwm::PwmCommand;
use super::samples::{SampleMode, Samples};
use serde::{Deserialize, Serialize};
use window::{Mean, signal};

/// Coefficients of the back-EMF station.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BackEmfCoefficients {
    /// Scale of the phase terminals.
    pub terminal: ChannelScale,
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

/// Where the motor is expected to run.
#[derive(Clone, Copy, Debug, Default)]
pub struct OperatingPoint {
    /// Which way the torque acts.
    pub torque: Direction,
    /// Time of a sector, 1/65 536 tick; 0 unknown.
    pub interval: u32,
    /// Line-to-line back-EMF at that speed, raw I16F16 V; 0 unknown.
    pub emf: i32,
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

/// The ordinary crossing of a running motor.
#[derive(Clone, Copy)]
pub struct Crossing {
    /// The rotor's sector.
    pub sector: u8,
    /// Age at the present boundary, 1/65 536 tick; negative if the crossing comes after that boundary.
    pub age: i32,
    /// The signal's value at it, signed as it rises, raw I16F16 V.
    pub threshold: i32,
    /// Its age without the delays of comparators, and the mean that showed it.
    ago: i32,
    mean: Mean,
}

/// What is told from noise, times this, is a rotor on its way.
const FIRST_SIGN: i32 = 4;
/// Samples that the mean reaches back at most.
const WINDOW: usize = 8;

/// How far a step's crossing has come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
enum Passage {
    /// Neither side of it has been seen for certain.
    #[default]
    Unseen,
    /// The level before it was seen: what follows is a crossing and no demagnetisation.
    Healthy,
    /// The signal has passed its threshold, and not yet gone far enough to be believed.
    Crossing,
    /// It was seen, or was late.
    Found,
}

/// What a running step watches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Watch {
    /// The rotor's sector.
    sector: u8,
    /// The floating phase.
    phase: u8,
}

/// State of the station.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BackEmf {
    step: Step,
    /// It followed another step, so that its crossing is still to come.
    whole: bool,
    watch: Option<Watch>,
    passage: Passage,
    /// Signals, raw I16F16 V, that say nothing new as long as this step goes on and is sampled in the on-time; empty while there is more to
    /// it than one comparison. A recording is without it.
    #[serde(skip)]
    stale: Band,
    /// Samples that the mean takes: 2^shift.
    shift: u8,
    /// Samples since the blanking.
    count: u8,
    after_run: u8,
    /// Comparator outputs as last captured.
    code: u8,
    /// Where in its period the sample before was taken, 1/65 536.
    sampled_at: u16,
    /// Age of the pattern at the present boundary, and when its blanking ends, 1/65 536 tick.
    age: i32,
    blank: i32,
    /// What was expected of this step as it began: its time, 1/65 536 tick, 0 unknown; the flank that one mean may hold, and what is
    /// told from noise, raw I16F16 V.
    interval: u32,
    flank: i32,
    noise: i32,
    /// Mean of the tick before.
    previous: i32,
    /// How long ago the signal has passed its threshold, while it is not yet believed.
    crossed: i32,
    window: [i32; WINDOW],
    sum: i32,
}

impl BackEmf {
    /// How far the signal must go beyond its threshold. The first sign of motion moves the field on, and in the next step a rotor that hardly turns yet
    /// has half the torque: it must be well on its way.
    #[inline]
    const fn beyond(&self) -> i32 {
        if self.interval == 0 { FIRST_SIGN * self.noise } else { self.noise }
    }

    /// How long ago the signal passed its threshold, on its way from the last mean to this one.
    #[inline]
    fn crossed_at(&self, mean: i32, threshold: i32, sample_at: u16) -> i32 {
        let now = -i32::from(sample_at);
        let previous_age = TICK as i32 - i32::from(self.sampled_at);
        let part = fraction(threshold - self.previous, mean - self.previous);
        let span = i64::from(previous_age.saturating_sub(now));
        previous_age - ((span * i64::from(part)) >> 16) as i32 + self.mean_delay()
    }

    /// What was applied in the period that has ended begins another step.
    #[inline]
    pub fn is_changed_by(&self, applied: &PwmCommand) -> bool {
        applied.step != self.step || !applied.commutations.is_empty()
    }

    /// One tick. `bus_voltage` is raw I16F16 V as it is now, `applied` was in force in the period that has ended.
    pub fn step(
        &mut self,
        c: &BackEmfCoefficients,
        samples: &Samples,
        bus_voltage: i32,
        applied: &PwmCommand,
        point: &OperatingPoint,
    ) -> Sight {
        let earlier = if c.comparator { self.edges_before_change(c, samples, applied) } else { None };
        self.beware();
        let missed = self.follow(c, applied, point);
        let mut sight = Sight { missed, ..Sight::default() };
        let Some(watch) = self.watch else { return earlier.unwrap_or(sight) };
        sight.sector = Some(watch.sector);
        if c.comparator {
            self.edges(samples, watch, &mut sight);
            // At rest a comparator's output says nothing.
            sight.late &= point.interval > 0;
        } else if self.age.saturating_add(applied.sample_at.into()) >= self.blank {
            let unseen = self.passage == Passage::Unseen;
            if !(unseen && self.demagnetises(c, samples, bus_voltage, self.age, watch)) {
                self.sample(c, samples, applied.sample_at, watch, &mut sight);
            }
        }
        if let Some(age) = sight.crossing {
            let delay = if watch.rises() { c.delay_rising } else { c.delay_falling };
            sight.crossing = Some(age.saturating_add(delay));
        }
        if sight.crossing.is_some() || sight.late {
            self.passage = Passage::Found;
        }
        sight.passed = self.passage == Passage::Found;
        if c.comparator { earlier.unwrap_or(sight) } else { sight }
    }

    /// The crossing was too early to be one: it is looked for again.
    pub fn reject(&mut self) {
        (self.passage, self.after_run) = (Passage::Unseen, 0);
        self.beware();
    }

    /// The sector whose crossing is still to come in `present`, the step that goes on from here.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub fn expects(&self, present: Step, torque: Direction) -> Option<u8> {
        if present == self.step && self.passage == Passage::Found {
            None
        } else {
            present.rotor_sector(torque)
        }
    }

    /// Ages the pattern by the period that has ended and takes over its changes. True if a step ended unseen.
    fn follow(&mut self, c: &BackEmfCoefficients, applied: &PwmCommand, point: &OperatingPoint) -> bool {
        self.age = self.age.saturating_add(TICK as i32);
        self.crossed = self.crossed.saturating_add(TICK as i32);
        if !self.is_changed_by(applied) {
            return false;
        }
        let first = (applied.step, c.earliest);
        let later = applied.commutations.iter().map(|change| (change.step, change.instant));
        let mut missed = false;
        for (step, instant) in core::iter::once(first).chain(later) {
            if step != self.step {
                missed |= self.passage != Passage::Found && self.whole && step.sector().is_some();
                self.begin_late(c, step, instant, point);
            }
        }
        missed
    }

    /// [`begin`](Self::begin) where time matters less than room.
    #[inline(never)]
    fn begin_late(&mut self, c: &BackEmfCoefficients, step: Step, instant: u16, point: &OperatingPoint) {
        self.begin(c, step, instant, point);
    }

    /// `step` began at `instant` of the period that has ended.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn begin(&mut self, c: &BackEmfCoefficients, step: Step, instant: u16, point: &OperatingPoint) {
        let OperatingPoint { torque, interval, emf } = *point;
        // The mean takes about an eighth of the step: one sample at 6 a step.
        let shift = match interval >> 16 {
            0 if interval == 0 => 3,
            0..24 => 0,
            24..48 => 1,
            48..96 => 2,
            _ => 3,
        };
        self.whole = self.step.sector().is_some();
        (self.step, self.watch) = (step, watch(step, torque));
        (self.passage, self.stale, self.shift) = (Passage::Unseen, Band::EMPTY, shift);
        (self.age, self.blank, self.interval) =
            (TICK as i32 - i32::from(instant), blanking(c, interval), interval);
        self.flank = emf / 4;
        // A mean of 8 samples has a third of the noise.
        self.noise = if shift == 3 { c.noise / 2 } else { c.noise };
        // Nothing of the samples before counts: neither those in the window nor the last mean are looked at.
        (self.count, self.sum, self.after_run) = (0, 0, 0);
    }

    /// Off-time: at 2 noises of the unsigned signal, from either side.
    #[inline]
    fn threshold(&self, samples: &Samples, watch: Watch) -> i32 {
        match samples.sample_mode {
            SampleMode::OnTime => 0,
            SampleMode::OffTime if watch.rises() => 2 * self.noise,
            SampleMode::OffTime => -2 * self.noise,
        }
    }

    fn sample(
        &mut self,
        c: &BackEmfCoefficients,
        samples: &Samples,
        sample_at: u16,
        watch: Watch,
        sight: &mut Sight,
    ) {
        let off_time = samples.sample_mode == SampleMode::OffTime;
        let (noise, threshold) = (self.noise, self.threshold(samples, watch));
        let beyond = self.beyond();
        let sample = self.mean(signal(c, samples, watch.sector));
        let mean = sample.value;
        if mean < threshold - noise {
            if self.passage == Passage::Unseen {
                self.passage = Passage::Healthy;
            }
            self.after_run = 0;
            if !off_time || !watch.rises() {
                sight.level = Level::Before;
            }
        } else if mean > threshold + beyond && (!off_time || watch.rises()) {
            self.after_run = self.after_run.saturating_add(1);
            sight.level = Level::After;
        }
        match self.passage {
            Passage::Crossing if mean < threshold => self.passage = Passage::Healthy,
            Passage::Healthy if mean >= threshold => {
                self.crossed = self.crossed_at(mean, threshold, sample_at);
                self.passage = Passage::Crossing;
            }
            _ => {}
        }
        // As far beyond as it was before: a rotor that stops half way has not crossed.
        if self.passage == Passage::Crossing && mean > threshold + beyond {
            sight.crossing = Some(self.crossed);
            sight.threshold = threshold;
        }
        sight.late = self.passage == Passage::Unseen && self.after_run > 2 + (1 << self.shift) / 2;
        self.keep(sample, sample_at);
    }

    /// Before anything is seen of a step, its winding's current may still hold the floating terminal at a rail: no evidence, and the mean starts
    /// anew. So for a rotor that nothing is known of however long it takes; one that turns may cross behind it, and from three eighths of the
    /// step on that is a late crossing.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    fn demagnetises(
        &mut self,
        c: &BackEmfCoefficients,
        samples: &Samples,
        bus_voltage: i32,
        age: i32,
        watch: Watch,
    ) -> bool {
        let overdue = self.interval > 0 && age > (self.interval / 8 * 3) as i32;
        let held = !overdue && is_held(c, samples, bus_voltage, watch);
        if held {
            (self.count, self.sum) = (0, 0);
        }
        held
    }
}

impl Watch {
    /// Its crossing rises.
    #[inline]
    const fn rises(self) -> bool {
        self.sector & 1 == 1
    }
}

/// Blanking = max(time floor, an eighth of the step), but a sample before the crossing must be left: at most a quarter of
/// the step.
fn blanking(c: &BackEmfCoefficients, interval: u32) -> i32 {
    let blank = if interval == 0 { c.discard } else { c.discard.max(interval / 8).min(interval / 4) };
    blank.min(i32::MAX as u32) as i32
}

/// What a running step with torque in `torque` shows.
fn watch(step: Step, torque: Direction) -> Option<Watch> {
    Some(Watch { sector: step.rotor_sector(torque)?, phase: step.floating()? })
}

/// The floating terminal is at a rail: current into it before a rising crossing, out of it before a falling one, on the far side of the
/// crossing.
#[inline]
fn is_held(c: &BackEmfCoefficients, samples: &Samples, bus_voltage: i32, watch: Watch) -> bool {
    let code = samples.phase_voltage.get(usize::from(watch.phase)).copied().unwrap_or(0);
    let terminal = c.terminal.convert(code);
    if watch.rises() {
        terminal > bus_voltage - c.noise
    } else {
        samples.sample_mode == SampleMode::OnTime && terminal < c.noise
    }
}
