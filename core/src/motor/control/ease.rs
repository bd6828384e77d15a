//! Ease: while nothing comes near a limit, control is the division by the bus voltage.

use super::coast::RETURN;
use super::{Control, ControlCoefficients, Demand, ModeCoefficients};
use crate::motor::band::Band;
use crate::motor::commutate::pwm::Rectification;
use crate::motor::control::limits::Limiter;
use crate::motor::sense::measurement::{BUS_MIN, Measurement};
use crate::units::{Amps, Duty};
use serde::{Deserialize, Serialize};

/// Between these every limit would let the wanted voltage pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Ease {
    /// The bridge is off, and stays so.
    off: bool,
    /// Bus voltages, raw I16F16.
    voltage: Band,
    /// Largest bus current of one period, raw I16F16.
    current: i32,
    /// Duties with dead time, raw U1F15: few enough that the slew limit lets any follow any other.
    duty: Band,
}

impl Ease {
    /// Nowhere.
    pub(super) const NONE: Self = Self { off: false, voltage: Band::EMPTY, current: 0, duty: Band::EMPTY };
    /// The bridge is off.
    pub(super) const OFF: Self = Self { off: true, ..Self::NONE };
}

impl Default for Ease {
    fn default() -> Self {
        Self::NONE
    }
}

impl Control {
    /// The tick at ease. False if something may come near a limit; then nothing is changed, and the tick is
    /// to be decided.
    #[inline]
    pub fn divides(&mut self, c: &ControlCoefficients, bus_current: Amps, measurement: &Measurement) -> bool {
        let ease = &self.ease;
        let within = ease.voltage.contains(measurement.bus_voltage())
            && bus_current.to_bits() <= ease.current
            && measurement.bus_current() >= RETURN;
        if !within {
            return ease.off;
        }
        let duty = measurement.duty_within(self.wanted) as i32 + i32::from(c.dead_time);
        let fits = ease.duty.contains(duty);
        if fits {
            self.output.duty = Duty::from_bits_within(duty as u16);
        }
        fits
    }

    /// After a decision: where none will be needed until the loops have had another turn. `duties` are
    /// sampled like this one.
    pub fn ease(
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
            self.ease = Ease {
                off: false,
                voltage: Band::new(low.max(BUS_MIN + 1), c.bus_guard),
                // The bound by phase current falls with the duty.
                current: self.limit.bound(duties.low() as u16).0,
                duty: duties,
            };
        }
    }

    /// The speed loop has had its turn. The ease lasts if this tick's decision would let the new voltage pass
    /// the current limiter, which waits there then.
    pub(super) fn keep_ease(&mut self, c: &ControlCoefficients, bus_current: Amps) {
        let (voltage, rise) = (self.speed_voltage, self.speed_voltage - self.wanted);
        let room = self.ease.current - bus_current.to_bits();
        let passes = room >= 0 && (rise <= 0 || c.current.proportional.apply(room) >= i64::from(rise));
        let within = 0 < voltage && voltage < self.ease.voltage.low();
        if within && passes {
            self.wanted = voltage;
            self.current.wait(voltage);
        } else {
            self.beware();
        }
    }
}
