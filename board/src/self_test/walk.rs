//! The program in its flash: a slow walk with a CRC, over and over, compared with the sum that boot has
//! found.
//!
//! The walk does not show whether the program was the right one at boot: the signature does, where a
//! bootloader verifies it.

use crc::{CRC_32_ISO_HDLC, Crc, Digest, NoTable};

/// Without a table: a kilobyte of flash is more than the time that it saves.
static CRC32: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// A walk over a program.
#[derive(Clone)]
pub struct Walk {
    expected: u32,
    at: usize,
    sum: Digest<'static, u32, NoTable>,
    is_intact: bool,
}

impl Walk {
    /// Sums up the whole of `program`, once.
    pub fn new(program: &[u8]) -> Self {
        Self { expected: CRC32.checksum(program), at: 0, sum: CRC32.digest(), is_intact: true }
    }

    /// Walks on by `bytes` of the same program. False from the end of the first round on whose sum was
    /// another one.
    pub fn step(&mut self, program: &[u8], bytes: usize) -> bool {
        let rest = program.get(self.at..).unwrap_or_default();
        let piece = rest.get(..bytes).unwrap_or(rest);
        self.sum.update(piece);
        self.at += piece.len();
        if self.at >= program.len() {
            self.is_intact &= core::mem::replace(&mut self.sum, CRC32.digest()).finalize() == self.expected;
            self.at = 0;
        }
        self.is_intact
    }

    /// The sum that boot has found.
    pub const fn sum(&self) -> u32 {
        self.expected
    }
}
