//! The state pages: what is marked to be swapped, and how far the swap is. They are embassy-boot's, which
//! writes them; here they are read more closely, because it does not tell a swap that has begun from one that
//! has not.
//!
//! ```text
//!  word 0            magic: swap, reverted, or anything else
//!  word 1            erased: what follows counts
//!  words 2..2+2n     a word for each page that was copied in the swap, n pages in the active slot
//!  then 2n           likewise in the revert
//!  last word         ours: why the last candidate was refused
//! ```

use crate::map::Map;
use embassy_boot::State;
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};

/// The longest word of a flash.
pub(crate) const WORD_MAX: usize = 32;
const ERASED: u8 = 0xFF;

/// State that the state pages record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Nothing is to be done.
    Settled {
        /// The last swap was taken back.
        reverted: bool,
    },
    /// A candidate is to be swapped in; no page was moved yet.
    Candidate,
    /// A swap is under way.
    Swapping,
    /// The swap is done, and nobody has confirmed the image.
    Trial,
    /// The swap is being taken back.
    Reverting,
    /// A confirmation, or the end of a revert, was cut off: the active image is the one to keep.
    Settling,
}

impl Mark {
    /// Reads the state pages.
    pub(crate) fn read<F: NorFlash>(flash: &mut F, map: &Map) -> Result<Self, NorFlashErrorKind> {
        let mut pages = StatePages::new(flash, map);
        let magic = pages.word(0)?;
        match State::from(magic.as_ref()) {
            State::Swap => {}
            State::Revert => return Ok(Self::Settled { reverted: true }),
            State::Boot | State::DfuDetach => return Ok(Self::Settled { reverted: false }),
        }
        if !pages.word(1)?.is_erased() {
            return Ok(Self::Settling);
        }
        let swapped = 2 * map.room() / F::ERASE_SIZE as u32;
        Ok(match pages.progress(2 * swapped)? {
            0 => Self::Candidate,
            moved if moved < swapped => Self::Swapping,
            moved if moved == swapped => Self::Trial,
            _ => Self::Reverting,
        })
    }
}

/// Reads the reason for which the bootloader has refused the last candidate: a code of ours, not of
/// embassy-boot; 0 for none.
pub(crate) fn verdict<F: NorFlash>(flash: &mut F, map: &Map) -> Result<u8, NorFlashErrorKind> {
    let mut pages = StatePages::new(flash, map);
    let last = (pages.to - pages.from) / F::WRITE_SIZE as u32 - 1;
    let word = pages.word(last)?;
    // Torn, it says nothing.
    Ok(match word.as_ref() {
        [code, rest @ ..] if rest.iter().all(|byte| *byte == !*code) => *code,
        _ => 0,
    })
}

/// Notes the code of a refusal, in state pages that have been erased since the last one.
pub(crate) fn note_verdict<F: NorFlash>(flash: &mut F, map: &Map, code: u8) -> Result<(), NorFlashErrorKind> {
    let mut word = [!code; WORD_MAX];
    let [first, ..] = &mut word;
    *first = code;
    let at = map.state.end - F::WRITE_SIZE as u32;
    let word = word.get(..F::WRITE_SIZE).unwrap_or(&word);
    flash.write(at, word).map_err(|error| error.kind())
}

/// A flash of their own. Unlike a partition that shares its flash, it borrows nothing while it runs, so
/// nothing of it can panic in an application.
pub(crate) struct StatePages<'f, F> {
    flash: &'f mut F,
    from: u32,
    to: u32,
}

struct Word {
    bytes: [u8; WORD_MAX],
    length: usize,
}

impl<'f, F: NorFlash> StatePages<'f, F> {
    pub(crate) fn new(flash: &'f mut F, map: &Map) -> Self {
        Self { flash, from: map.state.start, to: map.state.end }
    }

    fn word(&mut self, index: u32) -> Result<Word, NorFlashErrorKind> {
        let mut word = Word { bytes: [0; WORD_MAX], length: F::WRITE_SIZE.min(WORD_MAX) };
        let place = word.bytes.get_mut(..word.length).unwrap_or_default();
        self.read(index * F::WRITE_SIZE as u32, place)?;
        Ok(word)
    }

    /// Pages that were copied: a word that is not wholly programmed does not count, as in embassy-boot.
    fn progress(&mut self, most: u32) -> Result<u32, NorFlashErrorKind> {
        for moved in 0..most {
            if self.word(2 + moved)?.as_ref().contains(&ERASED) {
                return Ok(moved);
            }
        }
        Ok(most)
    }
}

impl<F> ErrorType for StatePages<'_, F> {
    type Error = NorFlashErrorKind;
}

impl<F: NorFlash> ReadNorFlash for StatePages<'_, F> {
    const READ_SIZE: usize = F::READ_SIZE;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        check_read(self, offset, bytes.len())?;
        self.flash.read(self.from + offset, bytes).map_err(|error| error.kind())
    }

    fn capacity(&self) -> usize {
        self.to.saturating_sub(self.from) as usize
    }
}

impl<F: NorFlash> NorFlash for StatePages<'_, F> {
    const WRITE_SIZE: usize = F::WRITE_SIZE;
    const ERASE_SIZE: usize = F::ERASE_SIZE;

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        check_write(self, offset, bytes.len())?;
        self.flash.write(self.from + offset, bytes).map_err(|error| error.kind())
    }

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        check_erase(self, from, to)?;
        self.flash.erase(self.from + from, self.from + to).map_err(|error| error.kind())
    }
}

impl Word {
    fn is_erased(&self) -> bool {
        self.as_ref().iter().all(|byte| *byte == ERASED)
    }
}

impl AsRef<[u8]> for Word {
    fn as_ref(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or(&self.bytes)
    }
}
