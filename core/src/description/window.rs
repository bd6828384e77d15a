//! Destinations of lines: one keeps a piece of them, the other only their length and check value.

use core::fmt;
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};
use serde::{Deserialize, Serialize};

/// CRC without a table: it is computed once a power-up, in the background.
static CRC32: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// Skips the first bytes of a line and keeps the rest while there is room; when full, it ends the writing.
pub(super) struct Window<'a> {
    skip: usize,
    out: &'a mut [u8],
    written: usize,
}

impl<'a> Window<'a> {
    pub(super) fn new(skip: u16, out: &'a mut [u8]) -> Self {
        Self { skip: skip.into(), out, written: 0 }
    }

    pub(super) const fn written(&self) -> usize {
        self.written
    }
}

impl fmt::Write for Window<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let Some(bytes) = text.as_bytes().get(self.skip..) else {
            self.skip -= text.len();
            return Ok(());
        };
        self.skip = 0;
        let room = self.out.iter_mut().skip(self.written);
        let copied = room.zip(bytes).map(|(place, byte)| *place = *byte).count();
        self.written += copied;
        if copied == bytes.len() { Ok(()) } else { Err(fmt::Error) }
    }
}

/// Counts bytes, and computes the CRC-32 of all that were counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Measure {
    bytes: u32,
    check: u32,
}

impl Measure {
    /// Words of two bytes.
    pub const fn words(&self) -> u32 {
        self.bytes.div_ceil(2)
    }

    /// CRC-32 (ISO-HDLC) of the words, high byte first; an odd last byte is filled up with a line's end.
    pub fn check(mut self) -> u32 {
        if !self.bytes.is_multiple_of(2) {
            self.add(b"\n");
        }
        self.check
    }

    fn add(&mut self, bytes: &[u8]) {
        // The CRC register before the final inversion, in the bit order that the algorithm starts with.
        let mut digest = CRC32.digest_with_initial((!self.check).reverse_bits());
        digest.update(bytes);
        self.check = digest.finalize();
        self.bytes = self.bytes.saturating_add(bytes.len() as u32);
    }
}

impl fmt::Write for Measure {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.add(text.as_bytes());
        Ok(())
    }
}
