//! Firmware and board.

use serde::{Deserialize, Serialize};

/// Identity of firmware and board (BUILD_INFO, DEVICE_INFO, parameters 4 to 7).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// Build number of the firmware.
    pub build_number: u16,
    /// Built from sources that were not committed.
    pub source_modified: bool,
    /// Date of the build, YYYYMMDD in decimal.
    pub build_date: u32,
    /// Release of the board.
    pub hardware_release: u16,
    /// Release of the firmware: major in the high byte, minor in the low byte.
    pub software_release: u16,
}
