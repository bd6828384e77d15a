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

impl Id {
    /// An 11-bit identifier.
    pub const fn standard(id: u16) -> Option<Self> {
        if id < 1 << 11 { Some(Self::Standard(id)) } else { None }
    }
    /// A 29-bit identifier.
    pub const fn extended(id: u32) -> Option<Self> {
        if id < 1 << 29 { Some(Self::Extended(id)) } else { None }
    }
}

/// A classic CAN frame: up to 8 data bytes, or a remote request for that many.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Frame {
    id: Id,
    remote: bool,
    length: u8,
    data: [u8; 8],
}

impl Frame {
    /// A data frame; `None` for more than 8 bytes.
    pub fn data(id: Id, bytes: &[u8]) -> Option<Self> {
        let mut data = [0; 8];
        data.get_mut(..bytes.len())?.copy_from_slice(bytes);
        Some(Self { id, remote: false, length: bytes.len() as u8, data })
    }
    /// A remote frame that asks for `dlc` bytes; `None` for more than 8.
    pub const fn remote(id: Id, dlc: u8) -> Option<Self> {
        if dlc <= 8 { Some(Self { id, remote: true, length: dlc, data: [0; 8] }) } else { None }
    }
    /// Identifier.
    pub const fn id(&self) -> Id {
        self.id
    }
    /// Whether it asks for data instead of carrying them.
    pub const fn is_remote(&self) -> bool {
        self.remote
    }
    /// Data length code, 0..=8.
    pub const fn dlc(&self) -> u8 {
        self.length
    }
    /// The data bytes; none in a remote frame.
    pub fn payload(&self) -> &[u8] {
        if self.remote { &[] } else { self.data.get(..usize::from(self.length)).unwrap_or(&[]) }
    }
}
