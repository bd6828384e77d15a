//! The broadcast measurements in their units, and when they were received.

use super::Received;
use crate::bus::narmotion::{ControlMode, FromDrive, Measurement, Opcode, SIGNALS, Signal};
use crate::dictionary::Decimal;

/// MEASUREMENT_0 to MEASUREMENT_8; 6 does not exist.
const FRAMES: usize = 9;

/// The last frame of each measurement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Measurements([Option<Received<Measurement>>; FRAMES]);

impl Measurements {
    /// Returns every signal of Figure 14 with its value; `None` before the value was first received.
    pub fn iter(&self) -> impl Iterator<Item = (&'static Signal, Option<Received<Decimal>>)> + '_ {
        SIGNALS.iter().map(|signal| (signal, self.get(signal)))
    }

    /// The value of a signal, in its unit.
    pub fn get(&self, signal: &Signal) -> Option<Received<Decimal>> {
        let Received { value, at } = self.frame(signal.opcode)?;
        Some(Received { value: signal.value(value.encode()), at })
    }

    /// The value of the signal of that name, in its unit; case does not matter.
    pub fn find(&self, name: &str) -> Option<Received<Decimal>> {
        self.get(SIGNALS.iter().find(|signal| signal.name.eq_ignore_ascii_case(name))?)
    }

    /// Returns the last frame of one kind, raw; also of the reserved kinds, which have no signals.
    pub fn frame(&self, opcode: Opcode) -> Option<Received<Measurement>> {
        *self.0.get(place(opcode)?)?
    }

    pub(super) fn note(&mut self, message: &FromDrive, at: u64) {
        if let FromDrive::Measurement(value) = *message
            && let Some(frame) = place(value.opcode()).and_then(|place| self.0.get_mut(place))
        {
            *frame = Some(Received { value, at });
        }
    }

    /// Returns the mechanical speed, rpm, negative in reverse, from the source that the control mode of
    /// STATUS_WORD uses: the hall sensors in hall closed loop (MEASUREMENT_5), the back-EMF in sensorless
    /// closed loop (MEASUREMENT_1). In open loop MEASUREMENT_1 is the speed of the field. With the bridge
    /// off, and before the control mode is known, it is the one of the two that is not 0: a coasting rotor is
    /// seen by its hall sensors or by its back-EMF.
    pub fn speed(&self, control: Option<ControlMode>) -> Option<Received<i16>> {
        let (by_field, by_hall) = (self.speed_sensorless(), self.speed_hall());
        match control {
            Some(ControlMode::Hall) => by_hall,
            Some(ControlMode::Sensorless) => by_field,
            // A hall calibration runs in open loop, and the hall sensors measure its speed.
            Some(ControlMode::OpenLoop | ControlMode::Off) | None => {
                by_field.filter(|received| received.value != 0).or(by_hall).or(by_field)
            }
        }
    }

    fn speed_sensorless(&self) -> Option<Received<i16>> {
        let [_, Some(Received { value: Measurement::M1 { speed_sensorless: value, .. }, at }), ..] = self.0
        else {
            return None;
        };
        Some(Received { value, at })
    }

    fn speed_hall(&self) -> Option<Received<i16>> {
        let [.., Some(Received { value: Measurement::M5 { speed_hall: value, .. }, at }), _, _, _] = self.0
        else {
            return None;
        };
        Some(Received { value, at })
    }
}

fn place(opcode: Opcode) -> Option<usize> {
    opcode.raw().checked_sub(Opcode::MEASUREMENT_0.raw()).map(usize::from)
}
