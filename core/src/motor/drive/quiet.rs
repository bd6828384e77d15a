//! What a quiet tick is: no deadline has come, and the samples lie where they concern no station.

use super::Drive;
use crate::motor::band::Band;
use crate::motor::clock::Instant;
use crate::motor::open_phase::OpenPhase;
use crate::motor::protection::ProtectionCoefficients;
use crate::motor::samples::{Lines, Samples};
use crate::motor::state::State;
use crate::units::Amps;
use serde::{Deserialize, Serialize};

/// Samples that concern no station.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Quiet {
    /// Bus voltages that are no fault, raw I16F16, and digital inputs that are one.
    voltage: Band,
    lines: Lines,
    /// Bus currents that are no fault, raw I16F16, and where a winding is held that carries one.
    current: Band,
    /// Largest speed that is no fault, 2^-32 turn a tick.
    pub(super) turns: u32,
    /// The hall code that lasts.
    pub(super) hall: u8,
}

impl Quiet {
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
}

bitflags::bitflags! {
    /// What a tick brings that concerns a station.
    #[derive(Clone, Copy)]
    pub(super) struct News: u8 {
        /// Voltage, current or digital inputs for the fault logic.
        const ELECTRICAL = 1 << 0;
        /// Another code of the hall sensors, or captured edges.
        const HALL = 1 << 1;
        /// The terminals have shown where the rotor is.
        const ROTOR = 1 << 2;
    }
}

impl Drive {
    /// What the samples bring.
    #[inline]
    pub(super) fn news(&self, samples: &Samples, current: Amps) -> News {
        let quiet = &self.quiet;
        let electrical = quiet.allows(samples, self.measurement.bus_voltage())
            && quiet.current.contains(current.to_bits());
        let hall = samples.hall == quiet.hall && samples.edges.is_empty();
        let mut news = News::empty();
        news.set(News::ELECTRICAL, !electrical);
        news.set(News::HALL, !hall);
        news
    }

    /// When the stations have to be asked again if the samples stay quiet: the earliest of their deadlines.
    #[inline]
    pub(super) fn deadline(&self) -> Instant {
        if self.watchful || self.steers {
            return self.now.next();
        }
        let due = self.machine.due().earlier(self.rotor.due());
        if !self.machine.state().is_driving() {
            return due;
        }
        let due = due.earlier(self.commutation);
        if self.listens { due.earlier(self.sensorless.due()) } else { due }
    }
}
