//! Converter codes to volts and amperes, with calibration, and the reciprocal of the bus voltage.

use super::gain::Gain;
use super::samples::Samples;
use crate::units::{Amps, Duty, Volts, saturate64};
use serde::{Deserialize, Serialize};

/// One converter channel: `value = (code - zero) x gain + offset`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ChannelScale {
    /// Code of 0.
    pub zero: u16,
    /// Raw I16F16 per code.
    pub gain: Gain,
    /// Calibration offset, raw I16F16, added.
    pub offset: i32,
}

impl ChannelScale {
    /// Raw I16F16 of `code`.
    #[inline]
    pub const fn convert(&self, code: u16) -> i32 {
        let value = self.gain.apply(code as i32 - self.zero as i32);
        saturate64(value + self.offset as i64)
    }
}

/// Scales of the fast channels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MeasurementScales {
    /// Bus voltage (parameter 14 is its offset).
    pub bus_voltage: ChannelScale,
    /// DC-link current (parameter 13 is its offset).
    pub bus_current: ChannelScale,
    /// Phase terminal voltages.
    pub phase_voltage: ChannelScale,
}

/// What this tick measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Measured {
    /// Bus voltage.
    pub bus_voltage: Volts,
    /// Mean DC-link current.
    pub bus_current: Amps,
    /// The same after a first-order filter of 64 ticks: longer than what a commutation returns to the bus.
    pub bus_current_filtered: Amps,
    /// Terminal voltages A, B, C, where somebody looks at them; else 0.
    pub phase_voltage: [Volts; 3],
}

/// State of the measurement station.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Measurement {
    /// Raw I16F16 with 6 extra bits.
    filtered: i64,
    zero: ZeroCurrent,
    reciprocal: Reciprocal,
}

/// The bus current's zero, found while the bridge is off during Initialization: what the converter reads then is
/// its offset. A first-order mean of 1024 ticks, raw I16F16 with 10 extra bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct ZeroCurrent(i64);

impl ZeroCurrent {
    /// No credible offset is larger: 0.25 A.
    const MAX: i32 = 1 << 14;

    #[inline]
    fn step(&mut self, current: i32, idle: bool) -> i32 {
        let zero = ((self.0 >> 10) as i32).clamp(-Self::MAX, Self::MAX);
        if idle {
            self.0 += i64::from(current) - (self.0 >> 10);
        }
        current.saturating_sub(zero)
    }
}

impl MeasurementScales {
    /// Terminal voltages A, B, C. Only the back-EMF station and reports ask for them.
    #[inline]
    pub fn phase_voltage(&self, samples: &Samples) -> [Volts; 3] {
        samples.phase_voltage.map(|code| Volts::from_bits(self.phase_voltage.convert(code)))
    }
}

impl Measurement {
    /// Converts one tick's codes, phase voltages apart. `idle`: no current can flow, so what the current channel reads is its zero.
    #[inline]
    pub fn step(&mut self, scales: &MeasurementScales, samples: &Samples, idle: bool) -> Measured {
        let bus_voltage = scales.bus_voltage.convert(samples.bus_voltage);
        let bus_current = self.zero.step(scales.bus_current.convert(samples.bus_current), idle);
        self.filtered += i64::from(bus_current) - (self.filtered >> 6);
        self.reciprocal.follow(bus_voltage);
        Measured {
            bus_voltage: Volts::from_bits(bus_voltage),
            bus_current: Amps::from_bits(bus_current),
            bus_current_filtered: Amps::from_bits((self.filtered >> 6) as i32),
            phase_voltage: [Volts::ZERO; 3],
        }
    }

    /// The duty that gives `voltage` (raw I16F16, >= 0) on the present bus, 0..=1.
    #[inline]
    pub fn duty(&self, voltage: i32) -> Duty {
        self.reciprocal.quotient(voltage)
    }
}

/// `2^47 / voltage bits`, kept by two Newton steps a tick: `r' = r (2 - v r)`. At most 2^29 and a little, by [`BUS_MIN`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Reciprocal(i64);

/// Below 4 V nothing runs, and the reciprocal stays within 30 bits.
const BUS_MIN: i32 = 4 << 16;

impl Reciprocal {
    #[inline]
    fn follow(&mut self, bus_voltage: i32) {
        let voltage = bus_voltage.max(BUS_MIN);
        let error = self.error(voltage);
        // A step squares the relative error: from within 1/16 two leave 2^-16. Outside (power-up, a torn supply)
        // divide once.
        *self = if error.abs() < 1 << 43 {
            let first = self.refined(error);
            first.refined(first.error(voltage))
        } else {
            Self((1 << 47) / i64::from(voltage))
        };
    }

    /// 2^47 less voltage x reciprocal. Both factors have 32 bits: one multiply instruction.
    #[inline]
    const fn error(self, voltage: i32) -> i64 {
        (1 << 47) - voltage as i64 * self.0 as i32 as i64
    }

    /// One Newton step; `error` is within 2^43.
    #[inline]
    const fn refined(self, error: i64) -> Self {
        Self((self.0 as i32 as i64) + ((self.0 as i32 as i64 * (error >> 16) as i32 as i64) >> 31))
    }

    #[inline]
    fn quotient(self, voltage: i32) -> Duty {
        let bits = (voltage.max(0) as i64 * self.0 as i32 as i64) >> 32;
        Duty::from_bits(bits.min(Duty::ONE.to_bits() as i64) as u16)
    }
}
