//! Ease: while nothing comes near a limit, control is the division by the bus voltage.

use super::coast::RETURN;
use super::{Control, ControlCoefficients, Demand, ModeCoefficients};
use crate::motor::band::Band;
use crate::motor::limits::Limiter;
use crate::motor::measurement::{BUS_MIN, Measurement};
use crate::motor::pwm::Rectification;
use crate::units::{Amps, Duty};
use serde::{Deserialize, Serialize};

/// Between these every limit would let the speed loop's voltage pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Ease {
    /// Bus voltages, raw I16F16.
    voltage: Band,
    /// Largest bus current of one period, raw I16F16.
    current: i32,
    /// Duties with dead time, raw U1F15: few enough that the slew limit lets any follow any other.
    duty: Band,
}

impl Ease {
    /// Nowhere.
    pub(super) const NONE: Self = Self { voltage: Band::EMPTY, current: 0, duty: Band::EMPTY };
}

impl Default for Ease {
    fn default() -> Self {
        Self::NONE
    }
}

impl Control {
    /// The tick at ease. False if something may come near a limit; then nothing is changed.
    #[inline]
    pub(super) fn divides(
        &mut self,
        c: &ControlCoefficients,
        demand: Demand,
        bus_current: Amps,
        measurement: &Measurement,
    ) -> bool {
        let ease = &self.ease;
        let at_ease = ease.voltage.contains(measurement.bus_voltage())
            && bus_current.to_bits() <= ease.current
            && measurement.bus_current() >= RETURN
            && matches!(demand, Demand::Speed { fade: 0, .. });
        if !at_ease {
            return false;
        }
        let duty = measurement.duty_within(self.speed_voltage) as i32 + i32::from(c.dead_time);
        let fits = ease.duty.contains(duty);
        if fits {
            self.output.duty = Duty::from_bits_within(duty as u16);
        }
        fits
    }

    /// After a decision: where none will be needed until the loops have had another turn.
    pub(super) fn ease(&mut self, c: &ControlCoefficients, mode: &ModeCoefficients, bus_voltage: i32) {
        let settled = self.output.limiter == Limiter::Speed
            && self.output.rectification == Rectification::Synchronous
            && self.current.waits_at(self.speed_voltage)
            && self.catching == 0
            && self.speed_voltage > 0;
        let duty = i32::from(self.output.duty.to_bits());
        let (slew, least) = (i32::from(c.slew), c.duty_min.max(c.dead_time.saturating_add(1)));
        let first = duty - slew / 2;
        let duties = Band::new(first.max(least.into()), (first + slew - 1).min(mode.duty_max.into()));
        if settled && duties.contains(duty) {
            // Half way down to what the loop asks for.
            let low = bus_voltage - (bus_voltage - self.speed_voltage) / 2;
            self.ease = Ease {
                voltage: Band::new(low.max(BUS_MIN + 1), c.bus_guard),
                // The bound by phase current falls with the duty.
                current: self.limit.bound(duties.low() as u16).0,
                duty: duties,
            };
        }
    }
}
