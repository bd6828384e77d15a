//! Back-EMF of the floating phase: what one sample, or one comparator edge, says of the rotor.
//!
//! The floating terminal is compared with the mean of the other two, which is the same point as the mean of
//! all three. In the on-time the other two are at bus and ground, so the reference is half of the bus as it
//! is now; in the off-time both are at ground; with the bridge off it is the neutral. The signal is twice the
//! floating terminal less the other two, signed so that it rises through 0 at the crossing:
//!
//! ```text
//!  x        hidden    Before        After
//!           |blank |            _____/
//!   0 ......|......|......_____/...........   crossing: the middle of the sector
//!           |     _|_____/
//!        commutation                     commutation
//! ```
//!
//! In the off-time a terminal below ground reads 0 (diode and converter end there): the threshold then lies a
//! little above 0 and the crossing is found where the flank, whose slope is known from the back-EMF constant,
//! came from.

mod edges;
mod window;

use crate::motor::band::Band;
use crate::motor::clock::Instant;
use crate::motor::commutate::commutation::{Direction, Step};
use crate::motor::commutate::pwm::PwmCommand;
use crate::motor::gain::Gain;
use crate::motor::interval::{TICK, fraction, speed_of};
use crate::motor::sense::measurement::ChannelScale;
use crate::motor::sense::samples::{SampleMode, Samples};
use serde::{Deserialize, Serialize};
use window::signal;

/// Coefficients of the back-EMF station.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(C)]
pub struct BackEmfCoefficients {
    /// Scale of the phase terminals.
    pub terminal: ChannelScale,
    /// Smallest signal of one sample that stands out of the noise, converter codes.
    pub noise: i32,
    /// Terminals below this code show no back-EMF: less than the noise.
    pub silence: u16,
    /// Ticks without voltage after which the windings carry no more current.
    pub settle: u16,
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
    /// Back-EMF per 2^-32 turn a tick.
    pub emf_of_turns: Gain,
}

/// Operating point at which the motor is expected to run.
#[derive(Clone, Copy, Debug, Default)]
pub struct OperatingPoint {
    /// Which way the torque acts.
    pub torque: Direction,
    /// Time of a sector, 1/65 536 tick; 0 unknown.
    pub interval: u32,
    /// The rotor is being brought up: a sector may be much shorter than the one before it.
    pub accelerates: bool,
}

/// Finding of one tick about the step's crossing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Observation {
    /// Nothing that is certain and new.
    #[default]
    Nothing,
    /// The rotor has not reached the middle of the sector.
    Before,
    /// The level beyond the crossing stands since the blanking ended: the crossing came earlier than it could
    /// be seen.
    Late,
    /// A healthy crossing.
    Crossing {
        /// Time before the present boundary, 1/65 536 tick; negative is after it.
        age: i32,
        /// The signal's value there, signed as it rises, raw I16F16 V: off-time thresholds are not at 0.
        threshold: i32,
    },
}

/// End of the step before, when the pattern has changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Its crossing was seen, or it had none to show.
    Seen,
    /// Neither the crossing nor the level beyond it was seen.
    Missed,
    /// Its crossing came within the very period in which the pattern changed, `age` (1/65 536 tick) before
    /// the present boundary.
    Crossing {
        /// The sector whose crossing it is.
        sector: u8,
        /// 1/65 536 tick.
        age: i32,
    },
}

/// The first crossing after standstill must exceed the noise by this factor.
const FIRST_SIGN: i32 = 4;
/// Samples that the mean reaches back at most.
const WINDOW: usize = 8;

/// Progress of a step's crossing.
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

/// The signal that a running step watches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Watch {
    /// The rotor's sector.
    sector: u8,
    /// The floating phase.
    phase: u8,
}

/// The samples that bring no news.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Quiet {
    /// Samples before this tick are ignored.
    hidden: Instant,
    /// The crossing is overdue: every sample is looked at from then on.
    overdue: Instant,
    /// Signals of the watched crossing that say nothing new, codes, and the mode in which they are sampled.
    watch: Watch,
    band: Band,
    mode: SampleMode,
    /// Progress of the crossing after such a sample.
    passage: Passage,
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
    /// Sampling instant of the previous sample in its period, 1/65 536.
    sampled_at: u16,
    /// The first boundary of the step, and its age there, 1/65 536 tick.
    began: Instant,
    first_age: u32,
    /// End of its blanking, 1/65 536 tick, and the first tick whose sample is taken after that.
    blank: u32,
    visible: Instant,
    /// Expected time of the step, as it began, 1/65 536 tick; 0 unknown.
    interval: u32,
    /// The flank that one mean may hold, and what stands out of the noise.
    flank: i32,
    noise: i32,
    /// Mean of the tick before.
    previous: i32,
    /// Time since the signal has passed its threshold, while it is not yet believed.
    crossed: i32,
    window: [i16; WINDOW],
    sum: i32,
    quiet: Quiet,
}

impl BackEmf {
    /// Distance that the signal must go beyond its threshold. The first sign of motion moves the field on. In
    /// the next step a rotor that hardly turns has half the torque, so it must be well on its way.
    #[inline]
    const fn beyond(&self) -> i32 {
        if self.interval == 0 { FIRST_SIGN * self.noise } else { self.noise }
    }

    /// Time since the signal passed its threshold, on its way from the last mean to this one.
    #[inline]
    fn crossed_at(&self, mean: i32, threshold: i32, sample_at: u16) -> i32 {
        let now = -i32::from(sample_at);
        let previous_age = TICK as i32 - i32::from(self.sampled_at);
        let part = fraction(threshold - self.previous, mean - self.previous);
        let span = i64::from(previous_age.saturating_sub(now));
        previous_age - ((span * i64::from(part)) >> 16) as i32 + self.mean_delay()
    }

    /// The step goes on as it did.
    #[inline]
    pub fn goes_on(&self, applied: &PwmCommand) -> bool {
        applied.step == self.step && applied.commutations.is_empty()
    }

    /// True if this tick's sample of a step that goes on says nothing new. Then the sample is taken.
    #[inline]
    pub fn rests(&mut self, now: Instant, samples: &Samples, sample_at: u16) -> bool {
        if !self.quiet.hidden.is_due(now) {
            return true;
        }
        let signal = signal(samples, self.quiet.watch);
        let rests = self.quiet.band.contains(signal)
            && samples.sample_mode == self.quiet.mode
            && !self.quiet.overdue.is_due(now);
        if rests {
            (self.previous, self.sampled_at, self.passage) = (signal, sample_at, self.quiet.passage);
        }
        rests
    }

    /// The next tick looks at everything.
    pub const fn wake(&mut self, now: Instant) {
        (self.quiet.hidden, self.quiet.band) = (now, Band::EMPTY);
    }

    /// Finds out what this tick shows. `bus_voltage` is raw I16F16 V as it is now; the sample was taken at
    /// `sample_at` of its period.
    #[inline(always)]
    pub fn look(
        &mut self,
        c: &BackEmfCoefficients,
        now: Instant,
        samples: &Samples,
        bus_voltage: i32,
        sample_at: u16,
    ) -> Observation {
        let Some(watch) = self.watch else {
            self.quiet.hidden = now.after(u32::MAX);
            return Observation::Nothing;
        };
        if c.comparator {
            return self.look_at_edges(c, now, samples, watch);
        }
        if !self.visible.is_due(now) {
            self.quiet.hidden = self.visible;
            return Observation::Nothing;
        }
        self.crossed = self.crossed.saturating_add(TICK as i32);
        let unseen = self.passage == Passage::Unseen;
        if unseen && self.demagnetises(c, now, samples, bus_voltage, watch) {
            return Observation::Nothing;
        }
        let observation = self.sample(c, samples, sample_at, watch);
        self.rest_by(samples.sample_mode);
        observation
    }

    /// From here on a sample of this `mode` says nothing new as long as it stays in the band set here, and it
    /// brings the crossing as far as is set here: the first one certainly before the crossing makes what
    /// follows healthy. A mean of several samples needs them all.
    #[inline]
    fn rest_by(&mut self, mode: SampleMode) {
        const END: i32 = 1 << 20;
        let threshold = self.threshold(mode);
        let (band, passage) = match self.passage {
            _ if self.shift > 0 => (Band::EMPTY, Passage::Unseen),
            // What is certainly before the crossing, and so no demagnetisation.
            Passage::Unseen => (Band::new(-END, threshold - self.noise - 1), Passage::Healthy),
            Passage::Healthy => (Band::new(-END, threshold - 1), Passage::Healthy),
            Passage::Crossing => (Band::EMPTY, Passage::Crossing),
            // A false crossing shows by samples that are certainly before it.
            Passage::Found => (Band::new(self.before(mode), END), Passage::Found),
        };
        (self.quiet.band, self.quiet.mode, self.quiet.passage) = (band, mode, passage);
    }

    /// The delay of the watched crossing, 1/65 536 tick.
    #[inline]
    const fn delay(c: &BackEmfCoefficients, watch: Watch) -> i32 {
        if watch.rises() { c.delay_rising } else { c.delay_falling }
    }

    /// Age of the step at the boundary `now`, 1/65 536 tick.
    #[inline]
    const fn age(&self, now: Instant) -> u32 {
        self.first_age.saturating_add(now.time_since(self.began))
    }

    /// The sector whose crossing the step shows; `None` when no single phase floats.
    #[inline]
    pub fn sector(&self) -> Option<u8> {
        self.watch.map(|watch| watch.sector)
    }

    /// The crossing of this step was seen, or was late.
    #[inline]
    pub fn is_found(&self) -> bool {
        self.passage == Passage::Found
    }

    /// From that tick on the crossing is overdue, and a sample that lies before it is news; `None`: no
    /// crossing is awaited.
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

    /// Takes over the changes of the period that has ended; `applied` was in force in it.
    pub fn follow(
        &mut self,
        c: &BackEmfCoefficients,
        now: Instant,
        samples: &Samples,
        applied: &PwmCommand,
        point: &OperatingPoint,
    ) -> End {
        let crossing =
            if c.comparator { self.crossing_before_change(c, now, samples, applied) } else { None };
        let mut missed = false;
        if applied.step != self.step {
            missed = self.begin(c, now, applied, (applied.step, c.earliest), point);
        }
        for change in applied.commutations.iter() {
            if change.step != self.step {
                missed |= self.begin(c, now, applied, (change.step, change.instant), point);
            }
        }
        match crossing {
            Some(end) => end,
            None if missed => End::Missed,
            None => End::Seen,
        }
    }

    /// Another step began at an instant of the period that has ended. True if the one before ended unseen.
    #[inline(never)]
    fn begin(
        &mut self,
        c: &BackEmfCoefficients,
        now: Instant,
        applied: &PwmCommand,
        (step, instant): (Step, u16),
        point: &OperatingPoint,
    ) -> bool {
        let missed = self.passage != Passage::Found && self.whole && step.sector().is_some();
        let OperatingPoint { torque, interval, accelerates } = *point;
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
        (self.blank, self.interval) = (blanking(c, interval, accelerates), interval);
        if shift > 0 {
            let emf = if interval > 0 { c.emf_of_turns.apply32(speed_of(1, interval)) } else { 0 };
            self.flank = c.terminal.codes_of_difference(emf / 4);
        }
        // A mean of 8 samples has a third of the noise.
        self.noise = if shift == 3 { c.noise / 2 } else { c.noise };
        // Nothing of the samples before counts: neither those in the window nor the last mean are looked at.
        (self.count, self.sum, self.after_run) = (0, 0, 0);
        let unseen = self.blank.saturating_sub(self.first_age + u32::from(applied.sample_at));
        self.visible = now.after(unseen.div_ceil(TICK));
        self.wake(now);
        if let Some(watch) = self.watch
            && !c.comparator
        {
            (self.quiet.watch, self.quiet.hidden) = (watch, self.visible);
            self.rest_by(applied.sample_mode);
        }
        missed
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

    /// The mean that this sample makes against the threshold.
    #[inline]
    fn sample(
        &mut self,
        c: &BackEmfCoefficients,
        samples: &Samples,
        sample_at: u16,
        watch: Watch,
    ) -> Observation {
        let mode = samples.sample_mode;
        let off_time = mode == SampleMode::OffTime;
        let (threshold, beyond) = (self.threshold(mode), self.beyond());
        let sample = self.mean(signal(samples, watch));
        let mean = sample.value;
        let mut observation = Observation::Nothing;
        if mean < threshold - self.noise {
            if self.passage == Passage::Unseen {
                self.passage = Passage::Healthy;
            }
            self.after_run = 0;
            if !off_time || !watch.rises() {
                observation = Observation::Before;
            }
        } else if mean > threshold + beyond && (!off_time || watch.rises()) {
            self.after_run = self.after_run.saturating_add(1);
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
            self.passage = Passage::Found;
            let threshold = if threshold == 0 { 0 } else { c.terminal.convert_difference(threshold) };
            observation =
                Observation::Crossing { age: self.crossed.saturating_add(Self::delay(c, watch)), threshold };
        } else if self.passage == Passage::Unseen && self.after_run > 2 + (1 << self.shift) / 2 {
            self.passage = Passage::Found;
            observation = Observation::Late;
        }
        self.keep(sample, sample_at);
        observation
    }

    /// Before anything is seen of a step, its winding's current may still hold the floating terminal at a
    /// rail: no evidence, and the mean starts anew. For a rotor of unknown speed that lasts as long as it
    /// takes; one that turns may cross behind it, and from three eighths of the step on that is a late
    /// crossing.
    #[inline]
    fn demagnetises(
        &mut self,
        c: &BackEmfCoefficients,
        now: Instant,
        samples: &Samples,
        bus_voltage: i32,
        watch: Watch,
    ) -> bool {
        let overdue = self.interval > 0 && self.age(now) > self.interval / 8 * 3;
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

/// Blanking: an eighth of the step, at least the discard time (parameter 86), but a sample before the
/// crossing must be left: at most a quarter of the step. The step before may have held a rest while the
/// rotor `accelerates`, and an eighth of that can outlast the crossing: then at most as long as a winding
/// carries current.
fn blanking(c: &BackEmfCoefficients, interval: u32, accelerates: bool) -> u32 {
    let longest = if accelerates { u32::from(c.settle) * TICK } else { u32::MAX };
    if interval == 0 { c.discard } else { c.discard.max((interval / 8).min(longest)).min(interval / 4) }
}

/// The signal of a running step with torque in `torque`.
fn watch(step: Step, torque: Direction) -> Option<Watch> {
    Some(Watch { sector: step.rotor_sector(torque)?, phase: step.floating()? })
}

/// The floating terminal is at a rail: current into it before a rising crossing, out of it before a falling
/// one, on the far side of the crossing.
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
