//! The reports of the tick, and when they are due.

use super::Drive;
use crate::motor::commutate::commutation::{Direction, Step};
use crate::motor::machine::event::{Limiter, Status};
use crate::motor::machine::state::State;
use crate::motor::rotor::Source;
use crate::motor::sense::samples::Samples;
use crate::units::{Amps, ElectricalAngle, ElectricalSpeed, Volts, Watts};
use serde::{Deserialize, Serialize};

/// Timing of status reports: every millisecond, and when the state or the fault word changes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Reports {
    state: State,
    faults: u32,
    /// Something happened that may have changed one of them.
    pub(super) stirred: bool,
    due: bool,
    /// The tick that is to be reported, and its terminals.
    tick: u64,
    terminals: [u16; 3],
}

impl Drive {
    /// The report of the last step, if one is due: every millisecond, and when state or fault word change.
    pub fn poll_status(&mut self) -> Option<Status> {
        if !core::mem::take(&mut self.reports.due) {
            return None;
        }
        Some(self.status())
    }

    /// The limit that bounded the duty in the last tick.
    pub fn limiter(&self) -> Limiter {
        match self.control.output().limiter {
            Limiter::Return => Limiter::Return,
            _ if self.applied.step == Step::Coast => Limiter::Off,
            limiter => limiter,
        }
    }

    /// Exact state.
    pub const fn state(&self) -> State {
        self.machine.state()
    }

    /// Something may have changed.
    #[inline(never)]
    pub(super) fn find_change(&mut self, samples: &Samples) {
        let (state, faults) = (self.machine.state(), self.protection.word().bits());
        self.reports.stirred = false;
        if state != self.reports.state || faults != self.reports.faults {
            self.make_due(samples);
        }
    }

    /// This tick is reported.
    #[inline(never)]
    pub(super) fn make_due(&mut self, samples: &Samples) {
        let (state, faults) = (self.machine.state(), self.protection.word().bits());
        let (tick, terminals) = (samples.tick, samples.phase_voltage);
        let stirred = self.reports.stirred;
        self.reports = Reports { state, faults, stirred, due: true, tick, terminals };
    }

    /// Set-point after saturation and ramp while a speed loop or the open-loop field runs, signed, raw I16F16
    /// electrical rev/s.
    pub(super) fn setpoint(&self) -> i32 {
        let closed = match self.machine.state() {
            State::HallClosedLoop => true,
            State::SensorlessClosedLoop | State::SensorlessAutoRestart => self.rotor.sensorless.is_running(),
            _ => false,
        };
        let setpoint = match closed {
            true => self.control.setpoint(),
            false if self.rotor.source() == Source::Field => self.rotor.field.frequency(),
            false => 0,
        };
        match self.machine.direction() {
            Direction::Forward => setpoint,
            Direction::Reverse => setpoint.saturating_neg(),
        }
    }

    /// Speed without hall sensors, signed, raw I16F16 electrical rev/s: by back-EMF, or that of the open-loop
    /// field; 0 if neither is there.
    pub(super) fn speed_sensorless(&self) -> i32 {
        self.rotor.speed_without_halls(&self.coefficients, self.now, self.machine.direction())
    }

    /// The rotor may turn while [`Status::sectors`] stands: no hall sensor shows it, and no commutation leads
    /// or follows it.
    fn loses_sight(&self) -> bool {
        // The position is counted from the end of Initialization.
        let counts = self.machine.state() != State::Initialization && self.rotor.is_mute();
        counts && !self.rotor.is_led() && !self.rotor.stands_still(&self.coefficients, self.now)
    }

    fn status(&self) -> Status {
        let c = &self.coefficients;
        let direction = self.machine.direction();
        let state = self.machine.state();
        let hall = self.rotor.hall.diagnostics();
        let (voltage, current) = (self.measurement.bus_voltage(), self.measurement.bus_current());
        let power = (i64::from(voltage) * i64::from(current)) >> 16;
        let (crossing, crossing_margin, crossings) = self.rotor.sensorless.why();
        Status {
            tick: self.reports.tick,
            state,
            faults: self.protection.word(),
            critical: self.protection.critical(),
            extended_code: self.protection.code(),
            command_expired: self.machine.command_expired(&c.machine, self.now),
            refusal: self.machine.refusal(),
            supply_low: voltage < c.protection.supply_low,
            direction,
            setpoint: ElectricalSpeed::from_bits(self.setpoint()),
            speed_hall: self.rotor.hall_speed(c, self.now),
            speed_sensorless: ElectricalSpeed::from_bits(self.speed_sensorless()),
            angle: ElectricalAngle((self.angle() >> 16) as u16),
            sectors: self.rotor.sectors(),
            standstill: self.rotor.stands_still(c, self.now),
            unseen: self.loses_sight(),
            bus_voltage: Volts::from_bits(voltage),
            bus_current: Amps::from_bits(current),
            power: Watts::from_bits(crate::units::saturate64(power)),
            phase_voltage: c.measurement.phase_voltage.convert_all(&self.reports.terminals),
            duty: self.control.output().duty,
            limiter: self.limiter(),
            hall_invalid: hall.invalid,
            hall_jumps: hall.jumps,
            hall_calibration: self.calibration,
            crossing,
            crossing_margin,
            crossings,
        }
    }
}
