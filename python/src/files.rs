//! Files for other tools, as they are committed.

use crate::error::Given;
use crate::tx_master;
use narx_core::bus::eddycan::Channels;
use narx_core::bus::narmotion::Addresses;
use narx_core::description::Document;
use narx_sim::bench::IDENTITY;
use pyo3::prelude::*;

/// Returns the CAN database of the drive's messages (DBC).
#[pyfunction]
pub(crate) const fn dbc() -> &'static str {
    include_str!("files/narx.dbc")
}

/// Returns the electronic data sheet (EDS) of a TX-Driver with this number of channels, whose PDOs have the
/// encoder or not.
#[pyfunction]
#[pyo3(signature = (channels=Given::Whole(1), encoder=false), text_signature = "(channels=1, encoder=False)")]
pub(crate) fn eds(channels: Given, encoder: bool) -> PyResult<&'static str> {
    Ok(match (tx_master::channels(channels)?, encoder) {
        (Channels::Single, false) => include_str!("files/eddycan-single.eds"),
        (Channels::Single, true) => include_str!("files/eddycan-single-encoder.eds"),
        (Channels::Dual, false) => include_str!("files/eddycan-dual.eds"),
        (Channels::Dual, true) => include_str!("files/eddycan-dual-encoder.eds"),
    })
}

/// Returns the description (XML) that a drive of this version serves. With other addresses or another board
/// its first line differs.
#[pyfunction]
pub(crate) fn xml() -> String {
    let document = Document { identity: IDENTITY, addresses: Addresses::FACTORY, tick_rate: 10_000 };
    let mut text = String::new();
    // Writing into a string cannot fail.
    let _ = document.write(&mut text);
    text
}
