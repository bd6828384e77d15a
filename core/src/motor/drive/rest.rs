//! When the stations are asked again: at the earliest deadline that one of them has set, or as soon as a sample leaves the bands within which it
//! concerns none of them.

use super::Drive;
use crate::motor::band::Band;
use crate::motor::open_phase::OpenPhase;
use crate::motor::protection::ProtectionCoefficients;
use crate::motor::samples::{Lines, Samples};
use crate::motor::state::State;
use crate::units::Amps;
use serde::{Deserialize, Serialize};

/// For how long nobody is asked, and the bands of samples that leave it so.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Rest {
    /// Ticks that may pass before the stations are asked again, and those that have passed since they were.
    granted: u32,
    passed: u32,
    /// Bus voltages that are no fault, raw I16F16, and digital inputs that are one.
    voltage: Band,
    lines: Lines,
    /// Bus currents that are no fault, raw I16F16, and where a winding is held that carries one.
    current: Band,
    /// The hall code that lasts.
    pub(super) hall: u8,
}

impl Rest {
    /// What goes unnoticed in `state`.
    pub(super) fn stay_within(&mut self, c: &ProtectionCoefficients, state: State) {
        let holds = matches!(state, State::RotorLock | State::OpenLoop | State::SensorlessAutoRestart);
        let currents = c.bus_current();
        let current = if holds { OpenPhase::carrying(currents) } else { currents };
        (self.voltage, self.lines, self.current) = (c.bus_voltage(), c.lines(), current);
    }

    /// Voltage and digital inputs are no fault.
    #[inline]
    pub(super) fn allows(&self, samples: &Samples, bus_voltage: i32) -> bool {
        self.voltage.contains(bus_voltage) && !samples.lines.intersects(self.lines)
    }

    /// The stations need not be asked for so many ticks.
    #[inline]
    pub(super) const fn grant(&mut self, ticks: u32) {
        self.granted = ticks;
    }

    /// The next tick asks every station.
    #[inline]
    pub(super) const fn end(&mut self) {
        self.granted = 0;
    }

    /// Ticks since the stations were asked.
    #[inline]
    pub(super) const fn passed(&self) -> u32 {
        self.passed
    }
}

impl Drive {
    /// A quiet tick: nothing is due, and what it brings concerns no station.
    #[inline(always)]
    pub(super) fn rests(&mut self, samples: &Samples, current: Amps) -> bool {
        let (c, bus, torque) =
            (&self.coefficients.sensorless, self.measurement.bus_voltage(), self.machine.direction());
        let heard = self.listens && self.sensorless.hears(c, samples, bus, &self.applied, torque);
        let rest = &mut self.rest;
        rest.passed = rest.passed.wrapping_add(1);
        let quiet = rest.passed <= rest.granted
            && rest.allows(samples, self.measurement.bus_voltage())
            && rest.current.contains(current.to_bits())
            && samples.hall == rest.hall
            && samples.edges.is_empty()
            && !heard;
        if quiet {
            self.open_phase.count(current);
        }
        quiet
    }

    /// The stations are told of the ticks that have passed.
    #[inline]
    pub(super) fn pass_time(&mut self) {
        let ticks = core::mem::take(&mut self.rest.passed);
        self.rest.granted = self.rest.granted.saturating_sub(ticks);
        self.machine.pass(ticks);
        self.rotor.pass(ticks);
        self.commutator.pass(ticks);
        if self.listens {
            self.sensorless.pass(ticks);
        }
    }

    /// For how many ticks from now no station has more to do than to let time pass. `stands`: the rotor is not known to turn.
    #[inline]
    pub(super) fn due(&self, stands: bool) -> u32 {
        let own = match self.machine.state() {
            State::HallClosedLoop if stands || self.rotor.hall_mute() => 0,
            State::HallClosedLoop => self.commutator.rest(),
            state => self.due_without_sensors(state),
        };
        own.min(self.machine.rest()).min(self.rotor.rest())
    }

    #[inline]
    fn due_without_sensors(&self, state: State) -> u32 {
        let c = &self.coefficients;
        if self.open_phase.is_resting() {
            return 0;
        }
        if self.turns_field() {
            return self.commutator.rest().min(self.rotor.field_rest(c, !self.machine.reversing()));
        }
        if self.sensorless_fault().is_some() {
            return 0;
        }
        let (present, torque) = (self.pattern.step, self.machine.direction());
        let own = self.sensorless.rest(&c.sensorless, state, present, torque);
        if self.sensorless.is_running() && state.is_driving() { own.min(self.commutator.rest()) } else { own }
    }
}
