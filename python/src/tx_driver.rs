//! TX-Drivers on the bus of a bench.

use crate::error;
use crate::tx_master;
use narx_core::eddycan::Entry;
use narx_sim::sensor::{EddyCurrentConfig, Encoder, Target};
use narx_sim::tx_driver::TxDriverConfig;
use pyo3::prelude::*;

/// Builds the configuration of a TX-Driver that measures the distance of the shaft's surface, with a rotary
/// encoder of `encoder` counts on the shaft; measuring range in mm.
pub(crate) fn config(
    node_id: i128,
    channels: i128,
    encoder: Option<i128>,
    measuring_range: f64,
) -> PyResult<TxDriverConfig> {
    let (node, channels) = (tx_master::node(node_id)?, tx_master::channels(channels)?);
    let mut config = TxDriverConfig { channels, ..TxDriverConfig::new(node) };
    let range = error::finite("measuring_range", measuring_range, "mm")?;
    config.sensors =
        [0.0, 90.0].map(|bearing| EddyCurrentConfig::new(range, Target::surface(range / 2.0, bearing)));
    if let Some(counts) = encoder {
        let refused =
            || error::parameter(format!("encoder {counts}: must be a number of counts from 1 to 65535"));
        let counts = u16::try_from(counts).ok().filter(|counts| *counts > 0).ok_or_else(refused)?;
        config.encoder = Some(Encoder::Rotary { counts });
        config.configuration.set(Entry::CountsPerRevolution, counts.into()).map_err(|_| refused())?;
    }
    Ok(config)
}
