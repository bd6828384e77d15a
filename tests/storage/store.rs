//! Tests of the parameter store: the values that come back, its faults, and their cure.

use crate::support::{Chip, blank, boot, formatted, now, open, set, small, store};
use core::ops::Range;
use embedded_storage_async::nor_flash::{NorFlash, ReadNorFlash};
use narx_core::dictionary::{Dictionary, Parameters, number};
use narx_core::motor::guard::fault::FaultWord;
use narx_core::storage::layout::{Layout, capacity};
use narx_core::storage::{FlashReply, FlashTask, Part, Storage};
use narx_sim::flash::{KBYTE_512, MBIT_256, MBYTE_256};

const SUBSECTOR: u32 = 4096;

#[test]
fn the_size_is_the_devices_and_five_per_cent_are_fenced_off() {
    let cases = [
        ([0x20, 0xBA, 0x19], Some(32 << 20)),
        ([0x20, 0xBA, 0x22], Some(256 << 20)),
        ([0xEF, 0x40, 0x19], Some(32 << 20)),
        ([0xFF, 0xFF, 0xFF], None),
        ([0, 0, 0], None),
        // With a line that hangs, the last byte may look like a size.
        ([0xFF, 0xBA, 0x19], None),
        ([0, 0xBA, 0x19], None),
        ([0x20, 0xBA, 0x0F], None),
        ([0x20, 0xBA, 0x10], Some(64 << 10)),
        ([0x20, 0xBA, 0x1A], None),
        ([0x20, 0xBA, 0x20], Some(64 << 20)),
        ([0x20, 0xBA, 0x23], None),
    ];
    for (identification, bytes) in cases {
        assert_eq!(capacity(identification), bytes, "{identification:x?}");
    }
    for bytes in [32 << 20, 256 << 20, 512 << 10] {
        let layout = Layout::of(bytes, SUBSECTOR).unwrap();
        let subsectors = bytes / SUBSECTOR;
        assert_eq!(layout.log, 0..subsectors * 95 / 100 * SUBSECTOR);
        let mut end = layout.log.end;
        for range in [&layout.primary.label, &layout.primary.map, &layout.mirror.label, &layout.mirror.map] {
            assert_eq!((range.start, range.start % SUBSECTOR, range.end % SUBSECTOR), (end, 0, 0));
            end = range.end;
        }
        assert!(end <= bytes);
        assert_eq!(layout.primary.map.len(), layout.mirror.map.len());
    }
    // 256 Mbit: 7782 of 8192 subsectors.
    assert_eq!(Layout::of(32 << 20, SUBSECTOR).unwrap().log.end, 7782 * 4096);
    // The smallest has two subsectors for each map: one to write and one to move to.
    let smallest = Layout::of(101 * SUBSECTOR, SUBSECTOR).unwrap();
    assert_eq!(smallest.mirror.map, 99 * SUBSECTOR..101 * SUBSECTOR);
    assert_eq!(Layout::of(100 * SUBSECTOR, SUBSECTOR), None);
    assert_eq!(Layout::of(64 << 10, SUBSECTOR), None);
    assert_eq!(Layout::of(0, SUBSECTOR), None);
}

#[test]
fn both_parts_come_back_on_every_size() {
    for identification in [KBYTE_512, MBIT_256, MBYTE_256] {
        let chip = formatted(identification, &set(1));
        let (opened, chip) = boot(&chip);
        assert_eq!((opened.faults, opened.repaired), (FaultWord::empty(), false));
        assert_eq!(opened.parameters, set(1));
        assert!(opened.log.is_erased());
        // Each part is stored separately.
        let mut storage = Storage::new(chip);
        open(&mut storage);
        assert!(store(&mut storage, &set(2), Part::Set));
        let (opened, _) = boot(storage.flash());
        assert_eq!(opened.parameters.value(number::SPEED_RATE).unwrap(), 1002);
        assert_eq!(opened.parameters.value(number::HV_CURRENT_OFFSET).unwrap(), 1);
        assert!(store(&mut storage, &set(2), Part::Once));
        assert_eq!(boot(storage.flash()).0.parameters, set(2));
    }
}

#[test]
fn the_drives_own_values_and_commands_are_not_stored() {
    let mut parameters = set(1);
    for (number, raw) in [(number::BUILD_NUMBER, 7), (number::STORE, 1), (number::REFUSED_FRAMES, 9)] {
        parameters.set(number, raw).unwrap();
    }
    let (opened, _) = boot(&small(&parameters));
    assert_eq!(opened.parameters, set(1));
}

#[test]
fn a_flash_without_our_layout_is_fault_26_untouched_and_cured_by_storing() {
    let mut foreign = blank(KBYTE_512);
    let text = [0x5A; 3000];
    let layout = Layout::of(512 << 10, SUBSECTOR).unwrap();
    for at in [layout.primary.label.start, layout.mirror.map.start] {
        now(foreign.write(at, &text)).unwrap();
    }
    for chip in [blank(KBYTE_512), foreign] {
        let (opened, after) = boot(&chip);
        assert_eq!(opened.faults, FaultWord::STORE_MISMATCH);
        assert_eq!(opened.parameters, Parameters::new());
        assert_eq!(after.memory(), chip.memory(), "looking changes nothing");
        let mut storage = Storage::new(after);
        open(&mut storage);
        assert!(store(&mut storage, &set(3), Part::Set));
        let (opened, _) = boot(storage.flash());
        assert_eq!((opened.faults, opened.parameters), (FaultWord::empty(), set(3)));
        assert!(opened.log.lost, "nobody knows what the log's memory holds: it must be erased once");
    }
}

/// The labels have the name and version of the layout, the size of the flash, and their check value: firmware
/// that expected anything else would find nothing on the flash of a drive in the field.
#[test]
fn labels_are_those_of_the_drives_in_the_field() {
    let mut chip = small(&set(1));
    let layout = Layout::of(512 << 10, SUBSECTOR).unwrap();
    for label in [layout.primary.label, layout.mirror.label] {
        let mut bytes = [0; 16];
        now(chip.read(label.start, &mut bytes)).unwrap();
        let (text, numbers) = bytes.split_at(4);
        assert_eq!((text, numbers), (&b"narx"[..], &[0, 0, 0, 2, 0, 8, 0, 0, 0x91, 0x96, 0x8D, 0x85][..]));
    }
}

/// If neither copy of a part can be read, the drive reports it and keeps the other part, and the next store
/// of either part writes both.
#[test]
fn a_part_that_is_lost_is_fault_26() {
    let layout = Layout::of(512 << 10, SUBSECTOR).unwrap();
    let whole = small(&set(4));
    for (key, rate, device) in [(1, 2000, 100), (2, 1004, Parameters::new().raw(number::DEVICE_NUMBER))] {
        let mut chip = whole.clone();
        for map in [&layout.primary.map, &layout.mirror.map] {
            lose(&mut chip, map.clone(), key);
        }
        let (opened, after) = boot(&chip);
        assert_eq!(opened.faults, FaultWord::STORE_MISMATCH, "{key}");
        let value = |number| opened.parameters.value(number).unwrap();
        assert_eq!((value(number::SPEED_RATE), value(number::DEVICE_NUMBER)), (rate, device), "{key}");
        for part in [Part::Set, Part::Once] {
            let mut storage = Storage::new(after.clone());
            open(&mut storage);
            assert!(store(&mut storage, &set(5), part));
            let (opened, _) = boot(storage.flash());
            assert_eq!((opened.faults, opened.parameters), (FaultWord::empty(), set(5)), "{key}");
        }
    }
}

#[test]
fn no_answer_is_fault_30_and_what_was_stored_is_there_when_the_flash_is_back() {
    let mut chip = small(&set(4));
    chip.set_absent(true);
    let (opened, mut chip) = boot(&chip);
    assert_eq!((opened.faults, opened.log.records), (FaultWord::STORE_ABSENT, 0));
    let mut storage = Storage::new(chip.clone());
    open(&mut storage);
    assert!(!store(&mut storage, &set(5), Part::Set));
    chip.set_absent(false);
    let (opened, _) = boot(&chip);
    assert_eq!((opened.faults, opened.parameters), (FaultWord::empty(), set(4)));
}

#[test]
fn a_flash_that_fails_while_storing_says_so() {
    let mut storage = Storage::new(small(&set(1)));
    open(&mut storage);
    storage.flash().set_absent(true);
    assert!(!store(&mut storage, &set(2), Part::Set));
    assert_eq!(now(storage.execute(FlashTask::Read(0))), FlashReply::Record(None));
}

#[test]
fn an_older_drive_or_a_newer_one_finds_what_it_knows() {
    let mut chip = small(&set(1));
    // Taken from the flash, changed by hand, and put back with new check values.
    let layout = Layout::of(512 << 10, SUBSECTOR).unwrap();
    let cases: [(&str, Change, FaultWord, i32); 4] = [
        (
            "a number that nobody knows yet",
            &|body| body.extend([0x03, 0xFF, 0, 0, 0, 9]),
            FaultWord::empty(),
            1001,
        ),
        ("a number less", &|body| drop(body.drain(4..10)), FaultWord::empty(), 1001),
        ("a value out of range", &|body| patch(body, number::SPEED_RATE, -5), FaultWord::STORE_VERSION, 2000),
        ("a form to come", &|body| body[1] = 2, FaultWord::STORE_VERSION, 2000),
    ];
    for (what, change, faults, rate) in cases {
        let mut changed = chip.clone();
        for map in [&layout.primary.map, &layout.mirror.map] {
            rewrite(&mut changed, map.clone(), 1, change);
        }
        let (opened, after) = boot(&changed);
        assert_eq!(
            (opened.faults, opened.parameters.value(number::SPEED_RATE).unwrap()),
            (faults, rate),
            "{what}"
        );
        // Storing the drive's present set cures the fault.
        let mut storage = Storage::new(after);
        open(&mut storage);
        assert!(store(&mut storage, &opened.parameters, Part::Set));
        let (again, _) = boot(storage.flash());
        assert_eq!((again.faults, again.parameters), (FaultWord::empty(), opened.parameters), "{what}");
    }
    chip.restore_power();
}

/// Up to 8 unknown numbers of newer firmware are ignored; a set with more does not fit and counts as damaged.
#[test]
fn a_set_may_have_eight_numbers_more() {
    let stored = Dictionary::rows().filter(|row| Part::Set.contains(row) || Part::Once.contains(row)).count();
    for (more, faults, rate) in [(8, FaultWord::empty(), 1001), (9, FaultWord::STORE_MISMATCH, 2000)] {
        let mut chip = small(&set(1));
        let layout = Layout::of(512 << 10, SUBSECTOR).unwrap();
        for map in [&layout.primary.map, &layout.mirror.map] {
            rewrite(&mut chip, map.clone(), 1, &|body| {
                let numbers = (0xF000_u16..).take((4 + 6 * (stored + more) - body.len()) / 6);
                numbers.for_each(|number| body.extend([number.to_be_bytes(), [0, 0], [0, 9]].as_flattened()));
            });
        }
        let (opened, _) = boot(&chip);
        assert_eq!(
            (opened.faults, opened.parameters.value(number::SPEED_RATE).unwrap()),
            (faults, rate),
            "{more}"
        );
    }
}

/// Change of an item.
pub(crate) type Change<'a> = &'a dyn Fn(&mut Vec<u8>);

fn patch(body: &mut [u8], number: u16, raw: i32) {
    let pair = body[4..].chunks_mut(6).find(|pair| pair[..2] == number.to_be_bytes()).unwrap();
    pair[2..].copy_from_slice(&raw.to_be_bytes());
}

/// Changes the speed rate of the stored set to a value that is no longer allowed.
pub(crate) fn spoil(chip: &mut Chip) {
    let layout = Layout::of(512 << 10, SUBSECTOR).unwrap();
    for map in [&layout.primary.map, &layout.mirror.map] {
        rewrite(chip, map.clone(), 1, &|body| patch(body, number::SPEED_RATE, -5));
    }
}

/// Changes the body of the items of a key in one map, all of which are in its first page, and updates their
/// check values.
pub(crate) fn rewrite(chip: &mut Chip, map: Range<u32>, key: u8, change: Change) {
    let mut page = vec![0; 8];
    now(chip.read(map.start, &mut page)).unwrap();
    for (of, _, mut content) in items(chip, &map) {
        if of == key {
            let mut body = content.split_off(4);
            change(&mut body);
            content.extend(body);
        }
        let title = u32::from(of) << 24 | content.len() as u32;
        page.extend([title, !title].map(u32::to_be_bytes).as_flattened());
        let keyed = [&[of], content.as_slice()].concat();
        page.extend(content);
        page.extend(crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&keyed).to_be_bytes());
        page.resize(page.len().next_multiple_of(8), 0xFF);
    }
    now(chip.erase(map.start, map.start + SUBSECTOR)).unwrap();
    now(chip.write(map.start, &page)).unwrap();
}

/// Flips a bit of every item of that key in one map.
pub(crate) fn lose(chip: &mut Chip, map: Range<u32>, key: u8) {
    for (_, at, _) in items(chip, &map).into_iter().filter(|(of, ..)| *of == key) {
        chip.flip(at, 0);
    }
}

/// Items of a map's first page: key, position of the content, and the content, which is a count and a body.
/// Before it are key and length, and their complements; after it CRC-32 over key and content, and ones up to
/// a multiple of 8. The page begins with its number.
pub(crate) fn items(chip: &mut Chip, map: &Range<u32>) -> Vec<(u8, u32, Vec<u8>)> {
    let mut page = vec![0; SUBSECTOR as usize];
    now(chip.read(map.start, &mut page)).unwrap();
    let (mut at, mut items) = (8, Vec::new());
    while let [key, a, b, c, _, _, _, _, rest @ ..] = &page[at..]
        && *key != 0xFF
    {
        let length = u32::from_be_bytes([0, *a, *b, *c]) as usize;
        items.push((*key, map.start + at as u32 + 8, rest[..length].to_vec()));
        at += 8 + (length + 4).next_multiple_of(8);
    }
    items
}

#[test]
fn wear_is_even_and_bounded() {
    let mut storage = Storage::new(formatted(MBIT_256, &set(0)));
    open(&mut storage);
    let before = storage.flash().counts().erases;
    const STORES: u32 = 3000;
    for variant in 0..STORES {
        assert!(store(&mut storage, &set(variant as i32), Part::Set));
    }
    // Two maps of 64 subsectors; at least four sets fill one.
    let worst = storage.flash().memory().wear_max();
    let erases = storage.flash().counts().erases - before;
    assert!(erases <= u64::from(STORES) * 2 / 4, "{erases} erases");
    assert!(worst <= STORES.div_ceil(4 * 64) + 1, "{worst} erases of one subsector");
    assert_eq!(boot(storage.flash()).0.parameters.value(number::SPEED_RATE).unwrap(), 999 + STORES as i32);
}

/// On a flash of two MByte the mirror ends where the flash ends. A damaged page there is searched to its last
/// byte, and no further.
#[test]
fn the_last_page_of_the_flash_is_searched_to_its_end() {
    const MBYTE_2: [u8; 3] = [0x20, 0xBA, 0x15];
    let layout = Layout::of(2 << 20, SUBSECTOR).unwrap();
    assert_eq!(layout.mirror.map.end, 2 << 20);
    let mut storage = Storage::new(formatted(MBYTE_2, &set(0)));
    open(&mut storage);
    let last = layout.mirror.map.end - SUBSECTOR;
    let mut variant = 0;
    while storage.flash().memory().subsectors().all(|(start, _)| start != last) {
        variant += 1;
        assert!(store(&mut storage, &set(variant), Part::Set));
    }
    let mut chip = storage.into_flash();
    // In the first item's content.
    chip.flip(last + 24, 3);
    let (opened, chip) = boot(&chip);
    assert_eq!((opened.faults, opened.repaired), (FaultWord::empty(), true));
    assert_eq!(opened.parameters.value(number::SPEED_RATE).unwrap(), 1000 + variant);
    assert!(!boot(&chip).0.repaired);
}
