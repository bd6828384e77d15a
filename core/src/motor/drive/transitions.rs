//! When the state changes, and what a transition sets up.

use super::Drive;
use crate::motor::event::HallCalibration;
use crate::motor::machine::{Change, Inputs};
use crate::motor::ramp::Ramp;
use crate::motor::samples::Samples;
use crate::motor::state::State;

impl Drive {
    #[inline]
    pub(super) fn advance_state(&mut self, critical: bool, samples: &Samples) {
        let stopped = match self.machine.state() {
            State::HallClosedLoop => self.rotor.hall_stopped(&self.coefficients),
            // A calibration's field is slow enough to count as standing.
            State::OpenLoop if self.machine.is_sensorless() => !self.sensorless.is_running(),
            State::OpenLoop => self.machine.calibrating() || self.rotor.field_stopped(),
            // What was not brought up by the end of open loop (T34) has the time-out to show a crossing.
            State::SensorlessClosedLoop if self.sensorless.is_kicking() => {
                self.machine.age() << 16 > self.coefficients.sensorless.timeout
            }
            State::SensorlessClosedLoop | State::SensorlessAutoRestart => !self.sensorless.is_running(),
            _ => true,
        };
        let unhealthy = self.health.self_test_failed || !self.health.store_faults.is_empty();
        if !self.machine.rests(&self.coefficients.machine, critical, stopped, unhealthy) {
            self.change_state(critical, stopped, unhealthy, samples);
        }
    }

    #[inline(never)]
    fn change_state(&mut self, critical: bool, stopped: bool, unhealthy: bool, samples: &Samples) {
        let inputs = Inputs {
            critical,
            unhealthy,
            causes_gone: self.protection.causes_gone(),
            stopped,
            calibrated: matches!(self.calibration, HallCalibration::Done(_) | HallCalibration::Failed),
            parameters_fit: self.parameters_fit,
        };
        if let Some(change) = self.machine.advance(&self.coefficients.machine, &inputs) {
            self.protection.wake();
            self.reports.stirred = true;
            self.enter(change, samples);
            self.settle();
            self.heed_speed();
        }
    }

    /// What a transition sets up.
    fn enter(&mut self, change: Change, samples: &Samples) {
        if change.timed_out {
            self.protection.raise_timeout();
        }
        let c = &self.coefficients;
        let direction = self.machine.direction();
        let initial = self.volts(c.control.initial_level);
        match change.row.to {
            // What was seen while supplies came up and has gone is nobody's fault; what has not is latched again.
            State::Standby if !change.row.from.is_driving() => self.protection.acknowledge(),
            State::Fault if change.row.from == State::Initialization => {
                self.protection.raise_boot_failure(self.health);
            }
            State::RotorLock => {
                self.lock = Ramp::default();
                self.control.start(&c.control, 0, initial);
                if self.machine.calibrating() {
                    self.calibration = HallCalibration::Running;
                } else {
                    self.sensorless.start(true);
                }
            }
            State::OpenLoop if self.machine.is_sensorless() => {}
            State::SensorlessClosedLoop if self.sensorless.is_running() => {
                let brought_up = change.row.from == State::OpenLoop && !self.sensorless.is_caught();
                if brought_up && initial > 0 {
                    self.control.hand_over(self.control.setpoint(), initial);
                }
            }
            State::SensorlessAutoRestart => {
                self.sensorless.start(false);
                self.control.start(&c.control, 0, initial);
            }
            State::OpenLoop => {
                if self.machine.calibrating() {
                    self.calibrator.start(samples.hall);
                } else {
                    self.rotor.start_open_loop(0, direction);
                    self.control.start(&c.control, 0, initial);
                }
            }
            State::HallClosedLoop => {
                let speed = self.rotor.hall_speed().to_bits().saturating_mul(direction.sign());
                self.control.start(&c.control, speed.min(c.hall_mode.speed_max).max(0), initial);
            }
            _ => {}
        }
        if !change.row.to.is_driving() || !change.row.from.is_driving() {
            self.protection.forget_episode();
            self.open_phase.reset();
            self.commutator.reset();
        }
        if !change.row.to.is_driving() {
            self.sensorless.end_start();
            if self.calibration == HallCalibration::Running {
                self.calibration = HallCalibration::Failed;
            }
        }
    }
}
