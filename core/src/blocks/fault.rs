//! Fault logic: measurements and conditions to a qualified, latched fault word (Table 9).

use super::error::{SettingError, quantity_within, within};
use super::{factory, factory_quantity, tick_rate, ticks};
use crate::dictionary::number;
use crate::motor::clock::Instant;
use crate::motor::guard::fault::FaultWord;
use crate::motor::guard::protection::{Evidence, Protection, ProtectionCoefficients, Thresholds};
use crate::motor::machine::Change;
use crate::motor::machine::state::State;
use crate::motor::sense::samples::Lines;
use crate::units::{Amps, Celsius, ElectricalSpeed, Volts};

/// Settings of a [`Fault`]. The time for which each condition must hold is listed with its cause in
/// PROTOCOL.md.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FaultSettings {
    /// Ticks a second, 1 000 to 100 000 Hz.
    pub tick_rate: u32,
    /// Largest bus voltage, 0 to 1 000 V; cleared 0.5 V below.
    pub over_voltage: Volts,
    /// Least bus voltage, 0 V to 1 V below the largest; cleared 0.5 V above.
    pub under_voltage: Volts,
    /// Largest magnitude of the mean DC-link current, 0 to 1 000 A; cleared 1/16 below.
    pub over_current: Amps,
    /// Temperature of the shutdown, -100 to 1 000 degrees C; cleared 2 below.
    pub over_temperature: Celsius,
    /// Temperature of the warning, no more than that of the shutdown.
    pub warning: Celsius,
    /// Largest pressure reading, -1 000 to 1 000 V; cleared 1/16 below.
    pub over_pressure: Volts,
    /// Largest electrical speed that is requested, 0 to 10 000 rev/s: 30 % above is overspeed.
    pub speed_max: ElectricalSpeed,
    /// Critical fault mask (parameter 115, 1 = critical); faults that protect the power stage are critical
    /// while driving in any case.
    pub critical_mask: u32,
    /// Torque without a hall edge for this long is a stall, 1 to 65 535 ms (parameter 265).
    pub hall_stall_ms: u32,
    /// Digital inputs that shut down.
    pub shutdown_lines: Lines,
}

impl Default for FaultSettings {
    /// The drive's factory values at 10 kHz; no speed is too high.
    fn default() -> Self {
        Self {
            tick_rate: 10_000,
            over_voltage: Volts::from_bits(const { factory_quantity(number::OVER_VOLTAGE) }),
            under_voltage: Volts::from_bits(const { factory_quantity(number::UNDER_VOLTAGE) }),
            over_current: Amps::from_bits(const { factory_quantity(number::OVER_CURRENT) }),
            over_temperature: Celsius::from_bits(const { factory_quantity(number::OVER_TEMPERATURE) }),
            warning: Celsius::from_bits(const { factory_quantity(number::TEMPERATURE_WARNING) }),
            over_pressure: Volts::from_bits(const { factory_quantity(number::OVER_PRESSURE) }),
            speed_max: ElectricalSpeed::from_bits(SPEED_MAX),
            shutdown_lines: Lines::empty(),
            critical_mask: const { factory(number::CRITICAL_FAULT_MASK) },
            hall_stall_ms: const { factory(number::HALL_STALL_TIME) },
        }
    }
}

/// 10 000 rev/s.
const SPEED_MAX: i32 = 10_000 << 16;

/// The fault logic. A critical fault latches; [`acknowledge`](Self::acknowledge) clears it once its cause has
/// gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fault {
    ready: ProtectionCoefficients,
    now: Instant,
    station: Protection,
}

impl Fault {
    /// Builds a fault logic without a fault.
    ///
    /// # Errors
    /// The setting that is out of range.
    pub fn build(s: &FaultSettings) -> Result<Self, SettingError> {
        let rate = tick_rate(s.tick_rate)?;
        let (over, hot) = (s.over_voltage.to_bits(), s.over_temperature.to_bits());
        quantity_within("over_voltage", over, 0, 1000 << 16, "V")?;
        quantity_within("under_voltage", s.under_voltage.to_bits(), 0, over.saturating_sub(1 << 16), "V")?;
        quantity_within("over_current", s.over_current.to_bits(), 0, 1000 << 16, "A")?;
        quantity_within("over_temperature", hot, -100 << 16, 1000 << 16, "degrees C")?;
        quantity_within("warning", s.warning.to_bits(), -100 << 16, hot, "degrees C")?;
        quantity_within("over_pressure", s.over_pressure.to_bits(), -1000 << 16, 1000 << 16, "V")?;
        quantity_within("speed_max", s.speed_max.to_bits(), 0, SPEED_MAX, "rev/s")?;
        within("hall_stall_ms", s.hall_stall_ms.into(), 1, 65_535, "ms")?;
        let thresholds = Thresholds {
            over_voltage: over,
            under_voltage: s.under_voltage.to_bits(),
            over_current: s.over_current.to_bits(),
            over_temperature: hot,
            warning: s.warning.to_bits(),
            over_pressure: s.over_pressure.to_bits(),
            speed_max_hall: s.speed_max.to_bits(),
            speed_max_sensorless: s.speed_max.to_bits(),
            shutdown_lines: s.shutdown_lines,
            critical_mask: s.critical_mask,
            hall_stall_ticks: ticks(s.hall_stall_ms, rate),
        };
        let coefficients = ProtectionCoefficients::new(rate, &thresholds);
        Ok(Self::new(coefficients))
    }

    /// A fault logic without a fault, with ready-made coefficients, which are not checked.
    pub fn new(ready: ProtectionCoefficients) -> Self {
        Self { ready, now: Instant::default(), station: Protection::default() }
    }

    /// Its coefficients, for [`new`](Self::new) elsewhere.
    pub const fn ready(&self) -> &ProtectionCoefficients {
        &self.ready
    }

    /// Runs one tick. Returns true while a critical fault is present: the bridge must be switched off.
    pub fn step(&mut self, evidence: &Evidence) -> bool {
        self.now = self.now.next();
        self.station.step(&self.ready, self.now, evidence)
    }

    /// Follows a state change of the [`StateMachine`](super::StateMachine) beside it: a time-out and a failed
    /// boot are latched, leaving Fault acknowledges, and sensors are judged anew in every driven episode.
    pub fn handle_change(&mut self, change: &Change, evidence: &Evidence) {
        let (from, to) = (change.row.from, change.row.to);
        if change.timed_out {
            self.station.raise_timeout();
        }
        match to {
            State::Standby if !from.is_driving() => self.station.acknowledge(),
            State::Fault if from == State::Initialization => self.station.raise_boot_failure(evidence.health),
            _ => {}
        }
        if !to.is_driving() || !from.is_driving() {
            self.station.forget_episode();
        }
    }

    /// Clears the latched faults and returns true if none of their causes is present any more; else does
    /// nothing.
    pub fn acknowledge(&mut self) -> bool {
        let gone = self.causes_gone();
        if gone {
            self.station.acknowledge();
        }
        gone
    }

    /// Returns whether none of the latched causes is present any more.
    pub fn causes_gone(&self) -> bool {
        self.station.causes_gone()
    }

    /// FAULT_WORD: faults that are present or latched.
    pub fn word(&self) -> FaultWord {
        self.station.word()
    }

    /// CRITICAL_FAULT: latched faults.
    pub const fn critical(&self) -> FaultWord {
        self.station.critical()
    }

    /// Extended code of the first critical fault (a [`Cause`](crate::motor::Cause)), 0 without one.
    pub const fn code(&self) -> u16 {
        self.station.code()
    }
}
