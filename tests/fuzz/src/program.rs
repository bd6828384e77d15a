//! An input as a program: its bytes are read from front to back, little endian. After the end zeros follow,
//! so that every input is a valid program.

use narx_core::bus::{Frame, Id};

/// Rest of an input.
#[derive(Clone, Copy, Debug)]
pub struct Program<'a>(pub &'a [u8]);

/// Bit of a frame's head for a 29-bit identifier: the other bits, modulo 9, are the data length code.
const EXTENDED: u8 = 1 << 7;
const REMOTE: u8 = 1 << 6;
const LENGTH: u8 = 0x0F;

impl<'a> Program<'a> {
    /// Returns whether the program has ended.
    pub const fn is_over(&self) -> bool {
        self.0.is_empty()
    }

    /// Reads the next bytes.
    pub fn array<const N: usize>(&mut self) -> [u8; N] {
        let mut bytes = [0; N];
        let (now, later) = self.0.split_at(N.min(self.0.len()));
        bytes[..now.len()].copy_from_slice(now);
        self.0 = later;
        bytes
    }

    /// Reads the next bytes, as many as are left.
    pub fn take(&mut self, length: usize) -> &'a [u8] {
        let (now, later) = self.0.split_at(length.min(self.0.len()));
        self.0 = later;
        now
    }

    /// Reads 8 bits.
    pub fn byte(&mut self) -> u8 {
        u8::from_le_bytes(self.array())
    }

    /// Reads 16 bits.
    pub fn word(&mut self) -> u16 {
        u16::from_le_bytes(self.array())
    }

    /// Reads 32 bits.
    pub fn long(&mut self) -> u32 {
        u32::from_le_bytes(self.array())
    }

    /// Reads a frame: its head, an identifier of 2 or 4 bytes, and its data; at the end of the input fewer
    /// bytes than the head gives.
    pub fn frame(&mut self) -> Frame {
        let head = self.byte();
        let id = if head & EXTENDED != 0 {
            Id::extended(self.long() & 0x1FFF_FFFF)
        } else {
            Id::standard(self.word() & 0x7FF)
        };
        let dlc = (head & LENGTH) % 9;
        let id = id.expect("as many bits as it may have");
        let frame =
            if head & REMOTE != 0 { Frame::remote(id, dlc) } else { Frame::data(id, self.take(dlc.into())) };
        frame.expect("at most 8 bytes")
    }
}

/// Writes what [`Program::frame`] reads.
pub fn write_frame(frame: &Frame, program: &mut Vec<u8>) {
    let extended = if frame.id().is_extended() { EXTENDED } else { 0 };
    let remote = if frame.is_remote() { REMOTE } else { 0 };
    program.push(extended | remote | frame.dlc());
    let id = frame.id().raw().to_le_bytes();
    program.extend(&id[..if extended != 0 { 4 } else { 2 }]);
    program.extend(frame.payload());
}
