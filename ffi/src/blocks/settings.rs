//! Settings of the blocks, made from the structs of `narx_core::blocks` by `cargo xtask header`.

use super::gain::gain;
use crate::board::narx_channel_t;
use narx_core::blocks::{
    CommutationSettings, FaultSettings, HallSettings, PiSettings, RampSettings, SettingError, StateSettings,
    ZeroCrossingSettings,
};
use narx_core::motor::Lines;
use narx_core::motor::gain::Gain;
use narx_core::units::{Amps, Celsius, ElectricalSpeed, Volts};

/// Settings for narx_commutation_init.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_commutation_settings_t {
    /// Timing advance, electrical, 0 to 3000 in 0.01 degree (parameter 273).
    pub advance_cdeg: u16,
    /// First instant of a period at which a new step can act, 1/65 536 of it: when the caller has its answer.
    pub earliest: u16,
}

impl TryFrom<&narx_commutation_settings_t> for CommutationSettings {
    type Error = SettingError;

    fn try_from(settings: &narx_commutation_settings_t) -> Result<Self, SettingError> {
        Ok(Self {
            advance_cdeg: settings.advance_cdeg,
            earliest: settings.earliest,
        })
    }
}

impl From<CommutationSettings> for narx_commutation_settings_t {
    fn from(settings: CommutationSettings) -> Self {
        Self {
            advance_cdeg: settings.advance_cdeg,
            earliest: settings.earliest,
        }
    }
}

/// Settings for narx_fault_init. The time for which each condition must hold is listed with its cause in
/// PROTOCOL.md.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_fault_settings_t {
    /// Ticks a second, 1 000 to 100 000 Hz.
    pub tick_rate: u32,
    /// Largest bus voltage, 0 to 1 000 V; cleared 0.5 V below. Q16.
    pub over_voltage: i32,
    /// Least bus voltage, 0 V to 1 V below the largest; cleared 0.5 V above. Q16.
    pub under_voltage: i32,
    /// Largest magnitude of the mean DC-link current, 0 to 1 000 A; cleared 1/16 below. Q16.
    pub over_current: i32,
    /// Temperature of the shutdown, -100 to 1 000 degrees C; cleared 2 below. Q16.
    pub over_temperature: i32,
    /// Temperature of the warning, no more than that of the shutdown. Q16.
    pub warning: i32,
    /// Largest pressure reading, -1 000 to 1 000 V; cleared 1/16 below. Q16.
    pub over_pressure: i32,
    /// Largest electrical speed that is requested, 0 to 10 000 rev/s: 30 % above is overspeed. Q16.
    pub speed_max: i32,
    /// Critical fault mask (parameter 115, 1 = critical); faults that protect the power stage are critical
    /// while driving in any case.
    pub critical_mask: u32,
    /// Torque without a hall edge for this long is a stall, 1 to 65 535 ms (parameter 265).
    pub hall_stall_ms: u32,
    /// Digital inputs that shut down. Sum of NARX_LINE_*.
    pub shutdown_lines: u8,
}

impl TryFrom<&narx_fault_settings_t> for FaultSettings {
    type Error = SettingError;

    fn try_from(settings: &narx_fault_settings_t) -> Result<Self, SettingError> {
        Ok(Self {
            tick_rate: settings.tick_rate,
            over_voltage: Volts::from_bits(settings.over_voltage),
            under_voltage: Volts::from_bits(settings.under_voltage),
            over_current: Amps::from_bits(settings.over_current),
            over_temperature: Celsius::from_bits(settings.over_temperature),
            warning: Celsius::from_bits(settings.warning),
            over_pressure: Volts::from_bits(settings.over_pressure),
            speed_max: ElectricalSpeed::from_bits(settings.speed_max),
            critical_mask: settings.critical_mask,
            hall_stall_ms: settings.hall_stall_ms,
            shutdown_lines: Lines::from_bits_retain(settings.shutdown_lines),
        })
    }
}

impl From<FaultSettings> for narx_fault_settings_t {
    fn from(settings: FaultSettings) -> Self {
        Self {
            tick_rate: settings.tick_rate,
            over_voltage: settings.over_voltage.to_bits(),
            under_voltage: settings.under_voltage.to_bits(),
            over_current: settings.over_current.to_bits(),
            over_temperature: settings.over_temperature.to_bits(),
            warning: settings.warning.to_bits(),
            over_pressure: settings.over_pressure.to_bits(),
            speed_max: settings.speed_max.to_bits(),
            critical_mask: settings.critical_mask,
            hall_stall_ms: settings.hall_stall_ms,
            shutdown_lines: settings.shutdown_lines.bits(),
        }
    }
}

/// Settings for narx_hall_init.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_hall_settings_t {
    /// Ticks a second, 1 000 to 100 000 Hz.
    pub tick_rate: u32,
    /// Offset of the edges beyond their place, -18 000 to 18 000 in 0.01 electrical degree (parameter 80).
    pub offset_cdeg: i32,
    /// No edge for this long means standstill, 1 to 65 535 ms (parameter 113), and no more than 65 535 ticks.
    pub timeout_ms: u32,
    /// Slowest electrical speed that is interpolated between edges, rev/s; below, the middle of the sector
    /// stands for all of it. Q16.
    pub interpolation_min: i32,
    /// Permutation of the lines, 0 to 5 (parameter 262); 0 is A, B, C.
    pub order: u8,
    /// Lines to invert before the permutation, 0 to 7: bit 0 = A, bit 1 = B, bit 2 = C.
    pub polarity: u8,
    /// Not 0: edges are time-stamped; else only the level is read, once a tick.
    pub captured: u8,
}

impl TryFrom<&narx_hall_settings_t> for HallSettings {
    type Error = SettingError;

    fn try_from(settings: &narx_hall_settings_t) -> Result<Self, SettingError> {
        Ok(Self {
            tick_rate: settings.tick_rate,
            offset_cdeg: settings.offset_cdeg,
            timeout_ms: settings.timeout_ms,
            interpolation_min: ElectricalSpeed::from_bits(settings.interpolation_min),
            order: settings.order,
            polarity: settings.polarity,
            captured: settings.captured != 0,
        })
    }
}

impl From<HallSettings> for narx_hall_settings_t {
    fn from(settings: HallSettings) -> Self {
        Self {
            tick_rate: settings.tick_rate,
            offset_cdeg: settings.offset_cdeg,
            timeout_ms: settings.timeout_ms,
            interpolation_min: settings.interpolation_min.to_bits(),
            order: settings.order,
            polarity: settings.polarity,
            captured: settings.captured.into(),
        }
    }
}

/// Settings for narx_pi_init. Errors and outputs are Q16 in units of the caller's choice.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_pi_settings_t {
    /// Kp: output per error.
    pub proportional: Gain,
    /// Ki: output per error and second.
    pub integral: Gain,
    /// Steps a second, 1 to 1 000 000 Hz.
    pub step_rate: u32,
    /// Least output, Q16.
    pub minimum: i32,
    /// Largest output, Q16, not below the least.
    pub maximum: i32,
}

impl TryFrom<&narx_pi_settings_t> for PiSettings {
    type Error = SettingError;

    fn try_from(settings: &narx_pi_settings_t) -> Result<Self, SettingError> {
        Ok(Self {
            proportional: gain("proportional", settings.proportional)?,
            integral: gain("integral", settings.integral)?,
            step_rate: settings.step_rate,
            minimum: settings.minimum,
            maximum: settings.maximum,
        })
    }
}

/// Settings for narx_ramp_init.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_ramp_settings_t {
    /// Steepest change, Q16 a second, more than 0.
    pub rate: i32,
    /// Steps a second, 1 to 1 000 000 Hz.
    pub step_rate: u32,
}

impl TryFrom<&narx_ramp_settings_t> for RampSettings {
    type Error = SettingError;

    fn try_from(settings: &narx_ramp_settings_t) -> Result<Self, SettingError> {
        Ok(Self {
            rate: settings.rate,
            step_rate: settings.step_rate,
        })
    }
}

/// Settings for narx_state_init. Durations are 0 to 3 600 000 ms.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_state_settings_t {
    /// Ticks a second, 1 000 to 100 000 Hz.
    pub tick_rate: u32,
    /// Boot time (T01).
    pub boot_ms: u32,
    /// Rotor lock (T23).
    pub lock_ms: u32,
    /// Open loop before sensorless (T34).
    pub open_loop_ms: u32,
    /// Auto-restart (T71, T74).
    pub auto_restart_ms: u32,
    /// Wait before a fault can be acknowledged (T61).
    pub fault_wait_ms: u32,
    /// Longest time without a command while driving; more is a fault.
    pub command_timeout_ms: u32,
    /// Not 0: open loop may run the motor (Table 6).
    pub open_loop: u8,
    /// Not 0: the sensorless loop may run the motor (Table 6).
    pub sensorless: u8,
    /// Not 0: the hall loop may run the motor (Table 6), before the others.
    pub hall: u8,
}

impl TryFrom<&narx_state_settings_t> for StateSettings {
    type Error = SettingError;

    fn try_from(settings: &narx_state_settings_t) -> Result<Self, SettingError> {
        Ok(Self {
            tick_rate: settings.tick_rate,
            boot_ms: settings.boot_ms,
            lock_ms: settings.lock_ms,
            open_loop_ms: settings.open_loop_ms,
            auto_restart_ms: settings.auto_restart_ms,
            fault_wait_ms: settings.fault_wait_ms,
            command_timeout_ms: settings.command_timeout_ms,
            open_loop: settings.open_loop != 0,
            sensorless: settings.sensorless != 0,
            hall: settings.hall != 0,
        })
    }
}

impl From<StateSettings> for narx_state_settings_t {
    fn from(settings: StateSettings) -> Self {
        Self {
            tick_rate: settings.tick_rate,
            boot_ms: settings.boot_ms,
            lock_ms: settings.lock_ms,
            open_loop_ms: settings.open_loop_ms,
            auto_restart_ms: settings.auto_restart_ms,
            fault_wait_ms: settings.fault_wait_ms,
            command_timeout_ms: settings.command_timeout_ms,
            open_loop: settings.open_loop.into(),
            sensorless: settings.sensorless.into(),
            hall: settings.hall.into(),
        }
    }
}

/// Settings for narx_zero_crossing_init.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_zero_crossing_settings_t {
    /// Ticks a second, 1 000 to 100 000 Hz.
    pub tick_rate: u32,
    /// Scale of the three phase terminals.
    pub terminal: narx_channel_t,
    /// Scale of the bus voltage.
    pub bus_voltage: narx_channel_t,
    /// Least blanking after a commutation, 0 to 100 000 us (parameter 86).
    pub blanking_us: u32,
    /// Delay of a rising crossing, -10 000 to 10 000 us (parameter 100).
    pub delay_rising_us: i32,
    /// Delay of a falling crossing, -10 000 to 10 000 us.
    pub delay_falling_us: i32,
    /// Line-to-line back-EMF, 0 to 1 000 000 uV a mechanical rpm (parameter 267); 0 unknown, then off-time
    /// crossings are not corrected for their threshold.
    pub back_emf_uv_per_rpm: u32,
    /// Instant of the period at which a new step acts, 1/65 536 of it, and the advance of the next
    /// commutation.
    pub commutation: narx_commutation_settings_t,
    /// Pole pairs, 1 to 100.
    pub pole_pairs: u16,
    /// No crossing for this long is standstill, 1 to 32 767 ticks (parameter 85).
    pub timeout_ticks: u16,
    /// Smallest signal that stands out of the noise, 1 to 255 codes of a terminal.
    pub noise_codes: u8,
    /// Not 0: comparators with captured edges take the place of samples.
    pub comparator: u8,
}

impl TryFrom<&narx_zero_crossing_settings_t> for ZeroCrossingSettings {
    type Error = SettingError;

    fn try_from(settings: &narx_zero_crossing_settings_t) -> Result<Self, SettingError> {
        Ok(Self {
            tick_rate: settings.tick_rate,
            terminal: settings.terminal.into(),
            bus_voltage: settings.bus_voltage.into(),
            blanking_us: settings.blanking_us,
            delay_rising_us: settings.delay_rising_us,
            delay_falling_us: settings.delay_falling_us,
            back_emf_uv_per_rpm: settings.back_emf_uv_per_rpm,
            commutation: (&settings.commutation).try_into()?,
            pole_pairs: settings.pole_pairs,
            timeout_ticks: settings.timeout_ticks,
            noise_codes: settings.noise_codes,
            comparator: settings.comparator != 0,
        })
    }
}

impl From<ZeroCrossingSettings> for narx_zero_crossing_settings_t {
    fn from(settings: ZeroCrossingSettings) -> Self {
        Self {
            tick_rate: settings.tick_rate,
            terminal: settings.terminal.into(),
            bus_voltage: settings.bus_voltage.into(),
            blanking_us: settings.blanking_us,
            delay_rising_us: settings.delay_rising_us,
            delay_falling_us: settings.delay_falling_us,
            back_emf_uv_per_rpm: settings.back_emf_uv_per_rpm,
            commutation: settings.commutation.into(),
            pole_pairs: settings.pole_pairs,
            timeout_ticks: settings.timeout_ticks,
            noise_codes: settings.noise_codes,
            comparator: settings.comparator.into(),
        }
    }
}
