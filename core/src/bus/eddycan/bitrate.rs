//! Bitrates (Tables 1 and 6) and the time that frames take.

use serde::{Deserialize, Serialize};

/// A bitrate by its index in entry 2001h.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[repr(u8)]
pub enum Bitrate {
    /// 50 kbit/s.
    K50 = 0,
    /// 100 kbit/s.
    K100 = 1,
    /// 250 kbit/s.
    K250 = 2,
    /// 500 kbit/s.
    K500 = 3,
    /// 1 Mbit/s.
    M1 = 4,
}

impl Bitrate {
    /// Every bitrate in the order of the indices.
    pub const ALL: [Self; 5] = [Self::K50, Self::K100, Self::K250, Self::K500, Self::M1];

    /// The bitrate of an index, or `None` above 4.
    pub const fn from_index(index: u8) -> Option<Self> {
        match index {
            0 => Some(Self::K50),
            1 => Some(Self::K100),
            2 => Some(Self::K250),
            3 => Some(Self::K500),
            4 => Some(Self::M1),
            _ => None,
        }
    }

    /// Length of one bit, microseconds: exact for all of them.
    pub const fn bit_us(self) -> u32 {
        match self {
            Self::K50 => 20,
            Self::K100 => 10,
            Self::K250 => 4,
            Self::K500 => 2,
            Self::M1 => 1,
        }
    }

    /// Bits per second.
    pub const fn bits_per_second(self) -> u32 {
        1_000_000 / self.bit_us()
    }

    /// Longest cable, metres (Table 1).
    pub const fn cable_metres(self) -> u16 {
        match self {
            Self::K50 => 1000,
            Self::K100 => 500,
            Self::K250 => 250,
            Self::K500 => 50,
            Self::M1 => 25,
        }
    }

    /// The longest that a frame with an 11-bit identifier and `bytes` data bytes occupies the bus for,
    /// microseconds: stuff bits and the gap to the next frame included.
    pub const fn longest_frame_us(self, bytes: u8) -> u32 {
        let data = 8 * bytes as u32;
        (47 + data + (33 + data) / 4) * self.bit_us()
    }
}
