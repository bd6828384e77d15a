//! Zero crossings: terminals of a driven or coasting motor to crossing, angle, speed and the next
//! commutation.

use super::commutation::{self, CommutationSettings};
use super::error::{SettingError, within};
use super::{Position, speed_of_turns, tick_rate};
use crate::motor::clock::Instant;
use crate::motor::commutate::commutation::{Direction, Step};
use crate::motor::commutate::commutator::{CommutatorCoefficients, time_in};
use crate::motor::commutate::pwm::PwmCommand;
use crate::motor::gain::Gain;
use crate::motor::guard::rails::Rail;
use crate::motor::rotor::back_emf::{BackEmf, BackEmfCoefficients, End, Observation, OperatingPoint};
use crate::motor::rotor::listening::Listening;
use crate::motor::rotor::zero_crossing::{Why, ZeroCrossing as Estimator};
use crate::motor::sense::front_end::{Channel, FrontEnd};
use crate::motor::sense::measurement::ChannelScale;
use crate::motor::sense::samples::Samples;
use crate::units::ElectricalSpeed;
use serde::Serialize;

/// Settings of a [`ZeroCrossing`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ZeroCrossingSettings {
    /// Ticks a second, 1 000 to 100 000 Hz.
    pub tick_rate: u32,
    /// Scale of the three phase terminals.
    pub terminal: Channel,
    /// Scale of the bus voltage.
    pub bus_voltage: Channel,
    /// Least blanking after a commutation, 0 to 100 000 us (parameter 86).
    pub blanking_us: u32,
    /// Delay of a rising crossing, -10 000 to 10 000 us (parameter 100).
    pub delay_rising_us: i32,
    /// Delay of a falling crossing, -10 000 to 10 000 us.
    pub delay_falling_us: i32,
    /// Line-to-line back-EMF, 0 to 1 000 000 uV a mechanical rpm (parameter 267); 0 unknown, then off-time
    /// crossings are not corrected for their threshold.
    pub back_emf_uv_per_rpm: u32,
    /// Instant of the period at which a new step acts, 1/65 536 of it, and the advance of the next
    /// commutation.
    pub commutation: CommutationSettings,
    /// Pole pairs, 1 to 100.
    pub pole_pairs: u16,
    /// No crossing for this long is standstill, 1 to 32 767 ticks (parameter 85).
    pub timeout_ticks: u16,
    /// Smallest signal that stands out of the noise, 1 to 255 codes of a terminal.
    pub noise_codes: u8,
    /// Comparators with captured edges take the place of samples.
    pub comparator: bool,
}

impl Default for ZeroCrossingSettings {
    /// 10 kHz, narx's own converter, 4 codes of noise, 200 us of blanking, samples, no delays, no advance,
    /// 500 ticks; the back-EMF is not known.
    fn default() -> Self {
        Self {
            tick_rate: 10_000,
            terminal: FrontEnd::NARX.phase_voltage,
            bus_voltage: FrontEnd::NARX.bus_voltage,
            noise_codes: 4,
            blanking_us: 200,
            commutation: CommutationSettings { advance_cdeg: 0, earliest: 8_192 },
            comparator: false,
            delay_rising_us: 0,
            delay_falling_us: 0,
            back_emf_uv_per_rpm: 0,
            pole_pairs: 1,
            timeout_ticks: 500,
        }
    }
}

/// Reading of the terminals after a tick.
#[derive(Clone, Copy, Debug, Default)]
pub struct ZeroCrossingReading {
    /// Age of a crossing that was seen in this tick: time from it to the present boundary, 1/65 536 tick;
    /// negative is after the boundary.
    pub crossing: Option<i32>,
    /// Outcome of the last step's crossing.
    pub why: Why,
    /// Lag of the last accepted crossing behind its prediction, 65 536 a turn.
    pub margin: i16,
    /// Crossings accepted since it was built, wrapping.
    pub accepted: u32,
    /// Angle and speed at the present boundary, for a [`Commutation`](super::Commutation).
    pub position: Position,
    /// Electrical speed, signed, over up to a revolution, limited by the time for which the next crossing has
    /// not come; 0 while unknown.
    pub speed: ElectricalSpeed,
    /// Time from the present boundary to the next commutation, 1/65 536 tick: 0 is now, `None` is unknown.
    pub commutation: Option<u32>,
    /// Six consistent crossings of both polarities: the position may close a loop.
    pub running: bool,
    /// Reason why this episode ends in this tick: stalled (blind, late or silent for too long), or out of
    /// step. The bridge must be switched off.
    pub lost: Rail,
}

/// Ready-made coefficients of a detector: those that its settings build.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[repr(C)]
pub struct ZeroCrossingReady {
    /// The station's own.
    pub back_emf: BackEmfCoefficients,
    /// Of the commutation that follows a crossing.
    pub commutator: CommutatorCoefficients,
    /// Scale of the bus voltage.
    pub bus_voltage: ChannelScale,
    /// Rev/s (raw I16F16) of 2^-32 turn a tick.
    pub speed_of_turns: Gain,
    /// No crossing for this long is standstill, 1/65 536 tick.
    pub timeout: u32,
}

/// Phase of the rotor's motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Mode {
    /// It coasts, if it turns at all.
    #[default]
    Listening,
    /// It is brought up from rest.
    Starting,
    /// Its crossings are regular.
    Running,
}

/// The back-EMF of the floating phase and the estimator behind it, without a start sequence:
/// [`start`](Self::start) after the rotor was aligned, or let it listen to a coasting motor until it is
/// `running`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ZeroCrossing {
    ready: ZeroCrossingReady,
    now: Instant,
    back_emf: BackEmf,
    listening: Listening,
    estimator: Estimator,
    mode: Mode,
}

impl ZeroCrossing {
    /// Builds a station that has not seen the motor yet.
    ///
    /// # Errors
    /// The setting that is out of range.
    pub fn build(s: &ZeroCrossingSettings) -> Result<Self, SettingError> {
        let rate = tick_rate(s.tick_rate)?;
        let scale_max = Channel::MICRO_PER_CODE_MAX.into();
        within("terminal", s.terminal.micro_per_code.into(), 1, scale_max, "uV/code")?;
        within("bus_voltage", s.bus_voltage.micro_per_code.into(), 1, scale_max, "uV/code")?;
        within("noise_codes", s.noise_codes.into(), 1, 255, "codes")?;
        within("blanking_us", s.blanking_us.into(), 0, 100_000, "us")?;
        within("delay_rising_us", s.delay_rising_us.into(), -10_000, 10_000, "us")?;
        within("delay_falling_us", s.delay_falling_us.into(), -10_000, 10_000, "us")?;
        within("back_emf_uv_per_rpm", s.back_emf_uv_per_rpm.into(), 0, 1_000_000, "uV/rpm")?;
        within("pole_pairs", s.pole_pairs.into(), 1, 100, "")?;
        within("timeout_ticks", s.timeout_ticks.into(), 1, 32_767, "ticks")?;
        let commutator = commutation::coefficients(&s.commutation)?;
        // 1/65 536 tick of a time in us.
        let time = |us: i64| ((us * i64::from(rate)) << 16) / 1_000_000;
        // V/rpm x 10^-6 to V per electrical rev/s, and per 2^-32 turn a tick.
        let (emf, poles) = (i128::from(s.back_emf_uv_per_rpm) * 60, i128::from(s.pole_pairs));
        let gain = |numerator, denominator| Gain::from_ratio(numerator, denominator).unwrap_or(Gain::ZERO);
        let back_emf = BackEmfCoefficients {
            terminal: ChannelScale::new(s.terminal, 0),
            noise: s.noise_codes.into(),
            silence: s.terminal.zero.saturating_add(s.noise_codes.into()),
            settle: (time(800) >> 16).clamp(1, u16::MAX.into()) as u16,
            discard: time(s.blanking_us.into()) as u32,
            earliest: commutator.earliest,
            comparator: s.comparator,
            delay_rising: time(s.delay_rising_us.into()) as i32,
            delay_falling: time(s.delay_falling_us.into()) as i32,
            back_emf: gain(emf, 1_000_000 * poles),
            emf_of_turns: gain(emf * i128::from(rate), 1_000_000 * 65_536 * poles),
        };
        Ok(Self::new(ZeroCrossingReady {
            back_emf,
            commutator,
            bus_voltage: ChannelScale::new(s.bus_voltage, 0),
            speed_of_turns: speed_of_turns(rate),
            timeout: u32::from(s.timeout_ticks) << 16,
        }))
    }

    /// A station that has not seen the motor yet, with ready-made coefficients, which are not checked.
    pub fn new(ready: ZeroCrossingReady) -> Self {
        Self {
            ready,
            now: Instant::default(),
            back_emf: BackEmf::default(),
            listening: Listening::default(),
            estimator: Estimator::default(),
            mode: Mode::Listening,
        }
    }

    /// Its coefficients, for [`new`](Self::new) elsewhere.
    pub const fn ready(&self) -> &ZeroCrossingReady {
        &self.ready
    }

    /// Begins to bring up a rotor that rests at `angle` (u32 turn), in `direction`.
    pub fn start(&mut self, angle: u32, direction: Direction) {
        self.estimator.start(self.now, angle, direction);
        self.mode = Mode::Starting;
    }

    /// Goes on by a step without any evidence: the rotor that is being brought up has not moved.
    pub fn force_step(&mut self) {
        self.estimator.force_step();
    }

    /// Runs one tick with the samples (phase and bus voltages with their mode, edges of comparators) and the
    /// command that was `applied` in the period that has ended, with torque in direction `torque`. Of
    /// `applied` the step, the commutations and the sampling instant count.
    pub fn step(
        &mut self,
        samples: &Samples,
        applied: &PwmCommand,
        torque: Direction,
    ) -> ZeroCrossingReading {
        self.now = self.now.next();
        self.estimator.pass(self.now);
        self.listening.renew(self.now);
        let mut crossing = None;
        if applied.step == Step::Coast && applied.commutations.is_empty() {
            self.listen(samples, applied);
        } else {
            crossing = self.observe(samples, applied, torque);
        }
        let lost = self.settle();
        self.reading(crossing, lost, applied, torque)
    }

    /// Evaluates a tick with the bridge off.
    fn listen(&mut self, samples: &Samples, applied: &PwmCommand) {
        if !self.back_emf.coasts() {
            self.back_emf = BackEmf::default();
            self.listening.reset(self.now);
        }
        self.estimator.begin_coasting(self.now);
        if self.mode == Mode::Starting {
            self.listening.reset(self.now);
            return;
        }
        let (c, codes) = (&self.ready.back_emf, &samples.phase_voltage);
        self.listening.inform(&mut self.estimator, c, self.now, codes, applied.sample_at);
    }

    /// Evaluates a tick with the bridge on; returns the age of a crossing that the estimator accepts.
    fn observe(&mut self, samples: &Samples, applied: &PwmCommand, torque: Direction) -> Option<i32> {
        let bus_voltage = self.ready.bus_voltage.convert(samples.bus_voltage);
        let (now, c) = (self.now, &self.ready.back_emf);
        let mut end = End::Seen;
        if !self.back_emf.goes_on(applied) {
            if self.back_emf.coasts() {
                self.listening.reset(now);
            }
            let point = OperatingPoint { torque, interval: self.estimator.expected(), accelerates: false };
            end = self.back_emf.follow(c, now, samples, applied, &point);
        }
        let observation = self.back_emf.look(c, now, samples, bus_voltage, applied.sample_at);
        if self.mode == Mode::Listening {
            return None;
        }
        match end {
            End::Crossing { sector, age } => self.take(sector, Observation::Crossing { age, threshold: 0 }),
            End::Seen => self.take(self.back_emf.sector()?, observation),
            End::Missed => {
                self.estimator.step_blind(now);
                self.take(self.back_emf.sector()?, observation)
            }
        }
    }

    /// Gives the estimator the observation in the step of `sector`; returns the age of a crossing that it
    /// accepts.
    fn take(&mut self, sector: u8, observation: Observation) -> Option<i32> {
        let (now, starting) = (self.now, self.mode == Mode::Starting);
        match observation {
            Observation::Crossing { age, threshold } => {
                let crossing = (age, threshold);
                if self.estimator.cross(now, sector, crossing, self.ready.back_emf.emf_of_turns, starting) {
                    return Some(age);
                }
                self.back_emf.reject(now);
            }
            Observation::Late => self.estimator.cross_late(now, sector, starting),
            Observation::Before => _ = self.estimator.wait(now, sector, starting),
            Observation::Nothing if starting && !self.back_emf.is_found() => {
                self.estimator.wait(now, sector, true);
            }
            Observation::Nothing => {}
        }
        None
    }

    /// Decides whether the loop may be closed or must be opened; returns the reason for opening it.
    fn settle(&mut self) -> Rail {
        let silent = self.estimator.since(self.now) >= self.ready.timeout;
        match self.mode {
            Mode::Listening if silent || !self.listening.is_turning() => {}
            Mode::Listening | Mode::Starting => {
                if self.estimator.is_prepared() {
                    self.mode = Mode::Running;
                }
            }
            Mode::Running => {
                let lost = if silent || self.estimator.is_lost() {
                    Rail::Stall
                } else if self.estimator.is_irregular() {
                    Rail::Desynchronised
                } else {
                    return Rail::None;
                };
                self.mode = Mode::Listening;
                return lost;
            }
        }
        Rail::None
    }

    fn reading(
        &self,
        crossing: Option<i32>,
        lost: Rail,
        applied: &PwmCommand,
        torque: Direction,
    ) -> ZeroCrossingReading {
        let estimator = &self.estimator;
        let (why, margin, accepted) = estimator.why();
        let position = Position { angle: estimator.angle(self.now), speed: estimator.speed() };
        let known = self.mode == Mode::Running || estimator.is_prepared() || self.listening.is_turning();
        let speed = if known && estimator.since(self.now) < self.ready.timeout {
            estimator.speed_bounded(self.now)
        } else {
            0
        };
        let step = applied.commutations.last().map_or(applied.step, |last| last.step);
        let sector = step.rotor_sector(torque).filter(|_| self.mode != Mode::Listening);
        ZeroCrossingReading {
            crossing,
            why,
            margin,
            accepted,
            position,
            speed: ElectricalSpeed::from_bits(self.ready.speed_of_turns.apply32(speed)),
            commutation: sector.and_then(|sector| {
                time_in(&self.ready.commutator, sector, position.angle, position.speed, torque)
            }),
            running: self.mode == Mode::Running,
            lost,
        }
    }
}
