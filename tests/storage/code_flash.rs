//! Tests of parameters in four pages of the flash that the code runs from: words of 8 bytes are programmed
//! once, and the power may fail in each of them.

use crate::support::set;
use narx_core::dictionary::{Parameters, number};
use narx_core::motor::guard::fault::FaultWord;
use narx_core::storage::{CodeFlash, FlashReply, FlashTask, Memory, Opened, Part};
use narx_sim::flash::{Memory as _, Sparse, Tear};
use narx_sim::internal_flash::{InternalFlash, WORD};
use proptest::prelude::*;

pub(crate) const PAGE: u32 = 2 << 10;
pub(crate) const PAGES: u32 = 4;
const TEARS: [Tear; 3] = [Tear::Nothing, Tear::Partial, Tear::Garbage];

pub(crate) type Chip = InternalFlash<Sparse>;

fn blank() -> CodeFlash<Chip> {
    CodeFlash::new(InternalFlash::new(Sparse::new(), PAGES * PAGE, 1))
}

/// Executes a request to its end, in no more steps than there are places to try.
fn execute(storage: &mut CodeFlash<Chip>, request: FlashTask) -> FlashReply {
    storage.begin(request);
    (0..3 * PAGES).find_map(|_| storage.step()).expect("a request ends")
}

pub(crate) fn open(storage: &mut CodeFlash<Chip>) -> Opened {
    match execute(storage, FlashTask::Open) {
        FlashReply::Opened(opened) => opened,
        other => panic!("{other:?}"),
    }
}

pub(crate) fn store(storage: &mut CodeFlash<Chip>, parameters: &Parameters, part: Part) -> bool {
    match execute(storage, FlashTask::Store(parameters.clone(), part)) {
        FlashReply::Stored { done, .. } => done,
        other => panic!("{other:?}"),
    }
}

/// State that a drive finds at power-up.
pub(crate) fn boot(chip: &Chip) -> (Opened, CodeFlash<Chip>) {
    let mut chip = chip.clone();
    chip.restore_power();
    let mut storage = CodeFlash::new(chip);
    (open(&mut storage), storage)
}

/// A flash on which both parts of `set(0)` are stored, then `stores` sets of one parameter and a few more.
pub(crate) fn worn(stores: i32) -> Chip {
    let mut storage = blank();
    open(&mut storage);
    for variant in 0..=stores {
        assert!(store(&mut storage, &set(variant), Part::Set));
    }
    storage.into_flash()
}

/// The set of `variant`, with the board's own facts of `once`.
pub(crate) fn with(variant: i32, once: i32) -> Parameters {
    let mut parameters = set(variant);
    for (row, raw) in set(once).iter().filter(|(row, _)| Part::Once.contains(row)) {
        parameters.set(row.number, raw).unwrap();
    }
    parameters
}

pub(crate) fn bytes(chip: &Chip) -> Vec<u8> {
    let mut bytes = vec![0; (PAGES * PAGE) as usize];
    chip.memory().read(0, &mut bytes);
    bytes
}

/// Number of stores of [`worn`] that fill the first page: with the next one both twins move.
pub(crate) fn until_full() -> i32 {
    let mut storage = CodeFlash::new(worn(0));
    open(&mut storage);
    let pages = |chip: &Chip| {
        bytes(chip).chunks(PAGE as usize).filter(|page| page.iter().any(|byte| *byte != 0xFF)).count()
    };
    let moves = |variant: &i32| store(&mut storage, &set(*variant), Part::Set) && pages(storage.flash()) > 2;
    (1..1000).find(moves).unwrap() - 1
}

#[test]
fn each_part_comes_back_as_it_was_stored() {
    let mut storage = blank();
    let opened = open(&mut storage);
    assert_eq!((opened.faults, opened.repaired), (FaultWord::STORE_MISMATCH, false), "nobody has stored yet");
    assert_eq!(opened.parameters, Parameters::new());
    assert!(store(&mut storage, &set(0), Part::Set));
    let (opened, mut storage) = boot(storage.flash());
    assert_eq!((opened.faults, opened.repaired), (FaultWord::empty(), false));
    assert_eq!(opened.parameters, set(0), "the first store writes both parts");
    for (variant, part, expected) in [
        (1, Part::Set, with(1, 0)),
        (2, Part::Once, with(1, 2)),
        (3, Part::Set, with(3, 2)),
        (0, Part::Set, with(0, 2)),
    ] {
        assert!(store(&mut storage, &set(variant), part));
        assert_eq!(boot(storage.flash()).0.parameters, expected, "{variant} {part:?}");
    }
}

#[test]
fn the_drives_own_values_and_commands_are_not_stored() {
    let mut parameters = set(1);
    for (number, raw) in [(number::BUILD_NUMBER, 7), (number::STORE, 1), (number::REFUSED_FRAMES, 9)] {
        parameters.set(number, raw).unwrap();
    }
    let mut storage = blank();
    open(&mut storage);
    assert!(store(&mut storage, &parameters, Part::Set));
    assert_eq!(boot(storage.flash()).0.parameters, set(1));
}

#[test]
fn there_is_no_log() {
    let mut storage = CodeFlash::new(worn(0));
    open(&mut storage);
    let before = bytes(storage.flash());
    let refused = FlashReply::Log { done: false, memory: Memory::default() };
    assert_eq!(execute(&mut storage, FlashTask::Erase), refused);
    assert_eq!(execute(&mut storage, FlashTask::Append(narx_core::storage::Entry::default())), refused);
    assert_eq!(execute(&mut storage, FlashTask::Read(0)), FlashReply::Record(None));
    assert_eq!(bytes(storage.flash()), before);
}

#[test]
fn a_store_writes_what_has_changed_and_an_erase_is_for_a_full_page() {
    let mut storage = CodeFlash::new(worn(0));
    open(&mut storage);
    let steps = |storage: &mut CodeFlash<Chip>, parameters: &Parameters| {
        let before = (storage.flash().steps(), storage.flash().take_busy());
        assert!(store(storage, parameters, Part::Set));
        (storage.flash().steps() - before.0, storage.flash().take_busy())
    };
    assert_eq!(steps(&mut storage, &set(0)).0, 0, "nothing has changed");
    let mut one = set(0);
    one.set(number::SPEED_RATE, 77).unwrap();
    let (words, nanoseconds) = steps(&mut storage, &one);
    assert_eq!(words, 2 * 2, "a record and a commit, twice");
    assert!(nanoseconds < 1_000_000, "{nanoseconds} ns");
    // Each page holds the set and some stores; then everything moves, and every page is used in turn.
    let before = storage.flash().memory().wear_max();
    for value in 100..1100 {
        one.set(number::SPEED_RATE, value).unwrap();
        assert!(store(&mut storage, &one, Part::Set));
    }
    let worst = storage.flash().memory().wear_max() - before;
    assert!((4..=12).contains(&worst), "{worst} erases of one page for 1000 stores");
    assert_eq!(boot(storage.flash()).0.parameters, one);
}

#[test]
fn a_flash_that_holds_something_else_is_untouched_until_somebody_stores() {
    let mut chip = InternalFlash::new(Sparse::new(), PAGES * PAGE, 1);
    (0..PAGES).for_each(|page| chip.load(page * PAGE + 8 * page, &[0x5A; 1000]));
    let (opened, mut storage) = boot(&chip);
    assert_eq!((opened.faults, opened.parameters), (FaultWord::STORE_MISMATCH, Parameters::new()));
    assert_eq!(bytes(storage.flash()), bytes(&chip), "looking changes nothing");
    assert!(store(&mut storage, &set(3), Part::Set));
    let (opened, _) = boot(storage.flash());
    assert_eq!((opened.faults, opened.parameters), (FaultWord::empty(), set(3)));
}

#[test]
fn a_flash_of_the_wrong_size_is_absent() {
    for (capacity, faults) in [(2 * PAGE, FaultWord::STORE_ABSENT), (3 * PAGE, FaultWord::STORE_MISMATCH)] {
        let chip: Chip = InternalFlash::new(Sparse::new(), capacity, 1);
        let (opened, mut storage) = boot(&chip);
        assert_eq!(opened.faults, faults, "{capacity} bytes");
        let fits = faults == FaultWord::STORE_MISMATCH;
        assert_eq!(store(&mut storage, &set(1), Part::Set), fits, "{capacity} bytes");
    }
    // A page of 512 bytes has no room for a set, one of 1024 has.
    assert_eq!(on_pages_of::<512>(), FaultWord::STORE_ABSENT);
    assert_eq!(on_pages_of::<1024>(), FaultWord::STORE_MISMATCH);
}

/// Faults of a first power-up on a blank flash with pages of this size.
fn on_pages_of<const BYTES: usize>() -> FaultWord {
    let mut storage = CodeFlash::new(InternalFlash::<Sparse, BYTES>::new(Sparse::new(), 4096, 1));
    storage.begin(FlashTask::Open);
    let Some(FlashReply::Opened(opened)) = (0..3).find_map(|_| storage.step()) else { panic!() };
    opened.faults
}

#[test]
fn a_flash_that_fails_while_storing_says_so_and_keeps_what_it_had() {
    let mut storage = CodeFlash::new(worn(1));
    open(&mut storage);
    storage.flash().cut_after(0, Tear::Nothing);
    assert!(!store(&mut storage, &set(2), Part::Set));
    assert_eq!(boot(storage.flash()).0.parameters, with(1, 0));
}

/// A word as it is on the flash: number, value, CRC-16 of both, big endian.
fn word(number: u16, value: i32) -> [u8; WORD] {
    let mut word = [0; WORD];
    word[..2].copy_from_slice(&number.to_be_bytes());
    word[2..6].copy_from_slice(&value.to_be_bytes());
    let check = crc::Crc::<u16>::new(&crc::CRC_16_IBM_3740).checksum(&word[..6]);
    word[6..].copy_from_slice(&check.to_be_bytes());
    word
}

/// A page of other firmware: form 1 or another, records, and the commit of store 1.
fn page_of(form: i32, records: &[(u16, i32)]) -> Vec<u8> {
    let head = [(0xFFFD, form << 16 | 1)];
    let words = head.iter().chain(records).chain(&[(0xFFFE, 1)]);
    words.flat_map(|(number, value)| word(*number, *value)).collect()
}

/// Content of a page (name, form, records), and the result: faults, and the rate.
type Left<'a> = (&'a str, i32, &'a [(u16, i32)], FaultWord, i32);

#[test]
fn an_older_drive_or_a_newer_one_finds_what_it_knows() {
    let (rate, factory) = (number::SPEED_RATE, Parameters::new().raw(number::SPEED_RATE));
    let cases: [Left<'_>; 6] = [
        ("a number that nobody knows yet", 1, &[(rate, 1001), (0x3FF, 9)], FaultWord::empty(), 1001),
        ("a number less", 1, &[(number::LOG_PERIOD, 20)], FaultWord::empty(), factory),
        ("a value out of range", 1, &[(rate, -5)], FaultWord::STORE_VERSION, factory),
        ("one that was put right later", 1, &[(rate, -5), (rate, 70)], FaultWord::empty(), 70),
        ("a board's fact out of range", 1, &[(number::DEVICE_NUMBER, -1)], FaultWord::STORE_VERSION, factory),
        ("a form to come", 2, &[(rate, 1001)], FaultWord::STORE_VERSION, factory),
    ];
    for (what, form, records, faults, raw) in cases {
        let mut chip: Chip = InternalFlash::new(Sparse::new(), PAGES * PAGE, 1);
        (0..2).for_each(|page| chip.load(page * PAGE, &page_of(form, records)));
        let (opened, mut storage) = boot(&chip);
        assert_eq!((opened.faults, opened.parameters.value(rate).unwrap()), (faults, raw), "{what}");
        assert!(!opened.repaired && bytes(storage.flash()) == bytes(&chip), "{what}");
        // Storing the drive's present set cures the fault.
        assert!(store(&mut storage, &opened.parameters, Part::Set), "{what}");
        let (again, _) = boot(storage.flash());
        assert_eq!((again.faults, again.parameters), (FaultWord::empty(), opened.parameters), "{what}");
    }
}

/// Cuts a store at every step, with every kind of tear: the set before or the new one is found, and the next
/// store and boot work as if nothing had happened. The boot after some cuts is cut, too.
fn cut_everywhere(chip: &Chip, old: &Parameters, new: &Parameters) -> u64 {
    let mut whole = boot(chip).1;
    let before = whole.flash().steps();
    assert!(store(&mut whole, new, Part::Set));
    let steps = whole.flash().steps() - before;
    for (cut, tear) in (0..steps).flat_map(|cut| TEARS.map(|tear| (cut, tear))) {
        let what = format!("step {cut} of {steps}, {tear:?}");
        let mut storage = boot(chip).1;
        storage.flash().cut_after(cut, tear);
        assert!(!store(&mut storage, new, Part::Set), "{what}");
        let torn = storage.into_flash();
        assert_recovers(&torn, old, new, &what);
        if cut % 31 > 1 {
            continue;
        }
        let before = torn.steps();
        let recovery = boot(&torn).1.into_flash().steps() - before;
        for second in (0..recovery).step_by(1 + recovery as usize / 5) {
            let mut again = torn.clone();
            again.restore_power();
            again.cut_after(second, TEARS[second as usize % 3]);
            let mut storage = CodeFlash::new(again);
            open(&mut storage);
            assert!(storage.flash().is_off(), "{what}");
            assert_recovers(storage.flash(), old, new, &format!("{what}, then {second} of {recovery}"));
        }
    }
    steps
}

fn assert_recovers(torn: &Chip, old: &Parameters, new: &Parameters, what: &str) {
    let (opened, storage) = boot(torn);
    assert_eq!(opened.faults, FaultWord::empty(), "{what}");
    assert!(
        opened.parameters == *old || opened.parameters == *new,
        "{what}: neither the old nor the new set"
    );
    let (again, mut storage) = boot(&storage.into_flash());
    assert_eq!((again.repaired, &again.parameters), (false, &opened.parameters), "{what}");
    assert!(store(&mut storage, &set(900), Part::Set), "{what}");
    let (last, _) = boot(storage.flash());
    assert_eq!(
        (last.faults, last.repaired, last.parameters),
        (FaultWord::empty(), false, with(900, 0)),
        "{what}"
    );
}

#[test]
fn every_cut_of_a_store_leaves_the_old_set_or_the_new_one() {
    // Behind other records, and into other pages.
    let steps = [1, until_full()].map(|count| cut_everywhere(&worn(count), &with(count, 0), &with(500, 0)));
    println!("{steps:?} steps");
    assert!(steps[0] < 20 && steps[1] > 200, "{steps:?}");
}

#[test]
fn every_cut_of_storing_once() {
    let chip = worn(2);
    let mut once = with(2, 600);
    once.set(number::DEVICE_NUMBER, 7).unwrap();
    let mut whole = boot(&chip).1;
    let before = whole.flash().steps();
    assert!(store(&mut whole, &once, Part::Once));
    for cut in 0..whole.flash().steps() - before {
        let mut storage = boot(&chip).1;
        storage.flash().cut_after(cut, TEARS[cut as usize % 3]);
        assert!(!store(&mut storage, &once, Part::Once));
        let (opened, _) = boot(storage.flash());
        assert_eq!(opened.faults, FaultWord::empty(), "step {cut}");
        assert!(opened.parameters == with(2, 0) || opened.parameters == once, "step {cut}");
    }
}

/// After a cut of the first store, either nothing is stored yet, or everything is.
#[test]
fn every_cut_of_the_first_store() {
    let mut whole = blank();
    open(&mut whole);
    assert!(store(&mut whole, &set(7), Part::Set));
    for (cut, tear) in (0..whole.flash().steps()).flat_map(|cut| TEARS.map(|tear| (cut, tear))) {
        let mut storage = blank();
        open(&mut storage);
        storage.flash().cut_after(cut, tear);
        assert!(!store(&mut storage, &set(7), Part::Set));
        let (opened, mut storage) = boot(storage.flash());
        let is_there = opened.faults.is_empty() && opened.parameters == set(7);
        assert!(
            is_there || opened.faults == FaultWord::STORE_MISMATCH,
            "step {cut}, {tear:?}: {:?}",
            opened.faults
        );
        assert!(store(&mut storage, &set(7), Part::Set), "step {cut}, {tear:?}");
        assert_eq!(boot(storage.flash()).0.parameters, set(7));
    }
}

/// A step in the life of a flash.
#[derive(Clone, Debug)]
enum Step {
    Store(i32, Part),
    Cut(i32, u64),
    Boot,
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let part = prop_oneof![4 => Just(Part::Set), 1 => Just(Part::Once)];
    prop::collection::vec(
        prop_oneof![
            4 => (1..900_i32, part).prop_map(|(variant, part)| Step::Store(variant, part)),
            2 => (1..900_i32, 0..300_u64).prop_map(|(variant, cut)| Step::Cut(variant, cut)),
            1 => Just(Step::Boot),
        ],
        1..40,
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Stores, cuts and boots in any order agree with a model of two numbers: the variants in force.
    #[test]
    fn it_is_a_set_and_the_boards_facts(steps in steps()) {
        let mut storage = CodeFlash::new(worn(0));
        open(&mut storage);
        let (mut variant, mut once) = (0, 0);
        for step in steps {
            match step {
                Step::Store(new, part) => {
                    prop_assert!(store(&mut storage, &set(new), part));
                    *if part == Part::Set { &mut variant } else { &mut once } = new;
                }
                Step::Cut(new, cut) => {
                    storage.flash().cut_after(cut, TEARS[cut as usize % 3]);
                    let done = store(&mut storage, &set(new), Part::Set);
                    let (opened, after) = boot(storage.flash());
                    storage = after;
                    prop_assert!(opened.parameters == with(new, once) || !done && opened.parameters == with(variant, once));
                    if opened.parameters == with(new, once) {
                        variant = new;
                    }
                }
                Step::Boot => storage = boot(storage.flash()).1,
            }
            let (opened, _) = boot(storage.flash());
            prop_assert_eq!((opened.faults, opened.repaired), (FaultWord::empty(), false));
            prop_assert_eq!(opened.parameters, with(variant, once));
        }
    }

    /// With any content of the flash nothing panics, and a store works afterwards.
    #[test]
    fn no_content_makes_it_panic(seed: u64, density in 1..=16_u64) {
        let mut chip = worn(3);
        let mut random = narx_sim::random::Random::new(seed);
        for at in 0..PAGES * PAGE {
            let bits = random.bits();
            if bits % 64 < density {
                chip.load(at, &[(bits >> 8) as u8]);
            }
        }
        let mut storage = CodeFlash::new(chip);
        open(&mut storage);
        prop_assert!(store(&mut storage, &set(2), Part::Set));
        let (opened, _) = boot(storage.flash());
        prop_assert_eq!((opened.faults, opened.repaired), (FaultWord::empty(), false));
        prop_assert_eq!(opened.parameters.value(number::SPEED_RATE).unwrap(), set(2).raw(number::SPEED_RATE));
    }
}
