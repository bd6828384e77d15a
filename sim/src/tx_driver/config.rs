//! Configuration of a TX-Driver on a bench.

use crate::sensor::{EddyCurrentConfig, Encoder, SensorError, Target};
use core::fmt;
use narx_core::bus::eddycan::{Channels, NodeId};
use narx_core::eddycan::{Configuration, Entry};

/// A TX-Driver, its sensors and its encoder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TxDriverConfig {
    /// Configuration in its memory.
    pub configuration: Configuration,
    /// Sensors of it.
    pub channels: Channels,
    /// The sensors; the second one of a driver of one channel is not there.
    pub sensors: [EddyCurrentConfig; 2],
    /// Its encoder.
    pub encoder: Option<Encoder>,
}

impl TxDriverConfig {
    /// A driver of one channel of 2 mm with factory values but for its node-id. It looks at the shaft's
    /// surface; a second channel would a quarter of the way around.
    pub fn new(node: NodeId) -> Self {
        let mut configuration = Configuration::new();
        // Every node-id is one of the entry's values.
        let _ = configuration.set(Entry::NodeId, node.raw().into());
        let sensors = [0.0, 90.0].map(|bearing| EddyCurrentConfig::new(2.0, Target::surface(1.0, bearing)));
        Self { configuration, channels: Channels::Single, sensors, encoder: None }
    }
}

/// Reason why a TX-Driver cannot be added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AddError {
    /// One of its sensors cannot be.
    Sensor(SensorError),
    /// The bus has no place left.
    NoPlace,
}

impl fmt::Display for AddError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sensor(error) => error.fmt(f),
            Self::NoPlace => f.write_str("the bus has no place left for another node"),
        }
    }
}

impl core::error::Error for AddError {}

impl From<SensorError> for AddError {
    fn from(error: SensorError) -> Self {
        Self::Sensor(error)
    }
}
