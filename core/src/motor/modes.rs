//! The control modes that this build has, by features of the same names. Parameters that enable another one
//! are refused when coefficients are built, so no start leads into its states.

use crate::dictionary::number;

/// Closed loop with hall sensors.
pub const HALL: bool = cfg!(feature = "hall");
/// Closed loop by back-EMF.
pub const SENSORLESS: bool = cfg!(feature = "sensorless");
/// Open loop as a mode of its own.
pub const OPEN_LOOP: bool = cfg!(feature = "open-loop");
/// The service that finds the wiring of hall sensors.
pub const HALL_CALIBRATION: bool = cfg!(feature = "hall-calibration");
/// A closed loop can go on by the other one's source.
pub const OTHER_SOURCE: bool = HALL && SENSORLESS;
/// Something reads the hall sensors.
pub const HALL_SENSORS: bool = HALL || HALL_CALIBRATION;

/// Parameters that turn on what this build leaves out: each keeps its factory value, 0.
pub(crate) const LEFT_OUT: &[u16] = FOUND.0.split_at(FOUND.1).0;

const FOUND: ([u16; 5], usize) = {
    let parts = [
        (number::OPEN_LOOP_ENABLE, OPEN_LOOP),
        (number::SENSORLESS_ENABLE, SENSORLESS),
        (number::HALL_ENABLE, HALL),
        (number::HALL_CALIBRATE, HALL_CALIBRATION),
        (number::OTHER_SOURCE, OTHER_SOURCE),
    ];
    let (mut found, mut count, mut index) = ([0; 5], 0, 0);
    while index < parts.len() {
        let (switch, is_built) = parts[index];
        if !is_built {
            found[count] = switch;
            count += 1;
        }
        index += 1;
    }
    (found, count)
};
