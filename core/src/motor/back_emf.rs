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
mod window;

use super::band::Band;
use super::clock::Instant;
use super::commutation::{Direction, Step};
use super::gain::Gain;
use super::interval::{TICK, fraction, speed_of};
use super::measurement::ChannelScale;
use super::pwm::PwmCommand;
use super::samples::{SampleMode, Samples};
use serde::{Deserialize, Serialize};
use window::signal;

/// Coefficients of the back-EMF station.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BackEmfCoefficients {
    /// Scale of the phase terminals.
    pub terminal: ChannelScale,
    /// Smallest signal of one sample that stands out of the noise, converter codes.
    pub noise: i32,
    /// Terminals below this code show no back-EMF: less than the noise.
    pub silence: u16,
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
    /// The same per 2^-32 turn a tick.
    pub emf_of_turns: Gain,
}

/// Where the motor is expected to run.
#[derive(Clone, Copy, Debug, Default)]
pub struct OperatingPoint {
    /// Which way the torque acts.
    pub torque: Direction,
    /// Time of a sector, 1/65 536 tick; 0 unknown.
    pub interval: u32,
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
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
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

/// The first crossing after standstill must exceed the noise by this factor.
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

/// What leaves a sample without news.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Quiet {
    /// No sample is looked at before.
    hidden: Instant,
    /// The crossing is overdue: every sample is looked at from then on.
    overdue: Instant,
    /// Signals that say nothing new, codes, and the mode in which they are sampled.
    band: Band,
    mode: SampleMode,
}

/// State of the station. Signals are differences of converter codes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BackEmf {
    step: Step,
    /// It followed another step, so that its crossing is still to come.
    whole: bool,
    watch: Option<Watch>,
    passage: Passage,
    /// Samples that the mean takes: 2^shift.
    shift: u8,
    /// Samples since the blanking.
    count: u8,
    after_run: u8,
    /// Comparator outputs as last captured.
    code: u8,
    /// Where in its period the sample before was taken, 1/65 536.
    sampled_at: u16,
    /// The first boundary of the step, and its age there, 1/65 536 tick.
    began: Instant,
    first_age: u32,
    /// When its blanking ends, 1/65 536 tick.
    blank: u32,
    /// Expected time of the step, as it began, 1/65 536 tick; 0 unknown.
    interval: u32,
    /// The flank that one mean may hold, and what stands out of the noise.
    flank: i32,
    noise: i32,
    /// Mean of the tick before.
    previous: i32,
    /// How long ago the signal has passed its threshold, while it is not yet believed.
    crossed: i32,
    window: [i16; WINDOW],
    sum: i32,
    quiet: Quiet,
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

    /// True if the step goes on as it did and this tick's sample says nothing new. Then the sample is taken.
    #[inline]
    pub fn rests(&mut self, now: Instant, samples: &Samples, applied: &PwmCommand) -> bool {
        if applied.step != self.step || !applied.commutations.is_empty() {
            return false;
        }
        if !self.quiet.hidden.is_due(now) {
            return true;
        }
        let Some(watch) = self.watch else { return false };
        let signal = signal(samples, watch);
        let rests = samples.sample_mode == self.quiet.mode
            && self.quiet.band.contains(signal)
            && !self.quiet.overdue.is_due(now);
        if rests {
            (self.previous, self.sampled_at) = (signal, applied.sample_at);
        }
        rests
    }

    /// The next tick looks at everything.
    pub const fn wake(&mut self, now: Instant) {
        (self.quiet.hidden, self.quiet.band) = (now, Band::EMPTY);
    }

    /// One tick. `bus_voltage` is raw I16F16 V as it is now, `applied` was in force in the period that has ended.
    #[inline]
    pub fn step(
        &mut self,
        c: &BackEmfCoefficients,
        now: Instant,
        samples: &Samples,
        bus_voltage: i32,
        applied: &PwmCommand,
        point: &OperatingPoint,
    ) -> Sight {
        if c.comparator {
            return self.step_by_edges(c, now, samples, applied, point);
        }
        let mut sight = Sight { missed: self.follow(c, now, applied, point), ..Sight::default() };
        if let Some(watch) = self.watch {
            sight.sector = Some(watch.sector);
            self.look(c, now, (samples, applied.sample_at), bus_voltage, watch, &mut sight);
        }
        self.find(c, now, &mut sight);
        sight
    }

    /// A crossing that was seen, or that stood beyond since the blanking, ends the watch of this step.
    #[inline]
    fn find(&mut self, c: &BackEmfCoefficients, now: Instant, sight: &mut Sight) {
        if let Some(age) = sight.crossing {
            let rises = self.watch.is_some_and(Watch::rises);
            let delay = if rises { c.delay_rising } else { c.delay_falling };
            sight.crossing = Some(age.saturating_add(delay));
            if sight.threshold != 0 {
                sight.threshold = c.terminal.convert_difference(sight.threshold);
            }
        }
        if sight.crossing.is_some() || sight.late {
            self.passage = Passage::Found;
        }
        sight.passed = self.passage == Passage::Found;
        if self.watch.is_none() || (sight.passed && c.comparator) {
            self.quiet.hidden = now.after(u32::MAX);
        } else if sight.passed && self.shift == 0 {
            // A false crossing shows by samples that are certainly before it.
            self.quiet.band = Band::new(self.before(self.quiet.mode), 1 << 20);
        }
    }

    /// The sample of a step whose crossing is still to come.
    #[inline]
    fn look(
        &mut self,
        c: &BackEmfCoefficients,
        now: Instant,
        (samples, sample_at): (&Samples, u16),
        bus_voltage: i32,
        watch: Watch,
        sight: &mut Sight,
    ) {
        let age = self.age(now);
        let left = self.blank.saturating_sub(age.saturating_add(sample_at.into()));
        if left > 0 {
            // In a later tick the sample may be taken later.
            self.quiet.hidden = now.after((left >> 16).max(1));
            return;
        }
        self.wake(now);
        let unseen = self.passage == Passage::Unseen;
        if !(unseen && self.demagnetises(c, samples, bus_voltage, age, watch)) {
            self.sample(samples, sample_at, watch, sight);
        }
    }

    /// Age of the step at the boundary `now`, 1/65 536 tick.
    #[inline]
    const fn age(&self, now: Instant) -> u32 {
        self.first_age.saturating_add(now.time_since(self.began))
    }

    /// The sector whose crossing is watched for.
    #[inline]
    pub fn watched(&self) -> Option<u8> {
        if self.passage == Passage::Found { None } else { self.watch.map(|watch| watch.sector) }
    }

    /// From that tick on the crossing is overdue, and a sample before it is news; `None`: there is none.
    #[inline]
    pub fn expect(&mut self, overdue: Option<Instant>) {
        self.quiet.overdue = overdue.unwrap_or(self.began.after(u32::MAX));
    }

    /// By `now` the crossing should have been seen.
    #[inline]
    pub const fn is_overdue(&self, now: Instant) -> bool {
        self.quiet.overdue.is_due(now)
    }

    /// The crossing was too early to be one: it is looked for again.
    pub fn reject(&mut self, now: Instant) {
        (self.passage, self.after_run) = (Passage::Unseen, 0);
        self.wake(now);
    }

    /// The bridge is off.
    #[inline]
    pub const fn coasts(&self) -> bool {
        matches!(self.step, Step::Coast)
    }

    /// Takes over the changes of the period that has ended. True if a step ended unseen.
    #[inline]
    fn follow(
        &mut self,
        c: &BackEmfCoefficients,
        now: Instant,
        applied: &PwmCommand,
        point: &OperatingPoint,
    ) -> bool {
        self.crossed = self.crossed.saturating_add(TICK as i32);
        if applied.step == self.step && applied.commutations.is_empty() {
            return false;
        }
        let mut missed = self.enter(c, now, applied.step, c.earliest, point);
        for change in applied.commutations.iter() {
            missed |= self.enter(c, now, change.step, change.instant, point);
        }
        missed
    }

    /// `step` is in force from `instant` of the period that has ended. True if another one ended unseen.
    #[inline]
    fn enter(
        &mut self,
        c: &BackEmfCoefficients,
        now: Instant,
        step: Step,
        instant: u16,
        point: &OperatingPoint,
    ) -> bool {
        let changes = step != self.step;
        let missed = changes && self.passage != Passage::Found && self.whole && step.sector().is_some();
        if changes {
            self.begin(c, now, step, instant, point);
        }
        missed
    }

    /// `step` began at `instant` of the period that has ended.
    #[inline(never)]
    fn begin(
        &mut self,
        c: &BackEmfCoefficients,
        now: Instant,
        step: Step,
        instant: u16,
        point: &OperatingPoint,
    ) {
        let OperatingPoint { torque, interval } = *point;
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
        (self.passage, self.shift) = (Passage::Unseen, shift);
        (self.began, self.first_age) = (now, TICK - u32::from(instant));
        (self.blank, self.interval) = (blanking(c, interval), interval);
        if shift > 0 {
            let emf = if interval > 0 { c.emf_of_turns.apply32(speed_of(1, interval)) } else { 0 };
            self.flank = c.terminal.codes_of_difference(emf / 4);
        }
        // A mean of 8 samples has a third of the noise.
        self.noise = if shift == 3 { c.noise / 2 } else { c.noise };
        // Nothing of the samples before counts: neither those in the window nor the last mean are looked at.
        (self.count, self.sum, self.after_run) = (0, 0, 0);
        self.wake(now);
    }

    /// Off-time: at 2 noises of the unsigned signal, from either side.
    #[inline]
    fn threshold(&self, mode: SampleMode) -> i32 {
        match mode {
            SampleMode::OnTime => 0,
            SampleMode::OffTime if self.watch.is_some_and(Watch::rises) => 2 * self.noise,
            SampleMode::OffTime => -2 * self.noise,
        }
    }

    /// The least signal that does not say for certain that the rotor has not reached the crossing.
    #[inline]
    fn before(&self, mode: SampleMode) -> i32 {
        // In the off-time a terminal before a rising crossing is below ground, and reads 0 wherever it is.
        let hides = mode == SampleMode::OffTime && self.watch.is_some_and(Watch::rises);
        if hides { -(1 << 20) } else { self.threshold(mode) - self.noise }
    }

    #[inline]
    fn sample(&mut self, samples: &Samples, sample_at: u16, watch: Watch, sight: &mut Sight) {
        let mode = samples.sample_mode;
        let off_time = mode == SampleMode::OffTime;
        let (noise, threshold) = (self.noise, self.threshold(mode));
        let beyond = self.beyond();
        let sample = self.mean(signal(samples, watch));
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
        self.quiet.mode = mode;
        if self.passage == Passage::Healthy && self.shift == 0 {
            self.quiet.band = Band::new(-(1 << 20), threshold - 1);
        }
    }

    /// Before anything is seen of a step, its winding's current may still hold the floating terminal at a rail: no evidence, and the mean starts
    /// anew. So for a rotor that nothing is known of however long it takes; one that turns may cross behind it, and from three eighths of the
    /// step on that is a late crossing.
    #[inline]
    fn demagnetises(
        &mut self,
        c: &BackEmfCoefficients,
        samples: &Samples,
        bus_voltage: i32,
        age: u32,
        watch: Watch,
    ) -> bool {
        let overdue = self.interval > 0 && age > self.interval / 8 * 3;
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
fn blanking(c: &BackEmfCoefficients, interval: u32) -> u32 {
    if interval == 0 { c.discard } else { c.discard.max(interval / 8).min(interval / 4) }
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
    let (terminal, noise) = (c.terminal.convert(code), c.terminal.convert_difference(c.noise));
    if watch.rises() {
        terminal > bus_voltage - noise
    } else {
        samples.sample_mode == SampleMode::OnTime && terminal < noise
    }
}
