//! Tests of the SDO server: every command on every entry in every state, against a model of the rules.

use crate::bench::{Bench, FIRMWARE, STATES, answer, frame, node, value};
use narx_core::bus::Frame;
use narx_core::bus::eddycan::{
    AbortCode, Channels, FromNode, NmtState, SdoAction, SdoOutcome, SdoRequest, SdoValue, ToNode,
};
use narx_core::eddycan::{Access, Entry, Kind, OBJECTS};

/// Data bytes that are within every range.
const HARMLESS: [u8; 4] = [2, 0, 0, 0];

/// Outcome by Tables 4, 5 and 10 of a request, whose value is 2 if it writes; `None` for silence.
fn expected(bench: &Bench, state: NmtState, command: u8, index: u16, subindex: u8) -> Option<SdoOutcome> {
    let aborted = |code: AbortCode| Some(SdoOutcome::Aborted { code: code as u32 });
    if state == NmtState::Stopped || command == 0x80 {
        return None;
    }
    if state == NmtState::Operational {
        return aborted(AbortCode::General);
    }
    let size = match command {
        0x40 | 0x22 => None,
        0x23 => Some(4),
        0x27 => Some(3),
        0x2B => Some(2),
        0x2F => Some(1),
        _ => return aborted(AbortCode::CommandUnknown),
    };
    let Some(first) = OBJECTS.iter().find(|row| row.index == index) else {
        return aborted(AbortCode::IndexUnknown);
    };
    let Some(row) =
        OBJECTS.iter().find(|row| row.index == index && row.subindex.is_none_or(|s| s == subindex))
    else {
        return aborted(AbortCode::SubindexUnknown);
    };
    assert_eq!(row.subindex.is_some(), first.subindex.is_some());
    if command == 0x40 {
        let stored = match row.entry {
            Entry::FirmwareVersion => FIRMWARE.into(),
            entry => bench.driver.configuration().get(entry),
        };
        return match (row.access, row.kind) {
            (Access::WriteOnly, _) => aborted(AbortCode::WriteOnly),
            (_, Kind::U8) => Some(value(SdoValue::byte(stored as u8))),
            (_, Kind::U16) => Some(value(SdoValue::word(stored as u16))),
            (_, Kind::U32) => Some(value(SdoValue::long(stored))),
        };
    }
    if row.access == Access::ReadOnly {
        return aborted(AbortCode::ReadOnly);
    }
    if row.entry != Entry::ResetEncoder && size.is_some_and(|size| size != row.kind.size()) {
        return aborted(AbortCode::General);
    }
    Some(SdoOutcome::Written)
}

/// All 256 commands, every index and its neighbours, subindices of every class and three states give the
/// outcome of the model.
#[test]
fn every_command_index_subindex_and_state() {
    let mut seen = std::collections::BTreeSet::new();
    for state in STATES {
        let bench = Bench::in_state(state, Channels::Dual, &[]);
        for command in 0..=u8::MAX {
            for index in (0x1FFF..=0x200B).chain([0, 0x2020, 0x20FF, 0x2100, 0x2101, 0xFFFF]) {
                for subindex in [0, 1, 2, 3, 0xFF] {
                    let mut bench = Bench { driver: bench.driver.clone(), now: bench.now };
                    let expected = expected(&bench, state, command, index, subindex);
                    let [low, high] = index.to_le_bytes();
                    let [a, b, c, d] = HARMLESS;
                    bench.give(&frame(0x601, &[command, low, high, subindex, a, b, c, d]));
                    let answers: Vec<FromNode> =
                        expected.map(|outcome| answer(index, subindex, outcome)).into_iter().collect();
                    assert_eq!(bench.messages(), answers, "{state:?} {command:02X} {index:04X}h {subindex}");
                    if let Some(SdoOutcome::Aborted { code }) = expected {
                        seen.insert(code);
                    }
                    let written = expected == Some(SdoOutcome::Written) && index != 0x200A;
                    let changed = bench.driver.configuration() != &crate::bench::configured(&[]);
                    assert_eq!(changed, written, "{command:02X} {index:04X}h");
                }
            }
        }
    }
    // All codes but that of the range, which the next test exceeds.
    let all: std::collections::BTreeSet<u32> = AbortCode::ALL.iter().map(|code| *code as u32).collect();
    assert_eq!(all.difference(&seen).collect::<Vec<_>>(), [&(AbortCode::RangeExceeded as u32)]);
}

#[test]
fn values_out_of_range_are_refused_and_nothing_is_stored() {
    let exceeded = SdoOutcome::Aborted { code: AbortCode::RangeExceeded as u32 };
    for (index, subindex, refused) in [
        (0x2000, 0, &[0, 128, 255][..]),
        (0x2001, 0, &[5, 255]),
        (0x2002, 0, &[0, 128]),
        (0x2004, 0, &[8, 0x8000, 0xFFFF]),
        (0x2005, 0, &[1, 3, 7, 8, 0x8002]),
        (0x2006, 1, &[5, 255]),
        (0x2006, 2, &[5]),
        (0x2007, 1, &[(1 << 30) + 1, u32::MAX]),
        (0x2007, 2, &[1 << 31]),
        (0x2008, 0, &[0]),
        (0x2009, 0, &[0]),
    ] {
        for &wrong in refused {
            let mut bench = Bench::new(Channels::Dual, &[]);
            let before = *bench.driver.configuration();
            assert_eq!(bench.write(index, subindex, wrong), exceeded, "{index:04X}h = {wrong}");
            assert_eq!(bench.driver.configuration(), &before);
            assert_eq!(bench.driver.poll_store(), None);
        }
    }
}

/// Every entry is read back as written, and spare bytes do not count.
#[test]
fn what_is_written_is_read() {
    let mut bench = Bench::new(Channels::Dual, &[]);
    for row in OBJECTS.iter().filter(|row| row.access == Access::ReadWrite) {
        let subindex = row.subindex.unwrap_or(0);
        for number in [row.min, row.max, row.default] {
            let mut data = number.to_le_bytes();
            data[usize::from(row.kind.size())..].fill(0xA5);
            let write = SdoAction::Write { size: None, data };
            assert_eq!(bench.ask(row.index, subindex, write), SdoOutcome::Written);
            let SdoOutcome::Value(value) = bench.read(row.index, subindex) else { panic!("{}", row.name) };
            assert_eq!((value.size(), value.number()), (row.kind.size(), number), "{}", row.name);
        }
    }
}

/// The example of section 3.3.2 holds, and answers repeat a subindex that does not count.
#[test]
fn examples() {
    let mut bench = Bench::new(Channels::Dual, &[]);
    bench.give(&frame(0x601, &[0x22, 0x07, 0x20, 1, 0x00, 0x00, 0x00, 0x20]));
    assert_eq!(bench.frames(), [frame(0x581, &[0x60, 0x07, 0x20, 1, 0, 0, 0, 0])]);
    bench.give(&frame(0x601, &[0x40, 0x07, 0x20, 1, 0xFF, 0xFF, 0xFF, 0xFF]));
    assert_eq!(bench.frames(), [frame(0x581, &[0x43, 0x07, 0x20, 1, 0x00, 0x00, 0x00, 0x20])]);
    bench.give(&frame(0x601, &[0x40, 0x00, 0x20, 0x77, 0, 0, 0, 0]));
    assert_eq!(bench.frames(), [frame(0x581, &[0x4F, 0x00, 0x20, 0x77, 1, 0, 0, 0])]);
    bench.give(&frame(0x601, &[0x40, 0x00, 0x21, 0, 0, 0, 0, 0]));
    assert_eq!(bench.frames(), [frame(0x581, &[0x4B, 0x00, 0x21, 0, 0x03, 0x01, 0, 0])]);
}

#[test]
fn only_data_frames_of_eight_bytes_to_this_node_are_served() {
    let bench = Bench::new(Channels::Dual, &[]);
    let read = [0x40, 0x00, 0x20, 0, 0, 0, 0, 0];
    let id = frame(0x601, &[]).id();
    let extended = narx_core::bus::Id::extended(0x601).unwrap();
    let mut frames: Vec<Frame> = (0..8).map(|length| frame(0x601, &read[..length])).collect();
    frames.extend((0..=8).map(|length| Frame::remote(id, length).unwrap()));
    frames.extend([
        Frame::full(extended, read),
        frame(0x600, &read),
        frame(0x602, &read),
        frame(0x581, &read),
    ]);
    for frame in frames {
        let mut bench = Bench { driver: bench.driver.clone(), now: bench.now };
        let before = bench.driver.clone();
        bench.give(&frame);
        assert_eq!(bench.driver, before, "{frame:?}");
    }
}

/// Four answers may wait; a further request is not carried out, so that nothing is done without a
/// confirmation.
#[test]
fn what_cannot_be_answered_is_not_done() {
    let mut bench = Bench::new(Channels::Dual, &[]);
    let write = |value: u8| ToNode::Sdo {
        node: node(1),
        request: SdoRequest {
            index: 0x2002,
            subindex: 0,
            action: SdoAction::Write { size: None, data: [value, 0, 0, 0] },
        },
    };
    for value in 1..=9 {
        bench.send(write(value));
    }
    assert_eq!(bench.driver.configuration().get(Entry::NrOfNodes), 4);
    assert_eq!(bench.messages().len(), 4);
    bench.send(write(9));
    assert_eq!(bench.driver.configuration().get(Entry::NrOfNodes), 9);
    assert_eq!(bench.messages(), [answer(0x2002, 0, SdoOutcome::Written)]);
}
