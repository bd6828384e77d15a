//! A record of the log as its frames bring it, and whether it is what was written.

use crate::storage::Record;
use crate::storage::record::RECORD_MAX;

/// Words of the longest record.
const WORDS_MAX: u32 = RECORD_MAX as u32 / 2;

/// The record that is coming in.
#[derive(Clone, Debug)]
pub(super) struct Assembly {
    /// Its place in the download, records; `None` between two.
    place: Option<u32>,
    /// A bit for each word that has come, as bytes: a `u128` wants a place at a multiple of 16, which C does not give.
    seen: [u8; 16],
    bytes: [u8; RECORD_MAX],
}

impl Default for Assembly {
    fn default() -> Self {
        Self { place: None, seen: [0; 16], bytes: [0; RECORD_MAX] }
    }
}

impl Assembly {
    /// Words of a record of so many bytes: whole frames of three, and no more than there can be.
    pub(super) const fn words(bytes: u32) -> Option<u32> {
        let words = bytes / 2;
        if bytes.is_multiple_of(6) && words > 0 && words <= WORDS_MAX { Some(words) } else { None }
    }

    /// Whether the record at this place is coming in.
    pub(super) fn is_at(&self, place: u32) -> bool {
        self.place == Some(place)
    }

    /// The record at this place begins to come in; what has come of another one is dropped.
    pub(super) fn begin(&mut self, place: u32) {
        *self = Self { place: Some(place), ..Self::default() };
    }

    /// Puts three words at their offset in the record; false if they were there.
    pub(super) fn put(&mut self, offset: u32, data: [u16; 3]) -> bool {
        let bits = 0b111_u128.checked_shl(offset).unwrap_or(0);
        let seen = u128::from_le_bytes(self.seen);
        if seen & bits == bits {
            return false;
        }
        self.seen = (seen | bits).to_le_bytes();
        let bytes = data.into_iter().flat_map(u16::to_be_bytes);
        let places = self.bytes.iter_mut().skip(offset as usize * 2);
        places.zip(bytes).for_each(|(place, byte)| *place = byte);
        true
    }

    /// Whether all of its words have come.
    pub(super) const fn is_complete(&self, words: u32) -> bool {
        u128::from_le_bytes(self.seen).count_ones() == words
    }

    /// Whether it is the record with this number, its CRC is right, or the drive says with zeros that it has none.
    pub(super) fn is_sound(&self, number: u32) -> bool {
        let hole = self.bytes.iter().all(|byte| *byte == 0);
        hole || Record::parse(&self.bytes).is_some_and(|record| record.index() == number)
    }
}
