//! Two maps with the same content, of which at most one is being written at any instant.
//!
//! A write that is cut off can cost the map it was in, whatever state the flash is left in; the other one is whole. Which of two
//! items is the newer one is told by a count of its own, and that it is whole by a CRC.

use super::layout::Layout;
use super::parameters::BODY_MAX;
use core::ops::Range;
use crc::{CRC_32_ISO_HDLC, Crc};
use embedded_storage_async::nor_flash::NorFlash;
use sequential_storage::cache::Cache;
use sequential_storage::map::{MapConfig, MapStorage};

/// An item's count before its body, its CRC-32 behind it.
const COUNT: usize = 4;
const CRC: usize = 4;
const ITEM_MAX: usize = COUNT + BODY_MAX + CRC;

static CRC32: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// What a map can hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Key {
    Set = 1,
    Once = 2,
    Log = 3,
}

impl Key {
    const ALL: [Self; 3] = [Self::Set, Self::Once, Self::Log];
}

/// The memory does not do what it is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Failed;

/// Working memory: an item, and what the map needs to move one.
#[derive(Clone, Debug)]
pub(super) struct Buffers {
    item: [u8; ITEM_MAX],
    /// Of the item.
    length: usize,
    map: [u8; (1 + ITEM_MAX).next_multiple_of(8)],
}

impl Buffers {
    pub(super) const fn new() -> Self {
        Self { item: [0; ITEM_MAX], length: 0, map: [0; (1 + ITEM_MAX).next_multiple_of(8)] }
    }

    /// The body of the item that was read.
    pub(super) fn body(&self) -> &[u8] {
        self.item.get(COUNT..self.length.saturating_sub(CRC)).unwrap_or(&[])
    }

    /// Prepares an item: `body` writes into the room it is given and answers how much.
    fn fill(&mut self, key: Key, count: u32, body: impl FnOnce(&mut [u8]) -> usize) {
        let room = self.item.get_mut(COUNT..COUNT + BODY_MAX).unwrap_or_default();
        let end = COUNT + body(room).min(BODY_MAX);
        if let Some(place) = self.item.first_chunk_mut() {
            *place = count.to_be_bytes();
        }
        let crc = checksum(key, self.item.get(..end).unwrap_or_default());
        if let Some(place) = self.item.get_mut(end..end + CRC) {
            place.copy_from_slice(&crc.to_be_bytes());
        }
        self.length = end + CRC;
    }
}

/// The two maps.
#[derive(Clone, Debug)]
pub(super) struct Pair {
    primary: Range<u32>,
    mirror: Range<u32>,
}

/// Times that a map's items are looked through: writing the first one has the map put itself in order, which can cost others.
const PASSES: usize = 2;

/// What [`Pair::read`] has found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Found {
    /// There is such an item, and it stands in the buffer.
    pub present: bool,
    /// The two maps do not agree: [`Pair::mend`].
    pub differs: bool,
}

impl Pair {
    pub(super) fn of(layout: &Layout) -> Self {
        Self { primary: layout.primary.map.clone(), mirror: layout.mirror.map.clone() }
    }

    /// Reads the newer copy into the buffer.
    pub(super) async fn read<F: NorFlash>(
        &self,
        flash: &mut F,
        key: Key,
        buffers: &mut Buffers,
    ) -> Result<Found, Failed> {
        let [first, second] = self.look(flash, key, buffers).await?;
        let newest = newest(first, second);
        // The second copy is the one that now stands in the buffer.
        if second != newest {
            get(flash, &self.primary, key, buffers).await?;
        }
        Ok(Found { present: newest.is_some(), differs: first != second })
    }

    /// Makes the maps equal. The mirror is left alone until the primary has everything, so that each item stands in one of them.
    pub(super) async fn mend<F: NorFlash>(&self, flash: &mut F, buffers: &mut Buffers) -> Result<(), Failed> {
        for (map, other) in [(&self.primary, &self.mirror), (&self.mirror, &self.primary)] {
            for key in [Key::ALL; PASSES].into_iter().flatten() {
                let [first, second] = self.look(flash, key, buffers).await?;
                let newest = newest(first, second);
                let behind = newest.is_some() && get(flash, map, key, buffers).await? != newest;
                if behind && get(flash, other, key, buffers).await? == newest {
                    self.settle(flash, map, other, key, buffers).await?;
                }
            }
        }
        Ok(())
    }

    /// Writes an item into one map, reads it back, and only then writes it into the other.
    pub(super) async fn write<F: NorFlash>(
        &self,
        flash: &mut F,
        key: Key,
        buffers: &mut Buffers,
        body: impl FnOnce(&mut [u8]) -> usize,
    ) -> Result<(), Failed> {
        let [first, second] = self.look(flash, key, buffers).await?;
        let count = newest(first, second).map_or(0, |copy| copy.count);
        buffers.fill(key, count.wrapping_add(1), body);
        self.settle(flash, &self.primary, &self.mirror, key, buffers).await?;
        self.settle(flash, &self.mirror, &self.primary, key, buffers).await
    }

    /// The copies in both maps; the mirror's stands in the buffer then, if it is whole.
    async fn look<F: NorFlash>(
        &self,
        flash: &mut F,
        key: Key,
        buffers: &mut Buffers,
    ) -> Result<[Option<Whole>; 2], Failed> {
        let first = get(flash, &self.primary, key, buffers).await?;
        let second = get(flash, &self.mirror, key, buffers).await?;
        Ok([first, second])
    }

    /// Puts the item of the buffer into a map. If the map is past repair it is made anew from the other one, which is whole.
    async fn settle<F: NorFlash>(
        &self,
        flash: &mut F,
        map: &Range<u32>,
        other: &Range<u32>,
        key: Key,
        buffers: &mut Buffers,
    ) -> Result<(), Failed> {
        if put(flash, map, key, buffers).await? {
            return Ok(());
        }
        super::blank::erase(flash, map.clone()).await?;
        if !put(flash, map, key, buffers).await? {
            return Err(Failed);
        }
        for kept in Key::ALL.into_iter().filter(|kept| *kept != key) {
            if get(flash, other, kept, buffers).await?.is_some() && !put(flash, map, kept, buffers).await? {
                return Err(Failed);
            }
        }
        get(flash, map, key, buffers).await.map(|_| ())
    }
}

/// A copy that is whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Whole {
    count: u32,
    crc: u32,
}

fn newest(first: Option<Whole>, second: Option<Whole>) -> Option<Whole> {
    match (first, second) {
        (Some(first), Some(second)) => {
            let newer = second.count.wrapping_sub(first.count) as i32 > 0;
            Some(if newer { second } else { first })
        }
        (first, second) => first.or(second),
    }
}

fn checksum(key: Key, bytes: &[u8]) -> u32 {
    let mut digest = CRC32.digest();
    digest.update(&[key as u8]);
    digest.update(bytes);
    digest.finalize()
}

/// Reads an item into the buffer; `None` if there is none that is whole.
async fn get<F: NorFlash>(
    flash: &mut F,
    range: &Range<u32>,
    key: Key,
    buffers: &mut Buffers,
) -> Result<Option<Whole>, Failed> {
    let Ok(config) = MapConfig::try_new(range.clone()) else { return Err(Failed) };
    let mut map = MapStorage::<u8, _, _>::new(flash, config, Cache::new_uncached());
    let item = match map.fetch_item::<&[u8]>(&mut buffers.map, &(key as u8)).await {
        Ok(Some(item)) => item,
        Ok(None) => return Ok(None),
        Err(sequential_storage::Error::Storage { .. }) => return Err(Failed),
        // Past the map's own repair.
        Err(_) => return Ok(None),
    };
    let Some((counted, crc)) = item.split_last_chunk::<CRC>() else { return Ok(None) };
    let crc = u32::from_be_bytes(*crc);
    let (Some(count), Some(place)) = (counted.first_chunk::<COUNT>(), buffers.item.get_mut(..item.len()))
    else {
        return Ok(None);
    };
    if checksum(key, counted) != crc {
        return Ok(None);
    }
    place.copy_from_slice(item);
    buffers.length = item.len();
    Ok(Some(Whole { count: u32::from_be_bytes(*count), crc }))
}

/// Writes the item of the buffer and reads it back; false if that does not give the same.
async fn put<F: NorFlash>(
    flash: &mut F,
    range: &Range<u32>,
    key: Key,
    buffers: &mut Buffers,
) -> Result<bool, Failed> {
    let Ok(config) = MapConfig::try_new(range.clone()) else { return Err(Failed) };
    let mut map = MapStorage::<u8, _, _>::new(flash, config, Cache::new_uncached());
    let item = buffers.item.get(..buffers.length).unwrap_or_default();
    match map.store_item(&mut buffers.map, &(key as u8), &item).await {
        Ok(()) => {}
        Err(sequential_storage::Error::Storage { .. }) => return Err(Failed),
        Err(_) => return Ok(false),
    }
    match map.fetch_item::<&[u8]>(&mut buffers.map, &(key as u8)).await {
        Ok(read) => Ok(read == Some(item)),
        Err(sequential_storage::Error::Storage { .. }) => Err(Failed),
        Err(_) => Ok(false),
    }
}
