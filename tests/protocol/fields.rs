//! The table of messages against frames written by hand: which numbers stand where (PROTOCOL.md, section 3).

use crate::bench::frame;
use narx_core::bus::narmotion::{Addresses, DecodeError, MESSAGES, Message, MessageId, Words};

/// A message's name, an identifier, its bytes, and its fields with what they hold there.
type Row = (&'static str, u32, u64, &'static [(&'static str, i64)]);

const ROWS: [Row; 8] = [
    ("BUILD_INFO", 0x0AAD_5400, 0x0001_0002_0003_0004, &[]),
    ("REQUEST_WORD", 0x0AAD_5202, 0x0000_0002_0000_0000, &[("Motor mode", 2)]),
    (
        "STATUS_WORD",
        0x1552_A803,
        0x00CB_0302_0000_0000,
        &[
            ("Log erase possible", 0),
            ("Log download possible", 1),
            ("Log memory erased", 1),
            ("Log memory full", 0),
            ("Logging state", 11),
            ("Control mode", 3),
            ("Motor mode", 2),
        ],
    ),
    ("PARAMETER", 0x1552_A86E, 0x0050_FFFF_FFFE_0003, &[("Number", 80), ("Value", -2), ("Status", 3)]),
    (
        "LOG VIRTUAL SCOPE",
        0x1552_A870,
        0xFFFF_1000_F000_7FFF,
        &[("Address", 65_535), ("Sample 1", 4096), ("Sample 2", -4096), ("Sample 3", 32_767)],
    ),
    (
        "UPDATE_STATUS",
        0x1552_A8A4,
        0x020E_0020_8001_0002,
        &[("State", 2), ("Code", 14), ("Window", 32), ("Offset", 0x8001_0002)],
    ),
    (
        "MEASUREMENT_1",
        0x1552_A8C9,
        0xF060_FFFF_FFFE_05DC,
        &[
            ("Mechanical estimated speed SL", -4000),
            ("Mechanical position", -2),
            ("Electrical input Power", 1500),
        ],
    ),
    (
        "MEASUREMENT_5",
        0x1552_A8CD,
        0x0FA0_0001_0000_0000,
        &[("Mechanical estimated speed HES", 4000), ("DSI2_DSP", 1)],
    ),
];

#[test]
fn fields_are_read_from_their_places() {
    for (name, id, bytes, values) in ROWS {
        let frame = frame(id, bytes);
        let message = Message::of(MessageId::of(&frame).unwrap()).unwrap();
        let words = Words::of(&frame).unwrap().1;
        let read: Vec<_> = message.fields().map(|field| (field.name, field.raw(words))).collect();
        assert_eq!((message.name, &read[..]), (name, values));
        assert_eq!(message.id(Addresses::FACTORY).encode(), frame.id(), "{name}");
    }
}

#[test]
fn fields_are_put_where_they_are_read() {
    for (name, id, bytes, values) in ROWS.into_iter().filter(|row| !row.3.is_empty()) {
        let frame = frame(id, bytes);
        let message = Message::of(MessageId::of(&frame).unwrap()).unwrap();
        let mut words = Words::default();
        for (field, (_, raw)) in message.fields().zip(values) {
            assert_eq!(field.put(*raw, &mut words), Ok(()), "{name} {}", field.name);
        }
        assert_eq!(words, Words::of(&frame).unwrap().1, "{name}");
    }
}

/// The least and the greatest number of every field of every message fit, and nothing beyond them.
#[test]
fn a_number_that_a_field_has_no_room_for_is_refused() {
    for field in MESSAGES.iter().flat_map(Message::fields) {
        let span = 1_i64 << field.bits;
        let (least, greatest) = if field.signed { (-span / 2, span / 2 - 1) } else { (0, span - 1) };
        for raw in [least, greatest] {
            let mut words = Words::default();
            assert_eq!(field.put(raw, &mut words), Ok(()), "{} {raw}", field.name);
            assert_eq!(field.raw(words), raw, "{}", field.name);
        }
        for raw in [least - 1, greatest + 1, i64::MIN, i64::MAX] {
            let mut words = Words([1, 2, 3, 4]);
            assert_eq!(field.put(raw, &mut words), Err(DecodeError::Value), "{} {raw}", field.name);
            assert_eq!(words, Words([1, 2, 3, 4]), "{}", field.name);
        }
    }
}
