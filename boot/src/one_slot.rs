//! One slot and a bootloader that receives, for a flash without room for two.
//!
//! ```text
//!  application      BEGIN: floor and addresses noted, restart                 on trial, until it is confirmed
//!                      |                                                            ^
//!  bootloader          +-> receive: erase, write, complete -> restart -> verify ----+
//!                             ^                                            |
//!                             +--- refused, or restarted while on trial <--+
//! ```
//!
//! The image is written over the one that runs, so until a new one is complete there is none; but then the
//! bootloader receives, after every power cut and after an image that was refused or has not been confirmed.
//!
//! The state page holds records, each behind the one before. The last one says what is to be done:
//!
//! ```text
//!  Floor version | Left addresses | Complete | Trial | Confirmed
//!                                            | Refused reason
//! ```

use crate::Version;
use crate::image::{HEADER_LENGTH, Header};
use crate::map::{Map, MapError};
use crate::slot::{SlotError, Verdict};
use crate::verify::{self, Board, ImageError, Refused, Signatory};
use embedded_storage::nor_flash::{NorFlash, NorFlashError, NorFlashErrorKind};

/// Addresses of a drive and of its master on the bus.
pub type Addresses = [u8; 2];

/// Bytes of a record: whole words of any flash up to 32 bytes.
const RECORD: usize = 32;
/// Bytes of its content, behind which their complement stands: a torn record is none.
const CONTENT: usize = RECORD / 2;
const ERASED: u8 = 0xFF;
/// Reason in a record of an image that was not confirmed.
const REVERTED: u8 = 0xF0;

/// The slot of a board that has one.
#[derive(Clone, Debug)]
pub struct OneSlot<F> {
    flash: F,
    map: Map,
    hardware: u32,
}

/// Next step of the bootloader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entry {
    /// Enter the image, which has just been verified: its vector table stands at [`Map::entry`].
    Run(Header),
    /// Receive an image.
    Receive,
}

/// State that the records lead to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Condition {
    /// Next step of the bootloader, or of the master.
    pub step: Step,
    /// Version below which no image is taken; `None` before the first update.
    pub floor: Option<Version>,
    /// Addresses of the drive that has left; `None` before the first update.
    pub addresses: Option<Addresses>,
    /// Reason why the last image does not run.
    pub verdict: Option<Verdict>,
    /// Records that are written, torn ones too.
    records: u32,
}

/// Step that comes next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Enter the image.
    Run,
    /// Receive one.
    Receive,
    /// Enter the image that was received, on trial.
    Try,
    /// The image is on trial.
    Confirm,
}

#[derive(Clone, Copy, Debug)]
enum Record {
    Floor(Version),
    Left(Addresses),
    Complete,
    Trial,
    Confirmed,
    Refused(u8),
}

impl<F: NorFlash> OneSlot<F> {
    /// The slot `map.active` in this flash, on a board with this hardware id.
    ///
    /// # Errors
    /// The flash cannot have this map, or the map has two slots.
    pub fn new(flash: F, map: Map, hardware: u32) -> Result<Self, MapError> {
        map.check(&flash)?;
        if !map.dfu.is_empty() {
            return Err(MapError::Dfu);
        }
        Ok(Self { flash, map, hardware })
    }

    /// The bootloader's work between reset and the application.
    ///
    /// # Errors
    /// The flash fails; nothing may be entered then.
    pub fn boot<S: Signatory>(&mut self, key: S) -> Result<Entry, NorFlashErrorKind> {
        let Condition { step, floor, .. } = self.read_condition()?;
        if step == Step::Receive {
            return Ok(Entry::Receive);
        }
        if step == Step::Confirm {
            self.note(Record::Refused(REVERTED))?;
            return Ok(Entry::Receive);
        }
        let board = Board { hardware: self.hardware, key };
        let verified = match board.verify(&mut self.flash, self.map.active.clone())? {
            Ok(header) if step == Step::Try && Some(header.version) < floor => {
                Err(ImageError::Older(header.version))
            }
            verified => verified,
        };
        match (verified, step) {
            (Ok(header), Step::Try) => {
                self.note(Record::Trial)?;
                Ok(Entry::Run(header))
            }
            (Ok(header), _) => Ok(Entry::Run(header)),
            (Err(error), Step::Try) => {
                self.note(Record::Refused(error.kind() as u8))?;
                Ok(Entry::Receive)
            }
            (Err(_), _) => Ok(Entry::Receive),
        }
    }

    /// The application makes way for an image: the next boot receives, at these addresses.
    ///
    /// # Errors
    /// The application is on trial, or the flash fails.
    pub fn leave(&mut self, addresses: Addresses) -> Result<(), SlotError> {
        let condition = self.condition()?;
        if condition.step == Step::Confirm {
            return Err(SlotError::Trial);
        }
        let running = self.header()?.map(|header| header.version).ok();
        self.begin_anew(running.max(condition.floor), Some(addresses)).map_err(SlotError::Flash)
    }

    /// Confirms the image on trial: it stays. Without a trial there is nothing to do.
    ///
    /// # Errors
    /// The flash fails.
    pub fn confirm(&mut self) -> Result<(), SlotError> {
        match self.condition()?.step {
            Step::Confirm => self.note(Record::Confirmed).map_err(SlotError::Flash),
            _ => Ok(()),
        }
    }

    /// The bootloader begins to receive: what was complete is not any more.
    ///
    /// # Errors
    /// The flash fails.
    pub fn begin(&mut self, addresses: Addresses) -> Result<(), SlotError> {
        self.note(Record::Left(addresses)).map_err(SlotError::Flash)
    }

    /// Erases the page at `offset` of the slot, bytes.
    ///
    /// # Errors
    /// The flash fails, or the slot has no such page.
    pub fn erase(&mut self, offset: u32) -> Result<(), SlotError> {
        let from = self.place(offset, self.page())?;
        self.flash.erase(from, from + self.page()).map_err(|error| SlotError::Flash(error.kind()))
    }

    /// Writes into erased flash. Offset and length are multiples of the word that the flash programs.
    ///
    /// # Errors
    /// The flash fails, or the slot ends before.
    pub fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), SlotError> {
        let from = self.place(offset, bytes.len() as u32)?;
        self.flash.write(from, bytes).map_err(|error| SlotError::Flash(error.kind()))
    }

    /// Reads back.
    ///
    /// # Errors
    /// The flash fails, or the slot ends before.
    pub fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), SlotError> {
        let from = self.place(offset, bytes.len() as u32)?;
        self.flash.read(from, bytes).map_err(|error| SlotError::Flash(error.kind()))
    }

    /// Looks at the header of the image of `length` bytes that was received, and has the next boot verify and
    /// enter it.
    ///
    /// # Errors
    /// It is no image for this board, or older than the last one that ran, or the flash fails.
    pub fn complete(&mut self, length: u32) -> Result<(), SlotError> {
        let header = self.header()?.map_err(SlotError::Image)?;
        if header.image_length() != length {
            return Err(SlotError::Image(ImageError::TooLong(header.image_length())));
        }
        if Some(header.version) < self.condition()?.floor {
            return Err(SlotError::Image(ImageError::Older(header.version)));
        }
        self.note(Record::Complete).map_err(SlotError::Flash)
    }

    /// Reads what the records say.
    ///
    /// # Errors
    /// The flash cannot be read.
    pub fn condition(&mut self) -> Result<Condition, SlotError> {
        self.read_condition().map_err(SlotError::Flash)
    }

    /// Reads the header of the image in the slot, which need not be valid.
    ///
    /// # Errors
    /// The flash cannot be read.
    pub fn header(&mut self) -> Result<Result<Header, ImageError>, SlotError> {
        let mut bytes = [0; HEADER_LENGTH];
        self.read(0, &mut bytes)?;
        Ok(verify::inspect(&bytes, self.hardware, self.map.room()))
    }

    /// Longest image, header included, bytes.
    pub const fn room(&self) -> u32 {
        self.map.room()
    }

    /// Bytes that one [`erase`](Self::erase) erases.
    pub const fn page(&self) -> u32 {
        F::ERASE_SIZE as u32
    }

    /// The board that images must be for.
    pub const fn hardware(&self) -> u32 {
        self.hardware
    }

    /// The flash, to look at.
    pub const fn flash(&mut self) -> &mut F {
        &mut self.flash
    }

    /// The flash, to keep.
    pub fn into_flash(self) -> F {
        self.flash
    }

    fn read_condition(&mut self) -> Result<Condition, NorFlashErrorKind> {
        let mut condition =
            Condition { step: Step::Run, floor: None, addresses: None, verdict: None, records: 0 };
        let mut bytes = [0; RECORD];
        while condition.records < self.records_max() {
            self.flash
                .read(self.record_place(condition.records), &mut bytes)
                .map_err(|error| error.kind())?;
            if bytes.iter().all(|byte| *byte == ERASED) {
                break;
            }
            condition.records += 1;
            if let Some(record) = Record::decode(&bytes) {
                condition.take(record);
            }
        }
        Ok(condition)
    }

    /// Writes a record behind the others. Without room they begin anew, with what still counts.
    fn note(&mut self, record: Record) -> Result<(), NorFlashErrorKind> {
        let mut condition = self.read_condition()?;
        if condition.records >= self.records_max() {
            self.begin_anew(condition.floor, condition.addresses)?;
            condition = self.read_condition()?;
        }
        self.write_record(condition.records, record)
    }

    fn begin_anew(
        &mut self,
        floor: Option<Version>,
        addresses: Option<Addresses>,
    ) -> Result<(), NorFlashErrorKind> {
        let state = self.map.state.clone();
        self.flash.erase(state.start, state.end).map_err(|error| error.kind())?;
        // The floor counts by itself, so it comes first.
        let records = [floor.map(Record::Floor), addresses.map(Record::Left)];
        records.into_iter().flatten().zip(0..).try_for_each(|(record, at)| self.write_record(at, record))
    }

    fn write_record(&mut self, index: u32, record: Record) -> Result<(), NorFlashErrorKind> {
        let place = self.record_place(index);
        self.flash.write(place, &record.encode()).map_err(|error| error.kind())
    }

    fn records_max(&self) -> u32 {
        (self.map.state.end - self.map.state.start) / RECORD as u32
    }

    fn record_place(&self, index: u32) -> u32 {
        self.map.state.start + index * RECORD as u32
    }

    /// The place in the flash of a part of the slot.
    fn place(&self, offset: u32, length: u32) -> Result<u32, SlotError> {
        match offset.checked_add(length) {
            Some(end) if end <= self.map.room() => Ok(self.map.active.start + offset),
            _ => Err(SlotError::Flash(NorFlashErrorKind::OutOfBounds)),
        }
    }
}

impl Condition {
    fn take(&mut self, record: Record) {
        match record {
            Record::Floor(version) => self.floor = Some(version),
            Record::Left(addresses) => {
                (self.step, self.addresses, self.verdict) = (Step::Receive, Some(addresses), None);
            }
            Record::Complete => self.step = Step::Try,
            Record::Trial => self.step = Step::Confirm,
            Record::Confirmed => self.step = Step::Run,
            Record::Refused(reason) => {
                self.step = Step::Receive;
                self.verdict = match reason {
                    REVERTED => Some(Verdict::Reverted),
                    reason => Refused::of(reason).map(Verdict::Refused),
                };
            }
        }
    }
}

impl Record {
    fn encode(self) -> [u8; RECORD] {
        let (tag, [a, b, c, d, e, f]) = match self {
            Self::Floor(Version { major, minor, patch, build }) => {
                let ([c, d], [e, f]) = (patch.to_be_bytes(), build.to_be_bytes());
                (1, [major, minor, c, d, e, f])
            }
            Self::Left([drive, master]) => (2, [drive, master, 0, 0, 0, 0]),
            Self::Complete => (3, [0; 6]),
            Self::Trial => (4, [0; 6]),
            Self::Confirmed => (5, [0; 6]),
            Self::Refused(reason) => (6, [reason, 0, 0, 0, 0, 0]),
        };
        let mut bytes = [0; RECORD];
        let (content, complement) = bytes.split_at_mut(CONTENT);
        content.iter_mut().zip([tag, a, b, c, d, e, f]).for_each(|(place, byte)| *place = byte);
        complement.iter_mut().zip(content).for_each(|(place, byte)| *place = !*byte);
        bytes
    }

    fn decode(bytes: &[u8; RECORD]) -> Option<Self> {
        let (content, complement) = bytes.split_first_chunk::<CONTENT>()?;
        if !content.iter().zip(complement).all(|(byte, complement)| *byte == !*complement) {
            return None;
        }
        let [tag, a, b, c, d, e, f, ..] = *content;
        Some(match tag {
            1 => Self::Floor(Version {
                major: a,
                minor: b,
                patch: u16::from_be_bytes([c, d]),
                build: u16::from_be_bytes([e, f]),
            }),
            2 => Self::Left([a, b]),
            3 => Self::Complete,
            4 => Self::Trial,
            5 => Self::Confirmed,
            6 => Self::Refused(a),
            _ => return None,
        })
    }
}
