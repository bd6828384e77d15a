//! From thresholds to limits: hysteresis, and qualification as [`Cause::TABLE`] publishes it.

use super::{Limit, ProtectionCoefficients};
use crate::motor::guard::fault::Cause;
use crate::motor::sense::samples::Lines;
use crate::units::{quotient, saturate64};

/// Thresholds of the fault logic, raw I16F16 of the quantity's unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Thresholds {
    /// Bus voltage, largest, V.
    pub over_voltage: i32,
    /// Bus voltage, least, V.
    pub under_voltage: i32,
    /// Mean DC-link current, magnitude, A.
    pub over_current: i32,
    /// Temperature of the shutdown, degrees C.
    pub over_temperature: i32,
    /// Temperature of the warning, degrees C.
    pub warning: i32,
    /// Pressure reading, V.
    pub over_pressure: i32,
    /// Largest set-point with hall sensors, electrical rev/s; 30 % above is overspeed.
    pub speed_max_hall: i32,
    /// Largest set-point of sensorless and open loop, electrical rev/s; 30 % above is overspeed.
    pub speed_max_sensorless: i32,
    /// Which digital inputs shut down.
    pub shutdown_lines: Lines,
    /// Bits that are critical (parameter 115).
    pub critical_mask: u32,
    /// Ticks under torque without a hall edge (parameter 265).
    pub hall_stall_ticks: u32,
}

/// Hysteresis of the voltage faults: 0.5 V.
const VOLTAGE_HYSTERESIS: i32 = (1 << 16) / 2;
/// Hysteresis of the temperature faults: 2 degrees C.
const TEMPERATURE_HYSTERESIS: i32 = 2 << 16;

/// Qualification times, us: looked up by the compiler, so that no board carries the table with its texts.
mod times {
    use super::Cause;

    pub(super) const OVERSPEED: u32 = Cause::Overspeed.qualification();
    pub(super) const OVER_VOLTAGE: u32 = Cause::OverVoltage.qualification();
    pub(super) const UNDER_VOLTAGE: u32 = Cause::UnderVoltage.qualification();
    pub(super) const OVER_CURRENT: u32 = Cause::OverCurrent.qualification();
    pub(super) const OVER_TEMPERATURE: u32 = Cause::OverTemperature.qualification();
    pub(super) const TEMPERATURE_WARNING: u32 = Cause::TemperatureWarning.qualification();
    pub(super) const OVER_PRESSURE: u32 = Cause::OverPressure.qualification();
    pub(super) const SHUTDOWN_LINE: u32 = Cause::ShutdownLine.qualification();
}

impl ProtectionCoefficients {
    /// Limits at so many ticks a second.
    pub fn new(rate: u32, at: &Thresholds) -> Self {
        let ticks = |microseconds: u32| {
            let ticks = quotient(i64::from(microseconds) * i64::from(rate) + 999_999, 1_000_000);
            ticks.clamp(1, u16::MAX.into()) as u16
        };
        let limit =
            |microseconds: u32, trip: i32, clear: i32| Limit { trip, clear, ticks: ticks(microseconds) };
        let overspeed =
            |most: i32| limit(times::OVERSPEED, saturate64(quotient(i64::from(most) * 13, 10)), most);
        let Thresholds { over_voltage: over, under_voltage: under, over_current: current, .. } = *at;
        let (hot, warm, pressure) = (at.over_temperature, at.warning, at.over_pressure);
        Self {
            over_voltage: limit(times::OVER_VOLTAGE, over, over.saturating_sub(VOLTAGE_HYSTERESIS)),
            over_voltage_at_once: over.saturating_add(1 << 16),
            under_voltage: limit(times::UNDER_VOLTAGE, under, under.saturating_add(VOLTAGE_HYSTERESIS)),
            over_current: limit(times::OVER_CURRENT, current, current - current / 16),
            over_temperature: limit(times::OVER_TEMPERATURE, hot, hot.saturating_sub(TEMPERATURE_HYSTERESIS)),
            warning: limit(times::TEMPERATURE_WARNING, warm, warm.saturating_sub(TEMPERATURE_HYSTERESIS)),
            over_pressure: limit(
                times::OVER_PRESSURE,
                pressure,
                pressure.saturating_sub(pressure.abs() / 16),
            ),
            overspeed_hall: overspeed(at.speed_max_hall),
            overspeed_sensorless: overspeed(at.speed_max_sensorless),
            shutdown_lines: at.shutdown_lines,
            shutdown_ticks: ticks(times::SHUTDOWN_LINE),
            critical_mask: at.critical_mask,
            hall_stall_ticks: at.hall_stall_ticks,
            supply_low: 18 << 16,
            ticks_per_ms: quotient(i64::from(rate) << 8, 1000).clamp(1, u16::MAX.into()) as u16,
        }
    }
}
