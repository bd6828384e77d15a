//! TX-Drivers on the bus of a bench.

use crate::error::{self, Given};
use crate::tx_master;
use narx_core::eddycan::Entry;
use narx_sim::sensor::{EddyCurrentConfig, Encoder, Target};
use narx_sim::tx_driver::TxDriverConfig;
use pyo3::prelude::*;

/// Builds the configuration of a TX-Driver that measures the distance of the shaft's surface, with a rotary
/// encoder of `encoder` counts on the shaft; measuring range in mm.
pub(crate) fn config(
    node_id: Given,
    channels: Given,
    encoder: Option<Given>,
    measuring_range: Given,
) -> PyResult<TxDriverConfig> {
    let (node, channels) = (tx_master::node(node_id)?, tx_master::channels(channels)?);
    let mut config = TxDriverConfig { channels, ..TxDriverConfig::new(node) };
    let range = error::finite("measuring_range", measuring_range, "mm")?;
    config.sensors =
        [0.0, 90.0].map(|bearing| EddyCurrentConfig::new(range, Target::surface(range / 2.0, bearing)));
    if let Some(counts) = encoder {
        let counts = error::whole("encoder", counts, "", 1, u16::MAX)?;
        config.encoder = Some(Encoder::Rotary { counts });
        config.configuration.set(Entry::CountsPerRevolution, counts.into()).map_err(error::parameter)?;
    }
    Ok(config)
}
