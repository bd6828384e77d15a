//! The quiet tick: no deadline has come, and the samples lie in bands that concern no station.

use super::Drive;
use crate::motor::clock::Instant;
use crate::motor::sense::samples::Samples;
use crate::units::Amps;
use serde::{Deserialize, Serialize};

/// What the stations have seen when they were asked last, and by which a quiet tick is told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Quiet {
    /// Least bus current that is nothing for the detector of an open phase, raw I16F16.
    pub(super) least_current: i32,
    /// Largest speed that is no fault, 2^-32 turn a tick.
    pub(super) overspeed: u32,
    /// The hall code.
    pub(super) hall: u8,
}

impl Quiet {
    /// The hall sensors show the same code, and no edge was captured.
    #[inline]
    pub(super) fn repeats(&self, samples: &Samples) -> bool {
        samples.hall == self.hall && samples.edges.is_empty()
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
        let (voltage, current) = (self.measurement.bus_voltage(), current.to_bits());
        self.protection.stays_calm(voltage, current, samples.lines) && current >= self.quiet.least_current
    }

    /// When the stations have to be asked again if the samples stay quiet: the earliest of their deadlines.
    #[inline]
    pub(super) fn deadline(&self) -> Instant {
        if self.watchful || self.steers {
            return self.now.next();
        }
        let (machine, protection) = (self.machine.due(), self.protection.due());
        machine.earlier(protection).earlier(self.rotor.hall.due()).earlier(self.pattern_due)
    }
}
