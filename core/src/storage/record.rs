//! One record of the log: the same bytes on the flash and in the download.
//!
//! ```text
//!  word  0      | 1, 2   | 3, 4      | 5     | 6    | 7, 8  | ... | then 2     | then 1
//!        start  | index  | time, ms  | count | what | value | ... | CRC-32     | end        big endian
//! ```
//!
//! A record fills whole frames of three words: 3 frames for itself, and one for each value. It has one
//! program page of the flash to itself, so that a write that is cut off damages no other record. The CRC is
//! over everything before it.

use crc::{CRC_32_ISO_HDLC, Crc};
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Values of a record: the 37 slots 03 to 39.
pub const VALUES: usize = 37;
/// Bytes of the flash that each record takes: one program page.
pub const PAGE: u32 = 256;
/// First word of a record (parameter 27).
pub const START: u16 = 0xAA55;
/// Last word of a record (parameter 66).
pub const END: u16 = 0x55AA;

const HEAD: usize = 12;
const VALUE: usize = 6;
const TAIL: usize = 6;
/// Bytes of the longest record: 240.
pub const RECORD_MAX: usize = HEAD + VALUES * VALUE + TAIL;

/// CRC of a record, and of an image on its way to the bootloader.
pub(crate) static CRC32: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Content of a record, before it has an index.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Entry {
    /// Time since power-up, ms; wraps after 49 days.
    pub time: u32,
    /// Source of each value (bits 13:0 its number, bits 15:14 live, smallest, largest or mean), and the
    /// value.
    pub values: Vec<(u16, i32), VALUES>,
}

/// A record that is whole.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Record(Vec<u8, RECORD_MAX>);

impl Record {
    /// Bytes of a record with `values` values: 18 and 6 for each.
    pub const fn size(values: usize) -> usize {
        HEAD + VALUE * values + TAIL
    }

    /// Makes the record of an entry.
    pub fn new(index: u32, entry: &Entry) -> Self {
        let mut bytes = Vec::new();
        let mut put = |part: &[u8]| {
            // There is room for the longest.
            let _ = bytes.extend_from_slice(part);
        };
        put(&START.to_be_bytes());
        put(&index.to_be_bytes());
        put(&entry.time.to_be_bytes());
        put(&(entry.values.len() as u16).to_be_bytes());
        for (what, value) in &entry.values {
            put(&what.to_be_bytes());
            put(&value.to_be_bytes());
        }
        let crc = CRC32.checksum(&bytes);
        let _ = bytes.extend_from_slice(&crc.to_be_bytes());
        let _ = bytes.extend_from_slice(&END.to_be_bytes());
        Self(bytes)
    }

    /// Returns the record at the head of `bytes`, if there is one that is whole.
    pub fn parse(bytes: &[u8]) -> Option<Self> {
        let (head, _) = bytes.split_first_chunk::<HEAD>()?;
        let count = usize::from(u16::from_be_bytes([head[10], head[11]]));
        let bytes = bytes.get(..Self::size(count.min(VALUES)))?;
        let (checked, tail) = bytes.split_last_chunk::<TAIL>()?;
        let crc = u32::from_be_bytes([tail[0], tail[1], tail[2], tail[3]]);
        let marked = head[..2] == START.to_be_bytes() && tail[4..] == END.to_be_bytes();
        let whole = marked && count <= VALUES && CRC32.checksum(checked) == crc;
        whole.then(|| Vec::from_slice(bytes).map(Self).ok()).flatten()
    }

    /// Its number since the log was erased.
    pub fn index(&self) -> u32 {
        self.long(2)
    }

    /// Returns the content of the record.
    pub fn entry(&self) -> Entry {
        let values = self.0.get(HEAD..self.0.len().saturating_sub(TAIL)).unwrap_or_default();
        let (values, _) = values.as_chunks::<VALUE>();
        let value = |[a, b, c, d, e, f]: &[u8; VALUE]| {
            (u16::from_be_bytes([*a, *b]), i32::from_be_bytes([*c, *d, *e, *f]))
        };
        Entry { time: self.long(6), values: values.iter().map(value).collect() }
    }

    /// Its bytes.
    pub fn bytes(&self) -> &[u8] {
        &self.0
    }

    /// The three words of frame `place`, `None` beyond the last.
    pub fn frame(&self, place: usize) -> Option<[u16; 3]> {
        let (frames, _) = self.0.as_chunks::<6>();
        let [a, b, c, d, e, f] = *frames.get(place)?;
        Some([[a, b], [c, d], [e, f]].map(u16::from_be_bytes))
    }

    fn long(&self, at: usize) -> u32 {
        let bytes = self.0.get(at..).and_then(<[u8]>::first_chunk);
        bytes.map_or(0, |bytes| u32::from_be_bytes(*bytes))
    }
}
