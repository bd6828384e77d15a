//! Tests of the knowledge about the log's memory, and of requests that it refuses.

use crate::log::{append, ask, erase, filled, values};
use crate::node::device;
use crate::store::rewrite;
use crate::support::{blank, now, open, set, small, store};
use embedded_storage_async::nor_flash::NorFlash;
use narx_core::bus::narmotion::{MotorMode, ParameterStatus};
use narx_core::dictionary::number;
use narx_core::motor::State;
use narx_core::motor::guard::fault::FaultWord;
use narx_core::storage::layout::Layout;
use narx_core::storage::{Entry, FlashTask, Memory, Part, Storage};
use narx_sim::flash::MBIT_256;

/// A memory is full, erased, or neither; the status word and a master's request depend on this.
#[test]
fn a_memory_is_full_or_erased_or_neither() {
    let memory = |records, written, erasing, lost| {
        let memory = Memory { records, written, erasing, lost, ..Memory::default() };
        (memory.is_full(), memory.is_erased())
    };
    for (found, expected, what) in [
        (memory(0, 0, None, false), (false, false), "there is none"),
        (memory(16, 0, None, false), (false, true), "nothing is written"),
        (memory(16, 15, None, false), (false, false), "one more"),
        (memory(16, 16, None, false), (true, false), "the last is written"),
        (memory(16, 0, Some(0), false), (false, false), "it is being erased"),
        (memory(16, 0, None, true), (true, false), "nobody knows what it holds"),
    ] {
        assert_eq!(found, expected, "{what}");
    }
}

/// An entry with this many values.
fn entry_of(values: usize) -> FlashTask {
    FlashTask::Append(Entry { time: 1, values: (0..values as u16).map(|what| (what, 7)).collect() })
}

/// A full log, or one that is being erased, refuses an entry of any length: not a byte of the flash changes,
/// nor the knowledge about it.
#[test]
fn a_log_that_takes_nothing_stays_as_it_is() {
    let mut full = filled(0, 121 * 16);
    let mut erasing = filled(0, 40);
    assert!(ask(&mut erasing, FlashTask::Erase).0);
    for mut storage in [full.clone(), erasing] {
        let before = (storage.flash().counts(), ask(&mut storage, entry_of(2)).1);
        for values in [2, 3, 37] {
            assert_eq!(ask(&mut storage, entry_of(values)), (false, before.1), "{values}");
            assert_eq!(storage.flash().counts(), before.0, "{values}");
        }
    }
    assert_eq!(values(&mut full, 2), [Some(0), Some(1)]);
}

/// The maps are written for a record that is longer than all before, and for no other: they would wear.
#[test]
fn only_a_longer_record_is_noted() {
    let mut storage = filled(0, 1);
    for (values, is_noted) in
        [(2, false), (1, false), (3, true), (3, false), (2, false), (37, true), (37, false)]
    {
        let before = storage.flash().counts().programs;
        assert!(ask(&mut storage, entry_of(values)).0);
        let programs = storage.flash().counts().programs - before;
        assert_eq!(programs > 1, is_noted, "{values} values: {programs} programs");
    }
}

/// A beginning outside of the log is not used: the log is not read, but it can be erased.
#[test]
fn a_beginning_outside_of_the_log_is_none() {
    let layout = Layout::of(512 << 10, 4096).unwrap();
    for (first, lost) in [(120_u32, false), (121, true), (u32::MAX, true)] {
        let mut chip = small(&set(1));
        for map in [&layout.primary.map, &layout.mirror.map] {
            rewrite(&mut chip, map.clone(), 3, &|body| body[..4].copy_from_slice(&first.to_be_bytes()));
        }
        let mut storage = Storage::new(chip);
        assert_eq!(open(&mut storage).log.lost, lost, "{first}");
        assert_eq!(append(&mut storage, 1), !lost, "{first}");
        erase(&mut storage);
        assert!(append(&mut storage, 1));
    }
}

/// One step erases a sector at most, and the memory reports the progress.
#[test]
fn an_erase_goes_by_sectors() {
    let mut chip = blank(MBIT_256);
    for at in [0, 0x1_8000, 7781 * 4096] {
        now(chip.write(at, &[0])).unwrap();
    }
    let mut storage = Storage::new(chip);
    open(&mut storage);
    assert!(store(&mut storage, &set(1), Part::Set));
    open(&mut storage);
    assert_eq!(ask(&mut storage, FlashTask::Erase).1.erasing, Some(0));
    for step in 1..=7782_u32.div_ceil(16) {
        let before = storage.flash().counts().erases;
        let (done, memory) = ask(&mut storage, FlashTask::Erase);
        let erases = storage.flash().counts().erases - before;
        let expected = match step {
            // 98 304 is in the second sector, and the last one has six subsectors.
            1 | 2 => 16,
            487 => 6,
            _ => 0,
        };
        assert_eq!((done, erases), (true, expected), "{step}");
        assert_eq!(memory.erasing, Some((16 * step).min(7782)), "{step}");
    }
    assert!(ask(&mut storage, FlashTask::Erase).1.is_erased());
}

/// An erase that the flash does not accept ends with fault 30; when the flash is back, it can be requested
/// again.
#[test]
fn an_erase_that_fails_is_fault_30() {
    let mut device = device();
    device.storage.flash().set_absent(true);
    assert_eq!(device.command(number::LOG_ERASE_REQUEST), Some(ParameterStatus::Done));
    device.run(20);
    assert_eq!((device.state(), device.faults()), (State::Fault, FaultWord::STORE_ABSENT));
    device.storage.flash().set_absent(false);
    device.run(1100);
    device.request(MotorMode::Standby);
    device.run(20);
    assert_eq!((device.state(), device.faults()), (State::Standby, FaultWord::empty()));
    assert_eq!(device.command(number::LOG_ERASE_REQUEST), Some(ParameterStatus::Done));
    device.run(20);
    assert!(device.status().memory_erased);
}
