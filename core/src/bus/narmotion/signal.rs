//! Scales of the broadcast measurements. Documents and data base files are made from this one table.

use super::id::Opcode;
use super::words::{Words, long};
use crate::dictionary::Decimal;

/// One value in a measurement frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Signal {
    /// The frame.
    pub opcode: Opcode,
    /// First word, 0..=3.
    pub word: u8,
    /// Words that it takes: 2 mean 32 bits, high word first.
    pub words: u8,
    /// Two's complement, or else unsigned.
    pub signed: bool,
    /// Name as Figure 14 prints it.
    pub name: &'static str,
    /// Unit of the scaled value; "-" without one.
    pub unit: &'static str,
    /// Value = raw * 10^exponent.
    pub exponent: i8,
}

impl Signal {
    /// The signal's value, in its unit, in the words of its frame.
    pub const fn value(&self, Words([word0, word1, word2, word3]): Words) -> Decimal {
        let (first, second) = match self.word {
            0 => (word0, word1),
            1 => (word1, word2),
            2 => (word2, word3),
            _ => (word3, 0),
        };
        let digits = match (self.words, self.signed) {
            (1, true) => first as i16 as i64,
            (1, false) => first as i64,
            (_, true) => long(first, second) as i32 as i64,
            (_, false) => long(first, second) as i64,
        };
        Decimal { digits, exponent: self.exponent }
    }
}

/// Every measurement of Figure 14 in the order of the frames. Speeds are mechanical and signed: reverse is
/// negative. Values beyond 16 bits saturate; the position wraps.
pub const SIGNALS: [Signal; 21] = [
    signal(0, 0, "Accel X", "g", -3),
    signal(0, 1, "Accel Y", "g", -3),
    signal(0, 2, "Accel Z", "g", -3),
    digital(0, 3, "DSI1_DSP"),
    signal(1, 0, "Mechanical estimated speed SL", "rpm", 0),
    Signal { words: 2, ..signal(1, 1, "Mechanical position", "deg", -2) },
    signal(1, 3, "Electrical input Power", "W", -1),
    signal(2, 0, "HV Voltage", "V", -2),
    signal(2, 1, "HV Current", "A", -3),
    signal(2, 2, "+6V_MEAS", "V", -3),
    signal(2, 3, "Driver 14V Voltage", "V", -3),
    signal(3, 0, "Ambient Temperature", "°C", -1),
    signal(3, 1, "Vref Accel (+1.8V)", "V", -3),
    signal(3, 2, "+0.383VREF", "V", -3),
    signal(3, 3, "ASI_DSP", "V", -3),
    signal(4, 0, "VoltagePhaseA", "V", -2),
    signal(4, 1, "VoltagePhaseB", "V", -2),
    signal(4, 2, "VoltagePhaseC", "V", -2),
    signal(4, 3, "PIN_MEAS", "V", -3),
    signal(5, 0, "Mechanical estimated speed HES", "rpm", 0),
    digital(5, 1, "DSI2_DSP"),
];

const fn signal(frame: u32, word: u8, name: &'static str, unit: &'static str, exponent: i8) -> Signal {
    let opcode = Opcode::masked(Opcode::MEASUREMENT_0.raw() as u32 + frame);
    Signal { opcode, word, words: 1, signed: true, name, unit, exponent }
}

const fn digital(frame: u32, word: u8, name: &'static str) -> Signal {
    Signal { signed: false, ..signal(frame, word, name, "-", 0) }
}
