//! Tests of lines of candump logs: written, read, and refused.

use crate::frames::{extended, standard};
use narx_core::bus::candump::{Content, Line, ParseError, line};
use narx_core::bus::{Frame, Id};
use proptest::prelude::*;

fn parse(text: &str) -> Result<Option<Line<'_>>, ParseError> {
    Line::parse(text.as_bytes())
}

fn remote(id: Option<Id>, dlc: u8) -> Frame {
    Frame::remote(id.unwrap(), dlc).unwrap()
}

#[test]
fn frames_are_written_and_read_as_candump_writes_them() {
    for (nanoseconds, channel, frame, text) in [
        (
            1_234_567_890,
            "can0",
            extended(0x0AAD_5202, &[0, 0, 0, 1, 0, 0, 0, 0]),
            "(1.234567) can0 0AAD5202#0000000100000000",
        ),
        (999, "can0", standard(0x7F, &[0xAB]), "(0.000000) can0 07F#AB"),
        (12_000_000_001_000, "can0", extended(1, &[]), "(12000.000001) can0 00000001#"),
        (50_000, "vcan1", remote(Id::standard(0x382), 8), "(0.000050) vcan1 382#R8"),
    ] {
        assert_eq!(line(nanoseconds, channel, &frame).to_string(), text);
        let read = parse(text).unwrap().unwrap();
        assert_eq!(
            (read.content, read.channel, read.received),
            (Content::Frame(frame), channel, true),
            "{text}"
        );
        assert_eq!(read.time, (nanoseconds / 1000) as f64 / 1e6);
    }
}

#[test]
fn what_other_writers_do_is_read() {
    let plain = standard(0x1A2, &[0xDE, 0xAD]);
    for (text, time, received, frame) in [
        ("(1436509052.249713) can0 1A2#DEAD R\r\n", 1_436_509_052.249_713, true, plain),
        ("(1436509052.249713) can0 1a2#dead T\n", 1_436_509_052.249_713, false, plain),
        ("  (1436509052.249713123)   can0\t1A2#DEAD", 1_436_509_052.249_713_2, true, plain),
        // More digits than a float has: dividing rounded numbers would give a neighbouring value.
        ("(1810185161.8982853) can0 1A2#DEAD", 1_810_185_161.898_285_3, true, plain),
        // 2^64 + 1.
        ("(18446744073709551617) can0 1A2#DEAD", 18_446_744_073_709_551_617.0, true, plain),
        ("(0) 1 1A2#DEAD", 0.0, true, plain),
        ("(-0.5) can0 1A2#DEAD", -0.5, true, plain),
        ("(1e3) can0 1A2#DEAD", 1000.0, true, plain),
        ("(1.0) can0 1A2#R", 1.0, true, remote(Id::standard(0x1A2), 0)),
        ("(1.0) can0 1A2#r4 t", 1.0, false, remote(Id::standard(0x1A2), 4)),
        ("(1.0) can0 2#", 1.0, true, standard(2, &[])),
        ("(1.0) can0 01A2#00", 1.0, true, extended(0x1A2, &[0])),
        // The flag of 29-bit identifiers in a socket's frame.
        ("(1.0) can0 800001A2#00", 1.0, true, extended(0x1A2, &[0])),
    ] {
        let read = parse(text).unwrap().unwrap();
        assert_eq!(
            (read.time, read.received, read.content),
            (time, received, Content::Frame(frame)),
            "{text}"
        );
    }
    assert_eq!(parse(" \r\n"), Ok(None));
    let Content::Fd { id, flags, data } = parse("(1) c 12345678##3AABBCC").unwrap().unwrap().content else {
        panic!("not CAN FD")
    };
    assert_eq!(
        (id, flags, data.bytes().collect()),
        (Id::extended(0x1234_5678).unwrap(), 3, vec![0xAA, 0xBB, 0xCC])
    );
    let Content::Error { class, data } = parse("(1) c 20000088#00040000").unwrap().unwrap().content else {
        panic!("not an error frame")
    };
    assert_eq!((class, data.len(), data.bytes().nth(1)), (0x88, 4, Some(4)));
    // The largest number of digits of such frames, and none.
    for (digits, id) in [(16, "20000088#"), (0, "20000088#"), (128, "123##1"), (0, "123##1")] {
        let text = format!("(1) c {id}{}", "5A".repeat(digits / 2));
        let read = parse(&text).unwrap().unwrap();
        let (Content::Error { data, .. } | Content::Fd { data, .. }) = read.content else { panic!("{text}") };
        assert_eq!((data.len(), data.is_empty()), (digits / 2, digits == 0), "{text}");
        assert!(data.bytes().eq(std::iter::repeat_n(0x5A, digits / 2)), "{text}");
    }
}

#[test]
fn what_is_no_line_is_refused_for_what_is_wrong_with_it() {
    use ParseError::{Channel, Data, Identifier, Length, Separator, Shape, Time};
    let long = format!("(1) c 123##0{}", "00".repeat(65));
    for (text, error) in [
        ("(1.0)", Shape),
        ("(1.0) can0", Shape),
        ("1.0 can0 123#00", Shape),
        ("(1.0 can0 123#00", Shape),
        ("(1.0) can0 123#00 X", Shape),
        ("(1.0) can0 123#00 R T", Shape),
        ("(1.0) can0  123   [2]  11 22", Shape),
        ("() can0 123#00", Time),
        ("(1.0.0) can0 123#00", Time),
        ("(nan) can0 123#00", Time),
        ("(inf) can0 123#00", Time),
        ("(1,5) can0 123#00", Time),
        ("(1.0) can0 12300", Separator),
        ("(1.0) can0 #00", Identifier),
        ("(1.0) can0 800#00", Identifier),
        ("(1.0) can0 FFF#00", Identifier),
        ("(1.0) can0 12G#00", Identifier),
        ("(1.0) can0 123456789#00", Identifier),
        ("(1.0) can0 123#0", Data),
        ("(1.0) can0 123#0G", Data),
        ("(1.0) can0 123#00112233445566778", Data),
        ("(1.0) can0 123##", Data),
        ("(1.0) can0 123##G00", Data),
        ("(1.0) can0 123##0R", Data),
        ("(1.0) can0 123##0ABC", Data),
        ("(1.0) can0 123##0GG", Data),
        ("(1.0) can0 123#GG", Data),
        ("(1.0) can0 123#R10", Data),
        ("(1.0) can0 123#R9", Length),
        ("(1.0) can0 123#001122334455667788", Length),
        (long.as_str(), Length),
        ("(1.0) can0 20000088#001122334455667788", Length),
    ] {
        assert_eq!(parse(text), Err(error), "{text}");
    }
    assert_eq!(Line::parse(b"(1.0) \xFF 123#00"), Err(Channel));
}

/// Eight digits are converted at once: any byte at any place among them is a digit or an error.
#[test]
fn every_byte_at_every_place_of_a_line() {
    let line = b"(1436509052.249713) can0 0AAD52c8#0123456789abcDEF";
    assert!(Line::parse(line).unwrap().is_some());
    for byte in 0..=u8::MAX {
        for place in (25..33).chain(34..50) {
            let mut changed = *line;
            changed[place] = byte;
            // A remote frame, a blank and another # are other lines, which other tests have.
            if byte.is_ascii_whitespace() || byte == b'#' {
                continue;
            }
            let expected = if byte.is_ascii_hexdigit() {
                let value = |digits: &[u8]| u64::from_str_radix(str::from_utf8(digits).unwrap(), 16).unwrap();
                Ok((value(&changed[25..33]) as u32 & 0x1FFF_FFFF, value(&changed[34..])))
            } else if place < 33 {
                Err(ParseError::Identifier)
            } else {
                Err(ParseError::Data)
            };
            let content = Line::parse(&changed).map(|line| line.unwrap().content);
            let found = content.map(|content| match content {
                Content::Frame(frame) => {
                    (frame.id().raw(), u64::from_be_bytes(frame.payload().try_into().unwrap()))
                }
                Content::Error { class, data } => {
                    (class, data.bytes().fold(0, |all, byte| all << 8 | u64::from(byte)))
                }
                Content::Fd { .. } => unreachable!("no second #"),
            });
            assert_eq!(found, expected, "byte {byte:02X} at {place}");
        }
        for place in (1..11).chain(12..18) {
            let mut changed = *line;
            changed[place] = byte;
            let stamp = str::from_utf8(&changed[1..18]).ok().filter(|text| !text.contains(['#', ')', ' ']));
            let exact = stamp.and_then(|text| text.parse::<f64>().ok()).filter(|time| time.is_finite());
            let found = Line::parse(&changed).ok().flatten().map(|line| line.time.to_bits());
            assert_eq!(found, exact.map(f64::to_bits), "byte {byte:02X} at {place}");
        }
    }
}

#[test]
fn what_is_wrong_is_told_in_words() {
    for (error, text) in [
        (ParseError::Shape, "not \"(time) channel identifier#data\", with R or T behind it or not"),
        (ParseError::Time, "the time is not a finite number"),
        (ParseError::Channel, "the channel is not UTF-8"),
        (ParseError::Separator, "no # between identifier and data"),
        (ParseError::Identifier, "the identifier is not 1 to 3 hexadecimal digits up to 7FF, or 4 to 8"),
        (ParseError::Data, "the data are not pairs of hexadecimal digits"),
        (ParseError::Length, "more than 8 data bytes, or 64 of CAN FD"),
    ] {
        assert_eq!(error.to_string(), text);
    }
}

proptest! {
    #[test]
    fn what_is_written_is_read(micros in 0_u64..1 << 50, id: u32, wide: bool, data in proptest::collection::vec(any::<u8>(), 0..=8)) {
        let id = if wide { Id::extended(id >> 3) } else { Id::standard((id >> 21) as u16) };
        let frame = Frame::data(id.unwrap(), &data).unwrap();
        let text = line(micros * 1000, "can0", &frame).to_string();
        let read = parse(&text).unwrap().unwrap();
        prop_assert_eq!(read.content, Content::Frame(frame));
        let exact: f64 = text[1..text.find(')').unwrap()].parse().unwrap();
        prop_assert_eq!(read.time, exact);
    }

    #[test]
    fn times_are_the_nearest_numbers(stamp in "[0-9]{1,10}(\\.[0-9]{0,10})?") {
        let text = format!("({stamp}) can0 123#");
        let exact: f64 = stamp.parse().unwrap();
        prop_assert_eq!(parse(&text).unwrap().unwrap().time.to_bits(), exact.to_bits());
    }

    #[test]
    fn any_bytes_are_a_line_or_an_error(text in proptest::collection::vec(any::<u8>(), 0..60)) {
        let _ = Line::parse(&text);
        let with_head = [b"(1.5) can0 1".as_slice(), &text].concat();
        let _ = Line::parse(&with_head);
    }
}
