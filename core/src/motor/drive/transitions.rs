//! Changes of the state, and the set-up that each transition does.

use super::Drive;
use crate::motor::guard::fault::Cause;
use crate::motor::machine::event::HallCalibration;
use crate::motor::machine::state::State;
use crate::motor::machine::{Change, Inputs};
use crate::motor::modes::{HALL, OPEN_LOOP, OTHER_SOURCE, SENSORLESS};
use crate::motor::ramp::Ramp;
use crate::motor::sense::samples::Samples;

impl Drive {
    /// True if the state has changed.
    #[inline(never)]
    pub(super) fn advance_state(&mut self, critical: bool, samples: &Samples) -> bool {
        self.rotor.renew(self.now);
        let stands = self.rotor.may_stand();
        let c = &self.coefficients;
        if OTHER_SOURCE && c.machine.other_source && self.machine.state() == State::SensorlessClosedLoop {
            self.machine.offer_other_source(self.rotor.halls_work(c, self.machine.direction()));
        }
        !self.machine.rests(self.now, critical, stands) && self.change_state(critical, stands, samples)
    }

    /// Judges the hall sensors that run the motor by the terminals, once after each crossing, and whenever
    /// they contradict themselves (parameter 308).
    pub(super) fn compare_sources(&mut self, irregular: bool) {
        let compares = self.rotor.is_to_compare(self.now);
        if self.rotor.is_accompanied() && (compares || irregular) {
            let (c, torque) = (&self.coefficients, self.machine.direction());
            let fail = self.rotor.halls_fail(c, self.now, torque, compares);
            self.machine.offer_other_source(fail);
            self.watchful |= fail;
        }
    }

    /// Speed 0, as the running mode judges it.
    #[inline]
    fn stopped(&self, stands: bool) -> bool {
        match self.machine.state() {
            // A calibration's field is slow enough to count as standing.
            State::OpenLoop if !self.machine.is_sensorless() => {
                self.machine.calibrating() || self.rotor.field.stopped()
            }
            // A kick may take as long as open loop and the time-out together. It begins late if the rotor had
            // to be braked.
            State::SensorlessClosedLoop => match self.rotor.sensorless.start_age(self.now) {
                Some(age) => {
                    let c = &self.coefficients;
                    age > c.machine.open_loop.saturating_add(c.sensorless.timeout >> 16)
                }
                None => stands,
            },
            _ => stands,
        }
    }

    #[inline(never)]
    fn change_state(&mut self, critical: bool, stands: bool, samples: &Samples) -> bool {
        let stopped = self.stopped(stands);
        let unhealthy = self.health.self_test_failed || !self.health.store_faults.is_empty();
        let inputs = Inputs {
            critical,
            unhealthy,
            causes_gone: self.protection.causes_gone(),
            stopped,
            calibrated: matches!(self.calibration, HallCalibration::Done(_) | HallCalibration::Failed),
            parameters_fit: self.parameters_fit,
        };
        let change = self.machine.advance(&self.coefficients.machine, self.now, &inputs);
        if let Some(change) = change {
            self.protection.wake(self.now);
            self.reports.stirred = true;
            self.enter(change, samples);
            self.refresh();
            self.pattern_due = self.now;
        }
        change.is_some()
    }

    /// Sets up the state that a transition leads to.
    fn enter(&mut self, change: Change, samples: &Samples) {
        if change.timed_out {
            self.protection.raise_timeout();
        }
        match (change.row.from, change.row.to) {
            (State::HallClosedLoop, State::SensorlessClosedLoop) => {
                self.protection.tell(Some(Cause::HallsGivenUp));
            }
            (State::SensorlessClosedLoop, State::HallClosedLoop) => {
                self.protection.tell(Some(Cause::BackEmfGivenUp));
            }
            (State::Standby, to) if to.is_driving() => self.protection.tell(None),
            _ => {}
        }
        let c = &self.coefficients;
        let direction = self.machine.direction();
        let bus = self.measurement.bus_voltage();
        match change.row.to {
            // Faults that were seen while supplies came up and have gone are dropped; those still present are
            // latched again in the next tick.
            State::Standby if !change.row.from.is_driving() => self.protection.acknowledge(),
            State::Fault if change.row.from == State::Initialization => {
                self.protection.raise_boot_failure(self.health);
            }
            State::RotorLock => {
                self.lock = Ramp::default();
                self.control.start(&c.control, 0, bus);
                if self.machine.calibrating() {
                    self.calibration = HallCalibration::Running;
                } else if SENSORLESS {
                    self.rotor.sensorless.start(self.now, true);
                }
            }
            State::OpenLoop if self.machine.is_sensorless() => {}
            State::SensorlessClosedLoop if SENSORLESS && self.rotor.sensorless.is_running() => {
                let brought_up = change.row.from == State::OpenLoop && !self.rotor.sensorless.is_caught();
                let initial = c.control.volts(c.control.initial_level, bus);
                if brought_up && initial > 0 {
                    self.control.hand_over(self.control.setpoint(), initial);
                }
            }
            State::SensorlessAutoRestart if SENSORLESS => {
                self.rotor.sensorless.start(self.now, false);
                self.control.start(&c.control, 0, bus);
            }
            State::OpenLoop => {
                if self.machine.calibrating() {
                    self.calibrator.start(samples.hall);
                } else if OPEN_LOOP {
                    self.rotor.field.start(&c.open_loop, self.now, 0, direction);
                    self.control.start(&c.control, 0, bus);
                }
            }
            State::HallClosedLoop if HALL => {
                let speed = self.rotor.hall_speed(c, self.now).to_bits().saturating_mul(direction.sign());
                self.control.start(&c.control, speed.min(c.hall_mode.speed_max).max(0), bus);
                if OTHER_SOURCE && c.machine.other_source {
                    self.rotor.sensorless.accompany(self.now, self.rotor.hall.angle(self.now), direction);
                }
            }
            _ => {}
        }
        if !change.row.to.is_driving() || !change.row.from.is_driving() {
            self.protection.forget_episode();
            self.open_phase.reset();
            self.commutator.reset();
        }
        if !change.row.to.is_driving() {
            if SENSORLESS {
                self.rotor.sensorless.end_start(self.now);
            }
            if self.calibration == HallCalibration::Running {
                self.calibration = HallCalibration::Failed;
            }
        }
    }
}
