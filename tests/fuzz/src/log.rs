//! Target: records of the log as they are on the flash and in a download.

use crate::program::Program;
use crc::{CRC_32_ISO_HDLC, Crc};
use narx_core::storage::Record;

static CRC32: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);
/// Bytes after the values: CRC and end word.
const TAIL: usize = 6;
/// Position of the number of values.
const COUNT: usize = 10;

/// Runs an input. First byte even: the bytes. Odd: a record whose length and CRC are corrected.
pub fn run(data: &[u8]) {
    let mut program = Program(data);
    let sound = !program.byte().is_multiple_of(2);
    let mut bytes = program.0.to_vec();
    if sound && bytes.len() >= 12 + TAIL {
        let count = u16::from_be_bytes([bytes[COUNT], bytes[COUNT + 1]]) % 41;
        bytes[COUNT..COUNT + 2].copy_from_slice(&count.to_be_bytes());
        bytes.resize(Record::size(count.into()), 0);
        let end = bytes.len() - TAIL;
        let crc = CRC32.checksum(&bytes[..end]);
        bytes[end..end + 4].copy_from_slice(&crc.to_be_bytes());
    }
    let Some(record) = Record::parse(&bytes) else { return };
    assert!(bytes.starts_with(record.bytes()));
    assert_eq!(Record::parse(record.bytes()).as_ref(), Some(&record));
    assert_eq!(Record::new(record.index(), &record.entry()), record);
    // Divided into frames of three words it is the same again.
    let frames = (0..).map_while(|place| record.frame(place));
    let sent: Vec<u8> = frames.flatten().flat_map(u16::to_be_bytes).collect();
    assert_eq!(sent, record.bytes());
}
