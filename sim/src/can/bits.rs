//! A frame as bits on the wire.

use narx_core::bus::{Frame, Id};

/// Fixed-form bits after the CRC: delimiter, acknowledge slot and its delimiter, seven of end of frame.
const TAIL: u32 = 1 + 1 + 1 + 7;
/// Recessive bits that must separate frames.
pub(super) const INTERMISSION: u32 = 3;
/// Generator of the CRC-15: x^15 + x^14 + x^10 + x^8 + x^7 + x^4 + x^3 + 1, without its highest term.
const CRC15: u16 = 0x4599;
/// Change of the CRC by the four bits at its top, for each of their values.
const CRC15_OF_FOUR: [u16; 16] = crc15_of_four();

/// Bits that `frame` occupies the bus for, stuff bits and the intermission after it included.
pub fn frame_bits(frame: &Frame) -> u32 {
    let wire = WireBits::new(frame);
    u32::from(wire.length) + wire.stuff_bits() + TAIL + INTERMISSION
}

/// The most bits that any data frame with this kind of identifier and `bytes` (0..=8) data bytes occupies the
/// bus for.
pub const fn worst_case_bits(extended: bool, bytes: u8) -> u32 {
    // SOF, identifier, RTR, IDE, (SRR, r1,) r0, DLC, data, CRC: a stuff bit after the fifth and then every
    // fourth.
    let stuffed = if extended { 54 } else { 34 } + 8 * bytes as u32;
    stuffed + (stuffed - 1) / 4 + TAIL + INTERMISSION
}

/// Returns the bits that a node compares with the bus while it arbitrates; the lower value wins. Identifier,
/// RTR (or SRR), IDE and the rest of an extended identifier with its RTR, left-aligned.
pub fn arbitration_field(frame: &Frame) -> u32 {
    let remote = u32::from(frame.is_remote());
    match frame.id() {
        Id::Standard { raw: id, .. } => u32::from(id) << 21 | remote << 20,
        Id::Extended { raw: id, .. } => (id >> 18) << 21 | 0b11 << 19 | (id & 0x3_ffff) << 1 | remote,
    }
}

/// The part of a frame that is stuffed, start of frame to CRC, before stuffing. At most 118 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WireBits {
    /// Right-aligned: the last bit sent is bit 0.
    bits: u128,
    length: u8,
}

impl WireBits {
    /// Lays the frame out, dominant = 0.
    pub fn new(frame: &Frame) -> Self {
        let mut wire = Self { bits: 0, length: 0 };
        let remote = u128::from(frame.is_remote());
        wire.push(0, 1);
        match frame.id() {
            Id::Standard { raw: id, .. } => {
                wire.push(u128::from(id), 11);
                // RTR, IDE, r0.
                wire.push(remote << 2, 3);
            }
            Id::Extended { raw: id, .. } => {
                wire.push(u128::from(id >> 18), 11);
                // SRR, IDE.
                wire.push(0b11, 2);
                wire.push(u128::from(id & 0x3_ffff), 18);
                // RTR, r1, r0.
                wire.push(remote << 2, 3);
            }
        }
        wire.push(u128::from(frame.dlc()), 4);
        for byte in frame.payload() {
            wire.push(u128::from(*byte), 8);
        }
        wire.push(u128::from(wire.crc15()), 15);
        wire
    }

    /// The CRC-15 of all bits so far; 0 once the CRC itself is among them.
    pub fn crc15(&self) -> u16 {
        // Zeros before the first bit change nothing, so that there are whole groups of four.
        (0..self.length.div_ceil(4)).rev().fold(0, |crc, group| {
            let bits = (self.bits >> (4 * group)) as u16 & 15;
            crc << 4 & 0x7fff ^ CRC15_OF_FOUR[usize::from(crc >> 11 ^ bits)]
        })
    }

    /// The bits before stuffing, in the order sent, true = recessive.
    pub fn unstuffed(&self) -> impl Iterator<Item = bool> + use<> {
        // Left-aligned; there is always a start of frame.
        let mut bits = self.bits << (128 - u32::from(self.length));
        (0..self.length).map(move |_| {
            let bit = bits >> 127 == 1;
            bits <<= 1;
            bit
        })
    }

    /// All bits of the frame in the order sent, true = recessive: stuffed to the CRC, then delimiters, an
    /// acknowledge slot that a receiver has made dominant, and end of frame. Without intermission.
    pub fn on_wire(&self) -> impl Iterator<Item = bool> + use<> {
        let tail = [true, false, true].into_iter().chain([true; 7]);
        Stuffed { bits: self.unstuffed(), run: Run::default(), held: None }.chain(tail)
    }

    /// Returns the number of stuff bits.
    pub fn stuff_bits(&self) -> u32 {
        let mut left = u32::from(self.length);
        // Left-aligned, and inverted while the bus is recessive: then a run is of zeros.
        let mut bits = self.bits << (128 - left);
        let (mut known, mut count) = (0, 0);
        while left > 0 {
            let run = bits.leading_zeros().min(left);
            let full = run + known >= 5;
            let taken = if full { 5 - known } else { run };
            // A stuff bit is of the other level and the first of the next run.
            (known, count) = if full { (1, count + 1) } else { (0, count) };
            bits = !(bits << taken);
            left -= taken;
        }
        count
    }

    fn push(&mut self, value: u128, width: u8) {
        self.bits = self.bits << width | value;
        self.length += width;
    }
}

const fn crc15_of_four() -> [u16; 16] {
    let mut table = [0; 16];
    let mut top = 0;
    while top < 16 {
        let mut crc = (top as u16) << 11;
        let mut bit = 0;
        while bit < 4 {
            crc = if crc & 0x4000 == 0 { crc << 1 } else { crc << 1 & 0x7fff ^ CRC15 };
            bit += 1;
        }
        table[top] = crc;
        top += 1;
    }
    table
}

/// Counts equal bits in a row, stuff bits among them.
#[derive(Default)]
struct Run {
    level: bool,
    length: u8,
}

impl Run {
    /// Takes a bit in; true when a bit of the other level must follow, which it then counts too.
    fn needs_stuffing(&mut self, bit: bool) -> bool {
        self.length = if bit == self.level { self.length + 1 } else { 1 };
        self.level = bit;
        let full = self.length == 5;
        if full {
            (self.level, self.length) = (!bit, 1);
        }
        full
    }
}

/// Inserts stuff bits.
struct Stuffed<I> {
    bits: I,
    run: Run,
    held: Option<bool>,
}

impl<I: Iterator<Item = bool>> Iterator for Stuffed<I> {
    type Item = bool;

    fn next(&mut self) -> Option<bool> {
        if let Some(stuff) = self.held.take() {
            return Some(stuff);
        }
        let bit = self.bits.next()?;
        if self.run.needs_stuffing(bit) {
            self.held = Some(!bit);
        }
        Some(bit)
    }
}
