//! Two maps with the same content, of which at most one is being written at any instant.
//!
//! A write that is cut off can destroy the map that it was in, whatever state the flash is left in; the other
//! map is whole. Each item has a count, which shows the newer of two items.

use super::layout::Layout;
use super::parameters::BODY_MAX;
use super::ring::{self, Failed, Key};
use core::ops::Range;
use embedded_storage_async::nor_flash::NorFlash;

/// Bytes of an item's count, which precedes its body.
const COUNT: usize = 4;
const ITEM_MAX: usize = COUNT + BODY_MAX;

/// Working memory: an item, and the room that a map needs to move one.
#[derive(Clone, Debug)]
pub(super) struct Buffers {
    item: [u8; ITEM_MAX],
    /// Length of the item, bytes.
    length: usize,
    map: [u8; ring::room(ITEM_MAX)],
}

impl Buffers {
    pub(super) const fn new() -> Self {
        Self { item: [0; ITEM_MAX], length: 0, map: [0; ring::room(ITEM_MAX)] }
    }

    /// The body of the item that was read.
    pub(super) fn body(&self) -> &[u8] {
        self.item.get(COUNT..self.length).unwrap_or(&[])
    }

    /// Returns whether a map has the item that is in the buffer.
    async fn holds<F: NorFlash>(
        &mut self,
        flash: &mut F,
        map: &Range<u32>,
        key: Key,
    ) -> Result<bool, Failed> {
        let kept = ring::get(flash, map, key, &mut self.map).await?;
        Ok(kept.is_some_and(|kept| self.item.get(..self.length) == Some(kept.content)))
    }

    /// Sets the item's count.
    fn count(&mut self, count: u32) {
        self.item.iter_mut().zip(count.to_be_bytes()).for_each(|(place, byte)| *place = byte);
    }

    /// Prepares an item: `body` writes into the room that it is given, and returns the number of bytes.
    fn fill(&mut self, count: u32, body: impl FnOnce(&mut [u8]) -> usize) {
        let (_, room) = self.item.split_at_mut(COUNT);
        self.length = COUNT + body(room).min(BODY_MAX);
        self.count(count);
    }
}

/// The two maps.
#[derive(Clone, Debug)]
pub(super) struct Pair {
    primary: Range<u32>,
    mirror: Range<u32>,
}

/// Result of [`Pair::read`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Found {
    /// There is such an item, and it is in the buffer.
    pub present: bool,
    /// The two maps differ: [`Pair::mend`] makes them equal.
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
        // The buffer now has the second copy.
        if second != newest {
            get(flash, &self.primary, key, buffers).await?;
        }
        Ok(Found { present: newest.is_some(), differs: first != second })
    }

    /// Makes the maps equal. The mirror is not changed until the primary has everything, so that each item is
    /// always in one of them.
    pub(super) async fn mend<F: NorFlash>(&self, flash: &mut F, buffers: &mut Buffers) -> Result<(), Failed> {
        for (map, other) in [(&self.primary, &self.mirror), (&self.mirror, &self.primary)] {
            for key in Key::ALL {
                let [first, second] = self.look(flash, key, buffers).await?;
                let newest = newest(first, second);
                let behind = newest.is_some() && get(flash, map, key, buffers).await? != newest;
                if behind && get(flash, other, key, buffers).await? == newest {
                    put(flash, map, key, buffers).await?;
                }
            }
        }
        Ok(())
    }

    /// Writes an item into one map, reads it back, and only then writes it into the other. An item that both
    /// hold already is not written again.
    pub(super) async fn write<F: NorFlash>(
        &self,
        flash: &mut F,
        key: Key,
        buffers: &mut Buffers,
        body: impl FnOnce(&mut [u8]) -> usize,
    ) -> Result<(), Failed> {
        let [first, second] = self.look(flash, key, buffers).await?;
        let count = newest(first, second).map_or(0, |copy| copy.count);
        // `body` is called once: the item gets its count afterwards.
        buffers.fill(count, body);
        if first.is_some() && first == second && buffers.holds(flash, &self.primary, key).await? {
            return Ok(());
        }
        buffers.count(count.wrapping_add(1));
        put(flash, &self.primary, key, buffers).await?;
        put(flash, &self.mirror, key, buffers).await
    }

    /// Reads the copies in both maps; the mirror's is in the buffer then, if it is whole.
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

/// Reads an item into the buffer; `None` if there is none that is whole.
async fn get<F: NorFlash>(
    flash: &mut F,
    map: &Range<u32>,
    key: Key,
    buffers: &mut Buffers,
) -> Result<Option<Whole>, Failed> {
    let Some(item) = ring::get(flash, map, key, &mut buffers.map).await? else { return Ok(None) };
    let (Some(count), true) = (item.content.first_chunk(), item.content.len() <= ITEM_MAX) else {
        return Ok(None);
    };
    buffers.item.iter_mut().zip(item.content).for_each(|(place, byte)| *place = *byte);
    buffers.length = item.content.len();
    Ok(Some(Whole { count: u32::from_be_bytes(*count), crc: item.crc }))
}

/// Writes the item of the buffer.
async fn put<F: NorFlash>(
    flash: &mut F,
    map: &Range<u32>,
    key: Key,
    buffers: &mut Buffers,
) -> Result<(), Failed> {
    let item = buffers.item.get(..buffers.length).unwrap_or_default();
    if ring::put(flash, map, key, item, &mut buffers.map).await? { Ok(()) } else { Err(Failed) }
}
