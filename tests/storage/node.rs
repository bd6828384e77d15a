//! Tests of the drive and its flash, as the master sees them.

use crate::device::Device;
use crate::support::{blank, set, small};
use ParameterStatus::{Done, OutOfRange, Storage, WrongState};
use narx_core::bus::narmotion::{FromDrive, MotorMode, ParameterStatus, ToDrive};
use narx_core::dictionary::{Parameters, number};
use narx_core::motor::State;
use narx_core::motor::guard::fault::FaultWord;
use narx_core::storage::record::VALUES;
use narx_sim::flash::KBYTE_512;

pub(crate) fn device() -> Device {
    Device::booted(small(&Parameters::new()))
}

/// Value of a slot: word `word` of the frame with this opcode; 0 live, 1 smallest, 2 largest, 3 mean.
pub(crate) fn signal(opcode: i32, word: i32, keep: i32) -> i32 {
    (0x2000 + opcode * 4 + word) | keep << 16
}

/// Device number and category 02 are stored by 257 alone; 256 is answered when it is done.
#[test]
fn what_is_stored_is_there_after_a_reboot_and_what_is_not_is_gone() {
    let mut device = device();
    device.set(number::SPEED_RATE, 1234);
    device.set(number::HV_CURRENT_OFFSET, 56);
    device.set(number::DEVICE_NUMBER, 9);
    assert_eq!(device.command(number::STORE), Some(Done));
    device = device.reboot();
    assert_eq!((device.get(number::SPEED_RATE), device.get(number::HV_CURRENT_OFFSET)), (1234, 0));
    assert_eq!(device.get(number::DEVICE_NUMBER), 1, "256 does not store it");
    device.set(number::HV_CURRENT_OFFSET, 56);
    device.set(number::DEVICE_NUMBER, 9);
    assert_eq!(device.command(number::STORE_ONCE), Some(Done));
    device = device.reboot();
    assert_eq!((device.get(number::SPEED_RATE), device.get(number::HV_CURRENT_OFFSET)), (1234, 56));
    assert_eq!(device.get(number::DEVICE_NUMBER), 9);
}

#[test]
fn the_answer_comes_when_it_is_stored_and_not_before() {
    let mut device = device();
    device.hold = true;
    assert_eq!(device.command(number::STORE), None);
    // A repeated request shares the answer; another store meanwhile is refused.
    assert_eq!(device.write(number::STORE, 1), None);
    assert_eq!(device.command(number::STORE_ONCE), Some(Storage));
    device.received.clear();
    device.hold = false;
    assert_eq!(device.answer(number::STORE), Some((1, Done)));
    // A 1 after a 1 is no edge: it is answered at once, and nothing is stored.
    let programs = device.storage.flash().counts().programs;
    assert_eq!(device.write(number::STORE, 1), Some((1, Done)));
    assert_eq!(device.storage.flash().counts().programs, programs);
    // Once a second at most.
    assert_eq!(device.command(number::STORE), Some(Storage));
    device.run(1000);
    device.hold = true;
    assert_eq!((device.command(number::STORE), device.command(number::STORE)), (None, Some(Storage)));
}

#[test]
fn stores_are_refused_while_driving() {
    let mut device = device();
    device.set(number::HALL_ENABLE, 1);
    device.request(MotorMode::Standby);
    device.run(10);
    device.request(MotorMode::Drive);
    device.run(10);
    assert_eq!(device.state(), State::HallClosedLoop);
    assert_eq!(device.write(number::STORE, 1), Some((0, WrongState)));
    device.request(MotorMode::Drive);
    assert_eq!(device.write(number::LOG_ERASE_REQUEST, 1), Some((0, WrongState)));
}

#[test]
fn where_code_and_parameters_share_a_flash_no_motor_starts_while_it_is_written() {
    let mut device = device();
    device.node.store_at_rest_only();
    device.set(number::HALL_ENABLE, 1);
    device.set(number::AUTOMATIC_STORE, 0);
    device.run(1000);
    device.request(MotorMode::Standby);
    device.run(10);
    // From the command on, before the flash has got a request.
    device.hold = true;
    device.send(ToDrive::SetParameter { number: number::STORE, value: 0 });
    device.send(ToDrive::SetParameter { number: number::STORE, value: 1 });
    device.tick();
    let refused = device.get(number::REFUSED_FRAMES);
    device.request(MotorMode::Drive);
    device.run(100);
    assert_eq!((device.state(), device.get(number::REFUSED_FRAMES)), (State::Standby, refused));
    // The command has waited.
    device.received.clear();
    device.hold = false;
    assert_eq!(device.answer(number::STORE), Some((1, Done)));
    device.run(10);
    assert_eq!(device.state(), State::HallClosedLoop);
}

/// If the code runs from the same flash, that is written at rest: a value that is written while the motor
/// turns is stored when it has stopped.
#[test]
fn where_code_and_parameters_share_a_flash_what_waits_to_be_stored_waits_for_the_motor() {
    for restore in [false, true] {
        let mut device = device();
        device.node.store_at_rest_only();
        device.set(number::HALL_ENABLE, 1);
        device.set(number::SPEED_RATE, 1234);
        device.run(900);
        device.request(MotorMode::Drive);
        device.run(10);
        if restore {
            device.send(ToDrive::RestoreFactory { serial: 1 });
        }
        let stores = device.stores;
        device.run(200);
        device.request(MotorMode::Drive);
        device.run(100);
        assert_eq!((device.state(), device.stores), (State::HallClosedLoop, stores));
        device.request(MotorMode::Standby);
        device.run(50);
        assert_eq!(device.stores, stores + 1);
        device.request(MotorMode::Drive);
        device.run(10);
        assert_eq!(device.state(), State::HallClosedLoop, "and the drive starts again");
        let device = device.power_cut();
        let expected = if restore { (2000, 0) } else { (1234, 1) };
        assert_eq!((device.get(number::SPEED_RATE), device.get(number::HALL_ENABLE)), expected);
    }
}

/// Faults of the store keep the drive in Fault from boot on, and storing cures them without a reboot.
#[test]
fn fault_26_is_cured_by_storing() {
    let mut device = Device::booted(blank(KBYTE_512));
    assert_eq!((device.state(), device.faults()), (State::Fault, FaultWord::STORE_MISMATCH));
    assert_eq!(device.get(number::MEMORY_MAPPING_FLAG), 0);
    assert_eq!(device.get(number::EXTENDED_FAULT_CODE), 0x1A01);
    assert_eq!(device.command(number::LOG_ERASE_REQUEST), Some(Storage));
    device.run(5000);
    assert_eq!(device.state(), State::Fault);
    device.set(number::SPEED_RATE, 1234);
    assert_eq!(device.command(number::STORE), Some(Done));
    device.request(MotorMode::Standby);
    device.run(20);
    assert_eq!((device.state(), device.faults()), (State::Standby, FaultWord::empty()));
    assert_eq!(device.get(number::MEMORY_MAPPING_FLAG), 1);
    // The log of such a flash must be erased once.
    let word = device.status();
    assert_eq!((word.memory_full, word.erase_enable, word.read_enable), (true, true, false));
    assert_eq!(device.command(number::LOG_ERASE_REQUEST), Some(Done));
    device.run(100);
    let word = device.status();
    assert_eq!((word.memory_full, word.memory_erased, word.erase_enable), (false, true, true));
    let device = device.reboot();
    assert_eq!((device.state(), device.get(number::SPEED_RATE)), (State::Standby, 1234));
}

#[test]
fn fault_30_is_cured_when_the_flash_answers_with_what_it_has_stored() {
    let mut stored = Parameters::new();
    stored.set(number::SPEED_RATE, 1234).unwrap();
    let mut chip = small(&stored);
    chip.set_absent(true);
    let mut device = Device::booted(chip);
    assert_eq!((device.state(), device.faults()), (State::Fault, FaultWord::STORE_ABSENT));
    assert_eq!(device.get(number::SPEED_RATE), 2000);
    assert_eq!(device.command(number::STORE), Some(Storage));
    assert_eq!((device.get(number::LOG_INDEX_MAX), device.status().logging), (0, 0));
    device.storage.flash().set_absent(false);
    device.run(1100);
    device.request(MotorMode::Standby);
    device.run(20);
    assert_eq!((device.state(), device.faults()), (State::Standby, FaultWord::empty()));
    assert_eq!(device.get(number::SPEED_RATE), 1234);
    assert!(device.get(number::LOG_INDEX_MAX) > 0);
}

#[test]
fn a_flash_that_goes_away_later_is_fault_30_and_takes_nothing_from_the_drive_when_it_is_back() {
    let mut device = device();
    device.set(number::SPEED_RATE, 1234);
    device.storage.flash().set_absent(true);
    assert_eq!(device.command(number::STORE), Some(Storage));
    device.run(20);
    assert_eq!((device.state(), device.faults()), (State::Fault, FaultWord::STORE_ABSENT));
    assert_eq!(device.get(number::STORE), 0);
    device.storage.flash().set_absent(false);
    device.run(1100);
    device.request(MotorMode::Standby);
    device.run(20);
    assert_eq!((device.state(), device.get(number::SPEED_RATE)), (State::Standby, 1234));
    assert_eq!(device.command(number::STORE), Some(Done));
    assert_eq!(device.reboot().get(number::SPEED_RATE), 1234);
}

#[test]
fn fault_31_is_cured_by_storing_or_restoring() {
    let mut chip = small(&set(0));
    crate::store::spoil(&mut chip);
    for cure in 0..3 {
        let mut device = Device::new(chip.clone());
        // The test's set has other addresses.
        device.node = {
            let mut parameters = device.node.parameters().clone();
            parameters.set(number::SLAVE_CAN_ADDRESS, 170).unwrap();
            let mut node = narx_core::node::Node::with_parameters(
                narx_core::node::Identity::default(),
                narx_core::motor::Board::BENCH,
                parameters,
            );
            node.attach_storage(&crate::support::open(&mut device.storage));
            node
        };
        device.run(510);
        assert_eq!((device.state(), device.faults()), (State::Fault, FaultWord::STORE_VERSION));
        assert_eq!(device.get(number::LOG_PERIOD), 10, "what fits was taken over");
        match cure {
            0 => device.send(ToDrive::RestoreFactory { serial: 100 }),
            1 => assert_eq!(device.command(number::STORE), Some(Done)),
            // The value that did not fit is in the other part.
            _ => assert_eq!(device.command(number::STORE_ONCE), Some(Done)),
        }
        device.run(10);
        device.request(MotorMode::Standby);
        device.run(20);
        assert_eq!((device.state(), device.faults()), (State::Standby, FaultWord::empty()));
        assert_eq!(crate::support::boot(device.storage.flash()).0.faults, FaultWord::empty(), "for good");
    }
}

/// A drive that logs voltage and temperature every 20 ms.
pub(crate) fn logging() -> Device {
    let mut device = device();
    device.set(number::LOG_PERIOD, 20);
    device.set(29, signal(202, 0, 3));
    device.set(30, i32::from(number::AUTOSEND_PERIOD));
    device.set(65, signal(201, 1, 0));
    device
}

#[test]
fn records_are_written_in_their_period_and_downloaded() {
    let mut device = logging();
    assert_eq!(device.get(number::LOG_RECORD_BYTES), 18 + 3 * 6);
    device.run(2000);
    let written = device.get(number::LOG_WRITE_INDEX);
    assert!((99..=101).contains(&written), "{written}");
    assert_eq!(device.get(number::LOGGING_PACKAGE), written - 1);
    let (records, counters) = device.download(0, written);
    assert_eq!(records.len(), written as usize);
    for (index, record) in records.iter().enumerate() {
        let entry = record.entry();
        assert_eq!(record.index(), index as u32);
        // 48 V within a code, 50 ms, position 0; mean is kind 3, word 0 of MEASUREMENT_2.
        let [(mean, voltage), period, position] = entry.values[..] else { panic!("{entry:?}") };
        assert_eq!(mean, (0x2000 + 202 * 4) | 3 << 14);
        assert!((4795..4805).contains(&voltage), "{voltage}");
        assert_eq!((period, position), ((111, 50), (0x2000 + 201 * 4 + 1, 0)));
        assert_eq!(entry.time - records[0].entry().time, 20 * index as u32);
    }
    let expected: Vec<u16> = (0..counters.len()).map(|place| (place * 3) as u16).collect();
    assert_eq!(counters, expected);
    // Records are words of the protocol: first the start marker, last the end marker.
    let bytes = records[0].bytes();
    assert_eq!((bytes.len(), &bytes[..2], &bytes[34..]), (36, &[0xAA, 0x55][..], &[0x55, 0xAA][..]));
}

#[test]
fn smallest_largest_and_mean_are_of_the_whole_period() {
    use narx_core::motor::Status;
    use narx_core::units::Volts;
    let mut device = device();
    for keep in 0..4 {
        device.set(29 + keep, signal(202, 0, keep.into()));
    }
    device.set(number::LOG_PERIOD, 10);
    let start = device.get(number::LOG_WRITE_INDEX);
    // The tick is left out: reports are made by hand, one per millisecond.
    let mut now = device.now;
    for milliseconds in 0..45 {
        let volts = [30, 10, 20, 60, 25, 25, 25, 25, 25, 35][milliseconds % 10];
        let bus_voltage = Volts::from_milli(volts * 1000);
        device.node.handle_status(Status { state: State::Standby, bus_voltage, ..Status::default() });
        for _ in 0..10 {
            device.node.poll(now);
            while let Some(request) = device.node.poll_storage() {
                device.node.handle_storage(crate::support::now(device.storage.execute(request)));
            }
            now += 1;
        }
    }
    device.now = now;
    let written = device.get(number::LOG_WRITE_INDEX);
    let (records, _) = device.download(start + 2, 1);
    assert!(written > start + 2);
    let values: Vec<i32> = records[0].entry().values.iter().map(|(_, value)| *value).collect();
    let [live, smallest, largest, mean] = values[..] else { panic!("{values:?}") };
    assert_eq!((smallest, largest, mean), (1000, 6000, 2800));
    assert!([1000, 2000, 2500, 3000, 3500, 6000].contains(&live));
}

#[test]
fn slots_name_what_there_is() {
    let mut device = device();
    for (slot, status) in [
        (0xFFFF, Done),
        (0x3_FFFF, Done),
        (0, Done),
        (289, Done),
        (122, OutOfRange),
        (255, OutOfRange),
        (0x1FFF, OutOfRange),
        (signal(200, 3, 1), Done),
        (signal(205, 1, 2), Done),
        (signal(205, 2, 0), OutOfRange),
        (signal(201, 2, 0), OutOfRange),
        (signal(206, 0, 0), OutOfRange),
        (signal(3, 0, 0), Done),
        (signal(4, 0, 0), Done),
        (signal(3, 1, 0), OutOfRange),
        (0x4_0000, OutOfRange),
    ] {
        assert_eq!(device.write(40, slot).map(|(_, status)| status), Some(status), "{slot:x}");
    }
}

#[test]
fn a_range_past_the_end_is_refused_and_one_within_can_be_resumed_and_aborted() {
    let mut device = logging();
    device.run(1000);
    for slot in [29, 30, 65] {
        device.set(slot, 0xFFFF);
    }
    let written = device.get(number::LOG_WRITE_INDEX);
    for (start, count, status) in [
        (0, 0, OutOfRange),
        (0, written + 1, OutOfRange),
        (written, 1, OutOfRange),
        (i32::MAX, i32::MAX, OutOfRange),
        (written - 1, 1, Done),
    ] {
        device.set(number::LOG_READ_START, start);
        device.set(number::LOG_READ_COUNT, count);
        assert_eq!(device.command(number::LOG_READ_REQUEST), Some(status), "{start} {count}");
        device.run(50);
    }
    // Aborted in the middle: frames stop, and the rest comes on request.
    device.download_rate = 1;
    device.set(number::LOG_READ_START, 0);
    device.set(number::LOG_READ_COUNT, written);
    assert_eq!(device.command(number::LOG_READ_REQUEST), Some(Done));
    device.run(5);
    // One at a time.
    assert_eq!(device.node.write_parameter(number::LOG_ERASE_REQUEST, 0), Done);
    assert_eq!(device.node.write_parameter(number::LOG_ERASE_REQUEST, 1), Storage);
    let (first, _) = device.records();
    assert!((1..written as usize - 5).contains(&first.len()));
    assert_eq!(device.write(number::LOG_READ_REQUEST, 0), Some((0, Done)));
    device.received.clear();
    device.run(100);
    assert_eq!(device.records().0, []);
    let resume = first.len() as i32;
    let (rest, counters) = device.download(resume, written - resume);
    assert_eq!(counters[0], 0);
    let indices: Vec<u32> = first.iter().chain(&rest).map(|record| record.index()).collect();
    assert_eq!(indices, (0..written as u32).collect::<Vec<u32>>());
}

#[test]
fn a_download_waits_for_everything_else() {
    let mut device = logging();
    device.run(1000);
    device.download_rate = 0;
    device.set(number::LOG_READ_COUNT, 10);
    assert_eq!(device.command(number::LOG_READ_REQUEST), Some(Done));
    device.run(5);
    device.send(ToDrive::RequestBuildInfo);
    assert_eq!(device.node.poll_bulk_frame(), None, "an answer waits");
    assert!(device.node.poll_frame().is_some());
    let frame = device.node.poll_bulk_frame().expect("nothing else waits");
    assert!(matches!(FromDrive::decode(&frame), Ok((_, FromDrive::LogData { counter: 0, .. }))));
}

/// Each state of Table 8 occurs in a status word on the bus, with the bits beside it.
#[test]
fn every_logging_state_and_bit_is_seen() {
    let mut device = Device::new(small(&Parameters::new()));
    let seen = |device: &mut Device| {
        let word = device.status();
        (word.logging, word.memory_full, word.memory_erased, word.read_enable, word.erase_enable)
    };
    assert_eq!(seen(&mut device), (0, false, false, false, false), "LOG_BOOT_UP");
    device.run(500);
    assert_eq!(seen(&mut device), (1, false, true, false, true), "LOG_INIT: nothing to log");
    device.set(number::LOG_PERIOD, 200);
    device.set(29, 111);
    assert_eq!(seen(&mut device), (2, false, true, false, true), "LOG_WRITE_WAIT_PER");
    device.hold = true;
    device.run(210);
    assert_eq!(seen(&mut device), (3, false, true, false, true), "LOG_WRITE");
    device.hold = false;
    device.tick();
    assert_eq!(seen(&mut device), (2, false, false, true, true));
    device.set(29, 0xFFFF);
    assert_eq!(seen(&mut device), (1, false, false, true, true));

    // A store under way delays the download.
    device.hold = true;
    assert_eq!(device.command(number::STORE), None);
    assert_eq!(device.command(number::LOG_READ_REQUEST), Some(Done));
    assert_eq!(seen(&mut device), (4, false, false, false, false), "LOG_READ_REQ_INIT");
    device.download_rate = 0;
    device.hold = false;
    device.tick();
    device.hold = true;
    device.tick();
    assert_eq!(seen(&mut device).0, 7, "LOG_WAIT_READ_RESULT");
    device.hold = false;
    assert_eq!(seen(&mut device), (8, false, false, false, false), "LOG_READ_SEND_CAN_FRAMES");
    device.download_rate = 3;
    assert_eq!(seen(&mut device), (11, false, false, true, true), "LOG_READ_END");
    assert_eq!(seen(&mut device).0, 1);

    device.hold = true;
    assert_eq!(device.command(number::LOG_ERASE_REQUEST), Some(Done));
    assert_eq!(seen(&mut device), (9, false, false, false, false), "LOG_ERASE_ONGOING");
    device.hold = false;
    assert_eq!(seen(&mut device), (10, false, true, false, true), "LOG_ERASE_END");
    assert_eq!(seen(&mut device), (1, false, true, false, true));
}

/// Between two records of a download, while the flash stores parameters, the state is LOG_SEND_READ_REQ.
#[test]
fn the_state_before_a_read_is_seen_while_the_flash_is_busy() {
    let mut device = logging();
    device.run(200);
    [29, 30, 65].into_iter().for_each(|slot| device.set(slot, 0xFFFF));
    device.set(number::LOG_READ_COUNT, 5);
    device.download_rate = 0;
    assert_eq!(device.command(number::LOG_READ_REQUEST), Some(Done));
    device.run(5);
    assert_eq!(device.status().logging, 8);
    device.hold = true;
    assert_eq!(device.command(number::STORE), None);
    device.download_rate = 3;
    assert_eq!(device.status().logging, 5);
    device.hold = false;
    assert_eq!(device.status().logging, 11);
}

#[test]
fn a_full_log_says_so_stops_and_is_erased() {
    let mut device = Device::booted(small(&Parameters::new()));
    let records = device.get(number::LOG_INDEX_MAX);
    assert_eq!(records, 121 * 16);
    assert_eq!(device.get(number::LOG_SUBSECTORS), 121);
    device.set(number::LOG_PERIOD, 1);
    device.set(29, 111);
    device.run(records as u64 + 50);
    assert_eq!((device.get(number::LOG_WRITE_INDEX), device.get(number::LOG_MEMORY_FULL)), (records, 1));
    let word = device.status();
    assert_eq!((word.logging, word.memory_full, word.read_enable), (1, true, true));
    let (last, _) = device.download(records - 1, 1);
    assert_eq!(last[0].index(), records as u32 - 1);
    device.set(29, 0xFFFF);
    let kept = device.get(number::SPEED_RATE);
    device.write(number::LOG_ERASE_REQUEST, 0);
    device.send(ToDrive::SetParameter { number: number::LOG_ERASE_REQUEST, value: 1 });
    let mut reached = Vec::new();
    for _ in 0..1000 {
        device.tick();
        reached.push(device.node.read_parameter(number::LOG_ERASE_SUBSECTOR).unwrap());
    }
    assert!(device.status().memory_erased);
    assert!(reached.iter().any(|subsector| *subsector > 0), "{reached:?}");
    assert_eq!((device.get(number::LOG_WRITE_INDEX), device.get(number::LOG_MEMORY_FULL)), (0, 0));
    assert_eq!(device.reboot().get(number::SPEED_RATE), kept);
}

#[test]
fn all_slots_fill_a_record() {
    let mut device = device();
    for place in 0..VALUES as u16 {
        device.set(29 + place, i32::from(78 + place));
    }
    device.set(number::LOG_PERIOD, 5);
    device.run(50);
    assert_eq!(device.get(number::LOG_RECORD_BYTES), 240);
    let (records, counters) = device.download(0, 2);
    assert_eq!((records.len(), counters.len()), (2, 80));
    for (what, value) in &records[1].entry().values {
        assert_eq!(Some(*value), device.node.read_parameter(*what));
    }
    assert_eq!(records[1].entry().values.len(), VALUES);
}

#[test]
fn without_a_flash_nothing_has_changed() {
    let mut node =
        narx_core::node::Node::new(narx_core::node::Identity::default(), narx_core::motor::Board::BENCH);
    node.poll(0);
    assert_eq!((node.poll_storage(), node.poll_bulk_frame()), (None, None));
}
