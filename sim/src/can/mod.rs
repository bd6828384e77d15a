//! The CAN bus: frames bit for bit as they occupy the wire, arbitration, errors and load.
//!
//! ```text
//!  send(node, frame, t) ──> queue ─┐
//!  send(node, frame, t) ──> queue ─┼─> arbitration ─> wire (exact bits) ─> receive queues of all others
//!  send(node, frame, t) ──> queue ─┘        └────── error frame, again ──────┘
//! ```
//!
//! Section references are to ISO 11898-1 (classic frames, base and extended format).

mod bits;
mod bus;
mod node;

pub use bits::{WireBits, arbitration_field, frame_bits, worst_case_bits};
pub use bus::{Bus, BusStatistics, NotQueued};
pub use narx_core::bus::ErrorState;
pub use node::{Attachment, NodeIndex, Received};
