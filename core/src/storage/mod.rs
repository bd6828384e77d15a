//! The flash: parameters, their mirror, and the log, over any NOR flash; or the parameters alone, in pages of
//! the code's own flash.
//!
//! ```text
//!  Node --- FlashTask --> Storage::execute --> flash      one task at a time, each of bounded length
//!       <-- FlashReply -- CodeFlash::step
//! ```
//!
//! [`Storage`] waits for the flash asynchronously: in an executor, or in a future that the background loop
//! polls. The node never waits: it hands out a task, and gets the reply later. `CodeFlash` (feature
//! `code-flash`) has nothing to wait for, because the processor stands still while its flash is written.

mod blank;
#[cfg(feature = "code-flash")]
mod code_flash;
pub mod layout;
pub mod log;
mod mailbox;
mod pair;
pub mod parameters;
pub mod record;
mod ring;

#[cfg(feature = "code-flash")]
pub use code_flash::CodeFlash;
pub use layout::Layout;
pub use log::Memory;
pub use mailbox::Mailbox;
pub use parameters::Part;
pub use record::{Entry, Record};

use crate::dictionary::Parameters;
use crate::motor::guard::fault::FaultWord;
use core::ops::Range;
use embedded_storage_async::nor_flash::NorFlash;
use log::Log;
use pair::{Buffers, Pair};
use ring::{Failed, Key};
use serde::{Deserialize, Serialize};

/// Task of the node for the flash.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant, reason = "a set is stored rarely, moves once, and there is no heap")]
pub enum FlashTask {
    /// Check whether the flash answers, and read its content.
    Open,
    /// Store a part of the parameters; both parts if a stored one did not fit, or if the flash had another
    /// layout.
    Store(Parameters, Part),
    /// Write a record behind the last.
    Append(Entry),
    /// Read a record.
    Read(u32),
    /// Begin to erase the log, or continue the erase.
    Erase,
}

/// Reply to a task.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant, reason = "as above")]
pub enum FlashReply {
    /// Content of the flash.
    Opened(Opened),
    /// The parameters are stored, read back and mirrored, or not.
    Stored {
        /// It was done.
        done: bool,
        /// The log now: a flash gets its log with its layout.
        log: Memory,
    },
    /// A record is written, or a piece of the log erased, or not.
    Log {
        /// It was done.
        done: bool,
        /// The log now.
        memory: Memory,
    },
    /// The record, if there is one and it is whole.
    Record(Option<Record>),
}

/// Content of a flash.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Opened {
    /// The stored parameters; factory values where none are stored.
    pub parameters: Parameters,
    /// Fault bits 26, 30, 31 (Table 9).
    pub faults: FaultWord,
    /// A copy was damaged and has been made anew from the other one.
    pub repaired: bool,
    /// The log.
    pub log: Memory,
}

/// The storage on one flash.
#[derive(Clone, Debug)]
pub struct Storage<F> {
    flash: F,
    place: Option<Place>,
    buffers: Buffers,
}

/// Data that depend on the size of the flash.
#[derive(Clone, Debug)]
struct Place {
    layout: Layout,
    pair: Pair,
    log: Log,
    /// The flash carries this layout.
    labelled: bool,
    /// A part did not fit: the next store writes both.
    unfit: bool,
}

/// The first words of a label: name and version of the layout. The third word is the size of the flash, the
/// fourth the inverted sum of the others, so that a single wrong bit makes a label invalid.
const LABEL: [u32; 2] = [u32::from_be_bytes(*b"narx"), 2];
const LABEL_BYTES: usize = 16;

impl<F> Storage<F> {
    /// Makes the storage; the flash is not read before the first request, which is [`FlashTask::Open`].
    pub const fn new(flash: F) -> Self {
        Self { flash, place: None, buffers: Buffers::new() }
    }
}

impl<F: NorFlash> Storage<F> {
    /// Gives the flash back.
    pub fn into_flash(self) -> F {
        self.flash
    }

    /// The flash.
    pub const fn flash(&mut self) -> &mut F {
        &mut self.flash
    }

    /// Executes one step of a request: a store, a record, a piece of an erase.
    pub async fn execute(&mut self, request: FlashTask) -> FlashReply {
        match request {
            FlashTask::Open => FlashReply::Opened(self.open().await),
            FlashTask::Store(parameters, part) => {
                let done = self.store(&parameters, part).await.is_ok();
                FlashReply::Stored { done, log: self.memory() }
            }
            FlashTask::Append(entry) => {
                let done = match &mut self.place {
                    Some(Place { log, pair, .. }) => {
                        log.append(&mut self.flash, pair, &mut self.buffers, &entry).await
                    }
                    _ => Err(Failed),
                };
                FlashReply::Log { done: done.is_ok(), memory: self.memory() }
            }
            FlashTask::Read(index) => {
                let found = match &self.place {
                    Some(place) => place.log.read(&mut self.flash, index).await,
                    _ => Err(Failed),
                };
                FlashReply::Record(found.unwrap_or(None))
            }
            FlashTask::Erase => {
                let done = match &mut self.place {
                    Some(Place { log, pair, labelled: true, .. }) => {
                        log.erase(&mut self.flash, pair, &mut self.buffers).await
                    }
                    _ => Err(Failed),
                };
                FlashReply::Log { done: done.is_ok(), memory: self.memory() }
            }
        }
    }

    /// Formats a blank flash: layout, both parts of the parameters, an empty log. Returns whether it
    /// succeeded.
    pub async fn format(&mut self, parameters: &Parameters) -> bool {
        self.open().await;
        let stored = self.store(parameters, Part::Set).await.is_ok();
        let Some(place) = &mut self.place else { return false };
        stored && place.log.begin(&mut self.flash, &place.pair, &mut self.buffers).await.is_ok()
    }

    fn memory(&self) -> Memory {
        self.place.as_ref().map_or_else(Memory::default, |place| place.log.memory())
    }

    async fn open(&mut self) -> Opened {
        let mut opened = Opened {
            parameters: Parameters::new(),
            faults: FaultWord::empty(),
            repaired: false,
            log: Memory::default(),
        };
        if self.load(&mut opened).await.is_err() {
            opened.faults = FaultWord::STORE_ABSENT;
            opened.log = Memory::default();
            self.place = None;
        }
        opened
    }

    async fn load(&mut self, opened: &mut Opened) -> Result<(), Failed> {
        let Self { flash, place, buffers } = self;
        let capacity = u32::try_from(flash.capacity()).map_err(|_| Failed)?;
        let subsector = F::ERASE_SIZE as u32;
        let layout = Layout::of(capacity, subsector).ok_or(Failed)?;
        let pair = Pair::of(&layout);
        let log = Log::new(layout.log.clone(), subsector);
        let place = place.insert(Place { layout, pair, log, labelled: false, unfit: false });
        opened.log = place.log.memory();
        let labels = [
            is_label(flash, &place.layout.primary.label, capacity).await?,
            is_label(flash, &place.layout.mirror.label, capacity).await?,
        ];
        if labels == [false; 2] {
            opened.faults = FaultWord::STORE_MISMATCH;
            return Ok(());
        }
        place.labelled = true;
        opened.repaired |= labels != [true; 2];
        for (label, whole) in
            [&place.layout.primary.label, &place.layout.mirror.label].into_iter().zip(labels)
        {
            if !whole {
                write_label(flash, label, capacity).await?;
            }
        }
        place.load_maps(flash, buffers, opened).await?;
        opened.repaired |= place.log.open(flash, &place.pair, buffers).await?;
        if opened.repaired {
            place.pair.mend(flash, buffers).await?;
        }
        opened.log = place.log.memory();
        Ok(())
    }

    /// Stores a part of the parameters. On a flash without a label the maps are made first and the labels
    /// last: a label states that everything is there.
    async fn store(&mut self, parameters: &Parameters, part: Part) -> Result<(), Failed> {
        let Self { flash, place: Some(place), buffers } = self else { return Err(Failed) };
        let Place { layout, pair, labelled, unfit, .. } = place;
        let one = core::slice::from_ref(&part);
        let parts = if *labelled && !*unfit { one } else { &[Part::Set, Part::Once] };
        if !*labelled {
            for copy in [&layout.primary, &layout.mirror] {
                blank::erase(flash, copy.label.start..copy.map.end).await?;
            }
        }
        for part in parts {
            let key = if *part == Part::Set { Key::Set } else { Key::Once };
            pair.write(flash, key, buffers, |body| part.encode(parameters, body)).await?;
        }
        if !*labelled {
            let capacity = u32::try_from(flash.capacity()).map_err(|_| Failed)?;
            write_label(flash, &layout.primary.label, capacity).await?;
            write_label(flash, &layout.mirror.label, capacity).await?;
        }
        (*labelled, *unfit) = (true, false);
        Ok(())
    }
}

impl Place {
    /// Reads the stored parameters.
    async fn load_maps<F: NorFlash>(
        &mut self,
        flash: &mut F,
        buffers: &mut Buffers,
        opened: &mut Opened,
    ) -> Result<(), Failed> {
        for (key, part) in [(Key::Set, Part::Set), (Key::Once, Part::Once)] {
            let found = self.pair.read(flash, key, buffers).await?;
            opened.repaired |= found.differs;
            let fault = if !found.present {
                FaultWord::STORE_MISMATCH
            } else if part.decode(buffers.body(), &mut opened.parameters).is_err() {
                FaultWord::STORE_VERSION
            } else {
                continue;
            };
            opened.faults |= fault;
            self.unfit = true;
        }
        Ok(())
    }
}

fn label(capacity: u32) -> [u8; LABEL_BYTES] {
    let [name, version] = LABEL;
    let check = !(name.wrapping_add(version).wrapping_add(capacity));
    let mut bytes = [0; LABEL_BYTES];
    let (words, _) = bytes.as_chunks_mut::<4>();
    for (place, word) in words.iter_mut().zip([name, version, capacity, check]) {
        *place = word.to_be_bytes();
    }
    bytes
}

async fn is_label<F: NorFlash>(flash: &mut F, at: &Range<u32>, capacity: u32) -> Result<bool, Failed> {
    let mut bytes = [0; LABEL_BYTES];
    flash.read(at.start, &mut bytes).await.map_err(|_| Failed)?;
    Ok(bytes == label(capacity))
}

async fn write_label<F: NorFlash>(flash: &mut F, at: &Range<u32>, capacity: u32) -> Result<(), Failed> {
    blank::erase(flash, at.clone()).await?;
    flash.write(at.start, &label(capacity)).await.map_err(|_| Failed)
}
