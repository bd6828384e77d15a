//! Tests of the wire format against frames written by hand from the specification, in both directions.

use crate::bench::{BITRATES, frame, node};
use narx_core::bus::eddycan::{
    AbortCode, Bitrate, Channels, CobId, DecodeError, ErrorCode, FromNode, IDENTIFIERS, Layout, NmtCommand,
    NmtState, NodeId, PdoKind, Position, Reading, SdoAction, SdoAnswer, SdoOutcome, SdoRequest, SdoValue,
    Target, ToNode,
};
use narx_core::bus::{Frame, Id};
use proptest::prelude::*;

const SINGLE: Layout = Layout { channels: Channels::Single, encoder: false };
const DUAL: Layout = Layout { channels: Channels::Dual, encoder: false };
const SINGLE_ENCODER: Layout = Layout { channels: Channels::Single, encoder: true };
const DUAL_ENCODER: Layout = Layout { channels: Channels::Dual, encoder: true };

fn sdo(index: u16, subindex: u8, action: SdoAction) -> ToNode {
    ToNode::Sdo { node: node(2), request: SdoRequest { index, subindex, action } }
}

fn answer(index: u16, subindex: u8, outcome: SdoOutcome) -> FromNode {
    FromNode::Sdo(SdoAnswer { index, subindex, outcome })
}

#[test]
fn what_masters_send() {
    let all = Target::All;
    let two = Target::Node(node(2));
    let write = |size, data| SdoAction::Write { size, data };
    // 0.5 of the measuring range is 2^29 = 536870912 (section 3.3.2's example).
    let half = 536_870_912_u32.to_le_bytes();
    let table = [
        (frame(0, &[0x01, 0]), ToNode::Nmt { command: NmtCommand::Start, target: all }),
        (frame(0, &[0x02, 2]), ToNode::Nmt { command: NmtCommand::Stop, target: two }),
        (frame(0, &[0x80, 2]), ToNode::Nmt { command: NmtCommand::PreOperational, target: two }),
        (frame(0, &[0x81, 127]), ToNode::Nmt { command: NmtCommand::Reset, target: Target::Node(node(127)) }),
        (frame(0x80, &[]), ToNode::Sync),
        (frame(0x602, &[0x40, 0x01, 0x20, 0, 0, 0, 0, 0]), sdo(0x2001, 0, SdoAction::Read)),
        (frame(0x602, &[0x22, 0x01, 0x20, 0, 4, 0, 0, 0]), sdo(0x2001, 0, write(None, [4, 0, 0, 0]))),
        (frame(0x602, &[0x22, 0x07, 0x20, 1, 0, 0, 0, 0x20]), sdo(0x2007, 1, write(None, half))),
        (frame(0x602, &[0x23, 0x07, 0x20, 2, 0, 0, 0, 0x20]), sdo(0x2007, 2, write(Some(4), half))),
        (frame(0x602, &[0x27, 0, 0x20, 0, 1, 2, 3, 0]), sdo(0x2000, 0, write(Some(3), [1, 2, 3, 0]))),
        (frame(0x602, &[0x2B, 3, 0x20, 0, 10, 0, 0, 0]), sdo(0x2003, 0, write(Some(2), [10, 0, 0, 0]))),
        (frame(0x602, &[0x2F, 0, 0x20, 0, 9, 0, 0, 0]), sdo(0x2000, 0, write(Some(1), [9, 0, 0, 0]))),
        (
            frame(0x602, &[0x80, 0, 0x20, 0, 0, 0, 4, 5]),
            sdo(0x2000, 0, SdoAction::Abort { code: 0x0504_0000 }),
        ),
        (frame(0x602, &[0x55, 0, 0, 0, 0, 0, 0, 0]), sdo(0, 0, SdoAction::Unknown { command: 0x55 })),
        (
            Frame::remote(Id::standard(0x382).unwrap(), 6).unwrap(),
            ToNode::RequestPdo { node: node(2), bytes: 6 },
        ),
    ];
    for (frame, message) in table {
        assert_eq!(message.encode(), frame, "{message:?}");
        assert_eq!(ToNode::decode(&frame), Ok(message));
    }
}

#[test]
fn what_a_node_sends() {
    let reading = |first: i32, second: i32, encoder| Reading {
        positions: [Position::from_raw(first), Position::from_raw(second)],
        encoder,
    };
    let pdo = |kind, reading| FromNode::Pdo { kind, reading };
    let outcome = |outcome| answer(0x2003, 0, outcome);
    let aborted = |code: AbortCode| outcome(SdoOutcome::Aborted { code: code as u32 });
    let table = [
        // Section 3.2's example: PDO1 of node 2 has 182h, PDO2 282h.
        (SINGLE, frame(0x182, &[1, 2, 3, 4]), pdo(PdoKind::Timer, reading(0x0403_0201, 0, 0))),
        (SINGLE, frame(0x282, &[0, 0, 0, 0x80]), pdo(PdoKind::Sync, reading(i32::MIN, 0, 0))),
        (
            DUAL,
            frame(0x382, &[1, 2, 3, 4, 5, 6, 7, 0x88]),
            pdo(PdoKind::Remote, reading(0x0403_0201, 0x8807_0605_u32 as i32, 0)),
        ),
        (
            SINGLE_ENCODER,
            frame(0x182, &[1, 2, 3, 4, 5, 6]),
            pdo(PdoKind::Timer, reading(0x0403_0201, 0, 0x0605)),
        ),
        (
            DUAL_ENCODER,
            frame(0x182, &[1, 2, 3, 4, 5, 0x86, 7, 8]),
            pdo(PdoKind::Timer, reading(0x0302_0100, 0x8605_0400_u32 as i32, 0x0807)),
        ),
        (SINGLE, frame(0x582, &[0x60, 3, 0x20, 0, 0, 0, 0, 0]), outcome(SdoOutcome::Written)),
        (
            SINGLE,
            frame(0x582, &[0x43, 3, 0x20, 0, 1, 2, 3, 4]),
            outcome(SdoOutcome::Value(SdoValue::long(0x0403_0201))),
        ),
        (
            SINGLE,
            frame(0x582, &[0x4B, 3, 0x20, 0, 1, 2, 0, 0]),
            outcome(SdoOutcome::Value(SdoValue::word(0x0201))),
        ),
        (
            SINGLE,
            frame(0x582, &[0x4F, 3, 0x20, 0, 1, 0, 0, 0]),
            outcome(SdoOutcome::Value(SdoValue::byte(1))),
        ),
        (SINGLE, frame(0x582, &[0x80, 3, 0x20, 0, 1, 0, 4, 5]), aborted(AbortCode::CommandUnknown)),
        (SINGLE, frame(0x582, &[0x80, 3, 0x20, 0, 0, 0, 2, 6]), aborted(AbortCode::IndexUnknown)),
        (SINGLE, frame(0x582, &[0x80, 3, 0x20, 0, 0x11, 0, 9, 6]), aborted(AbortCode::SubindexUnknown)),
        (SINGLE, frame(0x582, &[0x80, 3, 0x20, 0, 0x30, 0, 9, 6]), aborted(AbortCode::RangeExceeded)),
        (SINGLE, frame(0x582, &[0x80, 3, 0x20, 0, 1, 0, 1, 6]), aborted(AbortCode::WriteOnly)),
        (SINGLE, frame(0x582, &[0x80, 3, 0x20, 0, 2, 0, 1, 6]), aborted(AbortCode::ReadOnly)),
        (SINGLE, frame(0x582, &[0x80, 3, 0x20, 0, 0, 0, 0, 8]), aborted(AbortCode::General)),
        (SINGLE, frame(0x702, &[0]), FromNode::Heartbeat(NmtState::BootUp)),
        (SINGLE, frame(0x702, &[4]), FromNode::Heartbeat(NmtState::Stopped)),
        (SINGLE, frame(0x702, &[5]), FromNode::Heartbeat(NmtState::Operational)),
        (SINGLE, frame(0x702, &[127]), FromNode::Heartbeat(NmtState::PreOperational)),
        // Section 3.5's example: errors of node 2 have 82h.
        (SINGLE, frame(0x82, &[0x00, 0x10]), FromNode::Error { code: 0x1000 }),
        (SINGLE, frame(0x82, &[0x20, 0x81]), FromNode::Error { code: 0x8120 }),
        (SINGLE, frame(0x82, &[0x00, 0x82]), FromNode::Error { code: 0x8200 }),
    ];
    for (layout, frame, message) in table {
        assert_eq!(message.encode(node(2), layout), frame, "{message:?}");
        assert_eq!(FromNode::decode(&frame, layout), Ok((node(2), message)));
    }
}

#[test]
fn variations_of_other_nodes_are_understood() {
    let decode = |data| FromNode::decode(&frame(0x582, data), SINGLE).unwrap().1;
    let value = |size: u8, number: u32, message| match message {
        FromNode::Sdo(SdoAnswer { outcome: SdoOutcome::Value(value), .. }) => {
            assert_eq!((value.size(), value.number()), (size, number));
        }
        other => panic!("{other:?}"),
    };
    value(4, 0x0403_0201, decode(&[0x42, 0, 0x20, 0, 1, 2, 3, 4]));
    value(3, 0x0003_0201, decode(&[0x47, 0, 0x20, 0, 1, 2, 3, 4]));
    let three = frame(0x582, &[0x47, 0, 0x20, 0, 1, 2, 3, 0]);
    let (from, message) = FromNode::decode(&three, SINGLE).unwrap();
    assert_eq!(message.encode(from, SINGLE), three, "it goes on as it came");
    // Bytes beyond the size do not count.
    value(2, 0x0201, decode(&[0x4B, 0, 0x20, 0, 1, 2, 3, 4]));
    value(1, 0x01, decode(&[0x4F, 0, 0x20, 0, 1, 2, 3, 4]));
    assert_eq!(AbortCode::decode(0x0080_0000), Some(AbortCode::General), "the code as printed");
    assert_eq!(AbortCode::decode(0x0607_0010), None);
    let emergency = frame(0x82, &[0x20, 0x81, 0x11, 0, 0, 0, 0, 0]);
    assert_eq!(FromNode::decode(&emergency, SINGLE), Ok((node(2), FromNode::Error { code: 0x8120 })));
    assert_eq!(ErrorCode::decode(0x8120), Some(ErrorCode::Passive));
    assert_eq!(ErrorCode::decode(0x8130), None);
}

#[test]
fn frames_that_are_no_messages() {
    use DecodeError::{ExtendedId, Identifier, Length, NmtCommand, Remote, Value};
    let remote = |id, dlc| Frame::remote(Id::standard(id).unwrap(), dlc).unwrap();
    let extended = Frame::data(Id::extended(0x602).unwrap(), &[0x40, 0, 0x20, 0, 0, 0, 0, 0]).unwrap();
    for (frame, error) in [
        (extended, ExtendedId),
        (frame(0, &[1]), Length),
        (frame(0, &[1, 0, 0]), Length),
        (frame(0, &[]), Length),
        (frame(0, &[3, 0]), NmtCommand(Target::All)),
        (frame(0, &[0x82, 5]), NmtCommand(Target::Node(node(5)))),
        (frame(0, &[1, 128]), Value),
        (frame(0, &[3, 128]), Value),
        (frame(0x80, &[0]), Length),
        (frame(0x602, &[0x40, 0, 0x20, 0, 0, 0, 0]), Length),
        (frame(0x600, &[0x40, 0, 0x20, 0, 0, 0, 0, 0]), Identifier),
        (frame(0x182, &[1, 2, 3, 4]), Identifier),
        (frame(0x7FF, &[0]), Identifier),
        (remote(0, 2), Remote),
        (remote(0x80, 0), Remote),
        (remote(0x182, 4), Remote),
        (remote(0x282, 4), Remote),
        (remote(0x602, 8), Remote),
        (remote(0x702, 1), Remote),
        (remote(0x380, 4), Identifier),
    ] {
        assert_eq!(ToNode::decode(&frame), Err(error), "{frame:?}");
    }
    for (frame, error) in [
        (frame(0x182, &[1, 2, 3]), Length),
        (frame(0x182, &[1, 2, 3, 4, 5, 6]), Length),
        (frame(0x582, &[0x60, 0, 0x20, 0, 0, 0, 0]), Length),
        (frame(0x582, &[0x22, 0, 0x20, 0, 0, 0, 0, 0]), Value),
        (frame(0x702, &[6]), Value),
        (frame(0x702, &[0, 0]), Length),
        (frame(0x82, &[0x10]), Length),
        (frame(0x602, &[0x40, 0, 0x20, 0, 0, 0, 0, 0]), Identifier),
        (frame(0x80, &[]), Identifier),
        (remote(0x382, 4), Remote),
    ] {
        assert_eq!(FromNode::decode(&frame, SINGLE), Err(error), "{frame:?}");
    }
}

/// Every identifier is either one of Table 3 or unknown, and is encoded to itself again.
#[test]
fn every_identifier() {
    let mut known = 0;
    for raw in 0..0x800_u16 {
        let Ok(id) = CobId::decode(Id::standard(raw).unwrap()) else { continue };
        known += 1;
        assert_eq!(id.encode().raw(), u32::from(raw));
        let rows = IDENTIFIERS.iter().filter(|row| {
            let node = raw.wrapping_sub(row.base);
            if row.node { (1..=127).contains(&node) } else { node == 0 }
        });
        assert_eq!(rows.count(), 1, "{raw:03X}");
    }
    assert_eq!(known, 2 + 7 * 127);
    assert!(IDENTIFIERS.is_sorted_by_key(|row| (row.base, row.node)), "the highest priority first");
}

#[test]
fn node_ids_are_1_to_127() {
    for raw in 0..=u8::MAX {
        assert_eq!(NodeId::new(raw).map(NodeId::raw), (1..=127).contains(&raw).then_some(raw));
        assert_eq!(postcard::from_bytes(&[raw]).ok(), NodeId::new(raw));
        assert!(NodeId::new(raw).is_none_or(|node| postcard::to_stdvec(&node) == Ok(vec![raw])));
    }
}

/// Bitrates and their indices are those of Tables 1 and 6.
#[test]
fn bitrates() {
    let metres = [1000, 500, 250, 50, 25];
    for (index, ((bitrate, bits), metres)) in BITRATES.into_iter().zip(metres).enumerate() {
        assert_eq!(bitrate as usize, index);
        assert_eq!(Bitrate::from_index(index as u8), Some(bitrate));
        assert_eq!(bitrate.bits_per_second(), bits);
        assert_eq!(bitrate.cable_metres(), metres);
    }
    assert!((5..=u8::MAX).all(|index| Bitrate::from_index(index).is_none()));
}

/// The 32-bit value over 2^27 is the position in mm, and the 24-bit one over 2^19.
#[test]
fn positions_are_millimetres() {
    for (raw, picometres) in [
        (0, 0),
        (1 << 27, 1_000_000_000),
        (-(1 << 27), -1_000_000_000),
        (1 << 26, 500_000_000),
        (i32::MIN, -16_000_000_000),
        (i32::MAX, 15_999_999_993),
        // One step is 7.450580597 pm.
        (1, 7),
        (-1, -7),
        (2, 15),
    ] {
        assert_eq!(Position::from_raw(raw).picometres(), picometres, "{raw}");
        assert_eq!(Position::from_picometres(picometres).raw(), raw, "{picometres}");
    }
    for beyond in [16_000_000_000, 17_000_000_000, i64::MAX] {
        assert_eq!(Position::from_picometres(beyond), Position::MAX);
        assert_eq!(Position::from_picometres((-beyond).saturating_sub(100)), Position::MIN);
    }
    assert_eq!(Position::from_picometres(i64::MIN), Position::MIN);
    // 24 bits: 1 mm is 2^19.
    let reading = Reading { positions: [Position::from_raw(1 << 27), Position::from_raw(-1)], encoder: 0 };
    let data = DUAL_ENCODER.encode(reading);
    assert_eq!(data, [0, 0, 0x08, 0xFF, 0xFF, 0xFF, 0, 0]);
}

proptest! {
    #[test]
    fn positions_survive_picometres(raw: i32) {
        prop_assert_eq!(Position::from_picometres(Position::from_raw(raw).picometres()).raw(), raw);
    }

    #[test]
    fn readings_survive_their_layout(first: i32, second: i32, encoder: u16) {
        let positions = [first, second].map(Position::from_raw);
        for layout in Layout::ALL {
            let data = layout.encode(Reading { positions, encoder });
            let (used, spare) = data.split_at(usize::from(layout.length()));
            prop_assert!(spare.iter().all(|byte| *byte == 0));
            let found = layout.decode(used).unwrap();
            let dropped = if layout == DUAL_ENCODER { 0xFF } else { 0 };
            prop_assert_eq!(found.positions[0].raw(), first & !dropped);
            let second = if layout.channels == Channels::Dual { second & !dropped } else { 0 };
            prop_assert_eq!(found.positions[1].raw(), second);
            prop_assert_eq!(found.encoder, if layout.encoder { encoder } else { 0 });
            for length in (0..=8).filter(|length| *length != used.len()) {
                prop_assert_eq!(layout.decode(&data[..length]), None);
            }
        }
    }

    /// Every message that is decoded is decoded to the same again after it was encoded.
    #[test]
    fn any_frame_both_ways(id in 0..0x800_u16, remote: bool, data in prop::collection::vec(any::<u8>(), 0..=8)) {
        let id = Id::standard(id).unwrap();
        let frame = if remote { Frame::remote(id, data.len() as u8) } else { Frame::data(id, &data) }.unwrap();
        if let Ok(message) = ToNode::decode(&frame) {
            prop_assert_eq!(ToNode::decode(&message.encode()), Ok(message));
        }
        for layout in Layout::ALL {
            if let Ok((node, message)) = FromNode::decode(&frame, layout) {
                prop_assert_eq!(FromNode::decode(&message.encode(node, layout), layout), Ok((node, message)));
            }
        }
    }
}
