//! Tests of single bits that flip on the flash.

use crate::support::{Chip, boot, open, set, small, store};
use core::ops::Range;
use narx_core::motor::guard::fault::FaultWord;
use narx_core::storage::{Opened, Part, Storage, layout::Layout};
use narx_sim::flash::Memory as _;
use proptest::prelude::*;

/// For every flipped bit of everything that is stored, in either copy, the set is right, and the copy is
/// found damaged and made anew. The first and last byte of a subsector of a map are its marks, of whose eight
/// bits four must agree.
#[test]
fn every_flipped_bit_of_the_stored_image_is_detected_and_mended() {
    let chip = small(&set(1));
    let layout = Layout::of(512 << 10, 4096).unwrap();
    let mut flips = 0;
    for (first, bytes) in chip.memory().subsectors() {
        for (at, _) in (first..).zip(bytes).filter(|(_, byte)| **byte != 0xFF) {
            let mark = [&layout.primary.map, &layout.mirror.map].iter().any(|map| map.contains(&at))
                && matches!(at % 4096, 0 | 4095);
            for bit in 0..8 {
                let mut flipped = chip.clone();
                flipped.flip(at, bit);
                let (opened, after) = boot(&flipped);
                assert_eq!(opened.faults, FaultWord::empty(), "{at:x}.{bit}");
                assert_eq!(opened.parameters, set(1), "{at:x}.{bit}");
                assert!(opened.repaired || mark, "{at:x}.{bit} was not seen");
                assert!(!opened.log.lost);
                if bit == 3 {
                    let (again, _) = boot(&after);
                    assert_eq!((again.repaired, again.parameters), (false, set(1)), "{at:x}.{bit}");
                }
                flips += 1;
            }
        }
    }
    println!("{flips} flips");
    assert!(flips > 10_000, "{flips}");
}

/// With older sets beside it the newest one stays the newest: no wrong bit brings an older one back.
#[test]
fn no_flipped_bit_brings_an_older_set_back() {
    let mut storage = Storage::new(small(&set(0)));
    open(&mut storage);
    assert!(store(&mut storage, &set(1), Part::Once));
    for variant in 1..4 {
        assert!(store(&mut storage, &set(variant), Part::Set));
    }
    let chip = storage.into_flash();
    let stored = boot(&chip).0.parameters;
    assert_eq!(stored.raw(narx_core::dictionary::number::SPEED_RATE), 1003);
    for (first, bytes) in chip.memory().subsectors() {
        for (at, byte) in (first..).zip(bytes).filter(|(_, byte)| **byte != 0xFF) {
            let mut flipped = chip.clone();
            // Each byte once, with one of its eight bits.
            flipped.flip(at, (at as u8 ^ byte) % 8);
            let (opened, _) = boot(&flipped);
            assert_eq!((opened.faults, &opened.parameters), (FaultWord::empty(), &stored), "{at:x}");
        }
    }
}

/// Length of a run of bytes: from one subsector into the next.
const STRUCK: u32 = 4080;

/// Sets a run of bytes to one value.
fn strike(chip: &mut Chip, run: Range<u32>, byte: u8) {
    for at in run {
        let mut old = [0];
        chip.memory().read(at, &mut old);
        (0..8).filter(|bit| (old[0] ^ byte) >> bit & 1 != 0).for_each(|bit| chip.flip(at, bit));
    }
}

/// One power-up repairs a copy in which nearly a subsector was set to one byte, anywhere. A map that has lost
/// a mark is reorganised by the first write into it, which costs items that were valid; the same power-up
/// repairs those, too.
#[test]
fn one_power_up_mends_a_struck_copy() {
    let chip = small(&set(1));
    let layout = Layout::of(512 << 10, 4096).unwrap();
    for map in [&layout.primary.map, &layout.mirror.map] {
        for start in map.clone().step_by(97) {
            for byte in [0x00, 0xF7, 0xFF] {
                let what = format!("{byte:x} from {start:x}");
                let mut struck = chip.clone();
                strike(&mut struck, start..(start + STRUCK).min(map.end), byte);
                let (opened, after) = boot(&struck);
                assert_eq!((opened.faults, &opened.parameters), (FaultWord::empty(), &set(1)), "{what}");
                assert_same(&opened, &boot(&after).0, &what);
            }
        }
    }
}

/// If both copies are damaged in this way, around their items, the next power-up finds the parameters that
/// the first one found.
#[test]
fn mending_two_struck_copies_keeps_what_it_has_found() {
    let chip = small(&set(1));
    let layout = Layout::of(512 << 10, 4096).unwrap();
    let [primary, mirror] = [&layout.primary.map, &layout.mirror.map];
    let mut whole = 0;
    for (first, second) in (0..1000).step_by(100).flat_map(|first| {
        (0..1000).step_by(100).map(move |second| (primary.start + first, mirror.start + second))
    }) {
        let mut struck = chip.clone();
        strike(&mut struck, first..first + STRUCK, 0xF7);
        strike(&mut struck, second..second + STRUCK, 0xF7);
        let (opened, after) = boot(&struck);
        assert_same(&opened, &boot(&after).0, &format!("{first:x} and {second:x}"));
        whole += u32::from(opened.faults.is_empty() && opened.parameters == set(1));
    }
    println!("{whole} whole");
    assert!((10..90).contains(&whole), "{whole}");
}

/// Checks a power-up after one that has repaired.
fn assert_same(opened: &Opened, again: &Opened, what: &str) {
    assert_eq!((again.faults, &again.parameters), (opened.faults, &opened.parameters), "{what}");
    assert_eq!((again.repaired, again.log), (false, opened.log), "{what}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    /// If a bit has fallen where the next set goes, the set is read back, and stored elsewhere.
    #[test]
    fn a_set_is_stored_over_fallen_bits(at in 0..6 * 4096_u32, bit in 0..8_u8, others in prop::collection::vec((0..6 * 4096_u32, 0..8_u8), 0..3)) {
        let mut chip = small(&set(1));
        let first = Layout::of(512 << 10, 4096).unwrap().primary.label.start;
        chip.flip(first + at, bit);
        let mut storage = Storage::new(chip);
        prop_assert_eq!(open(&mut storage).parameters, set(1));
        for (at, bit) in others {
            // In one copy only: a mirror cannot repair two damaged copies.
            storage.flash().flip(first + at % (3 * 4096), bit);
        }
        prop_assert!(store(&mut storage, &set(2), Part::Set));
        prop_assert_eq!(boot(storage.flash()).0.parameters.value(narx_core::dictionary::number::SPEED_RATE).unwrap(), 1002);
    }

    /// With any content of the flash nothing panics, and a store works afterwards.
    #[test]
    fn no_content_makes_it_panic(seed in any::<u64>(), labelled: bool, density in 1..=8_u32) {
        let mut chip = small(&set(1));
        let layout = Layout::of(512 << 10, 4096).unwrap();
        let mut random = narx_sim::random::Random::new(seed);
        let first = if labelled { layout.primary.map.start } else { layout.primary.label.start };
        for at in first..layout.mirror.map.end {
            if labelled && layout.mirror.label.contains(&at) {
                continue;
            }
            let bits = random.bits();
            if bits as u32 % 8 < density {
                (0..8).filter(|bit| bits >> (8 + bit) & 1 == 1).for_each(|bit| chip.flip(at, bit as u8));
            }
        }
        let mut storage = Storage::new(chip);
        open(&mut storage);
        prop_assert!(store(&mut storage, &set(2), Part::Set));
        let (opened, _) = boot(storage.flash());
        prop_assert_eq!(opened.parameters.value(narx_core::dictionary::number::SPEED_RATE).unwrap(), 1002);
        prop_assert_eq!(opened.faults, FaultWord::empty());
    }
}
