//! Which TX-Drivers stand on the drive's bus.

use narx_core::bus::eddycan::{Channels, NodeId};
use narx_core::eddycan::{Configuration, Entry};
use narx_sim::sensor::Encoder;
use narx_sim::tx_driver::TxDriverConfig;

/// Drivers with different node-ids (1 to 127), with commas between: a node-id alone has one channel, `:dual`
/// behind it makes two. Each has a rotary encoder on the shaft, whose counts are the factory's.
///
/// # Errors
/// Description of a valid list, in words.
pub fn parse(list: &str) -> Result<Vec<TxDriverConfig>, &'static str> {
    let mut drivers: Vec<TxDriverConfig> = Vec::new();
    for text in list.split(',') {
        let driver = driver(text.trim()).filter(|new| drivers.iter().all(|old| node(old) != node(new)));
        drivers.push(driver.ok_or(
            "must be different node-ids from 1 to 127, with commas between, and :dual behind those with two channels",
        )?);
    }
    Ok(drivers)
}

fn driver(text: &str) -> Option<TxDriverConfig> {
    let (node, channels) = match text.split_once(':') {
        None => (text, Channels::Single),
        Some((node, "dual")) => (node, Channels::Dual),
        Some(_) => return None,
    };
    let config = TxDriverConfig::new(NodeId::new(node.parse().ok()?)?);
    let counts = Configuration::new().get(Entry::CountsPerRevolution) as u16;
    Some(TxDriverConfig { channels, encoder: Some(Encoder::Rotary { counts }), ..config })
}

fn node(driver: &TxDriverConfig) -> NodeId {
    driver.configuration.node()
}

/// One of them for people.
pub fn title(driver: &TxDriverConfig) -> String {
    let channels = match driver.channels {
        Channels::Single => "1 channel",
        Channels::Dual => "2 channels",
    };
    let range = driver.sensors[0].range;
    format!(
        "TX-Driver: node-id {}, {channels} of {range} mm, encoder on the shaft, eddyCAN at 500 kbit/s",
        node(driver).raw()
    )
}
