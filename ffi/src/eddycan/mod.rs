//! eddyCAN: the TX-Driver, its master, and its messages.

mod device;
mod master;
mod message;

pub use device::{
    NARX_TX_DRIVER_WORDS, NARX_TX_VALUES, narx_tx_driver_handle_bus_state, narx_tx_driver_handle_frame,
    narx_tx_driver_handle_sample, narx_tx_driver_handle_store, narx_tx_driver_init, narx_tx_driver_next_poll,
    narx_tx_driver_poll, narx_tx_driver_poll_frame, narx_tx_driver_poll_store, narx_tx_driver_report,
    narx_tx_driver_report_t, narx_tx_driver_size, narx_tx_driver_t, narx_tx_driver_take_reset,
    narx_tx_variant_t,
};
pub use master::{
    NARX_TX_MASTER_WORDS, narx_tx_answer_t, narx_tx_master_ask_positions, narx_tx_master_command,
    narx_tx_master_handle_frame, narx_tx_master_init, narx_tx_master_next_poll, narx_tx_master_poll_answer,
    narx_tx_master_poll_frame, narx_tx_master_read, narx_tx_master_report, narx_tx_master_size,
    narx_tx_master_sync, narx_tx_master_t, narx_tx_master_write, narx_tx_node_report_t,
};
pub use message::{
    narx_tx_kind_t, narx_tx_layout_t, narx_tx_message_decode, narx_tx_message_encode, narx_tx_message_t,
};

use crate::status::narx_status_t::{self, *};
use narx_core::bus::eddycan::NodeId;
use narx_core::eddycan::{Entry, OBJECTS};

/// Returns the node-id with this number.
fn node(number: u8) -> Result<NodeId, narx_status_t> {
    NodeId::new(number).ok_or(NARX_ERROR_NODE)
}

/// Returns the entry with this number, a NARX_TX_ENTRY_*.
fn entry(number: u8) -> Result<Entry, narx_status_t> {
    OBJECTS.get(usize::from(number)).map(|object| object.entry).ok_or(NARX_ERROR_UNKNOWN_ENTRY)
}
