//! Parts that a board may lack, and the parameters that need them.

use super::{LOGS, Node};
use crate::dictionary::{Dictionary, number};
use crate::motor::modes::LEFT_OUT;
use crate::motor::sense::front_end::Equipment;

/// Ranges of parameters, first to last, that need a part. Without the part each keeps its factory value,
/// which does not use the part.
const NEEDS: [(u16, u16, Equipment); 9] = [
    (number::TEMPERATURE_SOURCE, number::TEMPERATURE_SOURCE, Equipment::EXTERNAL_TEMPERATURE),
    (number::ACCEL_USE_REFERENCE, number::ACCEL_Z_OFFSET, Equipment::ACCELEROMETER),
    (number::ACCEL_MEAS_OFFSET, number::ACCEL_MEAS_OFFSET, Equipment::ACCELEROMETER),
    (number::PRESSURE_CALIB_OFFSET, number::PRESSURE_MEAS_GAIN, Equipment::PRESSURE),
    (number::OVER_PRESSURE, number::OVER_PRESSURE, Equipment::PRESSURE),
    (number::LOGGING_SLOT_FIRST, number::LOGGING_SLOT_LAST, Equipment::LOG),
    (number::LOG_READ_REQUEST, number::LOG_ERASE_REQUEST, Equipment::LOG),
    (number::HALL_SUPPLY_ENABLE, number::HALL_SUPPLY_ENABLE, Equipment::HALL_SUPPLY_SWITCH),
    (number::SHUTDOWN_INPUT, number::SHUTDOWN_INPUT, Equipment::DIGITAL_INPUTS),
];

/// Parts for which this build has code.
const BUILT: Equipment = {
    let accelerometer = if super::ACCELEROMETER { Equipment::empty() } else { Equipment::ACCELEROMETER };
    let log = if LOGS { Equipment::empty() } else { Equipment::LOG };
    Equipment::all().difference(accelerometer.union(log))
};

impl Node {
    /// Returns whether the board has a part, and this build can use it.
    pub(super) const fn has(&self, part: Equipment) -> bool {
        BUILT.contains(part) && self.board.equipment.contains(part)
    }

    /// Returns whether a value of a parameter needs a part that is missing, or code that this build leaves
    /// out.
    pub(super) fn lacks(&self, number: u16, raw: i32) -> bool {
        let lacks_part =
            NEEDS.iter().any(|(first, last, part)| (*first..=*last).contains(&number) && !self.has(*part));
        (lacks_part || LEFT_OUT.contains(&number))
            && Dictionary::row(number).is_some_and(|row| row.factory_raw() != raw)
    }

    /// Resets the parameters of missing parts and code to their factory values: the set may have been stored
    /// on another board, or by another build.
    pub(super) fn drop_what_is_lacking(&mut self) {
        for (first, last, part) in NEEDS {
            if self.has(part) {
                continue;
            }
            for row in Dictionary::rows().filter(|row| (first..=last).contains(&row.number)) {
                self.put(row.number, row.factory_raw());
            }
        }
        for number in LEFT_OUT {
            self.put(*number, 0);
        }
    }
}
