//! The log: a ring of records of one program page each. It begins where the last erase has ended, so that all
//! subsectors wear alike. Written records are never overwritten: a full log waits to be erased.
//!
//! The maps keep its beginning and the length of its longest record, which a download uses for every record.
//! Its end is found at boot by a binary search, because pages are written in turn: 20 pages are read instead
//! of a million.

use super::blank;
use super::pair::{Buffers, Pair};
use super::record::{Entry, PAGE, Record};
use super::ring::{Failed, Key};
use core::ops::Range;
use embedded_storage_async::nor_flash::NorFlash;
use serde::{Deserialize, Serialize};

/// Most pages in a row that the search for the end skips because they are neither blank nor hold a record:
/// each was left by a power cut.
const TORN_MAX: u32 = 8;
/// Attempts to write one record.
const TRIES: u32 = 4;

/// State of the log memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Memory {
    /// Records that it holds.
    pub records: u32,
    /// Records written since it was erased.
    pub written: u32,
    /// Subsectors that it has.
    pub subsectors: u32,
    /// Subsectors erased so far, while an erase goes on.
    pub erasing: Option<u32>,
    /// The beginning of the log is not known: the log can only be erased.
    pub lost: bool,
    /// Values of its longest record, or more.
    pub values: u32,
}

impl Memory {
    /// Returns whether nothing more can be written.
    pub const fn is_full(&self) -> bool {
        self.lost || (self.records > 0 && self.written >= self.records)
    }

    /// Returns whether no record is written.
    pub const fn is_erased(&self) -> bool {
        self.records > 0 && self.written == 0 && !self.lost && self.erasing.is_none()
    }
}

/// Data of the log in the maps: its beginning, and its longest record.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Origin {
    /// Subsector of record 0.
    first: u32,
    /// While erasing: number of subsectors to erase, from `first` on.
    erase: u32,
    /// Values of the longest record since the last erase.
    values: u32,
}

/// The log's place on the flash, and its state.
#[derive(Clone, Debug)]
pub(super) struct Log {
    range: Range<u32>,
    subsector: u32,
    origin: Origin,
    memory: Memory,
}

impl Log {
    /// Makes a log that has not been opened yet.
    pub(super) const fn new(range: Range<u32>, subsector: u32) -> Self {
        let bytes = range.end - range.start;
        let memory = Memory {
            records: bytes / PAGE,
            written: 0,
            subsectors: bytes / subsector,
            erasing: None,
            lost: true,
            values: 0,
        };
        Self { range, subsector, origin: Origin { first: 0, erase: 0, values: 0 }, memory }
    }

    pub(super) const fn memory(&self) -> Memory {
        self.memory
    }

    /// Finds both ends; returns true if the two maps differ in their data of the log and need mending.
    pub(super) async fn open<F: NorFlash>(
        &mut self,
        flash: &mut F,
        pair: &Pair,
        buffers: &mut Buffers,
    ) -> Result<bool, Failed> {
        let found = pair.read(flash, Key::Log, buffers).await?;
        let origin = if found.present { Origin::decode(buffers.body()) } else { None };
        let origin = origin.filter(|origin| origin.first < self.memory.subsectors);
        self.memory.lost = origin.is_none();
        self.origin = origin.unwrap_or_default();
        self.memory.erasing = (self.origin.erase > 0).then_some(0);
        self.memory.written = 0;
        if !self.memory.lost && self.memory.erasing.is_none() {
            self.memory.written = self.find_end(flash).await?;
        }
        self.memory.values = self.origin.values;
        Ok(found.differs)
    }

    /// Begins a log at the front of a blank memory, for a flash that has just been formatted.
    pub(super) async fn begin<F: NorFlash>(
        &mut self,
        flash: &mut F,
        pair: &Pair,
        buffers: &mut Buffers,
    ) -> Result<(), Failed> {
        self.move_to(flash, pair, buffers, Origin::default()).await?;
        (self.memory.lost, self.memory.erasing, self.memory.written) = (false, None, 0);
        Ok(())
    }

    /// Writes a record behind the last; the length of a new longest record is noted in the maps first. A page
    /// that does not take the record is skipped.
    pub(super) async fn append<F: NorFlash>(
        &mut self,
        flash: &mut F,
        pair: &Pair,
        buffers: &mut Buffers,
        entry: &Entry,
    ) -> Result<(), Failed> {
        let values = entry.values.len() as u32;
        if values > self.origin.values && !self.memory.is_full() && self.memory.erasing.is_none() {
            self.move_to(flash, pair, buffers, Origin { values, ..self.origin }).await?;
        }
        for _ in 0..TRIES {
            if self.memory.is_full() || self.memory.erasing.is_some() {
                return Err(Failed);
            }
            let index = self.memory.written;
            let at = self.address(index);
            if blank::is_blank(flash, at..at + PAGE).await? {
                let record = Record::new(index, entry);
                flash.write(at, record.bytes()).await.map_err(|_| Failed)?;
                if self.read(flash, index).await? == Some(record) {
                    self.memory.written += 1;
                    return Ok(());
                }
                // A page that stayed blank would look like the end of the log: it is tried again.
                if blank::is_blank(flash, at..at + PAGE).await? {
                    continue;
                }
            }
            self.memory.written += 1;
        }
        Err(Failed)
    }

    /// Record `index`, if it is whole.
    pub(super) async fn read<F: NorFlash>(
        &self,
        flash: &mut F,
        index: u32,
    ) -> Result<Option<Record>, Failed> {
        let mut page = [0; PAGE as usize];
        flash.read(self.address(index), &mut page).await.map_err(|_| Failed)?;
        Ok(Record::parse(&page).filter(|record| record.index() == index))
    }

    /// Begins an erase, or continues it by one piece; [`Memory::erasing`] shows the progress. The range is
    /// noted in the maps first, so that an erase that is cut off is finished after the next boot.
    pub(super) async fn erase<F: NorFlash>(
        &mut self,
        flash: &mut F,
        pair: &Pair,
        buffers: &mut Buffers,
    ) -> Result<(), Failed> {
        let Some(done) = self.memory.erasing else {
            let per_subsector = (self.subsector / PAGE).max(1);
            let used = if self.memory.lost {
                self.memory.subsectors
            } else {
                self.memory.written.div_ceil(per_subsector)
            };
            self.move_to(flash, pair, buffers, Origin { erase: used.max(1), ..self.origin }).await?;
            self.memory.erasing = Some(0);
            return Ok(());
        };
        let Origin { first, erase, .. } = self.origin;
        if done < erase {
            // At most up to the end of the ring, where the ring begins anew.
            let at = (first + done) % self.memory.subsectors.max(1);
            let end = (at + erase - done).min(self.memory.subsectors);
            let rest = self.range.start + at * self.subsector..self.range.start + end * self.subsector;
            let piece = blank::next_piece(&rest);
            blank::erase(flash, piece.clone()).await?;
            self.memory.erasing = Some(done + (piece.end - piece.start) / self.subsector.max(1));
            return Ok(());
        }
        let first = (first + erase) % self.memory.subsectors.max(1);
        self.move_to(flash, pair, buffers, Origin { first, erase: 0, values: 0 }).await?;
        (self.memory.lost, self.memory.erasing, self.memory.written) = (false, None, 0);
        Ok(())
    }

    async fn move_to<F: NorFlash>(
        &mut self,
        flash: &mut F,
        pair: &Pair,
        buffers: &mut Buffers,
        origin: Origin,
    ) -> Result<(), Failed> {
        pair.write(flash, Key::Log, buffers, |body| origin.encode(body)).await?;
        self.origin = origin;
        self.memory.values = origin.values;
        Ok(())
    }

    fn address(&self, index: u32) -> u32 {
        // Both below the number of records, which is far below 2^31.
        let position = (self.origin.first * (self.subsector / PAGE) + index) % self.memory.records.max(1);
        self.range.start + position * PAGE
    }

    /// Finds the number of written pages by a binary search: the smallest index that is not written.
    async fn find_end<F: NorFlash>(&self, flash: &mut F) -> Result<u32, Failed> {
        let (mut low, mut high) = (0, self.memory.records);
        while low < high {
            let middle = low + (high - low) / 2;
            if self.is_written(flash, middle).await? {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        Ok(low)
    }

    /// Returns whether a page has been written. A page that is neither blank nor whole counts as the page
    /// before it: behind a record it was left by a power cut, behind a blank page it has a bit that has
    /// fallen to 0.
    async fn is_written<F: NorFlash>(&self, flash: &mut F, index: u32) -> Result<bool, Failed> {
        for back in 0..TORN_MAX {
            let Some(index) = index.checked_sub(back) else { break };
            if self.read(flash, index).await?.is_some() {
                return Ok(true);
            }
            let at = self.address(index);
            if blank::is_blank(flash, at..at + PAGE).await? {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

impl Origin {
    fn encode(self, body: &mut [u8]) -> usize {
        let Some(place) = body.first_chunk_mut::<12>() else { return 0 };
        let words = [self.first, self.erase, self.values].map(u32::to_be_bytes);
        place.iter_mut().zip(words.as_flattened()).for_each(|(place, byte)| *place = *byte);
        12
    }

    fn decode(body: &[u8]) -> Option<Self> {
        let (words, _) = body.first_chunk::<12>()?.as_chunks::<4>();
        let [first, erase, values] = *words.first_chunk()?;
        let [first, erase, values] = [first, erase, values].map(u32::from_be_bytes);
        Some(Self { first, erase, values })
    }
}
