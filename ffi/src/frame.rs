//! CAN frames.

use crate::status::narx_status_t::{self, *};
use narx_core::bus::{Frame, Id};

/// A classic CAN frame.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_frame_t {
    /// Identifier: 11 bits, or 29 if `extended`.
    pub id: u32,
    /// Not 0: the identifier has 29 bits.
    pub extended: u8,
    /// Not 0: a remote request, without data.
    pub remote: u8,
    /// Number of data bytes, or of those that a remote frame requests: 0 to 8.
    pub length: u8,
    /// Data bytes; the first `length` are valid.
    pub data: [u8; 8],
}

impl TryFrom<&narx_frame_t> for Frame {
    type Error = narx_status_t;

    fn try_from(frame: &narx_frame_t) -> Result<Self, narx_status_t> {
        let id = if frame.extended != 0 {
            Id::extended(frame.id)
        } else {
            u16::try_from(frame.id).ok().and_then(Id::standard)
        };
        let id = id.ok_or(NARX_ERROR_FRAME)?;
        let data = frame.data.get(..frame.length.into()).ok_or(NARX_ERROR_FRAME)?;
        let converted = if frame.remote != 0 { Self::remote(id, frame.length) } else { Self::data(id, data) };
        converted.ok_or(NARX_ERROR_FRAME)
    }
}

impl From<Frame> for narx_frame_t {
    fn from(frame: Frame) -> Self {
        let mut data = [0; 8];
        for (to, from) in data.iter_mut().zip(frame.payload()) {
            *to = *from;
        }
        Self {
            id: frame.id().raw(),
            extended: frame.id().is_extended().into(),
            remote: frame.is_remote().into(),
            length: frame.dlc(),
            data,
        }
    }
}
