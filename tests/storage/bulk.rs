//! Tests of bulk frames of log and description, as they leave the node.

use crate::device::Device;
use crate::node::{device, logging, signal};
use narx_core::bus::narmotion::ParameterStatus::Done;
use narx_core::bus::narmotion::{FromDrive, ToDrive, XmlCommand};
use narx_core::description::LOG_RECORD;
use narx_core::dictionary::{Kind, number};
use narx_core::storage::{Record, record};

/// Kinds of the data frames that have come: true for the log's.
fn order(device: &Device) -> Vec<bool> {
    let data = device.received.iter().filter_map(|message| match message {
        FromDrive::LogData { .. } => Some(true),
        FromDrive::XmlData { .. } => Some(false),
        _ => None,
    });
    data.collect()
}

/// Bytes of the log's data frames.
fn log_bytes(device: &Device) -> Vec<u8> {
    let data = device.received.iter().filter_map(|message| match message {
        FromDrive::LogData { data, .. } => Some(data.map(u16::to_be_bytes)),
        _ => None,
    });
    data.flatten().flatten().collect()
}

#[test]
fn downloads_take_turns() {
    let mut device = logging();
    device.run(2000);
    device.send(ToDrive::DownloadXml(XmlCommand::Start));
    device.run(10);
    device.set(number::LOG_READ_COUNT, 50);
    device.received.clear();
    assert_eq!(device.command(number::LOG_READ_REQUEST), Some(Done));
    while order(&device).iter().filter(|log| **log).count() < 50 * 6 {
        device.run(1);
    }
    let order = order(&device);
    let first = order.iter().position(|log| *log).unwrap();
    let last = order.iter().rposition(|log| *log).unwrap();
    let both = &order[first..=last];
    // Between two records the log waits for the flash, but never longer than a tick of three frames.
    let others = both.iter().filter(|log| !**log).count();
    assert!((50 * 6 - 1..50 * 9).contains(&others), "{others}");
    assert!(both.windows(2).all(|pair| pair != [true, true]), "no two of the log in a row");
    assert!(both.windows(5).all(|five| five.contains(&true)), "nor many of the description");
    device.run(3000);
    let text = device.received.iter().filter(|message| matches!(message, FromDrive::XmlData { .. }));
    assert!(text.count() > 5000, "the description ends, too");
}

/// A record that cannot be read keeps its place, and shorter ones are filled up.
#[test]
fn every_record_has_its_place() {
    let mut device = device();
    device.set(number::LOG_PERIOD, 10);
    let mut sizes = Vec::new();
    for slots in [1, 3, 2] {
        for place in 0..3 {
            let slot = if place < slots { signal(202, 0, 0) } else { 0xFFFF };
            device.set(29 + place, slot);
        }
        device.run(55);
        sizes.resize(device.get(number::LOG_WRITE_INDEX) as usize, Record::size(slots.into()));
    }
    device.set(29, 0xFFFF);
    device.set(30, 0xFFFF);
    let longest = Record::size(3);
    assert_eq!(device.get(number::LOG_RECORD_BYTES), longest as i32);
    let spoiled = 4;
    device.storage.flash().flip(spoiled as u32 * record::PAGE + 20, 0);
    for _ in 0..2 {
        device.set(number::LOG_READ_COUNT, sizes.len() as i32);
        assert_eq!(device.command(number::LOG_READ_REQUEST), Some(Done));
        device.run(300);
        let bytes = log_bytes(&device);
        assert_eq!(bytes.len(), sizes.len() * longest);
        for (index, bytes) in bytes.chunks(longest).enumerate() {
            let record = Record::parse(bytes);
            if index == spoiled {
                assert!(bytes.iter().all(|byte| *byte == 0));
                continue;
            }
            let record = record.unwrap();
            assert_eq!((record.index() as usize, record.bytes().len()), (index, sizes[index]));
            assert!(bytes[sizes[index]..].iter().all(|byte| *byte == 0));
        }
        device = device.reboot();
        assert_eq!(device.get(number::LOG_RECORD_BYTES), longest as i32, "known after a boot");
    }
    assert_eq!(device.command(number::LOG_ERASE_REQUEST), Some(Done));
    device.run(3000);
    assert_eq!(device.get(number::LOG_RECORD_BYTES), Record::size(0) as i32);
}

/// The table of which the description and PROTOCOL.md are made matches a real record: every part is where the
/// table has it.
#[test]
fn records_are_as_the_description_says() {
    let mut device = logging();
    device.run(200);
    let (records, _) = device.download(2, 1);
    let [record] = &records[..] else { panic!("one record") };
    let mut bytes = record.bytes();
    let mut take = |kind: Kind| {
        let (number, rest) = bytes.split_at(if kind == Kind::U16 { 2 } else { 4 });
        bytes = rest;
        (number.iter().fold(0, |number, byte| number << 8 | u32::from(*byte)), rest.len())
    };
    let entry = record.entry();
    let each = LOG_RECORD.iter().position(|part| part.per_value).unwrap();
    let behind = LOG_RECORD.iter().rposition(|part| part.per_value).unwrap() + 1;
    let (head, rest) = LOG_RECORD.split_at(each);
    let (group, tail) = rest.split_at(behind - each);
    let named = |part: &narx_core::description::LogEntry| part.name;
    assert_eq!(
        head.iter().map(named).collect::<Vec<_>>(),
        ["Start marker", "Record number", "Time since power-up", "Number of values"]
    );
    let head: Vec<u32> = head.iter().map(|part| take(part.kind).0).collect();
    assert_eq!(head, [record::START.into(), 2, entry.time, 3]);
    for (what, value) in &entry.values {
        let read: Vec<u32> = group.iter().map(|part| take(part.kind).0).collect();
        assert_eq!(read, [u32::from(*what), *value as u32]);
    }
    let crc =
        crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&record.bytes()[..record.bytes().len() - 6]);
    let tail: Vec<(u32, usize)> = tail.iter().map(|part| take(part.kind)).collect();
    assert_eq!(tail, [(crc, 2), (record::END.into(), 0)]);
}
