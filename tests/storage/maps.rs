//! Parameters in four pages of a microcontroller's own flash: words of 8 bytes that are programmed once, pages of 2 KiB, and a power that may fail in any of them.

use crate::support::{now, set};
use embedded_storage_async::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use narx_core::dictionary::{Parameters, number};
use narx_core::motor::fault::FaultWord;
use narx_core::storage::{Opened, Part, Report, Request, Storage};

const PAGE: usize = 2 << 10;
const WORD: usize = 8;

/// Four pages. `left` operations go well; the one after that leaves `torn` in what it was about, and everything after it fails.
#[derive(Clone)]
struct Pages {
    bytes: Vec<u8>,
    left: Option<u32>,
    torn: u8,
    operations: u32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Failure {
    Power,
    NotAWord,
    ProgrammedTwice,
}

impl NorFlashError for Failure {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl Pages {
    fn blank() -> Self {
        Self { bytes: vec![0xFF; 4 * PAGE], left: None, torn: 0, operations: 0 }
    }

    fn put(&mut self, at: usize, bytes: &[u8]) -> Result<(), Failure> {
        self.operations += 1;
        match &mut self.left {
            Some(0) if self.torn == 0xFF => return Err(Failure::Power),
            Some(0) => {
                let torn = self.torn;
                self.torn = 0xFF;
                self.bytes[at..at + bytes.len()].iter_mut().for_each(|byte| *byte ^= torn);
                return Err(Failure::Power);
            }
            Some(left) => *left -= 1,
            None => {}
        }
        self.bytes[at..at + bytes.len()].copy_from_slice(bytes);
        Ok(())
    }
}

impl ErrorType for Pages {
    type Error = Failure;
}

impl ReadNorFlash for Pages {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Failure> {
        let from = offset as usize;
        bytes.copy_from_slice(&self.bytes[from..from + bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for Pages {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = PAGE;

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Failure> {
        if !(offset as usize).is_multiple_of(WORD) || !bytes.len().is_multiple_of(WORD) {
            return Err(Failure::NotAWord);
        }
        for (word, at) in bytes.chunks(WORD).zip((offset as usize..).step_by(WORD)) {
            let before = &self.bytes[at..at + WORD];
            // A word with its ECC takes a second programming only to all zeros (RM0440, section 3.3.7).
            if before.iter().any(|byte| *byte != 0xFF) && word.iter().any(|byte| *byte != 0) {
                return Err(Failure::ProgrammedTwice);
            }
            self.put(at, word)?;
        }
        Ok(())
    }

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Failure> {
        for page in (from as usize..to as usize).step_by(PAGE) {
            self.put(page, &[0xFF; PAGE])?;
        }
        Ok(())
    }
}

fn open(storage: &mut Storage<Pages, false>) -> Opened {
    match now(storage.execute(Request::Open)) {
        Report::Opened(opened) => opened,
        other => panic!("{other:?}"),
    }
}

fn store(storage: &mut Storage<Pages, false>, parameters: &Parameters, part: Part) -> bool {
    match now(storage.execute(Request::Store(parameters.clone(), part))) {
        Report::Stored { done, .. } => done,
        other => panic!("{other:?}"),
    }
}

/// Open and with both parts of `set(0)` on it.
fn stored() -> Storage<Pages, false> {
    let mut storage = Storage::of_maps(Pages::blank());
    assert_eq!(open(&mut storage).faults, FaultWord::STORE_MISMATCH, "blank: nobody has stored yet");
    assert!(store(&mut storage, &set(0), Part::Set));
    storage
}

fn reopened(mut pages: Pages) -> (Opened, Storage<Pages, false>) {
    pages.left = None;
    let mut storage = Storage::of_maps(pages);
    (open(&mut storage), storage)
}

#[test]
fn what_is_stored_is_found_again_and_there_is_no_log() {
    let (opened, mut storage) = reopened(stored().into_flash());
    assert_eq!((opened.faults, opened.repaired), (FaultWord::empty(), false));
    assert_eq!(opened.parameters, set(0), "the first store writes both parts");
    assert_eq!(opened.log, narx_core::storage::Memory::default());
    // The log's requests are answered and do nothing.
    let before = storage.flash().bytes.clone();
    assert!(matches!(now(storage.execute(Request::Erase)), Report::Log { done: false, .. }));
    assert!(matches!(now(storage.execute(Request::Read(0))), Report::Record(None)));
    assert!(storage.flash().bytes == before);
    // A page holds a set or two, so this goes round all pages many times.
    for variant in 1..=60 {
        assert!(store(&mut storage, &set(variant), if variant % 3 == 0 { Part::Once } else { Part::Set }));
    }
    let (opened, _) = reopened(storage.into_flash());
    assert_eq!(opened.faults, FaultWord::empty());
    assert_eq!(opened.parameters.raw(number::SPEED_RATE), set(59).raw(number::SPEED_RATE));
    assert_eq!(opened.parameters.raw(number::HV_CURRENT_OFFSET), set(60).raw(number::HV_CURRENT_OFFSET));
}

#[test]
fn a_store_that_is_cut_off_leaves_the_set_before_or_the_new_one() {
    let before = stored().into_flash();
    let mut whole = Storage::of_maps(before.clone());
    open(&mut whole);
    let start = whole.flash().operations;
    // So many that both maps move to their other page.
    (1..=3).for_each(|variant| assert!(store(&mut whole, &set(variant), Part::Set)));
    let operations = whole.flash().operations - start;
    // Every 7th operation, each kind of tear.
    for (cut, torn) in (0..operations).step_by(7).zip([0x00, 0x5A, 0x80].into_iter().cycle()) {
        let mut storage = Storage::of_maps(Pages { left: None, ..before.clone() });
        open(&mut storage);
        (storage.flash().left, storage.flash().torn) = (Some(cut), torn);
        let done =
            (1..=3).take_while(|variant| store(&mut storage, &set(*variant), Part::Set)).count() as i32;
        let (opened, mut storage) = reopened(storage.into_flash());
        let found = opened.parameters.raw(number::SPEED_RATE) - set(0).raw(number::SPEED_RATE);
        assert!(found == done || found == done + 1, "cut at {cut}, {torn:x}: {done} stored, {found} found");
        assert_eq!(opened.parameters, with_set(found), "cut at {cut}, {torn:x}");
        assert_eq!(opened.faults, FaultWord::empty(), "cut at {cut}, {torn:x}");
        // And it goes on.
        assert!(store(&mut storage, &set(9), Part::Set), "cut at {cut}, {torn:x}");
        let (opened, _) = reopened(storage.into_flash());
        assert_eq!(opened.parameters, with_set(9), "cut at {cut}, {torn:x}");
    }
}

/// The set of `variant` beside the board's own facts of variant 0.
fn with_set(variant: i32) -> Parameters {
    let mut parameters = set(variant);
    for number in [number::HV_CURRENT_OFFSET, number::DEVICE_NUMBER] {
        parameters.set(number, set(0).raw(number)).unwrap();
    }
    parameters
}
