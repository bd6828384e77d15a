//! Duties below the shortest pulse (parameter 272): whole pulses in some of the periods, whose mean is the
//! duty.

use crate::units::Duty;
use serde::{Deserialize, Serialize};

/// Pulses that are due.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Pulses {
    /// Duty that was asked for and not yet given, less than a pulse, raw U1F15.
    owed: u16,
}

impl Pulses {
    /// The duty of one period, of which every pulse loses `lost` to the dead time: `duty` if that is a pulse
    /// of at least `shortest`, else that pulse or none. All raw U1F15.
    #[inline]
    pub fn next(&mut self, duty: u16, shortest: u16, lost: u16) -> Duty {
        if duty == 0 || duty >= shortest {
            self.owed = 0;
            return Duty::from_bits(duty);
        }
        let given = shortest.saturating_sub(lost).max(1);
        let owed = self.owed.saturating_add(duty.saturating_sub(lost));
        let pulse = owed >= given;
        self.owed = if pulse { owed - given } else { owed };
        if pulse { Duty::from_bits(shortest) } else { Duty::ZERO }
    }
}
