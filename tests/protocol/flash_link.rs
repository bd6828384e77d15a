//! Tests of the node between a master and its flash with scripted answers, some of which a working flash
//! never gives.

use crate::bench::Bench;
use ParameterStatus::{Done, Storage};
use narx_core::bus::narmotion::{FromDrive, ParameterStatus, ToDrive};
use narx_core::dictionary::{Parameters, number};
use narx_core::motor::guard::fault::FaultWord;
use narx_core::motor::machine::event::{Event, Health};
use narx_core::motor::machine::state::State;
use narx_core::storage::{Entry, FlashReply, FlashTask, Memory, Opened, Part, Record};

/// A log with room and five records.
const LOG: Memory = Memory { records: 16, written: 5, subsectors: 4, erasing: None, lost: false, values: 1 };
/// Ticks per millisecond.
const MS: u64 = 10;

fn opened(faults: FaultWord, log: Memory) -> Opened {
    Opened { parameters: Parameters::new(), faults, repaired: false, log }
}

/// A bench after power-up with this log.
fn bench(log: Memory) -> Bench {
    let mut bench = Bench::new();
    bench.node.attach_storage(&opened(FaultWord::empty(), log));
    bench
}

/// Writes 0 and then 1: a command.
fn command(bench: &mut Bench, number: u16) -> ParameterStatus {
    bench.write(number, 0);
    bench.write(number, 1).1
}

fn store_faults(bench: &mut Bench) -> Vec<FaultWord> {
    let faults = |event| match event {
        Event::Health(Health { store_faults, .. }) => Some(store_faults),
        _ => None,
    };
    bench.events().into_iter().filter_map(faults).collect()
}

/// A piece of an erase takes longer than a running motor may wait for the flash's answers: the erase goes on
/// when the motor is at rest.
#[test]
fn an_erase_waits_for_the_motor() {
    let half = Memory { erasing: Some(2), ..LOG };
    // Requested before the motor started, or found at power-up after a power cut had interrupted it.
    for (log, asks) in [(LOG, true), (half, false)] {
        let mut bench = bench(log);
        if asks {
            assert_eq!(command(&mut bench, number::LOG_ERASE_REQUEST), Done);
        }
        for state in [State::HallClosedLoop, State::SensorlessAutoRestart, State::RotorLock] {
            bench.enter(state);
            assert_eq!(bench.node.poll_storage(), None, "{state:?}");
        }
        bench.enter(State::Standby);
        assert_eq!(bench.node.poll_storage(), Some(FlashTask::Erase));
        bench.node.handle_storage(FlashReply::Log { done: true, memory: half });
        bench.enter(State::OpenLoop);
        assert_eq!(bench.node.poll_storage(), None, "started between two pieces");
        bench.enter(State::Fault);
        assert_eq!(bench.node.poll_storage(), Some(FlashTask::Erase));
        bench.node.handle_storage(FlashReply::Log { done: true, memory: Memory { written: 0, ..LOG } });
        assert_eq!(bench.node.poll_storage(), None, "all of it is erased");
    }
}

#[test]
fn an_erase_that_fails_is_fault_30() {
    for left in [None, Some(1)] {
        let mut bench = bench(LOG);
        assert_eq!(command(&mut bench, number::LOG_ERASE_REQUEST), Done);
        assert_eq!(bench.node.poll_storage(), Some(FlashTask::Erase));
        bench.node.handle_storage(FlashReply::Log { done: false, memory: Memory { erasing: left, ..LOG } });
        assert_eq!(store_faults(&mut bench), [FaultWord::STORE_ABSENT], "{left:?}");
        // The node searches for the flash; until it answers, no other request is made.
        assert_eq!(bench.node.poll_storage(), Some(FlashTask::Open), "{left:?}");
        bench.node.handle_storage(FlashReply::Opened(opened(FaultWord::STORE_ABSENT, Memory::default())));
        assert_eq!(command(&mut bench, number::LOG_ERASE_REQUEST), Storage, "{left:?}");
        // When it answers, earlier requests are forgotten: its log may be another one.
        bench.node.poll(1000 * MS);
        assert_eq!(bench.node.poll_storage(), Some(FlashTask::Open), "{left:?}");
        bench.node.handle_storage(FlashReply::Opened(opened(FaultWord::empty(), LOG)));
        assert_eq!(store_faults(&mut bench), [FaultWord::empty()], "{left:?}");
        assert_eq!(bench.node.poll_storage(), None, "{left:?}");
    }
}

/// A record that is lost is no fault: the log is not needed for operation.
#[test]
fn a_record_that_finds_no_place_is_no_fault() {
    let mut bench = bench(LOG);
    bench.write(number::LOG_PERIOD, 10);
    bench.write(number::LOGGING_SLOT_FIRST, number::AUTOSEND_PERIOD.into());
    bench.node.poll(0);
    bench.node.poll(10 * MS);
    assert!(matches!(bench.node.poll_storage(), Some(FlashTask::Append(_))));
    bench.node.handle_storage(FlashReply::Log { done: false, memory: LOG });
    assert_eq!(store_faults(&mut bench), []);
    bench.node.poll(20 * MS);
    assert!(matches!(bench.node.poll_storage(), Some(FlashTask::Append(_))), "the next one is tried");
}

/// The flash may answer a request after the master has aborted it; the record is not sent.
#[test]
fn a_record_that_comes_after_an_abort_is_not_sent() {
    let mut bench = bench(LOG);
    bench.write(number::LOG_READ_COUNT, 2);
    assert_eq!(command(&mut bench, number::LOG_READ_REQUEST), Done);
    assert_eq!(bench.node.poll_storage(), Some(FlashTask::Read(0)));
    assert_eq!(bench.write(number::LOG_READ_REQUEST, 0), (0, Done));
    let record = |index| FlashReply::Record(Some(Record::new(index, &Entry::default())));
    bench.node.handle_storage(record(0));
    assert_eq!((bench.node.poll_bulk_frame(), bench.node.poll_storage()), (None, None));
    // Another range starts from its beginning.
    bench.write(number::LOG_READ_START, 3);
    assert_eq!(bench.write(number::LOG_READ_REQUEST, 1), (1, Done));
    assert_eq!(bench.node.poll_storage(), Some(FlashTask::Read(3)));
    bench.node.handle_storage(record(3));
    let frame = bench.node.poll_bulk_frame().expect("its first words");
    // The record's start marker and its index.
    let expected = FromDrive::LogData { counter: 0, data: [0xAA55, 0, 3] };
    assert_eq!(FromDrive::decode(&frame).unwrap().1, expected);
}

#[test]
fn a_log_that_has_lost_its_beginning_is_erased_and_not_read() {
    let mut bench = bench(Memory { lost: true, ..LOG });
    assert_eq!(command(&mut bench, number::LOG_READ_REQUEST), Storage);
    assert_eq!((bench.node.poll_storage(), bench.node.poll_bulk_frame()), (None, None));
    assert_eq!(command(&mut bench, number::LOG_ERASE_REQUEST), Done);
    assert_eq!(bench.node.poll_storage(), Some(FlashTask::Erase));
}

/// Times of the records that the polls at these ticks cause, ms. The flash answers at once, or after the
/// polls selected by `busy` not at all.
fn times(polls: &[u64], busy: impl Fn(u64) -> bool) -> Vec<u32> {
    let mut bench = bench(LOG);
    bench.write(number::LOG_PERIOD, 10);
    bench.write(number::LOGGING_SLOT_FIRST, number::AUTOSEND_PERIOD.into());
    let mut times = Vec::new();
    for now in polls {
        bench.node.poll(*now);
        if busy(*now) {
            continue;
        }
        while let Some(request) = bench.node.poll_storage() {
            let FlashTask::Append(Entry { time, .. }) = request else { panic!("{request:?}") };
            times.push(time);
            bench.node.handle_storage(FlashReply::Log { done: true, memory: LOG });
        }
    }
    times
}

/// The period begins with the first poll. A poll soon after a sample still makes the record that is due, and
/// a late poll makes one record and no more.
#[test]
fn records_keep_their_time() {
    let free = |_| false;
    let every: Vec<u64> = (0..=400).collect();
    assert_eq!(times(&every, free), [10, 20, 30, 40]);
    assert_eq!(times(&[0, 95, 99, 100, 195, 200], free), [10, 20], "half a millisecond after a sample");
    assert_eq!(times(&[0, 100, 205, 300], free), [10, 20, 30], "a late one moves no other");
    assert_eq!(times(&[0, 450, 451, 549, 550, 650], free), [45, 55, 65], "too late for the next one");
}

/// A record that waits for the flash is the one that was due then; those that fall due meanwhile are missed.
#[test]
fn a_flash_that_is_busy_misses_records() {
    let every: Vec<u64> = (0..=700).collect();
    assert_eq!(times(&every, |now| (90..350).contains(&now)), [10, 40, 50, 60, 70]);
}

/// A restore changes the stored set: the values in force stay until the reboot. If the flash does not answer,
/// the restore is refused.
#[test]
fn a_restore_without_a_flash_is_refused() {
    for present in [true, false] {
        let mut bench = bench(LOG);
        bench.write(number::SPEED_RATE, 1234);
        if !present {
            command(&mut bench, number::LOG_ERASE_REQUEST);
            assert_eq!(bench.node.poll_storage(), Some(FlashTask::Erase));
            bench.node.handle_storage(FlashReply::Log { done: false, memory: LOG });
        }
        bench.send(ToDrive::RestoreFactory { serial: 1 });
        assert_eq!((bench.refused(), bench.read(number::SPEED_RATE)), (i32::from(!present), (1234, Done)));
        let request = bench.node.poll_storage();
        if present {
            let mut factory = bench.node.parameters().clone();
            factory.set(number::SPEED_RATE, 2000).unwrap();
            assert_eq!(request, Some(FlashTask::Store(factory, Part::Set)));
            continue;
        }
        assert_eq!(request, Some(FlashTask::Open));
        bench.node.handle_storage(FlashReply::Opened(opened(FaultWord::empty(), LOG)));
        assert_eq!((bench.node.poll_storage(), bench.read(number::SPEED_RATE)), (None, (1234, Done)));
    }
}

/// A restore that waits for another store, which fails, is stored when the flash is back.
#[test]
fn a_restore_outlives_the_store_before_it() {
    let mut bench = bench(LOG);
    bench.write(number::SPEED_RATE, 1234);
    for value in [0, 1] {
        bench.send(ToDrive::SetParameter { number: number::STORE_ONCE, value });
    }
    assert!(matches!(bench.node.poll_storage(), Some(FlashTask::Store(_, Part::Once))));
    bench.send(ToDrive::RestoreFactory { serial: 1 });
    bench.node.handle_storage(FlashReply::Stored { done: false, log: LOG });
    assert_eq!(bench.node.poll_storage(), Some(FlashTask::Open));
    bench.node.handle_storage(FlashReply::Opened(opened(FaultWord::empty(), LOG)));
    let Some(FlashTask::Store(stored, Part::Set)) = bench.node.poll_storage() else {
        panic!("nothing is stored")
    };
    assert_eq!(stored.raw(number::SPEED_RATE), 2000);
}

/// A flash that was missing may bring another set of parameters: it is not searched for while a motor turns.
#[test]
fn a_missing_flash_is_looked_for_at_rest() {
    use State::{
        Fault, HallClosedLoop, Initialization, OpenLoop, RotorLock, SensorlessAutoRestart,
        SensorlessClosedLoop, Standby,
    };
    for (state, looks) in [
        (Initialization, true),
        (Standby, true),
        (Fault, true),
        (RotorLock, false),
        (OpenLoop, false),
        (SensorlessClosedLoop, false),
        (SensorlessAutoRestart, false),
        (HallClosedLoop, false),
    ] {
        let mut bench = Bench::new();
        bench.node.attach_storage(&opened(FaultWord::STORE_ABSENT, Memory::default()));
        bench.enter(state);
        assert_eq!(bench.node.poll_storage(), looks.then_some(FlashTask::Open), "{state:?}");
    }
}

/// A report of a store that was not requested causes neither a fault nor an answer.
#[test]
fn a_store_that_was_not_asked_for_is_none() {
    let mut bench = bench(LOG);
    let before = bench.node.clone();
    bench.node.handle_storage(FlashReply::Stored { done: false, log: LOG });
    assert_eq!(bench.node, before);
    assert_eq!((bench.messages(), store_faults(&mut bench)), (vec![], vec![]));
}
