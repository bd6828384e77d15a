//! Tests of bits and words that flip in the flash that the code runs from, at rest and while the drive runs.

use crate::code_flash::{Chip, PAGE, PAGES, boot, bytes, open, store, until_full, with, worn};
use crate::support::set;
use narx_core::dictionary::Parameters;
use narx_core::motor::guard::fault::FaultWord;
use narx_core::storage::{CodeFlash, Part};
use narx_sim::flash::{Memory as _, Sparse};
use narx_sim::internal_flash::{InternalFlash, WORD};

fn flip(chip: &mut Chip, at: u32, bit: u32) {
    let mut byte = [0];
    chip.memory().read(at, &mut byte);
    chip.load(at, &[byte[0] ^ 1 << bit]);
}

/// A flipped bit of any page, also a blank one, is detected; the set is right, no older one comes back, and
/// the page is made anew.
#[test]
fn a_flipped_bit_is_detected_and_mended() {
    // The older pages hold older sets.
    let stores = 3 * until_full() + 1;
    let chip = worn(stores);
    let (mut seen, mut flips) = (0, 0);
    for at in (0..PAGES * PAGE).step_by(3) {
        // One bit of most bytes, and all bits of some.
        for bit in if at % 97 == 0 { 0..8 } else { at % 8..at % 8 + 1 } {
            let mut flipped = chip.clone();
            flip(&mut flipped, at, bit);
            let (opened, storage) = boot(&flipped);
            assert_eq!(
                (opened.faults, opened.parameters),
                (FaultWord::empty(), with(stores, 0)),
                "{at:x}.{bit}"
            );
            if opened.repaired && at % 97 == 0 {
                let (again, _) = boot(&storage.into_flash());
                assert_eq!((again.repaired, again.parameters), (false, with(stores, 0)), "{at:x}.{bit}");
            }
            seen += u32::from(opened.repaired);
            flips += 1;
        }
    }
    // Half of the pages are not in use.
    assert!(seen.abs_diff(flips / 2) < 8, "{seen} of {flips} flips were seen");
}

/// A wrong bit in either twin makes the page be written anew from the other one.
#[test]
fn a_damaged_twin_is_made_anew() {
    for at in [20, PAGE + 20] {
        let mut chip = worn(1);
        flip(&mut chip, at, 3);
        let (opened, storage) = boot(&chip);
        assert!(opened.repaired && opened.parameters == with(1, 0), "{at}");
        assert!(!boot(&storage.into_flash()).0.repaired, "{at}");
    }
}

/// If a bit of a written word flips while the drive runs, the next store does not use that page as a twin.
#[test]
fn a_store_makes_a_twin_that_is_whole() {
    for page in 0..2 {
        let mut storage = CodeFlash::new(worn(1));
        open(&mut storage);
        flip(storage.flash(), page * PAGE + 20, 3);
        assert!(store(&mut storage, &set(2), Part::Set), "{page}");
        let chip = storage.into_flash();
        let whole = (0..PAGES).filter(|page| boot_of_one(&chip, *page) == with(2, 0)).count();
        assert_eq!(whole, 2, "{page}");
    }
}

/// A word that is blank again, which no power cut causes, makes the whole page invalid.
#[test]
fn a_word_that_is_gone_is_a_set_that_is_lost() {
    let mut chip = worn(1);
    for page in [0, PAGE] {
        chip.load(page + 5 * WORD as u32, &[0xFF; WORD]);
    }
    let (opened, _) = boot(&chip);
    assert_eq!((opened.faults, opened.parameters), (FaultWord::STORE_MISMATCH, Parameters::new()));
}

/// If a bit falls in the blank part while the drive runs, in either twin or in both, the next store goes
/// around it.
#[test]
fn a_store_goes_around_fallen_bits() {
    let chip = worn(1);
    let blank = |at: u32| bytes(&chip)[at as usize..][..WORD].iter().all(|byte| *byte == 0xFF);
    let end = (0..PAGE).step_by(WORD).find(|at| blank(*at)).unwrap();
    for at in (end..end + 64).step_by(5).chain([PAGE - 1]) {
        for struck in [&[0][..], &[PAGE], &[0, PAGE], &[0, PAGE, 2 * PAGE]] {
            let mut storage = boot(&chip).1;
            struck.iter().for_each(|page| flip(storage.flash(), page + at, 5));
            for variant in [2, 3] {
                assert!(store(&mut storage, &set(variant), Part::Set), "{at:x} of {struck:x?}");
                let (opened, _) = boot(storage.flash());
                let found = (opened.faults, opened.repaired, opened.parameters);
                assert_eq!(found, (FaultWord::empty(), false, with(variant, 0)), "{at:x} of {struck:x?}");
            }
        }
    }
}

/// If both twins are damaged, no older set comes back, and the drive reports a fault.
#[test]
fn a_set_that_is_lost_is_a_fault_and_not_the_set_before() {
    let stores = 3 * until_full() + 1;
    let mut chip = worn(stores);
    for page in 0..PAGES {
        let mut first = [0; 16];
        chip.memory().read(page * PAGE, &mut first);
        if boot_of_one(&chip, page) == with(stores, 0) {
            flip(&mut chip, page * PAGE + 8, 3);
        }
    }
    let (opened, mut storage) = boot(&chip);
    assert_eq!((opened.faults, opened.parameters), (FaultWord::STORE_MISMATCH, Parameters::new()));
    assert!(store(&mut storage, &set(5), Part::Set));
    let (opened, _) = boot(storage.flash());
    assert_eq!((opened.faults, opened.repaired, opened.parameters), (FaultWord::empty(), false, set(5)));
}

/// Parameters that would be found if `page` were the only page.
fn boot_of_one(chip: &Chip, page: u32) -> Parameters {
    let mut alone: Chip = InternalFlash::new(Sparse::new(), PAGES * PAGE, 1);
    let from = (page * PAGE) as usize;
    alone.load(0, &bytes(chip)[from..from + PAGE as usize]);
    boot(&alone).0.parameters
}
