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

impl FaultWord {
    /// Never maskable while the bridge is on.
    pub const FORCED: Self = Self::OVER_VOLTAGE
        .union(Self::UNDER_VOLTAGE)
        .union(Self::OVER_CURRENT)
        .union(Self::LEGS_DRIVER)
        .union(Self::EMERGENCY_SHUTDOWN)
        .union(Self::DEVICE_TIMEOUT)
        .union(Self::STORE_ABSENT)
        .union(Self::STORE_VERSION);
    /// The bits of the parameter store.
    pub const STORE: Self = Self::STORE_MISMATCH.union(Self::STORE_ABSENT).union(Self::STORE_VERSION);

    /// The bits that are critical under a mask (parameter 115, 1 = critical). The warning never is; what
    /// protects the power stage always is while `driving`.
    #[must_use]
    pub const fn critical(mask: u32, driving: bool) -> Self {
        let chosen = Self::from_bits_truncate(mask);
        let chosen = if driving { chosen.union(Self::FORCED) } else { chosen };
        chosen.difference(Self::TEMPERATURE_WARNING)
    }
}

/// Reason why a fault bit is set, finer than the bit: the Extended Fault Code is `bit << 8 | n`, n from 1
/// within the bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u16)]
#[allow(missing_docs, reason = "`Cause::TABLE` says what each is, for programs too")]
pub enum Cause {
    TemperatureWarning = 0x0001,
    OverTemperature = 0x0101,
    OverVoltage = 0x0201,
    UnderVoltage = 0x0301,
    OverCurrent = 0x0401,
    DriverLine = 0x0501,
    OpenPhase = 0x0502,
    HallInvalid = 0x0601,
    HallJumps = 0x0602,
    HallStall = 0x0603,
    HallDirection = 0x0604,
    HallsGivenUp = 0x0605,
    OverPressure = 0x0701,
    StoreMismatch = 0x1A01,
    EmergencyLine = 0x1B01,
    SelfTest = 0x1B02,
    Overspeed = 0x1B03,
    SensorlessStall = 0x1B04,
    Desynchronisation = 0x1B05,
    WrongLock = 0x1B06,
    BackEmfGivenUp = 0x1B07,
    ShutdownCommanded = 0x1C01,
    ShutdownLine = 0x1C02,
    CommandTimeout = 0x1D01,
    StoreAbsent = 0x1E01,
    StoreVersion = 0x1F01,
}

/// A row of [`Cause::TABLE`].
#[derive(Clone, Copy, Debug)]
pub struct CauseRow {
    /// The cause, its code is `cause as u16`.
    pub cause: Cause,
    /// Its meaning.
    pub meaning: &'static str,
    /// Qualification time in microseconds; 0 is the tick that sees it.
    pub qualification: u32,
}

const fn row(cause: Cause, qualification: u32, meaning: &'static str) -> CauseRow {
    CauseRow { cause, meaning, qualification }
}

impl Cause {
    /// Every cause with its qualification time.
    pub const TABLE: [CauseRow; 26] = [
        row(Self::TemperatureWarning, 100_000, "temperature above the warning threshold"),
        row(Self::OverTemperature, 100_000, "temperature above the shutdown threshold"),
        row(Self::OverVoltage, 10_000, "bus voltage above its threshold; at once when 1 V above"),
        row(Self::UnderVoltage, 1_000, "bus voltage below its threshold"),
        row(Self::OverCurrent, 300, "mean DC-link current above its threshold"),
        row(Self::DriverLine, 0, "the gate driver reports a fault"),
        row(Self::OpenPhase, 0, "a phase carries no current (three revolutions, or 100 ms at rest)"),
        row(Self::HallInvalid, 0, "hall codes 000 or 111 (64 more than one a millisecond)"),
        row(Self::HallJumps, 0, "hall sectors skipped (5 more than one in 13 ms)"),
        row(
            Self::HallStall,
            0,
            "torque applied at speed 0 (parameter 113) for the stall time (parameter 265)",
        ),
        row(
            Self::HallDirection,
            0,
            "hall edges run against the torque: wiring, or a load that drives backwards",
        ),
        row(
            Self::HallsGivenUp,
            0,
            "the motor goes on without its hall sensors (parameter 308); no fault bit",
        ),
        row(Self::OverPressure, 10_000, "pressure above its threshold"),
        row(Self::StoreMismatch, 0, "parameter store has another layout"),
        row(Self::EmergencyLine, 0, "hardware break input"),
        row(Self::SelfTest, 0, "self-test failed"),
        row(Self::Overspeed, 10_000, "speed above 130 % of the mode's maximum set-point"),
        row(
            Self::SensorlessStall,
            0,
            "the sensorless motor stalls or does not start, five times (one is forgiven in 10 s)",
        ),
        row(
            Self::Desynchronisation,
            0,
            "zero crossings jump by more than half an interval, five times (one is forgiven in 10 s)",
        ),
        row(
            Self::WrongLock,
            0,
            "sensorless speed and applied voltage do not fit together for 150 ms, five times (one is forgiven in 10 s)",
        ),
        row(Self::BackEmfGivenUp, 0, "the motor goes on with its hall sensors (parameter 308); no fault bit"),
        row(Self::ShutdownCommanded, 0, "shutdown requested over CAN (motor mode 3)"),
        row(Self::ShutdownLine, 1_000, "the digital input configured for shutdown"),
        row(Self::CommandTimeout, 0, "no valid command while driving for the time-out (parameter 114)"),
        row(Self::StoreAbsent, 0, "parameter store absent"),
        row(Self::StoreVersion, 0, "parameter store of another firmware version"),
    ];

    /// Qualification time in microseconds, as the table publishes it.
    #[must_use]
    pub const fn qualification(self) -> u32 {
        let mut row = 0;
        while row < Self::TABLE.len() {
            if Self::TABLE[row].cause as u16 == self as u16 {
                return Self::TABLE[row].qualification;
            }
            row += 1;
        }
        0
    }

    /// The bit of the fault word.
    #[must_use]
    pub const fn bit(self) -> FaultWord {
        FaultWord::from_bits_truncate(1 << (self as u16 >> 8))
    }
}
