//! Target: a drive's flash with any content. The drive powers up with stored values or factory values,
//! repairs what can be repaired, and stores.

use crate::program::Program;
use crate::real::{self, Chip, now, open, store};
use narx_core::dictionary::{Parameters, number};
use narx_core::motor::guard::fault::FaultWord;
use narx_core::motor::{Board, Coefficients};
use narx_core::storage::layout::Layout;
use narx_core::storage::{Entry, FlashReply, FlashTask, Opened, Part, Storage};
use narx_sim::flash::Tear;

const CAPACITY: u32 = 512 << 10;
const SUBSECTOR: u32 = 4096;

/// Runs an input. First byte: bit 0 for a flash with a drive's parameters, else a blank one. Changes follow:
/// position, kind, number.
pub fn run(data: &[u8]) {
    let mut program = Program(data);
    let formatted = program.byte() & 1 != 0;
    let mut chip = if formatted { real::chip().clone() } else { real::blank() };
    let unchanged = program.is_over();
    while !program.is_over() {
        change(&mut chip, &mut program);
    }

    let (first, chip) = boot(chip);
    check(&first);
    if unchanged {
        let faults = if formatted { FaultWord::empty() } else { FaultWord::STORE_MISMATCH };
        assert_eq!((first.faults, first.repaired), (faults, false));
        let stored = if formatted { real::parameters().clone() } else { Parameters::new() };
        assert_eq!(first.parameters, stored);
    }
    // The next power-up finds the same, and has nothing to repair.
    let (second, chip) = boot(chip);
    assert_eq!((&second.parameters, second.faults), (&first.parameters, first.faults));
    assert_eq!(second.log, first.log);
    assert!(!second.repaired, "one power-up mends all");
    stores(chip);
}

/// Powers up; returns what was found, and the flash.
fn boot(chip: Chip) -> (Opened, Chip) {
    let mut storage = Storage::new(chip);
    let opened = open(&mut storage);
    (opened, storage.into_flash())
}

/// Checks that a drive can start with this: every value is within its range, and the set builds or the
/// parameter at fault is named.
fn check(opened: &Opened) {
    for (row, raw) in opened.parameters.iter() {
        assert!(row.accepts(raw), "{row} is {raw}");
    }
    let _ = Coefficients::build(&opened.parameters, &Board::BENCH);
    assert_eq!(opened.faults.difference(FaultWord::STORE), FaultWord::empty());
    assert!(!opened.faults.contains(FaultWord::STORE_ABSENT), "the flash is there");
}

/// Checks that on any content both parts and a record can be stored, and are found again.
fn stores(chip: Chip) {
    let mut storage = Storage::new(chip);
    let opened = open(&mut storage);
    let mut wanted = opened.parameters.clone();
    wanted.set(number::SPEED_RATE, 1234).expect("in range");
    wanted.set(number::DEVICE_NUMBER, 4321).expect("in range");
    assert!(store(&mut storage, &wanted, Part::Set) && store(&mut storage, &wanted, Part::Once));
    let entry = Entry { time: 7, values: [(1, -1)].into_iter().collect() };
    let before = open(&mut storage).log;
    let appended = now(storage.execute(FlashTask::Append(entry.clone())));
    let FlashReply::Log { done, memory } = appended else { panic!("{appended:?}") };
    if done {
        let newest = memory.written - 1;
        let read = now(storage.execute(FlashTask::Read(newest)));
        let FlashReply::Record(Some(record)) = read else { panic!("record {newest}: {read:?}") };
        assert_eq!((record.index(), record.entry()), (newest, entry));
    } else {
        assert_eq!(memory.written, before.written);
    }
    let (again, _) = boot(storage.into_flash());
    assert_eq!((again.faults, again.repaired), (FaultWord::empty(), false));
    for (row, raw) in again
        .parameters
        .iter()
        .filter(|(row, _)| [Part::Set, Part::Once].iter().any(|part| part.contains(row)))
    {
        assert_eq!(raw, wanted.raw(row.number), "{row}");
    }
}

/// Changes the flash: the position is in the labels and maps, or in the log.
fn change(chip: &mut Chip, program: &mut Program<'_>) {
    let layout = Layout::of(CAPACITY, SUBSECTOR).expect("it is large enough");
    let (kind, place) = (program.byte(), program.word());
    let maps = layout.primary.label.start..layout.mirror.map.end;
    let at = match kind & 3 {
        // The first and last records, where the ring is searched.
        0 => u32::from(place) % layout.log.end,
        1 => layout.log.end - 1 - u32::from(place) % 4096,
        _ => maps.start + u32::from(place) % (maps.end - maps.start),
    };
    match kind >> 2 & 3 {
        0 => chip.flip(at, program.byte() % 8),
        1 => {
            let length = program.byte() % 32;
            for (at, byte) in (at..layout.mirror.map.end).zip(program.take(length.into())) {
                set(chip, at, *byte);
            }
        }
        2 => {
            // A run of one byte, up to a subsector.
            let (byte, length) = (program.byte(), u32::from(program.byte()) * 16);
            (at..(at + length).min(layout.mirror.map.end)).for_each(|at| set(chip, at, byte));
        }
        _ => cut(chip, program),
    }
}

/// Cuts the power while a drive stores or logs.
fn cut(chip: &mut Chip, program: &mut Program<'_>) {
    let (what, steps) = (program.byte(), program.word());
    let tear = [Tear::Nothing, Tear::Partial, Tear::Garbage][usize::from(what % 3)];
    let mut storage = Storage::new(chip.clone());
    let mut parameters = open(&mut storage).parameters;
    let _ = parameters.set(number::SPEED_RATE, 1000 + i32::from(what));
    storage.flash().cut_after(steps.into(), tear);
    let request = match what >> 2 & 3 {
        0 => FlashTask::Store(parameters, Part::Set),
        1 => FlashTask::Store(parameters, Part::Once),
        2 => FlashTask::Append(Entry::default()),
        _ => FlashTask::Erase,
    };
    now(storage.execute(request));
    *chip = storage.into_flash();
    chip.restore_power();
}

fn set(chip: &mut Chip, at: u32, byte: u8) {
    let mut old = [0];
    narx_sim::flash::Memory::read(chip.memory(), at, &mut old);
    (0..8).filter(|bit| (old[0] ^ byte) >> bit & 1 != 0).for_each(|bit| chip.flip(at, bit));
}
