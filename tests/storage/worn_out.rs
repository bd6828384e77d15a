//! Tests of a flash that does not keep written data but reports success: everything is read back, and data
//! that are not kept are written elsewhere.

use crate::code_flash;
use crate::log::{append, ask, erase, filled, values};
use crate::store::{items, lose};
use crate::support::{Chip, blank, boot, formatted, now, open, set, small, store};
use core::ops::Range;
use embedded_storage::nor_flash::{NorFlash as Blocking, ReadNorFlash as BlockingRead};
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use narx_core::dictionary::number;
use narx_core::motor::guard::fault::FaultWord;
use narx_core::storage::layout::Layout;
use narx_core::storage::{CodeFlash, FlashReply, FlashTask, Memory, Part, Storage};
use narx_sim::flash::{KBYTE_512, MBIT_256, Tear};

const SUBSECTOR: u32 = 4096;
const END: u32 = 512 << 10;

/// Result of a program that begins in the worn-out place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fate {
    /// All bits stay 1.
    Blank,
    /// The second half of the bytes stays blank.
    Half,
}

/// A chip with a place that does not keep the next `times` programs.
#[derive(Clone, Debug)]
struct WornOut<C> {
    chip: C,
    place: Range<u32>,
    fate: Fate,
    times: u32,
}

impl<C> WornOut<C> {
    /// A chip with a place that never keeps anything.
    fn new(chip: C, place: Range<u32>) -> Self {
        Self { chip, place, fate: Fate::Blank, times: u32::MAX }
    }

    /// Part of a program that is kept.
    fn kept<'b>(&mut self, offset: u32, bytes: &'b [u8]) -> &'b [u8] {
        if !self.place.contains(&offset) || self.times == 0 {
            return bytes;
        }
        self.times -= 1;
        match self.fate {
            Fate::Blank => &[],
            Fate::Half => &bytes[..bytes.len() / 2],
        }
    }
}

impl<C: ErrorType> ErrorType for WornOut<C> {
    type Error = C::Error;
}

impl<C: ReadNorFlash> ReadNorFlash for WornOut<C> {
    const READ_SIZE: usize = C::READ_SIZE;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), C::Error> {
        self.chip.read(offset, bytes).await
    }

    fn capacity(&self) -> usize {
        self.chip.capacity()
    }
}

impl<C: NorFlash> NorFlash for WornOut<C> {
    const WRITE_SIZE: usize = C::WRITE_SIZE;
    const ERASE_SIZE: usize = C::ERASE_SIZE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), C::Error> {
        self.chip.erase(from, to).await
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), C::Error> {
        let kept = self.kept(offset, bytes);
        self.chip.write(offset, kept).await
    }
}

impl<C: BlockingRead> BlockingRead for WornOut<C> {
    const READ_SIZE: usize = C::READ_SIZE;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), C::Error> {
        self.chip.read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        self.chip.capacity()
    }
}

impl<C: Blocking> Blocking for WornOut<C> {
    const WRITE_SIZE: usize = C::WRITE_SIZE;
    const ERASE_SIZE: usize = C::ERASE_SIZE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), C::Error> {
        self.chip.erase(from, to)
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), C::Error> {
        let kept = self.kept(offset, bytes);
        self.chip.write(offset, kept)
    }
}

fn stored<C: NorFlash>(storage: &mut Storage<C>, variant: i32) -> bool {
    matches!(
        now(storage.execute(FlashTask::Store(set(variant), Part::Set))),
        FlashReply::Stored { done: true, .. }
    )
}

#[test]
fn a_page_that_takes_nothing_any_more_is_passed_over() {
    let layout = Layout::of(32 << 20, SUBSECTOR).unwrap();
    for map in [&layout.primary.map, &layout.mirror.map] {
        for page in [0, 1, 3] {
            let start = map.start + page * SUBSECTOR;
            let chip = formatted(MBIT_256, &set(0));
            let mut storage = Storage::new(WornOut::new(chip, start..start + SUBSECTOR));
            now(storage.execute(FlashTask::Open));
            // Enough to fill four pages.
            for variant in 1..30 {
                assert!(stored(&mut storage, variant), "{page} of {map:x?}: {variant}");
            }
            let (opened, _) = boot(&storage.into_flash().chip);
            assert_eq!(opened.parameters.value(number::SPEED_RATE).unwrap(), 1029, "{page} of {map:x?}");
            assert_eq!((opened.faults, opened.repaired), (FaultWord::empty(), false), "{page} of {map:x?}");
        }
    }
}

/// If no page of a map keeps anything, the drive reports it, and the earlier set is there.
#[test]
fn a_map_that_takes_nothing_any_more_is_told() {
    let layout = Layout::of(END, SUBSECTOR).unwrap();
    for map in [&layout.primary.map, &layout.mirror.map] {
        let mut storage = Storage::new(WornOut::new(small(&set(0)), map.clone()));
        now(storage.execute(FlashTask::Open));
        assert!(!stored(&mut storage, 1), "{map:x?}");
        let (opened, _) = boot(&storage.into_flash().chip);
        let rate = opened.parameters.value(number::SPEED_RATE).unwrap();
        // The primary is written first.
        assert_eq!(rate, if *map == layout.primary.map { 1000 } else { 1001 }, "{map:x?}");
        assert_eq!(opened.faults, FaultWord::empty(), "{map:x?}");
        let mut fresh = Storage::new(WornOut::new(blank(KBYTE_512), map.clone()));
        assert!(!now(fresh.format(&set(1))), "{map:x?}");
    }
}

/// A record that is read back incomplete is written again: into the same page if that stayed blank, because a
/// blank page would be the log's end, else into the next one.
#[test]
fn a_record_that_is_not_kept_is_written_again() {
    for (fate, times, index) in [
        (Fate::Blank, 1, Some(40)),
        (Fate::Blank, 3, Some(40)),
        (Fate::Half, 1, Some(41)),
        (Fate::Half, 3, Some(43)),
        (Fate::Blank, 4, None),
    ] {
        let what = format!("{fate:?} {times} times");
        let mut storage = filled(0, 40);
        let entry = FlashTask::Append(narx_core::storage::Entry {
            time: 7,
            values: [(111, 700)].into_iter().collect(),
        });
        let place = 40 * 256..44 * 256;
        let mut worn = Storage::new(WornOut { chip: storage.flash().clone(), place, fate, times });
        now(worn.execute(FlashTask::Open));
        let FlashReply::Log { done, memory } = now(worn.execute(entry)) else { panic!("{what}") };
        assert_eq!((done, memory.written), (index.is_some(), index.map_or(40, |index| index + 1)), "{what}");
        let mut storage = Storage::new(worn.into_flash().chip);
        let written = open(&mut storage).log.written;
        assert_eq!(written, memory.written, "{what}");
        let found: Vec<i32> = values(&mut storage, written).into_iter().flatten().collect();
        let expected: Vec<i32> = (0..40).chain(index.map(|_| 700)).collect();
        assert_eq!(found, expected, "{what}");
    }
}

/// An item that is cut off does not hide the one before it, even if the other map is lost.
#[test]
fn one_map_alone_survives_every_cut() {
    let layout = Layout::of(END, SUBSECTOR).unwrap();
    let whole = small(&set(1));
    let mut cuts = 0;
    for tear in [Tear::Nothing, Tear::Partial, Tear::Garbage] {
        for cut in 0.. {
            let mut storage = Storage::new(whole.clone());
            open(&mut storage);
            storage.flash().cut_after(cut, tear);
            store(&mut storage, &set(2), Part::Set);
            if !storage.flash().is_off() {
                break;
            }
            let mut chip = storage.into_flash();
            chip.restore_power();
            now(chip.erase(layout.mirror.map.start, layout.mirror.map.end)).unwrap();
            let (opened, _) = boot(&chip);
            let rate = opened.parameters.value(number::SPEED_RATE).unwrap();
            assert_eq!(opened.faults, FaultWord::empty(), "step {cut}, {tear:?}");
            assert!(rate == 1001 || rate == 1002, "step {cut}, {tear:?}: {rate}");
            cuts += 1;
        }
    }
    assert!(cuts > 3 * 400, "{cuts}");
}

/// Bytes of a map.
fn content(chip: &mut Chip, map: &Range<u32>) -> Vec<u8> {
    let mut bytes = vec![0; map.len()];
    now(chip.read(map.start, &mut bytes)).unwrap();
    bytes
}

/// If an item of one map is lost, that item is written again, behind the others, and nothing is written into
/// the other map, which is valid.
#[test]
fn mending_writes_what_is_lost_and_no_more() {
    let layout = Layout::of(END, SUBSECTOR).unwrap();
    let whole = small(&set(4));
    for (map, other) in [(&layout.primary.map, &layout.mirror.map), (&layout.mirror.map, &layout.primary.map)]
    {
        for key in [1, 2, 3] {
            let mut chip = whole.clone();
            lose(&mut chip, map.clone(), key);
            let before = content(&mut chip, other);
            let (opened, mut after) = boot(&chip);
            assert!(opened.repaired && opened.faults.is_empty() && opened.parameters == set(4));
            assert_eq!(content(&mut after, other), before, "{key} of {map:x?}");
            let mut keys: Vec<u8> = items(&mut after, other).into_iter().map(|(key, ..)| key).collect();
            keys.sort_unstable();
            assert_eq!(keys, [1, 2, 3]);
            assert!(!boot(&after).0.repaired, "{key} of {map:x?}");
        }
    }
}

/// If the beginning of the log is lost, or an erase was cut off, no record is reported, whatever the flash
/// holds.
#[test]
fn a_log_without_a_beginning_has_no_records() {
    let layout = Layout::of(END, SUBSECTOR).unwrap();
    let mut lost = filled(0, 40).into_flash();
    for map in [&layout.primary.map, &layout.mirror.map] {
        lose(&mut lost, map.clone(), 3);
    }
    let mut erasing = filled(0, 40);
    assert!(ask(&mut erasing, FlashTask::Erase).0);
    for (chip, expected) in [(lost, (true, None)), (erasing.into_flash(), (false, Some(0)))] {
        let Memory { lost, erasing, written, .. } = boot(&chip).0.log;
        assert_eq!(((lost, erasing), written), (expected, 0));
    }
}

/// Of two sectors of a log only the parts in use are erased: of the second sector only the subsectors that
/// have records.
#[test]
fn an_erase_spares_what_is_blank() {
    let mut storage = filled(0, 17 * 16);
    erase(&mut storage);
    let worn: Vec<u32> = (0..121).filter(|at| storage.flash().memory().wear(at * SUBSECTOR) > 0).collect();
    assert_eq!(worn, (0..17).collect::<Vec<u32>>());
    assert!(append(&mut storage, 1));
}

/// If the next page of the flash that the code runs from keeps nothing, either, the one after it is used.
#[test]
fn parameters_beside_the_code_move_past_a_page_that_takes_nothing() {
    let stores = code_flash::until_full();
    for page in [2, 3] {
        let place = page * code_flash::PAGE..(page + 1) * code_flash::PAGE;
        let mut storage = CodeFlash::new(WornOut::new(code_flash::worn(stores), place));
        for request in [FlashTask::Open, FlashTask::Store(set(900), Part::Set)] {
            storage.begin(request);
            let report = (0..20).find_map(|_| storage.step()).expect("a request ends");
            assert!(
                matches!(report, FlashReply::Opened(_) | FlashReply::Stored { done: true, .. }),
                "{page}"
            );
        }
        let (opened, _) = code_flash::boot(&storage.into_flash().chip);
        assert_eq!((opened.faults, opened.repaired), (FaultWord::empty(), false), "{page}");
        assert_eq!(opened.parameters, code_flash::with(900, 0), "{page}");
    }
}
