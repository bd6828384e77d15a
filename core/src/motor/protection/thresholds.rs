//! From thresholds to limits: hysteresis, and qualification as [`Cause::TABLE`] publishes it.

use super::{Limit, ProtectionCoefficients};
use crate::motor::fault::Cause;
use crate::motor::samples::Lines;
use crate::units::saturate64;

/// What trips the fault logic, raw I16F16 of the quantity's unit.
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
    /// The same for sensorless and open loop.
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

impl ProtectionCoefficients {
    /// Limits at so many ticks a second.
    pub fn new(rate: u32, at: &Thresholds) -> Self {
        let ticks = |microseconds: u32| {
            let ticks = (u64::from(microseconds) * u64::from(rate)).div_ceil(1_000_000);
            ticks.clamp(1, u16::MAX.into()) as u16
        };
        let limit =
            |cause: Cause, trip: i32, clear: i32| Limit { trip, clear, ticks: ticks(cause.qualification()) };
        let overspeed = |most: i32| limit(Cause::Overspeed, saturate64(i64::from(most) * 13 / 10), most);
        let Thresholds { over_voltage: over, under_voltage: under, over_current: current, .. } = *at;
        let (hot, warm, pressure) = (at.over_temperature, at.warning, at.over_pressure);
        Self {
            over_voltage: limit(Cause::OverVoltage, over, over.saturating_sub(VOLTAGE_HYSTERESIS)),
            over_voltage_at_once: over.saturating_add(1 << 16),
            under_voltage: limit(Cause::UnderVoltage, under, under.saturating_add(VOLTAGE_HYSTERESIS)),
            over_current: limit(Cause::OverCurrent, current, current - current / 16),
            over_temperature: limit(Cause::OverTemperature, hot, hot.saturating_sub(TEMPERATURE_HYSTERESIS)),
            warning: limit(Cause::TemperatureWarning, warm, warm.saturating_sub(TEMPERATURE_HYSTERESIS)),
            over_pressure: limit(Cause::OverPressure, pressure, pressure.saturating_sub(pressure.abs() / 16)),
            overspeed_hall: overspeed(at.speed_max_hall),
            overspeed_sensorless: overspeed(at.speed_max_sensorless),
            shutdown_lines: at.shutdown_lines,
            shutdown_ticks: ticks(Cause::ShutdownLine.qualification()),
            critical_mask: at.critical_mask,
            hall_stall_ticks: at.hall_stall_ticks,
            supply_low: 18 << 16,
            ticks_per_ms: ticks(1_000),
        }
    }
}
