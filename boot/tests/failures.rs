//! A flash that does not do what it is told, and flashes that no map is for.

use crate::support::{Flash, HARDWARE, Hasty, MAP, NEW, OLD, PAGE, board_with, receive, slot};
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};
use narx_boot::{Board, Failure, MapError, Slot, SlotError};

/// Error of a flash that does not do what it is told.
#[derive(Clone, Copy, Debug)]
struct Worn;

impl NorFlashError for Worn {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::OutOfBounds
    }
}

/// Reads, and neither programs nor erases. It programs words of `WORD` bytes.
struct ReadOnly<const WORD: usize>(Flash);

impl<const WORD: usize> ErrorType for ReadOnly<WORD> {
    type Error = Worn;
}

impl<const WORD: usize> ReadNorFlash for ReadOnly<WORD> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Worn> {
        self.0.read(offset, bytes).map_err(|_| Worn)
    }

    fn capacity(&self) -> usize {
        self.0.capacity()
    }
}

impl<const WORD: usize> NorFlash for ReadOnly<WORD> {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = PAGE;

    fn write(&mut self, _: u32, _: &[u8]) -> Result<(), Worn> {
        Err(Worn)
    }

    fn erase(&mut self, _: u32, _: u32) -> Result<(), Worn> {
        Err(Worn)
    }
}

/// The kind of the failure is the flash's, whatever was to be done: swapped, or noted that it is not to be.
#[test]
fn a_boot_tells_how_the_flash_has_failed() {
    for candidate in [Hasty::image(NEW, 1000), vec![0; 600]] {
        let mut flash = board_with(&Hasty::image(OLD, 1000));
        flash.load(MAP.dfu.start, &candidate);
        slot(&mut flash).mark().unwrap();
        let outcome =
            narx_boot::boot(&mut ReadOnly::<8>(flash), &MAP, &Board { hardware: HARDWARE, key: Hasty });
        assert_eq!(outcome, Err(Failure::Flash(NorFlashErrorKind::OutOfBounds)));
    }
}

#[test]
fn an_application_is_told_how_the_flash_has_failed() {
    let error = Err(SlotError::Flash(NorFlashErrorKind::OutOfBounds));
    let mut settled = Slot::new(ReadOnly::<8>(board_with(&[])), MAP, HARDWARE).unwrap();
    assert_eq!(settled.mark(), error);
    assert_eq!(settled.erase(0), error);
    assert_eq!(settled.write(0, &[0; 8]), error);
    let mut flash = board_with(&Hasty::image(OLD, 1000));
    receive(&mut flash, &Hasty::image(NEW, 1000)).unwrap();
    let mut marked = Slot::new(ReadOnly::<8>(flash.clone()), MAP, HARDWARE).unwrap();
    assert_eq!(marked.begin(), error);
    Hasty::boot(&mut flash).unwrap();
    let mut trial = Slot::new(ReadOnly::<8>(flash), MAP, HARDWARE).unwrap();
    assert_eq!(trial.confirm(), error);
}

/// A word of 4 bytes torn could look like another, and embassy-boot has room for one of 32.
#[test]
fn words_of_8_to_32_bytes() {
    fn check<const WORD: usize>() -> Result<(), MapError> {
        // As many words of state, whatever their length.
        let page = PAGE as u32;
        let map = narx_boot::Map::stacked([page, page, 2 * page, 3 * page, 0]);
        map.check(&ReadOnly::<WORD>(board_with(&[])))
    }
    let found = [check::<4>(), check::<8>(), check::<16>(), check::<24>(), check::<32>(), check::<64>()];
    let no = Err(MapError::WriteSize);
    assert_eq!(found, [no, Ok(()), Ok(()), no, Ok(()), no]);
}
