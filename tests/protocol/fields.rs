//! Tests of the table of messages against frames written by hand: positions of the numbers, and their meaning
//! (PROTOCOL.md).

use crate::bench::frame;
use narx_core::bus::narmotion::{
    Addresses, DecodeError, Field, MESSAGES, Meaning, Message, MessageId, SIGNALS, Words,
};
use narx_core::dictionary::Decimal;

/// Name of a message, an identifier, its bytes, and its fields with their values there.
type Row = (&'static str, u32, u64, &'static [(&'static str, i64)]);

const ROWS: [Row; 9] = [
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
        "UPDATE_VERSION",
        0x1552_A8A1,
        0x0104_0203_00E7_0000,
        &[("Major version", 1), ("Minor version", 4), ("Patch level", 0x203), ("Build number", 231)],
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

/// A field of a message of a drive or a master.
fn field(message: &str, field: &str) -> Field {
    let mut fields = MESSAGES.iter().filter(|row| row.name == message).flat_map(Message::fields);
    fields.find(|found| found.name == field).expect(field)
}

/// The scales of Figure 14 hold: raw frames, and their values for the motor.
#[test]
fn measurements_have_their_scales() {
    let rows: [(u32, u64, &[&str]); 6] = [
        (0x1552_A8C8, 0xFC18_0002_0003_0001, &["-1 g", "0.002 g", "0.003 g", "1 -"]),
        (0x1552_A8C9, 0xF060_FFFF_FFFE_05DD, &["-4000 rpm", "-0.02 deg", "150.1 W"]),
        (0x1552_A8CA, 0x12C1_FFF9_1771_36B1, &["48.01 V", "-0.007 A", "6.001 V", "14.001 V"]),
        (0x1552_A8CB, 0x00FB_0709_017F_FFFF, &["25.1 °C", "1.801 V", "0.383 V", "-0.001 V"]),
        (0x1552_A8CC, 0x0001_FFFF_0963_0037, &["0.01 V", "-0.01 V", "24.03 V", "0.055 V"]),
        (0x1552_A8CD, 0x0FA0_0001_0000_0000, &["4000 rpm", "1 -"]),
    ];
    for (id, bytes, values) in rows {
        let (id, words) = Words::of(&frame(id, bytes)).unwrap();
        let signals = SIGNALS.iter().filter(|signal| signal.opcode == id.opcode);
        let read: Vec<_> = signals.map(|signal| format!("{} {}", signal.value(words), signal.unit)).collect();
        assert_eq!(read, values);
        // The table of messages gives the same values.
        let fields = Message::of(id).unwrap().fields();
        let read: Vec<_> = fields
            .map(|field| {
                let value = Decimal { digits: field.raw(words), exponent: field.exponent };
                format!("{value} {}", field.unit)
            })
            .collect();
        assert_eq!(read, values);
    }
}

#[test]
fn numbers_have_units_and_names() {
    for (message, name, unit) in [
        ("MOTOR_CMD", "Speed", "rpm"),
        ("XML_DOWNLOAD_ANSWER", "Length", "words"),
        ("UPDATE_DEVICE", "Room", "bytes"),
        ("UPDATE_BEGIN", "Length", "bytes"),
        ("UPDATE_STATUS", "Window", "blocks"),
        ("UPDATE_STATUS", "Offset", "bytes"),
        ("PARAMETER", "Value", "-"),
    ] {
        assert_eq!(field(message, name).unit, unit, "{message} {name}");
    }
    for (message, name, value, meaning) in [
        ("BUILD_INFO", "Source modified", 1, "yes"),
        ("STATUS_WORD", "Motor mode", 2, "Reverse"),
        ("STATUS_WORD", "Logging state", 11, "LOG_READ_END"),
        ("PARAMETER", "Status", 3, "Out of range"),
        ("XML_DOWNLOAD_REQUEST", "Command", 1, "Start"),
        ("UPDATE_STATUS", "Code", 14, "Reverted"),
        ("MEASUREMENT_5", "DSI2_DSP", 0, "low"),
    ] {
        let Meaning::Named(names) = field(message, name).meaning else { panic!("{message} {name}") };
        assert!(names.values.contains(&(value, meaning)), "{message} {name}");
    }
    for (message, name, meaning) in [
        ("FAULT_WORD", "Faults", Meaning::Faults),
        ("CRITICAL_FAULT", "Faults", Meaning::Faults),
        ("PARAMETER", "Number", Meaning::ParameterNumber),
        ("PARAMETER", "Value", Meaning::ParameterValue),
        ("MEASUREMENT_2", "HV Voltage", Meaning::Number),
    ] {
        assert_eq!(field(message, name).meaning, meaning, "{message} {name}");
    }
}

/// The smallest and the largest number of every field of every message fit, and nothing beyond them.
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
