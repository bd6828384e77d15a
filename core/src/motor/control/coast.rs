//! The bus is never fed: a motor that would return energy coasts, and a rotor that turns already is caught
//! with diodes.

use super::{Control, ControlCoefficients, MOTORING, share};
use crate::motor::gain::Gain;
use crate::motor::sense::measurement::{Measured, Measurement, ratio};
use crate::units::Duty;
use serde::{Deserialize, Serialize};

/// Speed and voltage at which a motor began to coast.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Coasting {
    speed: i32,
    voltage: i32,
}

/// Mean bus current that may flow back: 20 mA, what the drive itself consumes (Table 1).
pub(super) const RETURN: i32 = -(1 << 16) / 50;
/// Longest catching of an idle motor: 20 ms, more than an electrical revolution at 3000 electrical rpm.
pub(super) const CATCH: u16 = 20;

impl Control {
    /// A rotor that is caught, or that coasts: true while the bridge is to stay off.
    #[inline(never)]
    pub(super) fn coasts(
        &mut self,
        c: &ControlCoefficients,
        measured: &Measured,
        measurement: &Measurement,
        speed: i32,
    ) -> bool {
        self.resume(c, measurement, speed);
        self.finish_catching(c, measured, measurement, speed);
        self.coast(c, measured, measurement, speed)
    }

    /// A motor that is faster than its set-point and would feed the bus coasts, bridge off, until it has
    /// fallen to it. Then the loops go on from the voltage they had, less what back-EMF has lost since:
    /// proportional to the speed.
    ///
    /// It looks at the filtered current, because at every commutation the winding's energy comes back in a
    /// pulse, and that is no braking. Freewheeling through diodes instead would not do: discontinuous current
    /// drives an unloaded motor beyond the speed that the same duty holds with switches.
    fn coast(
        &mut self,
        c: &ControlCoefficients,
        measured: &Measured,
        measurement: &Measurement,
        speed: i32,
    ) -> bool {
        match self.coasting {
            None if self.speed_error < 0 && feeds(c, measured) => {
                self.coasting = Some(Coasting { speed, voltage: self.speed_voltage });
            }
            Some(from) if self.speed_error >= 0 => {
                self.coasting = None;
                let left = if speed < from.speed {
                    ratio(speed as u32, from.speed as u32) as u16
                } else {
                    Duty::ONE.to_bits()
                };
                self.take_over(share(from.voltage, left));
                // No slew from 0: on the way up the switches would brake the motor.
                self.output.duty = measurement.duty(self.speed_voltage);
            }
            _ => {}
        }
        self.coasting.is_some()
    }

    /// After the bridge was off (sensors in doubt, a rotor that turned the other way) a rotor that still
    /// turns is caught at its back-EMF, and with diodes until its speed is certain again: a duty that rises
    /// from 0 under switches would short it, and the bus would get its energy.
    fn resume(&mut self, c: &ControlCoefficients, measurement: &Measurement, speed: i32) {
        if !core::mem::take(&mut self.interrupted) {
            return;
        }
        self.coasting = None;
        self.catching = if speed == 0 { 0 } else { CATCH };
        self.take_over(c.back_emf.apply32(speed.min(self.setpoint.value())));
        self.output.duty = measurement.duty(self.speed_voltage);
    }

    /// A rotor that turned already is caught with diodes, where no voltage is too small. Their light-load
    /// current is discontinuous and a voltage below back-EMF holds the speed, so before the switches take
    /// over, the controllers are put at back-EMF, or the motor would brake. An idle motor never draws the
    /// current that ends it: there time does, where back-EMF is known.
    fn finish_catching(
        &mut self,
        c: &ControlCoefficients,
        measured: &Measured,
        measurement: &Measurement,
        speed: i32,
    ) {
        if self.catching == 0 {
            return;
        }
        let late = self.catching == 1 && c.back_emf != Gain::ZERO;
        if late || measured.bus_current_filtered.to_bits() > MOTORING {
            self.catching = 0;
            let back_emf = c.back_emf.apply32(speed);
            if back_emf > self.speed_voltage {
                self.take_over(back_emf);
                self.output.duty = measurement.duty(back_emf);
            }
        }
    }
}

/// The motor returns energy, or the bus is full and the motor hardly draws from it.
pub(super) fn feeds(c: &ControlCoefficients, measured: &Measured) -> bool {
    let current = measured.bus_current_filtered.to_bits();
    current < RETURN || (measured.bus_voltage.to_bits() > c.bus_guard && current < MOTORING)
}
