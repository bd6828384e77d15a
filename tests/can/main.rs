//! The CAN bus model: bits, arbitration, errors and load.

mod arbitration;
mod bits;
mod errors;
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
