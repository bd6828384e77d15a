//! Contents of process data objects (Figures 2 to 5).
//!
//! ```text
//!  byte          0     1     2     3     4     5     6     7
//!  1 channel     |  position 1           |
//!    and encoder |  position 1           |  encoder  |
//!  2 channels    |  position 1           |  position 2           |
//!    and encoder |  position 1     |  position 2     |  encoder  |
//! ```

use serde::{Deserialize, Serialize};

/// A position in 2^-27 mm, two's complement: from -16 mm to almost 16 mm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Position(i32);

/// Sensors of a driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Channels {
    /// One.
    Single,
    /// Two.
    Dual,
}

/// Layout of a PDO, one of four.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Layout {
    /// Sensors of the driver.
    pub channels: Channels,
    /// The encoder's value follows the positions.
    pub encoder: bool,
}

/// Readings of one instant. A value that the layout does not carry is decoded as 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Reading {
    /// Position of each channel.
    pub positions: [Position; 2],
    /// Counts of the encoder, 4 to a period: two's complement of a linear encoder, unsigned of a rotary one.
    pub encoder: u16,
}

/// Picometres of a millimetre.
const PER_MILLIMETRE: i64 = 1_000_000_000;

impl Position {
    /// The smallest.
    pub const MIN: Self = Self(i32::MIN);
    /// The largest.
    pub const MAX: Self = Self(i32::MAX);

    /// A position of `raw` times 2^-27 mm.
    pub const fn from_raw(raw: i32) -> Self {
        Self(raw)
    }

    /// In 2^-27 mm.
    pub const fn raw(self) -> i32 {
        self.0
    }

    /// The nearest position; a value beyond the range becomes the end of the range.
    pub fn from_picometres(picometres: i64) -> Self {
        // Beyond 17 mm it saturates anyway, and the product below must not.
        let bounded = picometres.clamp(-17 * PER_MILLIMETRE, 17 * PER_MILLIMETRE);
        let raw = ((bounded << 27) + PER_MILLIMETRE / 2).div_euclid(PER_MILLIMETRE);
        Self(raw.clamp(i32::MIN.into(), i32::MAX.into()) as i32)
    }

    /// In 10^-12 m, to the nearest.
    pub const fn picometres(self) -> i64 {
        (self.0 as i64 * PER_MILLIMETRE + (1 << 26)) >> 27
    }
}

impl Layout {
    /// The layouts of Figures 2, 3, 4 and 5.
    pub const ALL: [Self; 4] = [
        Self { channels: Channels::Single, encoder: false },
        Self { channels: Channels::Dual, encoder: false },
        Self { channels: Channels::Single, encoder: true },
        Self { channels: Channels::Dual, encoder: true },
    ];

    /// Data bytes.
    pub const fn length(self) -> u8 {
        match (self.channels, self.encoder) {
            (Channels::Single, false) => 4,
            (Channels::Single, true) => 6,
            (Channels::Dual, _) => 8,
        }
    }

    /// The data: the first [`Self::length`] bytes count, the others are 0.
    pub const fn encode(self, reading: Reading) -> [u8; 8] {
        let Reading { positions: [first, second], encoder } = reading;
        let [a0, a1, a2, a3] = first.0.to_le_bytes();
        let [b0, b1, b2, b3] = second.0.to_le_bytes();
        let [e0, e1] = encoder.to_le_bytes();
        match (self.channels, self.encoder) {
            (Channels::Single, false) => [a0, a1, a2, a3, 0, 0, 0, 0],
            (Channels::Single, true) => [a0, a1, a2, a3, e0, e1, 0, 0],
            (Channels::Dual, false) => [a0, a1, a2, a3, b0, b1, b2, b3],
            // The upper 24 of the 32 bits: a position in 2^-19 mm, rounded down.
            (Channels::Dual, true) => [a1, a2, a3, b1, b2, b3, e0, e1],
        }
    }

    /// Decodes the data; `None` if its length is not that of this layout.
    pub fn decode(self, data: &[u8]) -> Option<Reading> {
        let position = |bytes| Position(i32::from_le_bytes(bytes));
        let (positions, encoder) = match (self.channels, self.encoder, data) {
            (Channels::Single, false, &[a0, a1, a2, a3]) => {
                ([position([a0, a1, a2, a3]), Position(0)], [0, 0])
            }
            (Channels::Single, true, &[a0, a1, a2, a3, e0, e1]) => {
                ([position([a0, a1, a2, a3]), Position(0)], [e0, e1])
            }
            (Channels::Dual, false, &[a0, a1, a2, a3, b0, b1, b2, b3]) => {
                ([position([a0, a1, a2, a3]), position([b0, b1, b2, b3])], [0, 0])
            }
            (Channels::Dual, true, &[a1, a2, a3, b1, b2, b3, e0, e1]) => {
                ([position([0, a1, a2, a3]), position([0, b1, b2, b3])], [e0, e1])
            }
            _ => return None,
        };
        Some(Reading { positions, encoder: u16::from_le_bytes(encoder) })
    }
}
