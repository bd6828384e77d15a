//! Tests of the ring of records on the flash: both ends, wear, cuts, flips.

use crate::support::{Chip, blank, boot, formatted, now, open, set, small};
use embedded_storage_async::nor_flash::NorFlash;
use narx_core::motor::guard::fault::FaultWord;
use narx_core::storage::{Entry, FlashReply, FlashTask, Memory, Record, Storage};
use narx_sim::flash::{KBYTE_512, MBIT_256, MBYTE_256, Tear};
use proptest::prelude::*;

fn entry(value: i32) -> Entry {
    let values = [(111, value), (0x2000, -value)];
    Entry { time: value as u32, values: values.into_iter().collect() }
}

pub(crate) fn ask(storage: &mut Storage<Chip>, request: FlashTask) -> (bool, Memory) {
    match now(storage.execute(request)) {
        FlashReply::Log { done, memory } => (done, memory),
        other => panic!("{other:?}"),
    }
}

pub(crate) fn append(storage: &mut Storage<Chip>, value: i32) -> bool {
    ask(storage, FlashTask::Append(entry(value))).0
}

fn read(storage: &mut Storage<Chip>, index: u32) -> Option<Record> {
    match now(storage.execute(FlashTask::Read(index))) {
        FlashReply::Record(record) => record,
        other => panic!("{other:?}"),
    }
}

/// Erases to the end; returns the number of steps.
pub(crate) fn erase(storage: &mut Storage<Chip>) -> usize {
    for step in 0..10_000 {
        let (done, memory) = ask(storage, FlashTask::Erase);
        assert!(done);
        if memory.erasing.is_none() {
            assert!(memory.is_erased());
            return step;
        }
    }
    panic!("an erase without end");
}

/// A drive with `count` records since an erase, whose log begins at subsector `first`.
pub(crate) fn filled(first: u32, count: i32) -> Storage<Chip> {
    let mut storage = Storage::new(small(&set(1)));
    open(&mut storage);
    for value in 0..first * 16 {
        assert!(append(&mut storage, value as i32));
    }
    if first > 0 {
        erase(&mut storage);
    }
    for value in 0..count {
        assert!(append(&mut storage, value));
    }
    storage
}

pub(crate) fn values(storage: &mut Storage<Chip>, written: u32) -> Vec<Option<i32>> {
    (0..written).map(|index| read(storage, index).map(|record| record.entry().values[0].1)).collect()
}

#[test]
fn both_ends_are_found_wherever_the_log_begins() {
    for (first, count) in [
        (0, 0),
        (0, 1),
        (0, 100),
        (3, 0),
        (3, 17),
        (120, 0),
        (120, 100),
        (121, 5),
        (60, 121 * 16),
        (0, 121 * 16),
    ] {
        let mut storage = filled(first, count);
        let (opened, chip) = boot(storage.flash());
        assert_eq!(opened.log.written, count as u32, "from {first}");
        let mut storage = Storage::new(chip);
        open(&mut storage);
        let expected: Vec<Option<i32>> = (0..count).map(Some).collect();
        assert_eq!(values(&mut storage, count as u32), expected);
        assert_eq!(append(&mut storage, 9), count < 121 * 16, "a full log is not overwritten");
    }
}

/// On a flash of 256 MByte the end is found in a few milliseconds of its time.
#[test]
fn boot_is_quick_on_the_largest_flash() {
    let mut storage = Storage::new(formatted(MBYTE_256, &set(1)));
    open(&mut storage);
    for value in 0..500 {
        assert!(append(&mut storage, value));
    }
    storage.flash().take_busy();
    let opened = open(&mut storage);
    let busy = storage.flash().take_busy();
    println!("boot: {} us", busy / 1000);
    assert_eq!((opened.log.written, opened.log.records), (500, 62_259 * 16));
    assert!(busy < 50_000_000, "{busy} ns");
}

#[test]
fn an_erase_never_leaves_the_log_and_wears_all_subsectors_alike() {
    let mut storage = filled(0, 0);
    let end = 121 * 4096;
    for round in 0..121 * 2 {
        for value in 0..16 {
            assert!(append(&mut storage, value));
        }
        let outside: Vec<u32> =
            (end..512 << 10).step_by(4096).map(|at| storage.flash().memory().wear(at)).collect();
        erase(&mut storage);
        let after: Vec<u32> =
            (end..512 << 10).step_by(4096).map(|at| storage.flash().memory().wear(at)).collect();
        // The maps may move an item to a fresh subsector; that is the purpose of their subsectors.
        assert!(after.iter().zip(&outside).all(|(after, before)| after - before <= 1), "round {round}");
    }
    let worn: Vec<u32> = (0..end).step_by(4096).map(|at| storage.flash().memory().wear(at)).collect();
    assert!(worn.iter().all(|erases| *erases == 2), "{worn:?}");
    assert_eq!(boot(storage.flash()).0.parameters, set(1));
}

#[test]
fn a_fresh_flash_is_usable_at_once_and_an_unknown_one_after_an_erase() {
    let (opened, _) = boot(&small(&set(1)));
    assert!(opened.log.is_erased() && !opened.log.is_full());
    // Unknown content in the place of the log.
    let mut chip = blank(KBYTE_512);
    now(chip.write(8192, &[1; 512])).unwrap();
    let mut storage = Storage::new(chip);
    open(&mut storage);
    assert!(crate::support::store(&mut storage, &set(1), narx_core::storage::Part::Set));
    let mut storage = Storage::new(boot(storage.flash()).1);
    let opened = open(&mut storage);
    assert!(opened.log.lost && opened.log.is_full() && !append(&mut storage, 1));
    erase(&mut storage);
    // Only subsectors that were not blank were erased.
    assert_eq!(storage.flash().memory().wear(8192), 1);
    assert_eq!(storage.flash().memory().wear(0x4_0000), 0);
    assert!(append(&mut storage, 1));
}

/// A cut at any byte of a record's program, on every kind of page, loses at most that record: the earlier
/// ones are there, and the log goes on behind it.
#[test]
fn every_cut_of_a_record_loses_at_most_that_record() {
    let mut cuts = 0;
    for (first, count) in [(0, 0), (0, 5), (2, 15), (2, 16), (119, 32)] {
        let mut filled = filled(first, count);
        let chip = filled.flash().clone();
        for tear in [Tear::Nothing, Tear::Partial, Tear::Garbage] {
            for cut in 0.. {
                let mut storage = Storage::new(chip.clone());
                open(&mut storage);
                storage.flash().cut_after(cut, tear);
                let done = append(&mut storage, 999);
                if !storage.flash().is_off() {
                    assert!(done);
                    break;
                }
                assert!(!done);
                let (opened, after) = boot(storage.flash());
                let what = format!("from {first}, {count} records, byte {cut}, {tear:?}");
                assert_eq!((opened.faults, &opened.parameters), (FaultWord::empty(), &set(1)));
                let written = opened.log.written;
                assert!((count as u32..=count as u32 + 1).contains(&written), "{what}: {written}");
                let mut storage = Storage::new(after);
                open(&mut storage);
                assert!(append(&mut storage, 1000), "{what}");
                let written = boot(storage.flash()).0.log.written;
                let found = values(&mut storage, written);
                let (before, rest) = found.split_at(count as usize);
                assert!(
                    before.iter().enumerate().all(|(index, value)| *value == Some(index as i32)),
                    "{what}"
                );
                assert!(
                    rest == [Some(1000)] || rest == [None, Some(1000)] || rest == [Some(999), Some(1000)],
                    "{what}: {rest:?}"
                );
                cuts += 1;
            }
        }
    }
    println!("{cuts} cuts");
    assert!(cuts >= 5 * 3 * 30);
}

/// After a cut of an erase at any step the erase goes on after the boot, and ends; the parameters are there.
#[test]
fn every_cut_of_an_erase_is_finished_after_the_boot() {
    let mut full = filled(100, 30 * 16 + 5);
    let chip = full.flash().clone();
    let mut cuts = 0;
    for tear in [Tear::Nothing, Tear::Partial, Tear::Garbage] {
        for cut in 0.. {
            let mut storage = Storage::new(chip.clone());
            open(&mut storage);
            storage.flash().cut_after(cut, tear);
            while !storage.flash().is_off() {
                let (done, memory) = ask(&mut storage, FlashTask::Erase);
                if done && memory.erasing.is_none() {
                    break;
                }
            }
            if !storage.flash().is_off() {
                break;
            }
            let (opened, after) = boot(storage.flash());
            let what = format!("step {cut}, {tear:?}");
            assert_eq!((opened.faults, &opened.parameters), (FaultWord::empty(), &set(1)), "{what}");
            assert!(!opened.log.lost, "{what}");
            let mut storage = Storage::new(after);
            let opened = open(&mut storage);
            if opened.log.erasing.is_some() {
                erase(&mut storage);
            } else {
                let written = opened.log.written;
                assert!(written == 0 || written == 30 * 16 + 5, "{what}: {written}");
                let whole = values(&mut storage, written).into_iter().eq((0..written as i32).map(Some));
                assert!(whole, "{what}: an erase has begun, and nobody knows");
            }
            cuts += 1;
        }
    }
    println!("{cuts} cuts");
    assert!(cuts > 200, "{cuts}");
}

#[test]
fn every_flipped_bit_of_a_record_is_detected() {
    let mut storage = filled(0, 3);
    let length = read(&mut storage, 1).unwrap().bytes().len() as u32;
    let chip = storage.flash().clone();
    for at in 256..256 + length {
        for bit in 0..8 {
            let mut flipped = chip.clone();
            flipped.flip(at, bit);
            let mut storage = Storage::new(flipped);
            assert_eq!(open(&mut storage).log.written, 3, "{at}.{bit}");
            assert_eq!(values(&mut storage, 3), [Some(0), None, Some(2)], "{at}.{bit}");
        }
    }
}

/// A fallen bit anywhere in the blank part is neither the end of the log nor a record, and is written around.
#[test]
fn fallen_bits_in_the_blank_part_hide_nothing() {
    let mut storage = filled(0, 40);
    let chip = storage.flash().clone();
    for at in (40 * 256..121 * 4096).step_by(256) {
        let mut flipped = chip.clone();
        flipped.flip(at, 5);
        let mut storage = Storage::new(flipped);
        let written = open(&mut storage).log.written;
        assert!(written == 40 || (written == 41 && at < 41 * 256), "{at}: {written}");
        for value in 40..60 {
            assert!(append(&mut storage, value));
        }
        let written = open(&mut storage).log.written;
        let found: Vec<i32> = values(&mut storage, written).into_iter().flatten().collect();
        assert_eq!(found, (0..60).collect::<Vec<i32>>(), "{at}");
    }
}

#[test]
fn cuts_on_the_real_sizes() {
    for identification in [MBIT_256, MBYTE_256] {
        let mut storage = Storage::new(formatted(identification, &set(1)));
        open(&mut storage);
        for value in 0..3 {
            assert!(append(&mut storage, value));
        }
        let chip = storage.flash().clone();
        for cut in 0..30 {
            let mut storage = Storage::new(chip.clone());
            open(&mut storage);
            storage.flash().cut_after(cut, Tear::Garbage);
            append(&mut storage, 3);
            let mut storage = Storage::new(boot(storage.flash()).1);
            let written = open(&mut storage).log.written;
            assert_eq!(values(&mut storage, written)[..3], [Some(0), Some(1), Some(2)]);
        }
    }
}

#[derive(Clone, Debug)]
enum Operation {
    Append(u8),
    Erase,
    Boot,
    Cut { steps: u64, tear: u8, boot_steps: u64 },
}

fn operation() -> impl Strategy<Value = Operation> {
    prop_oneof![
        8 => (1..60_u8).prop_map(Operation::Append),
        1 => Just(Operation::Erase),
        2 => Just(Operation::Boot),
        3 => (0..3000_u64, 0..3_u8, 0..600_u64)
            .prop_map(|(steps, tear, boot_steps)| Operation::Cut { steps, tear, boot_steps }),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Any life of a log agrees with a list: no record that was completely written is lost, changed or moved.
    #[test]
    fn a_log_is_a_list(operations in prop::collection::vec(operation(), 1..25)) {
        let mut storage = filled(117, 0);
        let mut list: Vec<i32> = Vec::new();
        let mut next = 0;
        let tears = [Tear::Nothing, Tear::Partial, Tear::Garbage];
        for operation in operations {
            match operation {
                Operation::Append(count) => for _ in 0..count {
                    if append(&mut storage, next) {
                        list.push(next);
                    }
                    next += 1;
                },
                Operation::Erase => {
                    erase(&mut storage);
                    list.clear();
                }
                Operation::Boot => storage = Storage::new(boot(storage.flash()).1),
                Operation::Cut { steps, tear, boot_steps } => {
                    storage.flash().cut_after(steps, tears[usize::from(tear)]);
                    while append(&mut storage, next) {
                        list.push(next);
                        next += 1;
                    }
                    // Under way: there or not.
                    next += 1;
                    storage.flash().restore_power();
                    storage.flash().cut_after(boot_steps, tears[usize::from(tear)]);
                    open(&mut storage);
                    storage = Storage::new(boot(storage.flash()).1);
                }
            }
            let written = open(&mut storage).log.written;
            let found: Vec<i32> = values(&mut storage, written).into_iter().flatten().collect();
            let whole: Vec<i32> = found.iter().copied().filter(|value| list.contains(value)).collect();
            prop_assert_eq!(&whole, &list);
            prop_assert!(found.len() <= list.len() + 1);
            list = found;
            prop_assert_eq!(open(&mut storage).parameters, set(1));
        }
    }
}
