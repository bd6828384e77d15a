//! A classic CAN frame.

use core::cmp::Ordering;
use core::fmt;
use embedded_can::{ExtendedId, StandardId};
use serde::{Deserialize, Serialize};

/// A CAN identifier that cannot be out of range: outside of this crate it is made by [`Id::standard`] and
/// [`Id::extended`] alone. Sorts as the bus arbitrates: the smaller one wins.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "u32", into = "u32")]
pub enum Id {
    /// 11 bits.
    #[non_exhaustive]
    Standard {
        /// The number, 0..=7FFh.
        raw: u16,
    },
    /// 29 bits.
    #[non_exhaustive]
    Extended {
        /// The number, 0..=1FFF_FFFFh.
        raw: u32,
    },
}

/// Marks a 29-bit identifier in the serialised form.
const EXTENDED: u32 = 1 << 31;

impl Id {
    /// An 11-bit identifier, or `None` above 7FFh.
    pub const fn standard(raw: u16) -> Option<Self> {
        if raw < 1 << 11 { Some(Self::Standard { raw }) } else { None }
    }

    /// A 29-bit identifier, or `None` above 1FFF_FFFFh.
    pub const fn extended(raw: u32) -> Option<Self> {
        if raw < 1 << 29 { Some(Self::Extended { raw }) } else { None }
    }

    /// A 29-bit identifier of the low 29 bits of `raw`.
    pub(super) const fn extended_masked(raw: u32) -> Self {
        Self::Extended { raw: raw & 0x1FFF_FFFF }
    }

    /// An 11-bit identifier of the low 11 bits of `raw`.
    pub(super) const fn standard_masked(raw: u16) -> Self {
        Self::Standard { raw: raw & 0x7FF }
    }

    /// Returns whether the identifier has 29 bits.
    pub const fn is_extended(self) -> bool {
        matches!(self, Self::Extended { .. })
    }

    /// The serialised form.
    const fn marked(self) -> u32 {
        self.raw() | if self.is_extended() { EXTENDED } else { 0 }
    }

    /// The identifier's number.
    pub const fn raw(self) -> u32 {
        match self {
            Self::Standard { raw } => raw as u32,
            Self::Extended { raw } => raw,
        }
    }
}

/// A classic CAN frame: up to 8 data bytes, or a remote request for that many.
#[derive(Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "Parts", into = "Parts")]
pub struct Frame {
    /// The identifier in its serialised form: a frame then takes 16 bytes instead of 20, and there are dozens
    /// in queues.
    id: u32,
    remote: bool,
    length: u8,
    data: [u8; 8],
}

impl Frame {
    /// A data frame, or `None` with more than 8 bytes.
    pub fn data(id: Id, bytes: &[u8]) -> Option<Self> {
        let mut data = [0; 8];
        data.get_mut(..bytes.len())?.copy_from_slice(bytes);
        Some(Self { id: id.marked(), remote: false, length: bytes.len() as u8, data })
    }

    /// A data frame of 8 bytes.
    pub const fn full(id: Id, data: [u8; 8]) -> Self {
        Self { id: id.marked(), remote: false, length: 8, data }
    }

    /// A remote frame that asks for `dlc` bytes, or `None` above 8.
    pub const fn remote(id: Id, dlc: u8) -> Option<Self> {
        if dlc <= 8 { Some(Self { id: id.marked(), remote: true, length: dlc, data: [0; 8] }) } else { None }
    }

    /// A data frame of the first `length` bytes, at most 8; the others must be 0.
    pub(super) const fn short(id: Id, data: [u8; 8], length: u8) -> Self {
        Self { id: id.marked(), remote: false, length: if length < 8 { length } else { 8 }, data }
    }

    /// A remote frame that asks for `dlc` bytes, at most 8.
    pub(super) const fn remote_clamped(id: Id, dlc: u8) -> Self {
        Self { id: id.marked(), remote: true, length: if dlc < 8 { dlc } else { 8 }, data: [0; 8] }
    }

    /// The identifier.
    pub const fn id(&self) -> Id {
        let raw = self.id & !EXTENDED;
        if self.id & EXTENDED != 0 { Id::Extended { raw } } else { Id::Standard { raw: raw as u16 } }
    }

    /// Returns whether this is a remote frame.
    pub const fn is_remote(&self) -> bool {
        self.remote
    }

    /// The data length code, 0..=8. A remote frame has one, too, but no data.
    pub const fn dlc(&self) -> u8 {
        self.length
    }

    /// The data bytes; none in a remote frame.
    pub fn payload(&self) -> &[u8] {
        let length = if self.remote { 0 } else { usize::from(self.length) };
        self.data.get(..length).unwrap_or(&[])
    }

    /// The data bytes of a data frame of exactly 8.
    pub const fn full_payload(&self) -> Option<[u8; 8]> {
        if self.remote || self.length != 8 { None } else { Some(self.data) }
    }
}

impl fmt::Debug for Frame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { remote, length, data, .. } = self;
        let mut frame = f.debug_struct("Frame");
        frame
            .field("id", &self.id())
            .field("remote", remote)
            .field("length", length)
            .field("data", data)
            .finish()
    }
}

/// Identifier or frame parts that no CAN frame has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InvalidFrame;

impl fmt::Display for InvalidFrame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("not a CAN frame: identifier or length out of range")
    }
}

impl core::error::Error for InvalidFrame {}

/// The form in which a frame is serialised.
#[derive(Serialize, Deserialize)]
struct Parts(Id, bool, u8, [u8; 8]);

impl From<Frame> for Parts {
    fn from(frame: Frame) -> Self {
        Self(frame.id(), frame.remote, frame.length, frame.data)
    }
}

impl TryFrom<Parts> for Frame {
    type Error = InvalidFrame;

    fn try_from(Parts(id, remote, length, data): Parts) -> Result<Self, InvalidFrame> {
        let used = if remote { 0 } else { usize::from(length) };
        let padding = data.get(used..).unwrap_or(&[]);
        if length > 8 || padding.iter().any(|byte| *byte != 0) {
            return Err(InvalidFrame);
        }
        Ok(Self { id: id.marked(), remote, length, data })
    }
}

impl From<Id> for u32 {
    fn from(id: Id) -> Self {
        id.marked()
    }
}

impl TryFrom<u32> for Id {
    type Error = InvalidFrame;

    /// Bit 31 set: 29-bit identifier.
    fn try_from(marked: u32) -> Result<Self, InvalidFrame> {
        let raw = marked & !EXTENDED;
        let id =
            if marked & EXTENDED != 0 { Self::extended(raw) } else { Self::standard(raw.min(0xFFFF) as u16) };
        id.ok_or(InvalidFrame)
    }
}

impl From<Id> for embedded_can::Id {
    fn from(id: Id) -> Self {
        match id {
            Id::Standard { raw } => Self::Standard(StandardId::new(raw).unwrap_or(StandardId::MAX)),
            Id::Extended { raw } => Self::Extended(ExtendedId::new(raw).unwrap_or(ExtendedId::MAX)),
        }
    }
}

impl From<embedded_can::Id> for Id {
    fn from(id: embedded_can::Id) -> Self {
        match id {
            embedded_can::Id::Standard(id) => Self::Standard { raw: id.as_raw() },
            embedded_can::Id::Extended(id) => Self::extended_masked(id.as_raw()),
        }
    }
}

impl fmt::Display for Id {
    /// As candump writes it: 3 or 8 hexadecimal digits.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = if self.is_extended() { 8 } else { 3 };
        write!(f, "{:0width$X}", self.raw())
    }
}

impl fmt::Debug for Id {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Id({self})")
    }
}

impl Ord for Id {
    fn cmp(&self, other: &Self) -> Ordering {
        embedded_can::Id::from(*self).cmp(&embedded_can::Id::from(*other))
    }
}

impl PartialOrd for Id {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl embedded_can::Frame for Frame {
    fn new(id: impl Into<embedded_can::Id>, data: &[u8]) -> Option<Self> {
        Self::data(id.into().into(), data)
    }

    fn new_remote(id: impl Into<embedded_can::Id>, dlc: usize) -> Option<Self> {
        Self::remote(id.into().into(), u8::try_from(dlc).ok()?)
    }

    fn is_extended(&self) -> bool {
        Self::id(self).is_extended()
    }

    fn is_remote_frame(&self) -> bool {
        self.remote
    }

    fn id(&self) -> embedded_can::Id {
        Self::id(self).into()
    }

    fn dlc(&self) -> usize {
        usize::from(self.length)
    }

    fn data(&self) -> &[u8] {
        self.payload()
    }
}
