//! The settled loop: as long as nothing comes near a limit, control is the division by the bus voltage.

use super::coast::RETURN;
use super::{Control, ControlCoefficients, MOTORING};
use crate::motor::limits::Limiter;
use crate::motor::measurement::{Measured, Measurement};
use crate::motor::pwm::Rectification;
use crate::units::Duty;

impl Control {
    /// One tick of a settled closed loop, in full: the next duty, if nothing comes near a limit. Else nothing is changed, and [`step`](Self::step) decides.
    #[inline]
    pub fn cruise(
        &mut self,
        c: &ControlCoefficients,
        duty_max: u16,
        measured: &Measured,
        measurement: &Measurement,
    ) -> Option<Duty> {
        let (bus, filtered) = (measured.bus_voltage.to_bits(), measured.bus_current_filtered.to_bits());
        let before = self.output.duty.to_bits();
        let draws = (filtered >= RETURN && bus <= c.bus_guard) || filtered >= MOTORING;
        if !self.settled || !draws || measured.bus_current.to_bits() > self.limit.bound(before).0 {
            return None;
        }
        let duty = measurement.duty(self.speed_voltage).to_bits().saturating_add(c.dead_time);
        let plain = duty >= c.duty_min && duty > c.dead_time && duty <= duty_max;
        if !plain || duty.abs_diff(before) >= c.slew {
            return None;
        }
        self.output.duty = Duty::from_bits(duty);
        Some(self.output.duty)
    }

    /// What [`cruise`](Self::cruise) builds on.
    #[inline]
    pub(super) fn is_settled(&self, c: &ControlCoefficients) -> bool {
        self.output.limiter == Limiter::Speed
            && self.output.rectification == Rectification::Synchronous
            && self.output.duty.to_bits() >= c.duty_min
            && self.current.waits_at(self.speed_voltage)
            && self.catching == 0
            && self.speed_voltage > 0
    }

    /// Further down the current limiter waits there. Further up it does so if its proportional part would let that `rise` pass, which is at least what
    /// it would be at a duty of 1.
    pub(super) fn may_follow(&self, c: &ControlCoefficients, rise: i32, bus_current: i32) -> bool {
        let room = self.limit.bound(self.output.duty.to_bits()).0.saturating_sub(bus_current);
        rise <= 0 || (room > 0 && c.current.proportional.apply(room) >= i64::from(rise))
    }
}
