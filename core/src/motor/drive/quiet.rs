//! The quiet tick: no deadline has come, and the samples lie in bands that concern no station.

use super::Drive;
use crate::motor::band::Band;
use crate::motor::clock::Instant;
use crate::motor::guard::protection::{Protection, ProtectionCoefficients};
use crate::motor::sense::samples::{Lines, Samples};
use crate::units::Amps;
use serde::{Deserialize, Serialize};

/// Samples that concern no station, as of the last time that the stations were asked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Quiet {
    /// Bus voltages that change nothing, raw I16F16.
    voltage: Band,
    /// Bus currents that change nothing, raw I16F16.
    current: Band,
    /// Digital inputs that are looked at, and those of them that were asserted.
    watched: Lines,
    asserted: Lines,
    /// Largest speed that is no fault, 2^-32 turn a tick.
    pub(super) overspeed: u32,
    /// The hall code.
    pub(super) hall: u8,
}

impl Quiet {
    /// Takes the bands of the fault logic, and the digital inputs that it has seen.
    pub(super) fn stay_within(&mut self, protection: &Protection, c: &ProtectionCoefficients, lines: Lines) {
        self.current = c.bus_current();
        self.voltage = protection.calm_voltages(c);
        (self.watched, self.asserted) = (c.lines(), lines.intersection(c.lines()));
    }

    /// The hall sensors show the same code, and no edge was captured.
    #[inline]
    pub(super) fn repeats(&self, samples: &Samples) -> bool {
        samples.hall == self.hall && samples.edges.is_empty()
    }

    /// Voltage and digital inputs are what they were for the fault logic.
    #[inline]
    pub(super) fn allows(&self, samples: &Samples, bus_voltage: i32) -> bool {
        self.voltage.contains(bus_voltage) && samples.lines.intersection(self.watched) == self.asserted
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

    /// Time at which the stations must run again if the samples stay quiet: the earliest of their deadlines.
    #[inline]
    pub(super) fn deadline(&self) -> Instant {
        if self.watchful || self.steers {
            return self.now.next();
        }
        let (machine, protection) = (self.machine.due(), self.protection.due());
        let rotor = self.rotor.hall.due().earlier(self.rotor.compared(self.now));
        machine.earlier(protection).earlier(rotor).earlier(self.pattern_due)
    }
}
