//! The settled loop: as long as nothing comes near a limit, control is the division by the bus voltage.

use super::coast::RETURN;
use super::{Control, ControlCoefficients};
use crate::motor::band::Band;
use crate::motor::limits::Limiter;
use crate::motor::measurement::Measurement;
use crate::motor::pwm::Rectification;
use crate::units::{Amps, Duty};

/// Bus voltages and bus currents (raw I16F16) and duties (raw U1F15) between which nothing happens.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Lane {
    /// Bus voltages.
    pub voltage: Band,
    /// Bus currents of one period.
    pub current: Band,
    /// Duties.
    pub duty: Band,
}

impl Control {
    /// One tick of a settled closed loop on a bus above 4 V and not above `bus_guard`, in full: the next duty, if it lies in `duties` and nothing
    /// comes near a limit. Else nothing is changed, and
    /// [`step`](Self::step) decides.
    #[inline]
    pub fn cruise(
        &mut self,
        c: &ControlCoefficients,
        duties: Band,
        bus_current: Amps,
        measurement: &Measurement,
    ) -> Option<Duty> {
        let filtered = measurement.bus_current();
        let before = self.output.duty.to_bits();
        if !self.settled || filtered < RETURN || bus_current.to_bits() > self.limit.bound(before).0 {
            return None;
        }
        let duty = measurement.plain_duty(self.speed_voltage)? as i32 + i32::from(c.dead_time);
        if !duties.contains(duty) || duty.abs_diff(before.into()) >= u32::from(c.slew) {
            return None;
        }
        self.output.duty = Duty::from_bits_within(duty as u16);
        Some(self.output.duty)
    }

    /// Where `within` limits a settled loop finds none near: there [`glide`](Self::glide) is all of [`cruise`](Self::cruise), as long as the ratings stay
    /// and the speed loop [`keeps`](Self::keeps) to it. Nowhere, if the last duty is none of it.
    pub fn lane(&self, c: &ControlCoefficients, within: &Lane, bus_voltage: i32) -> Lane {
        let duty = i32::from(self.output.duty.to_bits());
        // Any two of these differ by less than the slew limit.
        let slew = i32::from(c.slew);
        let first = duty - slew / 2;
        let duties = within.duty.within(first, first + slew - 1);
        if !self.settled || !duties.contains(duty) {
            return Lane::default();
        }
        // The bound by phase current falls with the duty.
        let (bound, _) = self.limit.bound(duties.low() as u16);
        Lane {
            // Half way down to what the loop asks for: it may ask for a little more in its next turn.
            voltage: within.voltage.within(bus_voltage - (bus_voltage - self.speed_voltage) / 2, i32::MAX),
            current: within.current.within(i32::MIN, bound),
            duty: duties,
        }
    }

    /// After the speed loop's turn `lane` is as good as before.
    #[inline]
    pub const fn keeps(&self, lane: &Lane) -> bool {
        self.settled && 0 < self.speed_voltage && self.speed_voltage < lane.voltage.low()
    }

    /// One tick within `lane` as regards voltage and current: the next duty, if it stays there, too. Else nothing is changed.
    #[inline]
    pub fn glide(&mut self, c: &ControlCoefficients, lane: &Lane, measurement: &Measurement) -> Option<Duty> {
        let duty = measurement.duty_within(self.speed_voltage) as i32 + i32::from(c.dead_time);
        if measurement.bus_current() < RETURN || !lane.duty.contains(duty) {
            return None;
        }
        self.output.duty = Duty::from_bits_within(duty as u16);
        Some(self.output.duty)
    }

    /// True if the speed loop alone decides the duty, and the current limiter waits at its voltage.
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
