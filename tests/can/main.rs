//! The CAN bus model: bits, arbitration, errors and load; and logs of a bus.

mod arbitration;
mod bits;
mod candump;
mod errors;
mod log;
mod slcan;

use narx_core::bus::{Frame, Id};

/// 29-bit data frame.
fn extended(id: u32, bytes: &[u8]) -> Frame {
    Frame::data(Id::extended(id).unwrap(), bytes).unwrap()
}

/// 11-bit data frame.
fn standard(id: u16, bytes: &[u8]) -> Frame {
    Frame::data(Id::standard(id).unwrap(), bytes).unwrap()
}
