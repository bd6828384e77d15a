//! Fault word (Table 9).

use serde::{Deserialize, Serialize};

bitflags::bitflags! {
    /// FAULT_WORD, bit for bit as Table 9 prints it.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
    pub struct FaultWord: u32 {
        /// Ambient temperature above the warning threshold; never critical.
        const TEMPERATURE_WARNING = 1 << 0;
        /// Ambient temperature above the shutdown threshold.
        const OVER_TEMPERATURE = 1 << 1;
        /// Bus over-voltage.
        const OVER_VOLTAGE = 1 << 2;
        /// Bus under-voltage.
        const UNDER_VOLTAGE = 1 << 3;
        /// Bus or phase over-current.
        const OVER_CURRENT = 1 << 4;
        /// Gate driver fault or open phase.
        const LEGS_DRIVER = 1 << 5;
        /// Hall sensors stuck, invalid, mis-wired or stalled.
        const HALL_SENSORS = 1 << 6;
        /// Pressure above its threshold (input PIN).
        const OVER_PRESSURE = 1 << 7;
        /// Parameter store has another layout.
        const STORE_MISMATCH = 1 << 26;
        /// Hardware break input or failed self-test.
        const EMERGENCY_SHUTDOWN = 1 << 27;
        /// Shutdown commanded by CAN or by a digital input.
        const EXTERNAL_SHUTDOWN = 1 << 28;
        /// The master has fallen silent while driving.
        const DEVICE_TIMEOUT = 1 << 29;
        /// Parameter store absent.
        const STORE_ABSENT = 1 << 30;
        /// Parameter store of a firmware version that cannot be migrated.
        const STORE_VERSION = 1 << 31;
    }
}
