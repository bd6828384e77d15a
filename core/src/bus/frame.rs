//! A classic CAN frame.

use serde::{Deserialize, Serialize};

/// A CAN identifier that cannot be out of range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Id {
    /// 11 bits.
    Standard(u16),
    /// 29 bits.
    Extended(u32),
}

/// A classic CAN frame: up to 8 data bytes, or a remote request for that many.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Frame {
    id: Id,
    remote: bool,
    length: u8,
    data: [u8; 8],
}
