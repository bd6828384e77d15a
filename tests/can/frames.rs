//! Short constructors of data frames.

use narx_core::bus::{Frame, Id};

/// 29-bit data frame.
pub(crate) fn extended(id: u32, bytes: &[u8]) -> Frame {
    Frame::data(Id::extended(id).unwrap(), bytes).unwrap()
}

/// 11-bit data frame.
pub(crate) fn standard(id: u16, bytes: &[u8]) -> Frame {
    Frame::data(Id::standard(id).unwrap(), bytes).unwrap()
}
