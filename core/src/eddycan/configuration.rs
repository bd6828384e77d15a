//! The values of the dictionary: always within their ranges, whoever has stored them.

use super::objects::{Entry, OBJECTS, Object, STORED, UPDATE_TIME_HALF_LOAD};
use crate::bus::eddycan::{AbortCode, Bitrate, Channels, Layout, NodeId};
use core::fmt;
use serde::{Deserialize, Serialize};

/// Values that a TX-Driver keeps over a restart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "[u32; STORED]", into = "[u32; STORED]")]
pub struct Configuration {
    /// In the order of the table.
    values: [u32; STORED],
}

/// Update time of PDO1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UpdateTime {
    /// Never.
    Off,
    /// With this period, ms.
    Every(u16),
    /// As often as half of the bus allows.
    HalfLoad,
}

/// Type of an encoder, and its counting direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EncoderSetup {
    /// Counts per revolution of a rotary encoder; `None` for a linear one.
    pub counts_per_revolution: Option<u16>,
    /// The counting direction is reversed.
    pub reverse: bool,
}

/// Stored values that the dictionary does not allow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InvalidConfiguration(
    /// The first such entry.
    pub Entry,
);

impl Configuration {
    /// Factory values.
    pub fn new() -> Self {
        let mut values = [0; STORED];
        for (value, object) in values.iter_mut().zip(&OBJECTS) {
            *value = object.default;
        }
        Self { values }
    }

    /// The value of an entry; 0 for one that has none.
    pub fn get(&self, entry: Entry) -> u32 {
        self.values.get(entry as usize).copied().unwrap_or(0)
    }

    /// The value of an entry, for code that acts on it: the factory value while the entry is blind.
    pub(super) fn acting(&self, entry: Entry) -> u32 {
        if entry.is_blind() { entry.object().default } else { self.get(entry) }
    }

    /// Gives an entry a value.
    ///
    /// # Errors
    /// The value is out of range, or the entry has none; nothing has changed.
    pub fn set(&mut self, entry: Entry, value: u32) -> Result<(), AbortCode> {
        let Some(stored) = self.values.get_mut(entry as usize) else { return Err(AbortCode::General) };
        if !entry.object().accepts(value) {
            return Err(AbortCode::RangeExceeded);
        }
        *stored = value;
        Ok(())
    }

    /// 2000h.
    pub fn node(&self) -> NodeId {
        NodeId::new(self.acting(Entry::NodeId) as u8).unwrap_or(NodeId::FACTORY)
    }

    /// 2001h.
    pub fn bitrate(&self) -> Bitrate {
        Bitrate::from_index(self.acting(Entry::BitrateIndex) as u8).unwrap_or(Bitrate::K500)
    }

    /// 2003h.
    pub fn update_time(&self) -> UpdateTime {
        match self.acting(Entry::UpdateTime) {
            0 => UpdateTime::Off,
            UPDATE_TIME_HALF_LOAD.. => UpdateTime::HalfLoad,
            milliseconds => UpdateTime::Every(milliseconds as u16),
        }
    }

    /// Operational after boot-up (bit 0 of 2004h).
    pub fn autostart(&self) -> bool {
        self.acting(Entry::CanConfig) & 1 != 0
    }

    /// Layout of the PDOs of a driver with these channels (bit 1 of 2004h).
    pub fn layout(&self, channels: Channels) -> Layout {
        Layout { channels, encoder: self.acting(Entry::CanConfig) & 2 != 0 }
    }

    /// A heartbeat every 2 s (bit 2 of 2004h).
    pub fn heartbeat(&self) -> bool {
        self.acting(Entry::CanConfig) & 4 != 0
    }

    /// 2005h and 2008h.
    pub fn encoder(&self) -> EncoderSetup {
        let register = self.acting(Entry::BasicConfig);
        let counts = self.acting(Entry::CountsPerRevolution) as u16;
        EncoderSetup {
            counts_per_revolution: (register & 2 != 0).then_some(counts),
            reverse: register & 4 != 0,
        }
    }

    /// Edge frequencies of both channels, Hz; `None` without a filter (2006h, Table 9).
    pub fn edges(&self) -> [Option<u32>; 2] {
        [Entry::Filter1, Entry::Filter2].map(|entry| match self.acting(entry) {
            1 => Some(10),
            2 => Some(100),
            3 => Some(1000),
            4 => Some(10_000),
            _ => None,
        })
    }

    /// Both comparator values, 2^-30 (2007h).
    pub fn comparators(&self) -> [u32; 2] {
        [Entry::Comparator1, Entry::Comparator2].map(|entry| self.acting(entry))
    }
}

impl Default for Configuration {
    fn default() -> Self {
        Self::new()
    }
}

impl TryFrom<[u32; STORED]> for Configuration {
    type Error = InvalidConfiguration;

    fn try_from(values: [u32; STORED]) -> Result<Self, InvalidConfiguration> {
        let wrong = |(object, value): (&Object, u32)| (!object.accepts(value)).then_some(object.entry);
        match OBJECTS.iter().zip(values).find_map(wrong) {
            Some(entry) => Err(InvalidConfiguration(entry)),
            None => Ok(Self { values }),
        }
    }
}

impl From<Configuration> for [u32; STORED] {
    fn from(configuration: Configuration) -> Self {
        configuration.values
    }
}

impl fmt::Display for InvalidConfiguration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Object { index, name, .. } = self.0.object();
        write!(f, "{index:04X}h \"{name}\" is stored with a value out of range")
    }
}

impl core::error::Error for InvalidConfiguration {}
