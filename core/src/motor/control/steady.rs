//! Steady operation: while no limit comes near, the last decision stands. A tick then only divides the wanted
//! voltage by the bus voltage and adds the duty that the dead time takes.

use super::coast::RETURN;
use super::{Control, ControlCoefficients, Demand, ModeCoefficients};
use crate::motor::band::Band;
use crate::motor::commutate::pwm::Rectification;
use crate::motor::control::limits::Limiter;
use crate::motor::sense::measurement::{BUS_MIN, Measurement};
use crate::units::{Amps, Duty};
use serde::{Deserialize, Serialize};

/// Bands within which every limit lets the wanted voltage pass, so that the last decision stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Steady {
    /// The bridge is off, and stays so.
    off: bool,
    /// Bus voltages, raw I16F16.
    voltage: Band,
    /// Largest bus current of one period, raw I16F16.
    current: i32,
    /// Commanded duties, dead time included, raw U1F15. The band is so narrow that the slew limit lets any
    /// of them follow any other.
    duty: Band,
}

impl Steady {
    /// No decision stands: the next tick decides.
    pub(super) const NONE: Self = Self { off: false, voltage: Band::EMPTY, current: 0, duty: Band::EMPTY };
    /// The bridge is off.
    pub(super) const OFF: Self = Self { off: true, ..Self::NONE };
}

impl Default for Steady {
    fn default() -> Self {
        Self::NONE
    }
}

impl Control {
    /// Applies the last decision to this tick's bus voltage. Returns false, and changes nothing, if a limit
    /// may have come near: the tick must decide.
    #[inline]
    pub fn repeat_decision(
        &mut self,
        c: &ControlCoefficients,
        bus_current: Amps,
        measurement: &Measurement,
    ) -> bool {
        let steady = &self.steady;
        let within = steady.voltage.contains(measurement.bus_voltage())
            && bus_current.to_bits() <= steady.current
            && measurement.bus_current() >= RETURN;
        if !within {
            return steady.off;
        }
        // The `lost_duty` of synchronous rectification, the only one in which a decision stands.
        let duty = measurement.duty_within(self.wanted) as i32 + i32::from(c.dead_time);
        let fits = steady.duty.contains(duty);
        if fits {
            self.output.duty = Duty::from_bits_within(duty as u16);
        }
        fits
    }

    /// Finds, after a decision, the bands within which it stands until the loops have run again. `duties`:
    /// the duties at which the currents are sampled in the same way as now.
    pub fn find_steady(
        &mut self,
        c: &ControlCoefficients,
        mode: &ModeCoefficients,
        demand: Demand,
        bus_voltage: i32,
        duties: Band,
    ) {
        let own = match demand {
            Demand::Speed(0) => Limiter::Speed,
            Demand::Level(_) if !c.levels_of_bus => Limiter::Fixed,
            _ => return,
        };
        let settled = self.output.limiter == own
            && self.output.rectification == Rectification::Synchronous
            && self.current.waits_at(self.wanted)
            && self.catching == 0
            && self.wanted > 0;
        let duty = i32::from(self.output.duty.to_bits());
        let (slew, least) = (i32::from(c.slew), c.duty_min.max(c.dead_time.saturating_add(1)));
        let first = duty - slew / 2;
        let duties = duties.within(first.max(least.into()), (first + slew - 1).min(mode.duty_max.into()));
        if settled && duties.contains(duty) {
            // Half way down to what is asked for: the speed loop may ask for a little more in its next turn.
            let low = bus_voltage - (bus_voltage - self.wanted) / 2;
            self.steady = Steady {
                off: false,
                voltage: Band::new(low.max(BUS_MIN + 1), c.bus_guard),
                // The bound by phase current falls with the duty.
                current: self.limit.bound(duties.low() as u16).0,
                duty: duties,
            };
        }
    }

    /// Takes the speed loop's new output. The bands stay if the current limiter would let the new voltage
    /// pass; its integrator then waits at that voltage.
    pub(super) fn renew_steady(&mut self, c: &ControlCoefficients, bus_current: Amps) {
        let (voltage, rise) = (self.speed_voltage, self.speed_voltage - self.wanted);
        let room = self.steady.current - bus_current.to_bits();
        let passes = room >= 0 && (rise <= 0 || c.current.proportional.apply(room) >= i64::from(rise));
        let within = 0 < voltage && voltage < self.steady.voltage.low();
        if within && passes {
            self.wanted = voltage;
            self.current.wait(voltage);
        } else {
            self.decide_anew();
        }
    }
}
