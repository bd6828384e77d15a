//! The bootloader's work between reset and the application.

use crate::image::Header;
use crate::map::{Map, MapError};
use crate::mark::{self, Mark, StatePages, WORD_MAX};
use crate::verify::{Board, ImageError, Signatory};
use core::cell::RefCell;
use core::fmt;
use core::ops::Range;
use embassy_boot::{
    AlignedBuffer, BlockingFirmwareState, BootError, BootLoader, BootLoaderConfig, FirmwareUpdaterError,
};
use embassy_embedded_hal::flash::partition::BlockingPartition;
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embedded_storage::nor_flash::{NorFlash, NorFlashErrorKind};

/// Next step of the bootloader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Enter the active image, whose vector table stands at [`Map::entry`]. It has just been verified.
    Run {
        /// Header of the active image.
        header: Header,
        /// Work done on the slots before.
        event: Event,
    },
    /// Enter nothing: there is no verified image. What is wrong with the active one.
    Stay(ImageError),
}

/// Work done on the slots before the active image was verified.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// Nothing.
    Unchanged,
    /// The candidate was swapped in. It is on trial: without a confirmation the next boot takes the swap
    /// back.
    Swapped,
    /// The image before was swapped back.
    Reverted,
    /// The candidate was not swapped in, and is forgotten.
    Refused(ImageError),
    /// The image on trial was not confirmed, but the other slot holds no valid image to swap back: the trial
    /// goes on.
    Kept,
}

/// Reason why there is no outcome; nothing may be entered then.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// The map does not fit the flash.
    Map(MapError),
    /// The flash does not do what it is told.
    Flash(NorFlashErrorKind),
}

/// Swaps, reverts and verifies as the state pages ask for, from wherever a power cut has left them.
///
/// # Errors
/// The flash fails, or cannot have this map, or the map has one slot.
pub fn boot<F: NorFlash, S: Signatory>(
    flash: &mut F,
    map: &Map,
    board: &Board<S>,
) -> Result<Outcome, Failure> {
    map.check(flash).map_err(Failure::Map)?;
    if map.dfu.is_empty() {
        return Err(Failure::Map(MapError::Dfu));
    }
    settle_slots(flash, map, board).map_err(Failure::Flash)
}

fn settle_slots<F: NorFlash, S: Signatory>(
    flash: &mut F,
    map: &Map,
    board: &Board<S>,
) -> Result<Outcome, NorFlashErrorKind> {
    let mut event = handle_mark(flash, map, board)?;
    let mut active = board.verify(flash, map.active.clone())?;
    if active.is_err() && event == Event::Swapped {
        // It was verified before it was moved, so the flash has lost a bit since: back at once.
        prepare(flash, map)?;
        event = Event::Reverted;
        active = board.verify(flash, map.active.clone())?;
    }
    Ok(match active {
        Ok(header) => Outcome::Run { header, event },
        Err(error) => Outcome::Stay(error),
    })
}

fn handle_mark<F: NorFlash, S: Signatory>(
    flash: &mut F,
    map: &Map,
    board: &Board<S>,
) -> Result<Event, NorFlashErrorKind> {
    Ok(match Mark::read(flash, map)? {
        Mark::Settled { .. } => Event::Unchanged,
        Mark::Settling => {
            confirm(flash, map)?;
            Event::Unchanged
        }
        Mark::Candidate => match candidate(flash, map, board)? {
            Ok(_) => {
                prepare(flash, map)?;
                Event::Swapped
            }
            Err(error) => {
                confirm(flash, map)?;
                mark::note_verdict(flash, map, error.kind() as u8)?;
                Event::Refused(error)
            }
        },
        // Half of each image is in either slot: no other way than on.
        Mark::Swapping => {
            prepare(flash, map)?;
            Event::Swapped
        }
        Mark::Trial => match board.verify(flash, predecessor::<F>(map))? {
            Ok(_) => {
                prepare(flash, map)?;
                Event::Reverted
            }
            Err(_) => Event::Kept,
        },
        Mark::Reverting => {
            prepare(flash, map)?;
            Event::Reverted
        }
    })
}

/// The image that is to be swapped in, if it may be: verified, and not older than the one that runs. Where
/// nothing runs any age is better.
fn candidate<F: NorFlash, S: Signatory>(
    flash: &mut F,
    map: &Map,
    board: &Board<S>,
) -> Result<Result<Header, ImageError>, NorFlashErrorKind> {
    let candidate = match board.verify(flash, map.dfu.start..map.dfu.start + map.room())? {
        Ok(header) => header,
        Err(error) => return Ok(Err(error)),
    };
    Ok(match board.verify(flash, map.active.clone())? {
        Ok(running) if candidate.version < running.version => Err(ImageError::Older(candidate.version)),
        _ => Ok(candidate),
    })
}

/// Range into which a swap has put the image that was active: `dfu` without its first page.
fn predecessor<F: NorFlash>(map: &Map) -> Range<u32> {
    map.dfu.start + F::ERASE_SIZE as u32..map.dfu.end
}

type Part<'a, 'f, F> = BlockingPartition<'a, NoopRawMutex, &'f mut F>;
type Shared<'f, F> = Mutex<NoopRawMutex, RefCell<&'f mut F>>;

fn part<'a, 'f, F: NorFlash>(shared: &'a Shared<'f, F>, range: &Range<u32>) -> Part<'a, 'f, F> {
    BlockingPartition::new(shared, range.start, range.end - range.start)
}

/// Swaps, goes on with it, or takes it back: embassy-boot knows which.
fn prepare<F: NorFlash>(flash: &mut F, map: &Map) -> Result<(), NorFlashErrorKind> {
    let shared = Shared::new(RefCell::new(flash));
    let config = BootLoaderConfig {
        active: part(&shared, &map.active),
        dfu: part(&shared, &map.dfu),
        state: part(&shared, &map.state),
    };
    let mut buffer = AlignedBuffer([0; 256]);
    match BootLoader::new(config).prepare_boot(buffer.as_mut()) {
        Ok(_) => Ok(()),
        Err(BootError::Flash(kind)) => Err(kind),
        Err(BootError::BadMagic) => Err(NorFlashErrorKind::Other),
    }
}

/// Nothing is to be swapped any more: the active image is the one to keep.
pub(crate) fn confirm<F: NorFlash>(flash: &mut F, map: &Map) -> Result<(), NorFlashErrorKind> {
    write_state(flash, map, |state| state.mark_booted())
}

/// The image in `dfu` is to be swapped in at the next boot.
pub(crate) fn mark_candidate<F: NorFlash>(flash: &mut F, map: &Map) -> Result<(), NorFlashErrorKind> {
    write_state(flash, map, |state| state.mark_updated())
}

fn write_state<'f, F: NorFlash>(
    flash: &'f mut F,
    map: &Map,
    write: impl FnOnce(&mut BlockingFirmwareState<'_, StatePages<'f, F>>) -> Result<(), FirmwareUpdaterError>,
) -> Result<(), NorFlashErrorKind> {
    let mut buffer = AlignedBuffer([0; WORD_MAX]);
    let word = buffer.as_mut().get_mut(..F::WRITE_SIZE).unwrap_or_default();
    let mut state = BlockingFirmwareState::new(StatePages::new(flash, map), word);
    write(&mut state).map_err(|error| match error {
        FirmwareUpdaterError::Flash(kind) => kind,
        _ => NorFlashErrorKind::Other,
    })
}

impl fmt::Display for Outcome {
    /// For a bootloader with a line to write on.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stay(error) => write!(f, "no image to run: {error}"),
            Self::Run { header, event } => {
                match event {
                    Event::Unchanged => {}
                    Event::Swapped => f.write_str("candidate swapped in, on trial; ")?,
                    Event::Reverted => f.write_str("candidate not confirmed, swapped back; ")?,
                    Event::Refused(error) => write!(f, "candidate refused: {error}; ")?,
                    Event::Kept => f.write_str("candidate not confirmed, and nothing to go back to; ")?,
                }
                write!(f, "version {}", header.version)
            }
        }
    }
}
