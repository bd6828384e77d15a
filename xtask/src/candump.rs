//! Frames as `candump -l` of can-utils logs them, which python-can and most analysers read.

use narx_core::bus::Frame;
use std::fmt::Write;

/// One line without its end: `(seconds.micros) channel identifier#data`, remote frames `identifier#Rlength`.
/// `time_ns` is rounded down to microseconds.
pub fn line(time_ns: u64, channel: &str, frame: &Frame) -> String {
    let micros = time_ns / 1_000;
    // The number of digits tells 11-bit identifiers from 29-bit ones.
    let mut line = format!("({}.{:06}) {channel} {}#", micros / 1_000_000, micros % 1_000_000, frame.id());
    // Writing to a string cannot fail.
    if frame.is_remote() {
        let _ = write!(line, "R{}", frame.dlc());
    }
    for byte in frame.payload() {
        let _ = write!(line, "{byte:02X}");
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;
    use narx_core::bus::Id;

    #[test]
    fn lines_as_candump_writes_them() {
        let request = Frame::data(Id::extended(0x0AAD_5202).unwrap(), &[0, 0, 0, 1, 0, 0, 0, 0]).unwrap();
        assert_eq!(line(1_234_567_890, "can0", &request), "(1.234567) can0 0AAD5202#0000000100000000");
        let short = Frame::data(Id::standard(0x7f).unwrap(), &[0xab]).unwrap();
        assert_eq!(line(999, "can0", &short), "(0.000000) can0 07F#AB");
        let empty = Frame::data(Id::extended(1).unwrap(), &[]).unwrap();
        assert_eq!(line(12_000_000_001_000, "can0", &empty), "(12000.000001) can0 00000001#");
        let remote = Frame::remote(Id::standard(0x382).unwrap(), 8).unwrap();
        assert_eq!(line(50_000, "vcan1", &remote), "(0.000050) vcan1 382#R8");
    }
}
