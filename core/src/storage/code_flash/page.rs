//! A page of records of one flash word each.
//!
//! ```text
//!  word   number u16 | value i32 | CRC-16 of both     big endian
//!
//!  page   head: form, release | record | record | ... | commit: count of stores | record | commit | blank ...
//! ```
//!
//! Records behind the last commit belong to a store that was cut off. A page counts if every word of it is
//! right and it ends with a commit: then nothing of it has to be guessed.

use super::Failed;
use crc::{CRC_16_IBM_3740, Crc, NoTable};
use embedded_storage::nor_flash::NorFlash;

/// Bytes of a word, which the flash of an STM32G4 programs at once.
pub(super) const WORD: u32 = 8;
/// Numbers that no parameter has: of the first word of a page, and of the commit that ends a store. `FFFFh`
/// is that of a blank word.
pub(super) const HEAD: u16 = 0xFFFD;
pub(super) const COMMIT: u16 = 0xFFFE;

/// Without a table: half a kilobyte of flash is worth more than the time that a table saves.
static CRC16: Crc<u16, NoTable> = Crc::<u16, NoTable>::new(&CRC_16_IBM_3740);

/// Content of a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Word {
    Blank,
    Bad,
    Record(u16, i32),
}

impl Word {
    pub(super) fn encode(number: u16, value: i32) -> [u8; WORD as usize] {
        let ([a, b], [c, d, e, f]) = (number.to_be_bytes(), value.to_be_bytes());
        let [g, h] = CRC16.checksum(&[a, b, c, d, e, f]).to_be_bytes();
        [a, b, c, d, e, f, g, h]
    }

    pub(super) fn decode(bytes: [u8; WORD as usize]) -> Self {
        let [a, b, c, d, e, f, ..] = bytes;
        let (number, value) = (u16::from_be_bytes([a, b]), i32::from_be_bytes([c, d, e, f]));
        match bytes {
            [0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF] => Self::Blank,
            _ if Self::encode(number, value) == bytes => Self::Record(number, value),
            _ => Self::Bad,
        }
    }
}

/// State of a page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Page {
    /// Index of the page in the flash.
    pub(super) index: u32,
    /// Words that are not blank.
    pub(super) end: u32,
    /// Its form: the head's upper half.
    pub(super) form: u16,
    /// Count of its last commit.
    pub(super) count: Option<u32>,
    /// Every word is right, and the last one a commit.
    pub(super) is_whole: bool,
}

impl Page {
    /// Returns whether both hold the same stores.
    pub(super) fn is_equal(&self, other: &Self) -> bool {
        (self.end, self.count) == (other.end, other.count)
    }
}

/// Words of a page.
pub(super) const fn words<F: NorFlash>() -> u32 {
    F::ERASE_SIZE as u32 / WORD
}

/// The bytes of a word.
pub(super) fn read<F: NorFlash>(
    flash: &mut F,
    index: u32,
    place: u32,
) -> Result<[u8; WORD as usize], Failed> {
    let mut bytes = [0; WORD as usize];
    flash.read(address::<F>(index, place), &mut bytes).map_err(|_| Failed)?;
    Ok(bytes)
}

/// Writes a record.
pub(super) fn put<F: NorFlash>(
    flash: &mut F,
    index: u32,
    place: u32,
    number: u16,
    value: i32,
) -> Result<(), Failed> {
    write(flash, index, place, Word::encode(number, value))
}

/// Programs a blank word and reads it back.
pub(super) fn write<F: NorFlash>(
    flash: &mut F,
    index: u32,
    place: u32,
    bytes: [u8; WORD as usize],
) -> Result<(), Failed> {
    if place >= words::<F>() {
        return Err(Failed);
    }
    flash.write(address::<F>(index, place), &bytes).map_err(|_| Failed)?;
    if read(flash, index, place)? == bytes { Ok(()) } else { Err(Failed) }
}

pub(super) fn erase<F: NorFlash>(flash: &mut F, index: u32) -> Result<(), Failed> {
    flash.erase(address::<F>(index, 0), address::<F>(index + 1, 0)).map_err(|_| Failed)
}

/// Scans a page and passes every record to `each`, in order: the last one of a number counts.
pub(super) fn scan<F: NorFlash>(
    flash: &mut F,
    index: u32,
    each: &mut dyn FnMut(u16, i32),
) -> Result<Page, Failed> {
    let mut page = Page { index, end: 0, form: 0, count: None, is_whole: false };
    let mut is_right = true;
    for place in 0..words::<F>() {
        let word = Word::decode(read(flash, index, place)?);
        if word == Word::Blank {
            continue;
        }
        // A right page has no word behind a blank one, and a head in front and nowhere else.
        is_right &= page.end == place && (place == 0) == matches!(word, Word::Record(HEAD, _));
        page.end = place + 1;
        page.is_whole = false;
        match word {
            Word::Record(HEAD, value) => page.form = (value >> 16) as u16,
            Word::Record(COMMIT, count) => {
                page.count = Some(count as u32);
                page.is_whole = is_right;
            }
            Word::Record(number, value) => each(number, value),
            Word::Blank | Word::Bad => is_right = false,
        }
    }
    Ok(page)
}

const fn address<F: NorFlash>(index: u32, place: u32) -> u32 {
    index * F::ERASE_SIZE as u32 + place * WORD
}
