//! Tests of the description as a master reads it: the parameters in it, and damaged documents.

use crate::bench::IDENTITY;
use narx_core::bus::narmotion::Addresses;
use narx_core::bus::narmotion::{MESSAGES, MessageKind, Words};
use narx_core::description::Document;
use narx_core::dictionary::Category;
use narx_core::dictionary::{Decimal, Dictionary, PARAMETER_COUNT, Parameter};
use narx_core::master::{Described, DescribedParameter, DescriptionError, DescriptionReader, Reason};
use narx_core::motor::signal::DRIVE_SIGNALS;
use proptest::prelude::*;

fn text() -> String {
    let mut text = String::new();
    let document = Document { identity: IDENTITY, addresses: Addresses::FACTORY, tick_rate: 10_000 };
    document.write(&mut text).unwrap();
    text
}

/// All rows of a text, up to its end or its error.
fn rows(text: &[u8]) -> (Vec<Described>, Result<(), DescriptionError>) {
    let mut reader = DescriptionReader::new();
    let mut rows = Vec::new();
    for byte in text {
        match reader.handle_byte(*byte) {
            Ok(row) => rows.extend(row),
            Err(error) => {
                assert_eq!(reader.handle_byte(b'>'), Err(error), "there is no way on");
                return (
                    rows,
                    reader.finish().map_err(|same| {
                        assert_eq!(same, error);
                        error
                    }),
                );
            }
        }
    }
    (rows, reader.finish())
}

/// Rows of the parameters in a text.
fn read(text: &[u8]) -> (Vec<DescribedParameter>, Result<(), DescriptionError>) {
    let (rows, end) = rows(text);
    (rows.into_iter().filter_map(parameter).collect(), end)
}

fn parameter(row: Described) -> Option<DescribedParameter> {
    if let Described::Parameter(parameter) = row { Some(parameter) } else { None }
}

fn reason(text: &str) -> Reason {
    read(text.as_bytes()).1.expect_err(text).reason
}

fn is_same(row: &Parameter, described: &DescribedParameter) -> bool {
    let unit = if row.unit() == "-" { "" } else { row.unit() };
    (row.number, row.name(), unit, row.kind, row.exponent)
        == (described.number, &described.name, &described.unit, described.kind, described.exponent)
        && (row.min(), row.max(), row.default()) == (described.min, described.max, described.default)
        && (row.access, row.command, row.effect) == (described.access, described.command, described.effect)
}

#[test]
fn every_parameter_is_read_as_the_dictionary_has_it() {
    let (described, end) = read(text().as_bytes());
    assert_eq!(end, Ok(()));
    assert_eq!(described.len(), PARAMETER_COUNT);
    for (row, described) in Dictionary::rows().zip(&described) {
        assert!(is_same(row, described), "{row:?} {described:?}");
        let raw = row.factory_raw();
        assert_eq!(row.engineering(raw), described.engineering(raw));
        for raw in [row.min(), row.max(), row.min() - 1, row.max() + 1].map(|raw| raw as i32) {
            assert_eq!(row.accepts(raw), described.accepts(raw), "{} {raw}", row.number);
        }
    }
}

/// Categories, fields of messages and signals of the scope are those of the tables from which the document is
/// made.
#[test]
fn every_other_row_is_read_as_the_tables_have_it() {
    let (rows, end) = rows(text().as_bytes());
    assert_eq!(end, Ok(()));
    let unit = |unit: &'static str| if unit == "-" { "" } else { unit };
    let words = Words([0x8123, 0x4567, 0x89AB, 0xCDEF]);
    let (mut categories, mut signals) = (Category::ALL.iter(), DRIVE_SIGNALS.iter().enumerate());
    let mut fields = MESSAGES.iter().flat_map(|message| message.fields().map(move |field| (message, field)));
    for row in rows {
        match row {
            Described::Parameter(_) => {}
            Described::Category(read) => {
                let label = format!("{}-{}", read.number, read.name);
                assert_eq!(categories.next().unwrap().label(), label);
            }
            Described::Field(read) => {
                let (message, field) = fields.next().unwrap();
                let from_drive = message.kind == MessageKind::SlaveTx;
                assert_eq!((message.opcode.raw(), from_drive), (read.opcode, read.from_drive));
                assert_eq!((field.name, unit(field.unit)), (&*read.name, &*read.unit));
                assert_eq!(
                    (field.first_bit, field.bits, field.signed),
                    (read.first_bit, read.bits, read.signed)
                );
                let value = Decimal { digits: field.raw(words), exponent: field.exponent };
                assert_eq!(read.value(words), value, "{}", field.name);
            }
            Described::Signal(read) => {
                let (bit, signal) = signals.next().unwrap();
                assert_eq!((bit, signal.name), (read.bit.into(), &*read.name));
                assert_eq!((unit(signal.unit), signal.base), (&*read.unit, read.base));
            }
        }
    }
    assert!(categories.next().is_none() && fields.next().is_none() && signals.next().is_none());
}

#[test]
fn numbers_are_read_as_they_are_written() {
    for exponent in -9..=9 {
        for digits in [0, 1, -1, 10, 12_345, -700, i64::from(u32::MAX), i64::from(i32::MIN)] {
            let written = Decimal { digits, exponent }.to_string();
            let read = Decimal::parse(&written).unwrap();
            assert_eq!(read.rescaled(exponent), Some(digits), "{written}");
            assert_eq!(read.to_string(), written);
        }
    }
    for text in ["", "-", ".", "1.", ".5", "1e3", "+1", "1 ", "--1", "1.2.3", "9999999999999999999"] {
        assert_eq!(Decimal::parse(text), None, "{text}");
    }
    assert_eq!(Decimal { digits: 15, exponent: -1 }.rescaled(0), None, "1.5 is no whole number");
    assert_eq!(Decimal { digits: i64::MAX, exponent: 0 }.rescaled(-1), None);
    assert_eq!(Decimal { digits: 1, exponent: 18 }.rescaled(-18), None);
}

/// A document that is cut anywhere is reported as incomplete, and the rows before the cut are right.
#[test]
fn every_truncation_is_noticed() {
    let text = text();
    let end = text.trim_end().len();
    let (all, _) = read(text.as_bytes());
    let mut reader = DescriptionReader::new();
    let mut parameters = 0;
    for (length, byte) in text.bytes().enumerate().take(end) {
        let error = reader.clone().finish().unwrap_err();
        assert_eq!((error.byte as usize, error.reason), (length, Reason::Incomplete));
        assert_eq!(error.line as usize, text[..floor(&text, length)].matches('\n').count() + 1);
        if let Some(parameter) = reader.handle_byte(byte).unwrap().and_then(parameter) {
            assert_eq!(parameter, all[parameters]);
            parameters += 1;
        }
    }
    assert_eq!((parameters, reader.finish()), (PARAMETER_COUNT, Ok(())));
}

/// Next position that is not inside a character.
fn floor(text: &str, place: usize) -> usize {
    (0..=place).rev().find(|place| text.is_char_boundary(*place)).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Flipped bytes give an error with a position after the first of them, or change the flipped text and
    /// nothing else.
    #[test]
    fn spoiled_documents_are_refused_or_read(flips in prop::collection::vec((any::<prop::sample::Index>(), 1..=255_u8), 1..4)) {
        let text = text();
        let mut spoiled = text.clone().into_bytes();
        let mut places = Vec::new();
        for (index, flip) in flips {
            let place = index.index(spoiled.len());
            spoiled[place] ^= flip;
            places.push(place);
        }
        let (described, end) = read(&spoiled);
        match end {
            Ok(()) => {
                let wrong = Dictionary::rows().zip(&described).filter(|(row, described)| !is_same(row, described));
                prop_assert!(wrong.count() <= places.len());
            }
            Err(error) => {
                let first = *places.iter().min().unwrap();
                prop_assert!(error.byte as usize >= first, "{error}, flipped at {places:?}");
                let line = spoiled[..error.byte as usize].iter().filter(|byte| **byte == b'\n').count() + 1;
                prop_assert_eq!(error.line as usize, line);
            }
        }
        prop_assert!(described.len() <= PARAMETER_COUNT);
    }

    #[test]
    fn noise_is_no_description(noise in prop::collection::vec(any::<u8>(), 0..400)) {
        prop_assert!(read(&noise).1.is_err());
    }

    /// Markup without meaning, which gets further than random bytes, ends the reading.
    #[test]
    fn nonsense_in_markup_ends(parts in prop::collection::vec(0..12_usize, 0..60)) {
        const PARTS: [&str; 12] = ["<description format=\"1\">", "<parameters>", "<parameter", " number=\"1\"", " min=\"0\"", ">",
            "/>", "</parameter>", "</parameters>", "</description>", "text", "<a b=\"c\"/>"];
        let text: String = parts.into_iter().map(|part| PARTS[part]).collect();
        let (described, _) = read(text.as_bytes());
        prop_assert_eq!(described.len(), 0);
    }
}

const HEAD: &str = "<?xml version=\"1.0\"?>\n<description format=\"1\">\n<parameters>\n";
const ROW: &str = "<parameter number=\"5\" category=\"01\" name=\"n\" unit=\"V\" type=\"uint16\" scale=\"0.1\" min=\"0\" \
                   max=\"10.5\" factory=\"1\" access=\"live\" acts=\"reboot\">text</parameter>";

const OTHER_ROWS: &str = "<description format=\"1\"><categories><category number=\"01\" name=\"c\"/></categories><messages><message name=\"m\" \
                          opcode=\"201\" from=\"drive\"><field name=\"f\" bit=\"16\" bits=\"16\" type=\"int\" scale=\"0.1\"/></message></messages>\
                          <scope><signal bit=\"3\" name=\"s\" base=\"5\"/></scope></description>";

fn with_row(row: &str) -> String {
    format!("{HEAD}{row}\n</parameters>\n</description>\n")
}

#[test]
fn what_is_wrong_is_named() {
    assert_eq!(read(with_row(ROW).as_bytes()).1, Ok(()));
    let attribute = Reason::Attribute;
    for (old, new, expected) in [
        (" number=\"5\"", "", attribute("number")),
        (" category=\"01\"", "", attribute("category")),
        ("\"01\"", "\"00001\"", attribute("category")),
        (" number=\"5\"", " number=\"65536\"", attribute("number")),
        (" number=\"5\"", " number=\"5\" number=\"5\"", attribute("number")),
        ("uint16", "uint8", attribute("type")),
        ("0.1", "0.2", attribute("scale")),
        ("0.1", "0", attribute("scale")),
        ("10.5", "10.55", attribute("max")),
        ("10.5", "6553.6", attribute("max")),
        ("min=\"0\"", "min=\"-1\"", attribute("max")),
        ("min=\"0\"", "min=\"10.6\"", attribute("max")),
        ("factory=\"1\"", "factory=\"10.6\"", attribute("factory")),
        ("live", "dead", attribute("access")),
        ("acts=\"reboot\"", "acts=\"never\"", attribute("acts")),
        ("text", "a &amp; b", Reason::Markup),
        ("text", "<!-- -->", Reason::Markup),
        ("text", "<?xml version=\"1.0\"?>", Reason::Markup),
        ("text", "<empty/ >", Reason::Markup),
        (" unit", " unit unit", Reason::Markup),
        (" access=\"live\"", " access>", Reason::Markup),
        ("</parameter>", "</parameters>", Reason::Nesting),
        ("text", "<b><c></c></b>", Reason::Nesting),
        ("category", "averyveryverylongname", Reason::TooLong),
        ("\"n\"", &format!("\"{}\"", "n".repeat(65)), Reason::TooLong),
        ("\"V\"", "\"\u{7f}\"", Reason::Markup),
    ] {
        assert!(ROW.contains(old), "{old}");
        assert_eq!(reason(&with_row(&ROW.replacen(old, new, 1))), expected, "{old} {new}");
    }
    for (old, new, expected) in [
        (" opcode=\"201\"", "", attribute("opcode")),
        ("\"drive\"", "\"nobody\"", attribute("from")),
        (" bit=\"16\"", "", attribute("bit")),
        ("bit=\"16\"", "bit=\"64\"", attribute("bit")),
        ("bits=\"16\"", "bits=\"0\"", attribute("bits")),
        ("bits=\"16\"", "bits=\"49\"", attribute("bits")),
        ("bit=\"16\" bits=\"16\"", "bit=\"60\" bits=\"5\"", attribute("bits")),
        ("\"int\"", "\"float\"", attribute("type")),
        ("0.1", "0.3", attribute("scale")),
        ("bit=\"3\"", "bit=\"32\"", attribute("bit")),
        ("base=\"5\"", "base=\"0\"", attribute("base")),
        ("base=\"5\"", "base=\"-5\"", attribute("base")),
        (" base=\"5\"", "", attribute("base")),
        (" name=\"s\"", "", attribute("name")),
    ] {
        assert!(OTHER_ROWS.contains(old), "{old}");
        assert_eq!(reason(&OTHER_ROWS.replacen(old, new, 1)), expected, "{old} {new}");
    }
    assert_eq!(rows(OTHER_ROWS.as_bytes()).1, Ok(()));
    assert_eq!(reason("<description format=\"2\">"), Reason::Format);
    assert_eq!(reason("<description>"), Reason::Format);
    assert_eq!(reason("<other format=\"1\">"), Reason::Format);
    assert_eq!(reason(&(with_row(ROW) + "<more/>")), Reason::Markup);
    let error = read(with_row(&ROW.replacen("live", "dead", 1)).as_bytes()).1.unwrap_err();
    let byte = HEAD.len() + ROW.find("live\"").unwrap() + 4;
    assert_eq!((error.line, error.byte as usize), (4, byte));
    let expected = format!("description, line 4, byte {byte}: attribute \"access\" is missing or wrong");
    assert_eq!(error.to_string(), expected);
}

/// Attributes of later versions are ignored.
#[test]
fn what_is_new_is_passed_over() {
    let row = ROW.replacen(" unit", " news=\"1\" unit", 1);
    let (described, end) = read(with_row(&format!("<news a=\"b\"/>{row}")).as_bytes());
    assert_eq!((described.len(), end), (1, Ok(())));
    assert_eq!(described[0].max, 105);
}

/// A scale may be above one, though no parameter of ours has one.
#[test]
fn a_scale_may_be_above_one() {
    let row = ROW.replacen("0.1", "100", 1).replacen("10.5", "4200", 1).replacen(
        "factory=\"1\"",
        "factory=\"300\"",
        1,
    );
    let (described, end) = read(with_row(&row).as_bytes());
    assert_eq!(end, Ok(()));
    assert_eq!((described[0].exponent, described[0].max, described[0].default), (2, 42, 3));
}
