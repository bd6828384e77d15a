//! One map: a ring of pages with items. The last item of a key counts.
//!
//! ```text
//!  page   number u32 | inverted               | item | item | ... | blank     big endian, in units of 8 bytes
//!  item   key u8, length u24 | inverted       | content | CRC-32 of key and content | ones to the next unit
//! ```
//!
//! The page with the highest number is in force, and no other one is read, because each page begins with all
//! items of the page before. Its number is written last: a page that was cut off before that does not count.
//! An item that is not whole is skipped, and nothing more is written into its page. So nothing has to be
//! repaired, and all state is on the flash.

use super::blank;
use core::ops::Range;
use crc::{CRC_32_ISO_HDLC, Crc};
use embedded_storage_async::nor_flash::NorFlash;

/// Fewest bytes that are written at once: no flash has longer words.
const UNIT: usize = 8;
const CRC: usize = 4;
/// Bytes that are read back at once.
const PIECE: usize = 32;

static CRC32: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Key of an item in a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Key {
    Set = 1,
    Once = 2,
    Log = 3,
}

impl Key {
    pub(super) const ALL: [Self; 3] = [Self::Set, Self::Once, Self::Log];
}

/// An operation of the memory has failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Failed;

/// An item that is whole.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item<'b> {
    pub(super) content: &'b [u8],
    pub(super) crc: u32,
    /// The whole item, as it is on the flash.
    bytes: &'b [u8],
}

/// Place of an item.
#[derive(Clone, Copy, Debug)]
struct Place {
    at: u32,
    /// Length of the content, bytes.
    length: usize,
}

/// The page in force.
#[derive(Clone, Copy, Debug)]
struct Page {
    index: u32,
    number: u32,
    /// The last item of each key.
    items: [Option<Place>; Key::ALL.len()],
    /// Address behind the last item.
    end: u32,
    /// An item in it is not whole.
    is_torn: bool,
}

/// Returns the bytes of an item with `content` bytes of content.
pub(super) const fn room(content: usize) -> usize {
    UNIT + content.saturating_add(CRC).next_multiple_of(UNIT)
}

/// Reads the last item of a key into `buffer`, which has [`room`] for the longest; `None` if there is none
/// that is whole.
pub(super) async fn get<'b, F: NorFlash>(
    flash: &mut F,
    map: &Range<u32>,
    key: Key,
    buffer: &'b mut [u8],
) -> Result<Option<Item<'b>>, Failed> {
    let Some(page) = find(flash, map, buffer).await? else { return Ok(None) };
    let place =
        Key::ALL.into_iter().zip(page.items).find_map(|(other, place)| place.filter(|_| other == key));
    let Some(place) = place else { return Ok(None) };
    read(flash, key, place, buffer).await
}

/// Writes an item behind the last one and reads it back, or begins the next page with it; false if no page
/// takes it.
pub(super) async fn put<F: NorFlash>(
    flash: &mut F,
    map: &Range<u32>,
    key: Key,
    content: &[u8],
    buffer: &mut [u8],
) -> Result<bool, Failed> {
    let page = find(flash, map, buffer).await?;
    if let Some(Page { index, end, is_torn: false, .. }) = page {
        let item = encode(key, content, buffer);
        if append(flash, end, item, address::<F>(map, index + 1)).await? {
            return Ok(true);
        }
    }
    let last = page.map_or(u32::MAX, |page| page.index);
    for step in 1..=pages::<F>(map) {
        let index = last.wrapping_add(step) % pages::<F>(map).max(1);
        if index != last && begin(flash, map, index, page, key, content, buffer).await? {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Puts a page into force: it gets the items of the last page, with the new item in place of its key's.
async fn begin<F: NorFlash>(
    flash: &mut F,
    map: &Range<u32>,
    index: u32,
    last: Option<Page>,
    key: Key,
    content: &[u8],
    buffer: &mut [u8],
) -> Result<bool, Failed> {
    let (start, end) = (address::<F>(map, index), address::<F>(map, index + 1));
    blank::erase(flash, start..end).await?;
    let mut at = start + UNIT as u32;
    for (other, place) in Key::ALL.into_iter().zip(last.map_or([None; Key::ALL.len()], |page| page.items)) {
        let bytes = match place {
            _ if other == key => encode(key, content, buffer),
            Some(place) => match read(flash, other, place, buffer).await? {
                Some(item) => item.bytes,
                None => continue,
            },
            None => continue,
        };
        if !append(flash, at, bytes, end).await? {
            return Ok(false);
        }
        at += bytes.len() as u32;
    }
    let number = last.map_or(1, |page| page.number.wrapping_add(1));
    write(flash, start, &doubled(number)).await
}

/// Finds the page in force, and the items in it.
async fn find<F: NorFlash>(
    flash: &mut F,
    map: &Range<u32>,
    buffer: &mut [u8],
) -> Result<Option<Page>, Failed> {
    const { assert!(UNIT.is_multiple_of(F::WRITE_SIZE) && UNIT.is_multiple_of(F::READ_SIZE)) };
    let mut newest: Option<(u32, u32)> = None;
    for index in 0..pages::<F>(map) {
        let Some(number) = halved(unit(flash, address::<F>(map, index)).await?) else { continue };
        if newest.is_none_or(|(_, newest)| number.wrapping_sub(newest) as i32 > 0) {
            newest = Some((index, number));
        }
    }
    let Some((index, number)) = newest else { return Ok(None) };
    let (start, end) = (address::<F>(map, index) + UNIT as u32, address::<F>(map, index + 1));
    let mut page = Page { index, number, items: [None; Key::ALL.len()], end: start, is_torn: false };
    while page.end < end {
        let head = unit(flash, page.end).await?;
        // Behind an item that is not whole there may be blank units before the next item.
        if head == [0xFF; UNIT] && !page.is_torn {
            break;
        }
        let head = halved(head).map(u32::to_be_bytes);
        let known = head.and_then(|[byte, _, _, _]| Key::ALL.into_iter().find(|key| *key as u8 == byte));
        let length = head.map_or(0, |[_, a, b, c]| u32::from_be_bytes([0, a, b, c]) as usize);
        let place = Place { at: page.end, length };
        match known {
            Some(key)
                if room(length) <= (end - page.end) as usize
                    && read(flash, key, place, buffer).await?.is_some() =>
            {
                for (other, item) in Key::ALL.into_iter().zip(&mut page.items) {
                    if other == key {
                        *item = Some(place);
                    }
                }
                page.end += room(length) as u32;
            }
            _ => {
                page.is_torn = true;
                page.end += UNIT as u32;
            }
        }
    }
    Ok(Some(page))
}

/// Reads an item, if it is whole.
async fn read<'b, F: NorFlash>(
    flash: &mut F,
    key: Key,
    place: Place,
    buffer: &'b mut [u8],
) -> Result<Option<Item<'b>>, Failed> {
    let Some(bytes) = buffer.get_mut(..room(place.length)) else { return Ok(None) };
    flash.read(place.at, bytes).await.map_err(|_| Failed)?;
    let bytes: &'b [u8] = bytes;
    let Some((head, rest)) = bytes.split_first_chunk::<UNIT>() else { return Ok(None) };
    let Some((content, rest)) = rest.split_at_checked(place.length) else { return Ok(None) };
    let Some((crc, _)) = rest.split_first_chunk::<CRC>() else { return Ok(None) };
    let crc = u32::from_be_bytes(*crc);
    let is_whole = *head == title(key, place.length) && crc == checksum(key, content);
    Ok(is_whole.then_some(Item { content, crc, bytes }))
}

/// Encodes an item as it is on the flash; empty if the buffer has no room for it.
fn encode<'b>(key: Key, content: &[u8], buffer: &'b mut [u8]) -> &'b [u8] {
    let Some(bytes) = buffer.get_mut(..room(content.len())) else { return &[] };
    let crc = checksum(key, content).to_be_bytes();
    let written = title(key, content.len()).into_iter().chain(content.iter().copied()).chain(crc);
    for (place, byte) in bytes.iter_mut().zip(written.chain(core::iter::repeat(0xFF))) {
        *place = byte;
    }
    bytes
}

/// The first unit of an item.
fn title(key: Key, length: usize) -> [u8; UNIT] {
    doubled((key as u32) << 24 | length as u32)
}

fn checksum(key: Key, content: &[u8]) -> u32 {
    let mut digest = CRC32.digest();
    digest.update(&[key as u8]);
    digest.update(content);
    digest.finalize()
}

/// A word and its inverse: a single wrong bit never makes another valid word.
fn doubled(word: u32) -> [u8; UNIT] {
    (u64::from(word) << 32 | u64::from(!word)).to_be_bytes()
}

fn halved(unit: [u8; UNIT]) -> Option<u32> {
    let [a, b, c, d, ..] = unit;
    let word = u32::from_be_bytes([a, b, c, d]);
    (doubled(word) == unit).then_some(word)
}

async fn unit<F: NorFlash>(flash: &mut F, at: u32) -> Result<[u8; UNIT], Failed> {
    let mut bytes = [0; UNIT];
    flash.read(at, &mut bytes).await.map_err(|_| Failed)?;
    Ok(bytes)
}

/// Writes if there is room and the place is blank; returns false if not, or if the bytes read back wrong.
async fn append<F: NorFlash>(flash: &mut F, at: u32, bytes: &[u8], end: u32) -> Result<bool, Failed> {
    let place = at..at.saturating_add(bytes.len() as u32);
    Ok(!bytes.is_empty()
        && place.end <= end
        && blank::is_blank(flash, place).await?
        && write(flash, at, bytes).await?)
}

/// Writes and reads back; returns whether the bytes are the same.
async fn write<F: NorFlash>(flash: &mut F, at: u32, bytes: &[u8]) -> Result<bool, Failed> {
    flash.write(at, bytes).await.map_err(|_| Failed)?;
    let mut at = at;
    for piece in bytes.chunks(PIECE) {
        let mut back = [0; PIECE];
        let back = back.get_mut(..piece.len()).unwrap_or_default();
        flash.read(at, back).await.map_err(|_| Failed)?;
        if back != piece {
            return Ok(false);
        }
        at += piece.len() as u32;
    }
    Ok(true)
}

fn pages<F: NorFlash>(map: &Range<u32>) -> u32 {
    (map.end - map.start) / F::ERASE_SIZE as u32
}

const fn address<F: NorFlash>(map: &Range<u32>, index: u32) -> u32 {
    map.start + index * F::ERASE_SIZE as u32
}
