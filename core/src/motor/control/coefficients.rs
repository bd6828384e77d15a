//! Coefficients of the control station.

use crate::motor::control::limits::LimitCoefficients;
use crate::motor::control::pi::PiGains;
use crate::motor::gain::Gain;
use serde::{Deserialize, Serialize};

/// Coefficients of the control station. Volts, amperes and rev/s are raw I16F16, duties raw U1F15.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(C)]
pub struct ControlCoefficients {
    /// Ticks in a millisecond, 1/256.
    pub ticks_per_ms: u16,
    /// Part of its distance that the speed loop goes in a tick while something else decides, 1/65 536.
    pub track: u16,
    /// Bus current limiter, per tick.
    pub current: PiGains,
    /// Current ratings.
    pub limits: LimitCoefficients,
    /// Speed set-point ramp, electrical rev/s per millisecond with 16 extra bits (parameter 99).
    pub speed_rate: i64,
    /// Largest change of the duty in a tick (parameter 271).
    pub slew: u16,
    /// Shortest on-time (parameter 272).
    pub duty_min: u16,
    /// Duty that dead time takes away under synchronous rectification.
    pub dead_time: u16,
    /// Above this bus voltage nothing may flow back: the over-voltage threshold less a margin.
    pub bus_guard: i32,
    /// First level in closed loop (parameter 84). A level is raw I16F16: volts, or a share of the bus voltage
    /// (`levels_of_bus`).
    pub initial_level: i32,
    /// Levels are shares of the live bus voltage: there is no nominal supply (parameter 266 is 0).
    pub levels_of_bus: bool,
    /// Back-EMF per electrical rev/s (parameter 267); 0 unknown.
    pub back_emf: Gain,
}

impl ControlCoefficients {
    /// Volts of a level on this bus, raw I16F16.
    #[inline]
    pub const fn volts(&self, level: i32, bus_voltage: i32) -> i32 {
        if self.levels_of_bus { ((bus_voltage as i64 * level as i64) >> 16) as i32 } else { level }
    }
}

/// Coefficients of one closed-loop mode. Speeds are raw I16F16 electrical rev/s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(C)]
pub struct ModeCoefficients {
    /// Speed loop, volts per electrical rev/s, per millisecond.
    pub speed: PiGains,
    /// Smallest set-point.
    pub speed_min: i32,
    /// Largest set-point.
    pub speed_max: i32,
    /// Largest duty, raw U1F15.
    pub duty_max: u16,
    /// The speed is known from crossings alone, once in a sector.
    pub sparse: bool,
}
