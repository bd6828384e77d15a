//! Numbers in and out of bytes.

use super::{CHUNK_BYTES, ReadError};
use heapless::Vec;

/// Payload of a chunk in the making.
pub(super) type Payload = Vec<u8, CHUNK_BYTES>;

/// Appends a LEB128 varint; `None` when the payload is full.
pub(super) fn push_varint(out: &mut Payload, mut value: u64) -> Option<()> {
    while value > 0x7f {
        out.push(value as u8 | 0x80).ok()?;
        value >>= 7;
    }
    out.push(value as u8).ok()
}

/// Maps numbers of small magnitude and either sign to small numbers: 0, -1, 1, -2 to 0, 1, 2, 3.
pub(super) const fn zigzag(value: i64) -> u64 {
    ((value << 1) ^ (value >> 63)) as u64
}

/// The inverse of [`zigzag`].
pub(super) const fn unzigzag(value: u64) -> i64 {
    (value >> 1) as i64 ^ -((value & 1) as i64)
}

/// Reads from a slice and knows where in the file it is.
#[derive(Clone, Debug)]
pub(super) struct Cursor<'a> {
    rest: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    /// Reads `bytes`, the first of which stands at offset `at` of the file.
    pub(super) const fn new(bytes: &'a [u8], at: usize) -> Self {
        Self { rest: bytes, at }
    }

    /// Offset of the next byte in the file.
    pub(super) const fn at(&self) -> usize {
        self.at
    }

    /// The bytes not yet read.
    pub(super) const fn rest(&self) -> &'a [u8] {
        self.rest
    }

    /// The next `count` bytes.
    pub(super) fn take(&mut self, count: usize, expected: &'static str) -> Result<&'a [u8], ReadError> {
        let Some((taken, rest)) = self.rest.split_at_checked(count) else {
            return Err(ReadError::Truncated { at: self.at.saturating_add(self.rest.len()), expected });
        };
        self.rest = rest;
        self.at = self.at.saturating_add(count);
        Ok(taken)
    }

    /// One byte.
    pub(super) fn u8(&mut self, expected: &'static str) -> Result<u8, ReadError> {
        self.array::<1>(expected).map(|[byte]| byte)
    }

    /// Two bytes, little endian.
    pub(super) fn u16(&mut self, expected: &'static str) -> Result<u16, ReadError> {
        self.array(expected).map(u16::from_le_bytes)
    }

    /// Four bytes, little endian.
    pub(super) fn u32(&mut self, expected: &'static str) -> Result<u32, ReadError> {
        self.array(expected).map(u32::from_le_bytes)
    }

    /// Eight bytes, little endian.
    pub(super) fn u64(&mut self, expected: &'static str) -> Result<u64, ReadError> {
        self.array(expected).map(u64::from_le_bytes)
    }

    /// A varint of at most ten bytes.
    pub(super) fn varint(&mut self, expected: &'static str) -> Result<u64, ReadError> {
        let start = self.at;
        let mut value = 0u64;
        for shift in (0..64).step_by(7) {
            let byte = self.u8(expected)?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                return Ok(value);
            }
        }
        Err(ReadError::Malformed { at: start, expected })
    }

    fn array<const N: usize>(&mut self, expected: &'static str) -> Result<[u8; N], ReadError> {
        let mut array = [0; N];
        for (to, from) in array.iter_mut().zip(self.take(N, expected)?) {
            *to = *from;
        }
        Ok(array)
    }
}
