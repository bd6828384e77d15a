//! The quiet tick: no deadline has come, and the samples lie in bands that concern no station.

use super::Drive;
use crate::motor::band::Band;
use crate::motor::clock::Instant;
use crate::motor::guard::open_phase::OpenPhase;
use crate::motor::guard::protection::ProtectionCoefficients;
use crate::motor::machine::state::State;
use crate::motor::sense::samples::{Lines, Samples};
use crate::units::Amps;
use serde::{Deserialize, Serialize};

/// Samples that concern no station.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Quiet {
    /// Bus voltages without fault, raw I16F16.
    voltage: Band,
    /// Digital inputs that signal a fault.
    lines: Lines,
    /// Bus currents without fault, raw I16F16; in states that hold a winding, those that show it connected.
    current: Band,
    /// Largest speed that is no fault, 2^-32 turn a tick.
    pub(super) overspeed: u32,
    /// The hall code when the sensors were asked last.
    pub(super) hall: u8,
}

impl Quiet {
    /// Sets the bands for `state`.
    pub(super) fn stay_within(&mut self, c: &ProtectionCoefficients, state: State) {
        let holds = matches!(state, State::RotorLock | State::OpenLoop | State::SensorlessAutoRestart);
        let currents = c.bus_current();
        let current = if holds { OpenPhase::carrying(currents) } else { currents };
        (self.voltage, self.lines, self.current) = (c.bus_voltage(), c.lines(), current);
    }

    /// The hall sensors show the same code, and no edge was captured.
    #[inline]
    pub(super) fn repeats(&self, samples: &Samples) -> bool {
        samples.hall == self.hall && samples.edges.is_empty()
    }

    /// Voltage and digital inputs are no fault.
    #[inline]
    pub(super) fn allows(&self, samples: &Samples, bus_voltage: i32) -> bool {
        self.voltage.contains(bus_voltage) && !samples.lines.intersects(self.lines)
    }
}

impl Drive {
    /// The samples concern no station.
    #[inline]
    pub(super) fn is_quiet(&self, samples: &Samples, current: Amps) -> bool {
        self.is_electrically_quiet(samples, current) && self.quiet.repeats(samples)
    }

    /// Voltage, current and digital inputs are nothing for the fault logic.
    #[inline]
    pub(super) fn is_electrically_quiet(&self, samples: &Samples, current: Amps) -> bool {
        self.quiet.allows(samples, self.measurement.bus_voltage())
            && self.quiet.current.contains(current.to_bits())
    }

    /// When the stations have to be asked again if the samples stay quiet: the earliest of their deadlines.
    #[inline]
    pub(super) fn deadline(&self) -> Instant {
        if self.watchful || self.steers {
            return self.now.next();
        }
        self.machine.due().earlier(self.rotor.hall.due()).earlier(self.pattern_due)
    }
}
