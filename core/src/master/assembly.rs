//! Assembly of one log record from its frames, with a check of its number and CRC.

use crate::storage::Record;
use crate::storage::record::RECORD_MAX;

/// Words of the longest record.
const WORDS_MAX: u32 = RECORD_MAX as u32 / 2;

/// The record that is being received.
#[derive(Clone, Debug)]
pub(super) struct Assembly {
    /// Place of the record in the download, counted in records; `None` between two records.
    place: Option<u32>,
    /// One bit for each received word, as bytes: a `u128` needs an alignment of 16, which C does not give.
    seen: [u8; 16],
    bytes: [u8; RECORD_MAX],
}

impl Default for Assembly {
    fn default() -> Self {
        Self { place: None, seen: [0; 16], bytes: [0; RECORD_MAX] }
    }
}

impl Assembly {
    /// Returns the words of a record of `bytes` bytes; `None` unless they are whole frames of three words, at
    /// least one frame and at most `WORDS_MAX` words.
    pub(super) const fn words(bytes: u32) -> Option<u32> {
        let words = bytes / 2;
        if bytes.is_multiple_of(6) && words > 0 && words <= WORDS_MAX { Some(words) } else { None }
    }

    /// Returns whether the record at this place is being received.
    pub(super) fn is_at(&self, place: u32) -> bool {
        self.place == Some(place)
    }

    /// Begins to receive the record at this place; the words of another record are dropped.
    pub(super) fn begin(&mut self, place: u32) {
        *self = Self { place: Some(place), ..Self::default() };
    }

    /// Stores three words at their offset in the record; returns false if they were there already.
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

    /// Returns whether all words of the record were received.
    pub(super) const fn is_complete(&self, words: u32) -> bool {
        u128::from_le_bytes(self.seen).count_ones() == words
    }

    /// Returns whether the record is valid: it has this number and a correct CRC, or is all zeros, which the
    /// drive sends in place of a record that it does not have.
    pub(super) fn is_sound(&self, number: u32) -> bool {
        let hole = self.bytes.iter().all(|byte| *byte == 0);
        hole || Record::parse(&self.bytes).is_some_and(|record| record.index() == number)
    }
}
