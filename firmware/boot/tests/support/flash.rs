//! The flash inside a microcontroller: words of 8 bytes that are programmed once an erase, pages, and a power that fails anywhere.

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};

/// Bytes of a page.
pub(crate) const PAGE: u32 = 512;
/// Bytes of a word.
pub(crate) const WORD: usize = 8;
const CAPACITY: usize = 11 * PAGE as usize;

/// What is left of the word, or of the page, during which the power failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Tear {
    /// What was there before.
    Nothing,
    /// Some of the bits have changed.
    Part,
    /// Any bits.
    Garbage,
    /// All of them have, but the operation never told.
    All,
}

impl Tear {
    pub(crate) const ALL: [Self; 4] = [Self::Nothing, Self::Part, Self::Garbage, Self::All];
}

#[derive(Clone)]
pub(crate) struct Internal {
    pub(crate) bytes: Vec<u8>,
    /// Programs of a word and erases of a page since it was made.
    pub(crate) steps: u64,
    /// The step that fails, and how.
    pub(crate) cut: Option<(u64, Tear)>,
    pub(crate) off: bool,
    random: u64,
}

#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Trouble {
    PowerLost,
    NotAligned,
    OutOfBounds,
    /// A word that was programmed is programmed again, which the hardware refuses unless all of it becomes 0 (RM0440, section 3.3.7, PROGERR).
    ProgrammedTwice,
}

impl NorFlashError for Trouble {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::NotAligned => NorFlashErrorKind::NotAligned,
            Self::OutOfBounds => NorFlashErrorKind::OutOfBounds,
            _ => NorFlashErrorKind::Other,
        }
    }
}

impl Internal {
    pub(crate) fn new() -> Self {
        Self { bytes: vec![0xFF; CAPACITY], steps: 0, cut: None, off: false, random: 0x9E37_79B9_7F4A_7C15 }
    }

    /// As a debugger writes.
    pub(crate) fn put(&mut self, at: u32, bytes: &[u8]) {
        self.bytes[at as usize..at as usize + bytes.len()].copy_from_slice(bytes);
    }

    /// The power fails in the step number `steps` from now.
    pub(crate) fn cut_after(&mut self, steps: u64, tear: Tear) {
        self.cut = Some((self.steps + steps, tear));
        self.random ^= steps << 8;
    }

    pub(crate) fn restore_power(&mut self) {
        (self.off, self.cut) = (false, None);
    }

    fn random(&mut self) -> u8 {
        // xorshift64
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        (self.random >> 32) as u8
    }

    fn check(&self, from: usize, length: usize, unit: usize) -> Result<(), Trouble> {
        if self.off {
            return Err(Trouble::PowerLost);
        }
        if !from.is_multiple_of(unit) || !length.is_multiple_of(unit) {
            return Err(Trouble::NotAligned);
        }
        if from + length > self.bytes.len() { Err(Trouble::OutOfBounds) } else { Ok(()) }
    }

    /// One word or page becomes `wanted`, unless the power fails in it.
    fn step(&mut self, from: usize, wanted: &[u8]) -> Result<(), Trouble> {
        let struck = self.cut.filter(|(at, _)| *at == self.steps);
        self.steps += 1;
        for (at, wanted) in (from..).zip(wanted) {
            let old = self.bytes[at];
            self.bytes[at] = match struck {
                None | Some((_, Tear::All)) => *wanted,
                Some((_, Tear::Nothing)) => old,
                Some((_, Tear::Part)) => {
                    let changed = self.random();
                    (old & !changed) | (wanted & changed)
                }
                Some((_, Tear::Garbage)) => self.random(),
            };
        }
        self.off = struck.is_some();
        if self.off { Err(Trouble::PowerLost) } else { Ok(()) }
    }
}

impl ErrorType for Internal {
    type Error = Trouble;
}

impl ReadNorFlash for Internal {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Trouble> {
        self.check(offset as usize, bytes.len(), 1)?;
        bytes.copy_from_slice(&self.bytes[offset as usize..][..bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for Internal {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = PAGE as usize;

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Trouble> {
        self.check(offset as usize, bytes.len(), WORD)?;
        for (at, word) in (offset as usize..).step_by(WORD).zip(bytes.chunks(WORD)) {
            let is_erased = self.bytes[at..at + WORD].iter().all(|byte| *byte == 0xFF);
            if !is_erased && word.iter().any(|byte| *byte != 0) {
                return Err(Trouble::ProgrammedTwice);
            }
            self.step(at, word)?;
        }
        Ok(())
    }

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Trouble> {
        self.check(from as usize, (to - from) as usize, PAGE as usize)?;
        for at in (from as usize..to as usize).step_by(PAGE as usize) {
            self.step(at, &[0xFF; PAGE as usize])?;
        }
        Ok(())
    }
}
