//! The broadcast measurements (Figure 14, opcodes 200 to 205). Scales: [`super::SIGNALS`].

use super::id::Opcode;
use super::to_drive::flag;
use super::words::{DecodeError, Words, long};

/// One measurement frame, raw values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measurement {
    /// MEASUREMENT_0.
    M0 {
        /// Acceleration along X, Y, Z, 0.001 g.
        accel: [i16; 3],
        /// DSIO1 as read.
        dsi1: bool,
    },
    /// MEASUREMENT_1.
    M1 {
        /// Mechanical speed estimated from back-EMF, rpm, signed.
        speed_sensorless: i16,
        /// Mechanical position, 0.01 degrees, wrapping at 32 bits.
        position: i32,
        /// Electrical input power, 0.1 W.
        power: i16,
    },
    /// MEASUREMENT_2.
    M2 {
        /// Bus voltage, 0.01 V.
        bus_voltage: i16,
        /// Bus current, 0.001 A.
        bus_current: i16,
        /// 6 V rail, 0.001 V.
        rail_6v: i16,
        /// 14 V gate driver rail, 0.001 V.
        rail_14v: i16,
    },
    /// MEASUREMENT_3.
    M3 {
        /// Temperature, 0.1 degrees Celsius.
        temperature: i16,
        /// 1.8 V reference of the accelerometer, 0.001 V.
        accel_reference: i16,
        /// 0.383 VREF, 0.001 V.
        reference: i16,
        /// Analog input, 0.001 V.
        asi: i16,
    },
    /// MEASUREMENT_4.
    M4 {
        /// Terminal voltages of phases A, B, C, 0.01 V.
        phase_voltage: [i16; 3],
        /// Pressure input, 0.001 V.
        pressure: i16,
    },
    /// MEASUREMENT_5.
    M5 {
        /// Mechanical speed estimated from the hall sensors, rpm, signed.
        speed_hall: i16,
        /// DSIO2 as read.
        dsi2: bool,
    },
    /// MEASUREMENT_7, reserved: decoded, never sent.
    M7([u16; 4]),
    /// MEASUREMENT_8, reserved: decoded, never sent.
    M8([u16; 4]),
}

impl Measurement {
    /// The opcode.
    pub const fn opcode(self) -> Opcode {
        let number = match self {
            Self::M0 { .. } => 0,
            Self::M1 { .. } => 1,
            Self::M2 { .. } => 2,
            Self::M3 { .. } => 3,
            Self::M4 { .. } => 4,
            Self::M5 { .. } => 5,
            Self::M7(_) => 7,
            Self::M8(_) => 8,
        };
        Opcode::masked(Opcode::MEASUREMENT_0.raw() as u32 + number)
    }

    /// The four words.
    pub const fn encode(self) -> Words {
        Words(match self {
            Self::M0 { accel: [x, y, z], dsi1 } => [x as u16, y as u16, z as u16, dsi1 as u16],
            Self::M1 { speed_sensorless, position, power } => {
                [speed_sensorless as u16, (position >> 16) as u16, position as u16, power as u16]
            }
            Self::M2 { bus_voltage, bus_current, rail_6v, rail_14v } => {
                [bus_voltage as u16, bus_current as u16, rail_6v as u16, rail_14v as u16]
            }
            Self::M3 { temperature, accel_reference, reference, asi } => {
                [temperature as u16, accel_reference as u16, reference as u16, asi as u16]
            }
            Self::M4 { phase_voltage: [a, b, c], pressure } => {
                [a as u16, b as u16, c as u16, pressure as u16]
            }
            Self::M5 { speed_hall, dsi2 } => [speed_hall as u16, dsi2 as u16, 0, 0],
            Self::M7(words) | Self::M8(words) => words,
        })
    }

    /// Decodes a measurement from four words.
    ///
    /// # Errors
    /// Not the opcode of a measurement (206 does not exist), or a digital input that is neither 0 nor 1.
    pub fn decode(opcode: Opcode, Words(words): Words) -> Result<Self, DecodeError> {
        let [word0, word1, word2, word3] = words;
        let [signed0, signed1, signed2, signed3] = words.map(|word| word as i16);
        Ok(match opcode.raw().checked_sub(Opcode::MEASUREMENT_0.raw()) {
            Some(0) => Self::M0 { accel: [signed0, signed1, signed2], dsi1: flag(word3)? },
            Some(1) => {
                Self::M1 { speed_sensorless: signed0, position: long(word1, word2) as i32, power: signed3 }
            }
            Some(2) => {
                Self::M2 { bus_voltage: signed0, bus_current: signed1, rail_6v: signed2, rail_14v: signed3 }
            }
            Some(3) => {
                Self::M3 { temperature: signed0, accel_reference: signed1, reference: signed2, asi: signed3 }
            }
            Some(4) => Self::M4 { phase_voltage: [signed0, signed1, signed2], pressure: signed3 },
            Some(5) => Self::M5 { speed_hall: word0 as i16, dsi2: flag(word1)? },
            Some(7) => Self::M7(words),
            Some(8) => Self::M8(words),
            _ => return Err(DecodeError::Opcode),
        })
    }
}
