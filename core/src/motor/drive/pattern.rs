//! The pattern that a state applies, and the command that it becomes.

use super::Drive;
use crate::motor::coefficients::Coefficients;
use crate::motor::commutate::commutation::Step;
use crate::motor::commutate::pwm::Commutations;
use crate::motor::control::{Demand, Output};
use crate::motor::machine::event::HallCalibration;
use crate::motor::machine::state::State;
use crate::motor::modes::HALL;
use crate::motor::rotor::hall_calibration::HallCalibrator;
use crate::motor::rotor::sensorless::Plan;
use crate::motor::rotor::{Position, Source};
use crate::motor::sense::samples::{SampleMode, Samples};
use serde::{Deserialize, Serialize};

/// The bridge's orders until the stations are asked again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Pattern {
    pub(super) demand: Demand,
    /// The step that goes on.
    pub(super) step: Step,
    /// A duty of 0 is meant: the low sides short the windings.
    pub(super) short: bool,
}

impl Pattern {
    pub(super) const OFF: Self = Self::hold(Demand::Off, Step::Coast);

    const fn hold(demand: Demand, step: Step) -> Self {
        Self { demand, step, short: false }
    }
}

impl Drive {
    /// Sets what this state wants of the bridge. The rotor's position if the commutator is to choose the
    /// step, `None` if one is held or the bridge is off.
    #[inline]
    pub(super) fn choose_demand(&mut self, samples: &Samples) -> Option<Position> {
        let held = match self.rotor.source() {
            Source::Both => Pattern::OFF,
            Source::Terminals => return self.sensorless(),
            Source::Field => return self.open_loop(),
            Source::Halls if HALL && !self.machine.calibrating() => return self.hall_closed_loop(),
            Source::Halls if self.machine.state() == State::RotorLock => self.calibration_lock(),
            Source::Halls => self.hall_calibration(samples),
        };
        self.hold(held)
    }

    /// The bridge holds a step, or is off.
    #[inline(never)]
    fn hold(&mut self, held: Pattern) -> Option<Position> {
        self.want(held.demand);
        self.pattern = held;
        None
    }

    #[inline]
    fn want(&mut self, demand: Demand) {
        if demand != self.pattern.demand {
            self.control.decide_anew();
            self.stale = true;
            (self.pattern.demand, self.pattern.short) = (demand, false);
        }
    }

    /// The demand of the sequence from standstill to closed loop.
    #[inline]
    fn sensorless(&mut self) -> Option<Position> {
        let direction = self.machine.direction();
        let state = self.machine.state();
        // While a reversal is requested no rotor is started in the old direction.
        if !self.rotor.sensorless.is_running() && self.machine.reversing() {
            return self.hold(Pattern::OFF);
        }
        let plan = self.rotor.sensorless.step(&self.coefficients.sensorless, self.now, state, direction);
        self.pattern_due = self.rotor.sensorless.due();
        if let Some(caught) = self.rotor.sensorless.take_begun() {
            self.close_loop(caught);
        }
        match plan {
            Plan::Speed(fade) => self.want(Demand::Speed(fade)),
            Plan::Level(level) => {
                self.want(Demand::Level(level));
                // A current limit that takes the kick's duty to 0 freewheels: with the bridge off the
                // winding's energy would go to the bus.
                self.pattern.short = true;
            }
            Plan::Coast => return self.hold(Pattern::OFF),
            Plan::Short => {
                return self.hold(Pattern { short: true, ..Pattern::hold(Demand::Level(0), Step::LockA) });
            }
            Plan::Hold(step, level) => return self.hold(Pattern::hold(Demand::Level(level), step)),
        }
        let rotor = self.rotor.sensorless.estimator();
        Some(Position { angle: rotor.angle(self.now), speed: rotor.speed() })
    }

    /// Closed loop begins with a rotor that was `caught` coasting, or brought up.
    #[inline(never)]
    fn close_loop(&mut self, caught: bool) {
        let (speed, bus, c) = (self.speed_forward(), self.measurement.bus_voltage(), &self.coefficients);
        if caught {
            self.control.start(&c.control, speed, bus);
        } else {
            // A light rotor may have leapt beyond what is ever asked of it: the set-point does not.
            let applied = self.control.applied(&c.control, bus);
            self.control.hand_over(speed.min(c.sensorless_mode.speed_max), applied);
        }
    }

    /// Two locks one after the other, 60 degrees apart: a rotor that rests on the dead point of the first is
    /// off that of the second.
    fn calibration_lock(&mut self) -> Pattern {
        let c = &self.coefficients.machine;
        let level = self.lock.value();
        let second = self.machine.age(self.now) >= c.lock / 2;
        Pattern::hold(Demand::Level(level), if second { HallCalibrator::LOCK } else { Step::LockB })
    }

    #[inline(never)]
    fn hall_calibration(&mut self, samples: &Samples) -> Pattern {
        let c = &self.coefficients.hall_calibration;
        let (step, calibration) = self.calibrator.step(c, samples.hall);
        if calibration != HallCalibration::Running {
            self.machine.wake(self.now);
        }
        self.calibration = calibration;
        Pattern::hold(Demand::Level(c.level), step)
    }

    #[inline]
    fn open_loop(&mut self) -> Option<Position> {
        let (field, now) = (self.rotor.field, self.now);
        self.want(Demand::Level(field.level()));
        Some(Position { angle: field.angle(now), speed: field.speed() })
    }

    /// A rotor that turns the other way at speed is left to coast: torque now would brake it through the
    /// bridge, where no current is measured. So is one whose sensors contradict themselves.
    #[inline]
    fn hall_closed_loop(&mut self) -> Option<Position> {
        let torque = self.machine.direction();
        let turns_back = torque.signed(self.rotor.hall.speed()) < 0
            && torque.signed(self.speed()) < -(self.coefficients.hall_mode.speed_min / 2);
        if turns_back || self.rotor.hall.doubtful(&self.coefficients.hall) {
            return self.hold(Pattern::OFF);
        }
        self.want(Demand::Speed(0));
        Some(Position { angle: self.rotor.hall.angle(self.now), speed: self.rotor.hall.speed() })
    }

    /// Sets what is applied. A duty of 0 leaves the bridge off: with the low side on, a turning motor would
    /// brake itself. The step acts in this period and the duty in the next, so the bridge goes off when the
    /// duty that is in force is 0, too.
    #[inline]
    pub(super) fn command(&mut self, Output { duty, rectification, .. }: Output) {
        let Pattern { demand, short, .. } = self.pattern;
        let off = matches!(demand, Demand::Off);
        if duty.to_bits() == 0 && (off || (self.applied.duty.to_bits() == 0 && !short)) {
            (self.applied.step, self.applied.commutations) = (Step::Coast, Commutations::NONE);
        }
        let c = &self.coefficients.control;
        let pulse = self.pulses.next(duty.to_bits(), c.duty_min, self.control.lost_duty(c));
        (self.applied.sample_at, self.applied.sample_mode) = self.sampling(duty.to_bits(), pulse.to_bits());
        (self.applied.duty, self.applied.rectification) = (pulse, rectification);
    }

    /// A pulse that is long enough for a valid sample (parameter 272) is sampled in its middle: from an
    /// eighth above that limit on, and down to it. A duty below the shortest pulse is given as such pulses in
    /// some periods (`pulse > duty`); these are sampled in their middle, too. All else is sampled in the
    /// off-time.
    #[inline]
    fn sampling(&self, duty: u16, pulse: u16) -> (u16, SampleMode) {
        let (begins, lasts) = self.on_time;
        let stays = pulse > duty || self.applied.sample_mode == SampleMode::OnTime;
        if pulse >= if stays { lasts } else { begins } {
            (0, SampleMode::OnTime)
        } else {
            (self.after_pulse(pulse), SampleMode::OffTime)
        }
    }

    /// Sampling instant in the off-time: the pulse ends at D/2 of the period, and duty (1/32 768) is that
    /// many 1/65 536.
    #[inline]
    pub(super) const fn after_pulse(&self, duty: u16) -> u16 {
        duty.saturating_add(self.coefficients.sample_settle)
    }
}

/// Pulses from which the on-time is sampled, and below which the off-time is, raw U1F15.
pub(super) fn sampling_limits(source: Source, c: &Coefficients) -> (u16, u16) {
    if matches!(source, Source::Halls | Source::Field) {
        // Without an eye on back-EMF there is no need to go that far.
        return (ON_ABOVE, OFF_BELOW);
    }
    let shortest = c.control.duty_min.max(ON_TIME_LEAST);
    (shortest + shortest / 8, shortest)
}

/// Shortest pulse that is sampled in its middle if parameter 272 allows less: 1 us at 10 kHz, raw U1F15.
const ON_TIME_LEAST: u16 = 327;
/// Duties at which the mode changes where nothing depends on it: 25 and 20 %, raw U1F15.
const ON_ABOVE: u16 = 32_768 / 4 + 1;
const OFF_BELOW: u16 = 32_768 / 5;
