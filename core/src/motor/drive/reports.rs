//! What the tick reports, and when.

use super::Drive;
use crate::motor::commutation::{Direction, Step};
use crate::motor::event::{Limiter, Status};
use crate::motor::samples::Samples;
use crate::motor::state::State;
use crate::units::{Amps, ElectricalAngle, ElectricalSpeed, Volts, Watts};
use serde::{Deserialize, Serialize};

/// When a status is due: every millisecond, and when state or fault word change.
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
        self.tell();
        Some(self.status())
    }

    /// What bounds the duty in the last tick.
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

    /// Set-point after saturation and ramp while a speed loop runs, signed, raw I16F16 electrical rev/s.
    pub(super) fn setpoint(&self) -> i32 {
        let closed = match self.machine.state() {
            State::HallClosedLoop => true,
            State::SensorlessClosedLoop | State::SensorlessAutoRestart => self.sensorless.is_running(),
            _ => false,
        };
        let setpoint = if closed { self.control.setpoint() } else { 0 };
        match self.machine.direction() {
            Direction::Forward => setpoint,
            Direction::Reverse => setpoint.saturating_neg(),
        }
    }

    /// Speed by back-EMF, signed, raw I16F16 electrical rev/s; 0 if nobody listens.
    pub(super) const fn speed_sensorless(&self) -> i32 {
        if self.listens { self.sensorless_speed() } else { 0 }
    }

    /// Electrical angle that the commutation uses, u32 turn.
    pub(super) const fn angle(&self) -> u32 {
        if self.listens { self.sensorless.rotor().angle() } else { self.rotor.hall_position().angle }
    }

    fn status(&self) -> Status {
        let c = &self.coefficients;
        let direction = self.machine.direction();
        let state = self.machine.state();
        let hall = self.rotor.hall_diagnostics();
        let (voltage, current) = (self.measurement.bus_voltage(), self.measurement.bus_current());
        let power = (i64::from(voltage) * i64::from(current)) >> 16;
        let (crossing, crossing_margin, crossings) = self.sensorless.why();
        Status {
            tick: self.reports.tick,
            state,
            faults: self.protection.word(),
            critical: self.protection.critical(),
            extended_code: self.protection.code(),
            command_expired: self.machine.command_expired(&c.machine),
            refusal: self.machine.refusal(),
            supply_low: voltage < c.protection.supply_low,
            direction,
            setpoint: ElectricalSpeed::from_bits(self.setpoint()),
            speed_hall: self.rotor.hall_speed(),
            speed_sensorless: ElectricalSpeed::from_bits(self.speed_sensorless()),
            angle: ElectricalAngle((self.angle() >> 16) as u16),
            sectors: self.rotor.sectors(),
            bus_voltage: Volts::from_bits(voltage),
            bus_current: Amps::from_bits(current),
            power: Watts::from_bits(crate::units::saturate64(power)),
            phase_voltage: c.measurement.phase_voltage.convert_all(&self.reports.terminals),
            duty: self.applied.duty,
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
