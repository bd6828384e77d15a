//! Slow inputs of the board, and their calibration.

use crate::dictionary::{Parameters, number};
use crate::motor::machine::event::SlowMeasurements;
use crate::units::{Celsius, Volts, quotient};
use serde::{Deserialize, Serialize};

/// True if this build uses an accelerometer.
pub(super) const ACCELEROMETER: bool = cfg!(feature = "accelerometer");

/// Reciprocal of the accelerometer's sensitivity, 0.5 V a g. The specification states none; with the zero-g
/// level of 1.8 V (Table 10) this one brings +-2 g to 0.8 V and 2.8 V, within the converter's 3.3 V.
const MILLI_G_PER_VOLT: i32 = 2000;

/// Inputs that the board reads besides the tick's samples, before calibration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SlowInputs {
    /// Sensor on the power board.
    pub ambient_temperature: Celsius,
    /// External sensor, where there is one.
    pub external_temperature: Celsius,
    /// Pressure input (PIN) after its amplifier.
    pub pressure: Volts,
    /// Outputs of the accelerometer along X, Y, Z: 0.5 V a g about its zero-g level.
    pub accel: [Volts; 3],
    /// 1.8 V reference of the accelerometer.
    pub accel_reference: Volts,
    /// 0.383 VREF.
    pub reference: Volts,
    /// 6 V rail.
    pub rail_6v: Volts,
    /// 14 V rail of the gate drivers.
    pub rail_14v: Volts,
    /// Analog signal input.
    pub asi: Volts,
    /// DSIO1 as read.
    pub dsi1: bool,
    /// DSIO2 as read.
    pub dsi2: bool,
}

impl SlowInputs {
    /// Returns the inputs of the fault logic: the selected temperature and the calibrated pressure.
    pub(super) fn calibrated(&self, parameters: &Parameters) -> SlowMeasurements {
        let external = parameters.raw(number::TEMPERATURE_SOURCE) != 0;
        let temperature = if external { self.external_temperature } else { self.ambient_temperature };
        let offset = Celsius::from_ratio(parameters.raw(number::TEMPERATURE_OFFSET).into(), 10);
        SlowMeasurements {
            temperature: temperature.saturating_add(offset),
            pressure: linear(
                self.pressure,
                parameters.raw(number::PRESSURE_CALIB_GAIN),
                parameters.raw(number::PRESSURE_CALIB_OFFSET),
            ),
        }
    }

    /// Returns the value of PIN_MEAS: the calibrated pressure, scaled.
    pub(super) fn scaled_pressure(&self, parameters: &Parameters) -> Volts {
        linear(
            self.calibrated(parameters).pressure,
            parameters.raw(number::PRESSURE_MEAS_GAIN),
            parameters.raw(number::PRESSURE_MEAS_OFFSET),
        )
    }

    /// Calibrated acceleration, 0.001 g: (output - zero-g level) / sensitivity + offset.
    pub(super) fn calibrated_accel(&self, parameters: &Parameters) -> [i16; 3] {
        if !ACCELEROMETER {
            return [0; 3];
        }
        let zero = if parameters.raw(number::ACCEL_USE_REFERENCE) != 0 {
            self.accel_reference
        } else {
            Volts::from_milli(parameters.raw(number::ACCEL_MEAS_OFFSET))
        };
        let offsets = [number::ACCEL_X_OFFSET, number::ACCEL_Y_OFFSET, number::ACCEL_Z_OFFSET];
        core::array::from_fn(|axis| {
            let raw = self.accel[axis].saturating_sub(zero).scaled(MILLI_G_PER_VOLT);
            super::scale::saturate16(i64::from(raw) + i64::from(parameters.raw(offsets[axis])))
        })
    }
}

/// value * gain / 1 000 000 + offset / 1000, saturating.
fn linear(value: Volts, gain: i32, offset: i32) -> Volts {
    // Both factors have 32 bits, so the product of bits and gain fits 64.
    let product = quotient(i64::from(value.to_bits()) * i64::from(gain), 1_000_000);
    let bits = product.clamp(i32::MIN.into(), i32::MAX.into()) as i32;
    Volts::from_bits(bits).saturating_add(Volts::from_milli(offset))
}
