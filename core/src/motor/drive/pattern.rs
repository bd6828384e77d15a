//! What a state applies: the pattern, and the command that it becomes.

use super::Drive;
use crate::motor::commutation::Step;
use crate::motor::control::Demand;
use crate::motor::hall_calibration::HallCalibrator;
use crate::motor::pwm::{Commutations, PwmCommand, Rectification};
use crate::motor::samples::{SampleMode, Samples};
use crate::motor::sensorless::Plan;
use crate::motor::state::State;
use crate::units::Duty;

/// The pattern of one tick and what drives it.
pub(super) struct Pattern {
    pub(super) demand: Demand,
    pub(super) step: Step,
    pub(super) commutations: Commutations,
    /// A duty of 0 is meant: the low sides short the windings.
    pub(super) short: bool,
}

impl Pattern {
    const OFF: Self =
        Self { demand: Demand::Off, step: Step::Coast, commutations: Commutations::NONE, short: false };

    pub(super) fn hold(demand: Demand, step: Step) -> Self {
        Self { demand, step, ..Self::OFF }
    }

    /// The step after the last commutation.
    pub(super) fn last(&self) -> Step {
        self.commutations.last().map_or(self.step, |last| last.step)
    }
}

impl Drive {
    /// What this state applies.
    pub(super) fn pattern(&mut self, samples: &Samples) -> Pattern {
        match self.machine.state() {
            State::RotorLock if self.machine.calibrating() => self.calibration_lock(),
            State::OpenLoop if self.machine.calibrating() => self.hall_calibration(samples),
            State::OpenLoop if !self.machine.is_sensorless() => self.open_loop(),
            State::HallClosedLoop => self.hall_closed_loop(),
            State::RotorLock
            | State::OpenLoop
            | State::SensorlessClosedLoop
            | State::SensorlessAutoRestart => self.sensorless(),
            State::Initialization | State::Standby | State::Fault => Pattern::OFF,
        }
    }

    /// What the sequence from standstill to closed loop wants now.
    fn sensorless(&mut self) -> Pattern {
        let direction = self.machine.direction();
        let state = self.machine.state();
        let speed = self.sensorless_forward();
        let c = &self.coefficients;
        // Nothing is brought up in a direction that is no longer wanted.
        if self.machine.reversing() && !self.sensorless.is_running() {
            return Pattern::OFF;
        }
        let plan = self.sensorless.step(&c.sensorless, state, direction);
        self.heed_speed();
        let c = &self.coefficients;
        match self.sensorless.take_begun() {
            Some(true) => self.control.start(&c.control, speed, self.volts(c.control.initial_level)),
            // A light rotor may have leapt beyond what is ever asked of it: the set-point does not.
            Some(false) => {
                let applied = self.control.applied(&c.control, self.measurement.bus_voltage());
                self.control.hand_over(speed.min(c.sensorless_mode.speed_max), applied);
            }
            None => {}
        }
        let demand = match plan {
            Plan::Coast => return Pattern::OFF,
            Plan::Short => {
                return Pattern { short: true, ..Pattern::hold(Demand::Voltage { voltage: 0 }, Step::LockA) };
            }
            Plan::Hold(step, level) => return Pattern::hold(self.level(level), step),
            Plan::Level(level) => self.level(level),
            Plan::Speed(fade) => Demand::Speed { measured: speed, fade },
        };
        let rotor = self.sensorless.rotor();
        let (step, commutations) =
            self.commutator.step(&c.commutator, rotor.angle(), rotor.speed(), direction);
        // A current limit that takes the kick's duty to 0 freewheels: with the bridge off the winding's energy would go to the bus.
        let short = matches!(plan, Plan::Level(_));
        Pattern { demand, step, commutations, short }
    }

    /// Two locks one after the other, 60 degrees apart: a rotor that rests on the dead point of the first is off that
    /// of the second.
    fn calibration_lock(&mut self) -> Pattern {
        let c = &self.coefficients.machine;
        let level = self.lock.step(c.lock_level, c.lock_rate);
        let second = self.machine.age() >= c.lock / 2;
        Pattern::hold(self.level(level), if second { HallCalibrator::LOCK } else { Step::LockB })
    }

    fn hall_calibration(&mut self, samples: &Samples) -> Pattern {
        let c = &self.coefficients.hall_calibration;
        let (step, calibration) = self.calibrator.step(c, samples.hall);
        self.calibration = calibration;
        Pattern::hold(self.level(c.level), step)
    }

    fn level(&self, level: i32) -> Demand {
        Demand::Voltage { voltage: self.volts(level) }
    }

    fn open_loop(&mut self) -> Pattern {
        let direction = self.machine.direction();
        let run = !self.machine.reversing();
        let field = self.rotor.step_open_loop(&self.coefficients, direction, run);
        let (step, commutations) =
            self.commutator.step(&self.coefficients.commutator, field.angle, field.speed, direction);
        Pattern { demand: self.level(field.level), step, commutations, short: false }
    }

    /// A rotor that turns the other way at speed is left to coast: torque now would brake it through the bridge,
    /// where no current is measured. So is one whose sensors contradict themselves.
    #[inline]
    pub(super) fn hall_demand(&self) -> Option<Demand> {
        let least = -(self.coefficients.hall_mode.speed_min / 2);
        let speed = self.machine.direction().signed(self.rotor.hall_speed().to_bits());
        let runs = speed >= least && !self.rotor.hall_doubtful();
        runs.then_some(Demand::Speed { measured: speed.max(0), fade: 0 })
    }

    fn hall_closed_loop(&mut self) -> Pattern {
        let direction = self.machine.direction();
        let Some(demand) = self.hall_demand() else { return Pattern::OFF };
        let position = self.rotor.hall_position();
        let (step, commutations) =
            self.commutator.step(&self.coefficients.commutator, position.angle, position.speed, direction);
        Pattern { demand, step, commutations, short: false }
    }

    /// A duty of 0 leaves the bridge off: with the low side on, a turning motor would brake itself.
    pub(super) fn command(&self, pattern: &Pattern, duty: Duty, rectification: Rectification) -> PwmCommand {
        let now = self.applied.duty.to_bits();
        let idle =
            matches!(pattern.demand, Demand::Off) || (duty.to_bits() == 0 && now == 0 && !pattern.short);
        let (step, commutations) =
            if idle { (Step::Coast, Commutations::NONE) } else { (pattern.step, pattern.commutations) };
        let (sample_at, sample_mode) = self.sampling(duty.to_bits());
        PwmCommand {
            duty: if matches!(pattern.demand, Demand::Off) { Duty::ZERO } else { duty },
            rectification,
            sample_at,
            sample_mode,
            step,
            commutations,
        }
    }

    /// Duties from which the on-time is sampled, and below which the off-time is, raw U1F15.
    pub(super) fn sampling_limits(&self) -> (u16, u16) {
        if !self.listens {
            // Without an eye on back-EMF there is no need to go that far.
            return (ON_ABOVE, OFF_BELOW);
        }
        let shortest = self.coefficients.control.duty_min.max(ON_TIME_LEAST);
        (shortest, shortest - shortest / 8)
    }

    /// A pulse that is long enough for a valid sample (parameter 272) is sampled in its middle, a shorter one after it has ended; down to an eighth below the
    /// limit the mode stays.
    #[inline]
    pub(super) fn sampling(&self, duty: u16) -> (u16, SampleMode) {
        let (begins, lasts) = self.on_time;
        if duty >= begins || (duty >= lasts && self.applied.sample_mode == SampleMode::OnTime) {
            (0, SampleMode::OnTime)
        } else {
            (self.after_pulse(duty), SampleMode::OffTime)
        }
    }

    /// Where the off-time is sampled: the pulse ends at D/2 of the period, and duty (1/32 768) is that many 1/65 536.
    #[inline]
    pub(super) const fn after_pulse(&self, duty: u16) -> u16 {
        duty.saturating_add(self.coefficients.sample_settle)
    }
}

/// Shortest pulse that is sampled in its middle if parameter 272 allows less: 1 us at 10 kHz, raw U1F15.
const ON_TIME_LEAST: u16 = 327;
/// Where nothing depends on it the mode changes at 25 and 20 % duty, raw U1F15.
const ON_ABOVE: u16 = 32_768 / 4 + 1;
const OFF_BELOW: u16 = 32_768 / 5;
