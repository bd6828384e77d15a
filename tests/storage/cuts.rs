//! Tests of power cuts at every byte of every operation, and again while the drive recovers.

use crate::support::{Chip, boot, formatted, open, set, small, store};
use narx_core::dictionary::Parameters;
use narx_core::motor::guard::fault::FaultWord;
use narx_core::storage::{Part, Storage};
use narx_sim::flash::{MBIT_256, MBYTE_256, Tear};

const TEARS: [Tear; 3] = [Tear::Nothing, Tear::Partial, Tear::Garbage];

/// Stores `new` with a cut in step `cut`; returns whether the store was done, and the flash as the cut left
/// it.
fn cut_store(chip: &Chip, new: &Parameters, part: Part, cut: u64, tear: Tear) -> (bool, Chip) {
    let mut storage = Storage::new(chip.clone());
    open(&mut storage);
    storage.flash().cut_after(cut, tear);
    let done = store(&mut storage, new, part);
    (done, storage.into_flash())
}

/// Number of steps of a store; each is a place for a cut.
fn steps(chip: &Chip, new: &Parameters, part: Part) -> u64 {
    let mut storage = Storage::new(chip.clone());
    open(&mut storage);
    let before = storage.flash().steps();
    assert!(store(&mut storage, new, part));
    storage.flash().steps() - before
}

/// Boots twice; checks that the set is one of the two, that the store is healthy, and that the second boot
/// has nothing to repair.
fn assert_recovers(chip: &Chip, old: &Parameters, new: &Parameters, what: &str) -> Chip {
    let (opened, after) = boot(chip);
    assert_eq!(opened.faults, FaultWord::empty(), "{what}");
    assert!(
        opened.parameters == *old || opened.parameters == *new,
        "{what}: neither the old nor the new set"
    );
    let (again, after) = boot(&after);
    assert_eq!((again.repaired, &again.parameters), (false, &opened.parameters), "{what}");
    after
}

/// Makes all cuts of one store in steps of `stride`; returns their number.
fn cut_everywhere(chip: &Chip, old: &Parameters, new: &Parameters, part: Part, stride: usize) -> usize {
    let mut cuts = 0;
    for tear in TEARS {
        for cut in (0..steps(chip, new, part)).step_by(stride) {
            let what = format!("step {cut}, {tear:?}");
            let (done, torn) = cut_store(chip, new, part, cut, tear);
            assert!(!done && torn.is_off(), "{what}");
            let after = assert_recovers(&torn, old, new, &what);
            // The store still works afterwards.
            if cut % 97 == 0 {
                let mut storage = Storage::new(after);
                open(&mut storage);
                assert!(store(&mut storage, new, part), "{what}");
                assert_eq!(boot(storage.flash()).0.parameters, *new, "{what}");
            }
            cuts += 1;
        }
    }
    cuts
}

/// A drive that has stored `count` sets since its maps were made; the last is `set(count)`.
fn worn(count: i32) -> Chip {
    let mut storage = Storage::new(small(&set(0)));
    open(&mut storage);
    for variant in 1..=count {
        assert!(store(&mut storage, &set(variant), Part::Set));
        assert!(store(&mut storage, &set(variant), Part::Once));
    }
    storage.into_flash()
}

/// A cut of a store leaves the old set or the new one. With two subsectors per map and about four sets in
/// each, nine stores include every kind of operation.
#[test]
fn every_cut_of_a_store_leaves_the_old_set_or_the_new_one() {
    let mut cuts = 0;
    for count in 0..9 {
        let chip = worn(count);
        let mut new = set(500);
        // The other part is unchanged: a set is old or new as a whole.
        for (row, raw) in set(count).iter().filter(|(row, _)| Part::Once.contains(row)) {
            new.set(row.number, raw).unwrap();
        }
        let stride = if count == 0 || steps(&chip, &new, Part::Set) > 2000 { 1 } else { 3 };
        cuts += cut_everywhere(&chip, &set(count), &new, Part::Set, stride);
    }
    println!("{cuts} cuts");
    assert!(cuts > 15_000, "{cuts}");
}

#[test]
fn every_cut_of_storing_once() {
    let chip = worn(2);
    let mut new = set(2);
    for (row, raw) in set(600).iter().filter(|(row, _)| Part::Once.contains(row)) {
        new.set(row.number, raw).unwrap();
    }
    cut_everywhere(&chip, &set(2), &new, Part::Once, 1);
}

/// A recovery that is cut at any step recovers the next time.
#[test]
fn every_cut_of_a_recovery() {
    let mut cuts = 0;
    for count in [1, 3, 4] {
        let (chip, old) = (worn(count), set(count));
        let mut new = set(500);
        for (row, raw) in old.iter().filter(|(row, _)| Part::Once.contains(row)) {
            new.set(row.number, raw).unwrap();
        }
        let all = steps(&chip, &new, Part::Set);
        for (turn, cut) in (0..all).step_by(97).enumerate() {
            let tear = TEARS[turn % 3];
            let (_, torn) = cut_store(&chip, &new, Part::Set, cut, tear);
            let before = torn.steps();
            let recovery = boot(&torn).1.steps() - before;
            for second in (0..recovery).step_by(5) {
                let what = format!("step {cut}, {tear:?}, then step {second} of {recovery}");
                let mut storage = Storage::new(torn.clone());
                storage.flash().restore_power();
                storage.flash().cut_after(second, TEARS[second as usize % 3]);
                open(&mut storage);
                assert!(storage.flash().is_off(), "{what}");
                assert_recovers(storage.flash(), &old, &new, &what);
                cuts += 1;
            }
        }
    }
    println!("{cuts} cuts of recoveries");
    assert!(cuts > 3_000, "{cuts}");
}

/// If the first store, which makes the layout, is cut, the flash is blank as before (fault 26), or it has the
/// layout and the stored set.
#[test]
fn every_cut_of_the_first_store() {
    let blank = crate::support::blank(narx_sim::flash::KBYTE_512);
    let new = set(7);
    for tear in TEARS {
        for cut in (0..steps(&blank, &new, Part::Set)).step_by(3) {
            let (_, torn) = cut_store(&blank, &new, Part::Set, cut, tear);
            let (opened, after) = boot(&torn);
            let whole = opened.faults.is_empty() && opened.parameters == new;
            assert!(
                whole || opened.faults == FaultWord::STORE_MISMATCH,
                "step {cut}, {tear:?}: {:?}",
                opened.faults
            );
            let mut storage = Storage::new(after);
            open(&mut storage);
            assert!(store(&mut storage, &new, Part::Set), "step {cut}, {tear:?}");
            assert_eq!(boot(storage.flash()).0.parameters, new);
        }
    }
}

#[test]
fn cuts_on_the_real_sizes() {
    for identification in [MBIT_256, MBYTE_256] {
        let mut old = set(1);
        let mut storage = Storage::new(formatted(identification, &old));
        open(&mut storage);
        // Beyond the first subsector.
        for variant in 2..8 {
            old = set(variant);
            assert!(store(&mut storage, &old, Part::Set) && store(&mut storage, &old, Part::Once));
        }
        let mut new = old.clone();
        new.set(narx_core::dictionary::number::SPEED_RATE, 77).unwrap();
        cut_everywhere(storage.flash(), &old, &new, Part::Set, 41);
    }
}
