//! Test that the tables of the drive in PROTOCOL.md are made from the code and up to date.

use narx_core::bus::Id;
use narx_core::bus::narmotion::{Addresses, MESSAGES, Meaning, MessageId, NAMES, SIGNALS};
use narx_core::description::{LOG_RECORD, LogEntry};
use narx_core::dictionary::{Access, Decimal, Dictionary, Effect, Kind, Parameter};
use narx_core::motor::guard::fault::Cause;
use narx_core::motor::signal::DRIVE_SIGNALS;
use narx_tests::{Block, check_blocks, protocol};
use std::fmt::Write;

const BLOCKS: [Block; 10] = [
    ("causes", causes),
    ("categories", categories),
    ("general", || parameters(0..78)),
    ("control", || parameters(78..122)),
    ("own", || parameters(256..u16::MAX)),
    ("signals", signals),
    ("fields", fields),
    ("names", names),
    ("scope", scope),
    ("record", record),
];

fn causes() -> String {
    let mut out = String::from("| code | bit | cause | qualification, us |\n|---|---|---|---|\n");
    for row in Cause::TABLE {
        let code = row.cause as u16;
        writeln!(out, "| {code:04X}h | {} | {} | {} |", code >> 8, row.meaning, row.qualification).unwrap();
    }
    out
}

fn signals() -> String {
    let mut out = String::from("| frame | word | signal | type | unit | step |\n|---|---|---|---|---|---|\n");
    for signal in SIGNALS {
        let frame = signal.opcode.raw() - 200;
        let last = signal.word + signal.words - 1;
        let words =
            if signal.words == 1 { signal.word.to_string() } else { format!("{}-{last}", signal.word) };
        let kind = match (signal.signed, signal.words) {
            (true, 1) => "int16",
            (true, _) => "int32",
            (false, _) => "uint16, 0 or 1",
        };
        let step = Decimal { digits: 1, exponent: signal.exponent };
        let (name, unit) = (signal.name, signal.unit);
        writeln!(out, "| MEASUREMENT_{frame} | {words} | {name} | {kind} | {unit} | {step} |").unwrap();
    }
    out
}

fn fields() -> String {
    let mut out = String::from(
        "| message | type | word | bits | field | unit | values |\n|---|---|---|---|---|---|---|\n",
    );
    for message in MESSAGES.iter().filter(|message| !message.name.starts_with("MEASUREMENT")) {
        for field in message.fields() {
            let (word, high) = (field.first_bit / 16, 15 - field.first_bit % 16);
            let (words, bits) = match field.bits {
                32 => (format!("{word}-{}", word + 1), "all".into()),
                16 => (word.to_string(), "all".into()),
                1 => (word.to_string(), high.to_string()),
                length => (word.to_string(), format!("{high}-{}", high + 1 - length)),
            };
            let values = match field.meaning {
                Meaning::Number if field.signed => "int16",
                Meaning::Number => "",
                Meaning::Named(names) => names.of,
                Meaning::Faults => "section 4",
                Meaning::ParameterNumber | Meaning::ParameterValue => "section 5",
            };
            let (kind, name, unit) = (message.kind as u8, field.name, field.unit);
            writeln!(out, "| {} | {kind} | {words} | {bits} | {name} | {unit} | {values} |", message.name)
                .unwrap();
        }
    }
    out
}

fn names() -> String {
    let mut out = String::from("| values | |\n|---|---|\n");
    for names in NAMES {
        let values: Vec<String> =
            names.values.iter().map(|(value, name)| format!("{value} {name}")).collect();
        writeln!(out, "| {} | {} |", names.of, values.join(", ")).unwrap();
    }
    out
}

fn scope() -> String {
    let mut out = String::from("| bit | signal | base | unit |\n|---|---|---|---|\n");
    for (bit, signal) in DRIVE_SIGNALS.iter().enumerate() {
        writeln!(out, "| {bit} | {} | {} | {} |", signal.name, signal.base, signal.unit).unwrap();
    }
    out
}

/// Table with the words of each part of a record: those of a value repeat, and the parts after them follow
/// all n values.
fn record() -> String {
    let mut out = String::from("| words | part | type | unit | parameters |\n|---|---|---|---|---|\n");
    let words = |entry: &LogEntry| if entry.kind == Kind::U16 { 1 } else { 2 };
    let stride: usize = LOG_RECORD.iter().filter(|entry| entry.per_value).map(words).sum();
    let (mut place, mut suffix) = (0, String::new());
    for (index, entry) in LOG_RECORD.iter().enumerate() {
        if entry.per_value {
            suffix = format!(" + {stride} i");
        } else if index > 0 && LOG_RECORD[index - 1].per_value {
            (place, suffix) = (place - stride, format!(" + {stride} n"));
        }
        let first = format!("{place}{suffix}");
        place += words(entry);
        let at = if words(entry) == 1 { first } else { format!("{first}, {}{suffix}", place - 1) };
        let parameters = match entry.parameters {
            None => String::new(),
            Some((first, last)) if first == last => first.to_string(),
            Some((first, last)) => format!("{first} to {last}"),
        };
        let (name, kind, unit) = (entry.name, entry.kind.label(), entry.unit);
        writeln!(out, "| {at} | {name} | {kind} | {unit} | {parameters} |").unwrap();
    }
    out
}

fn categories() -> String {
    let mut out = String::from("| category | written |\n|---|---|\n");
    let mut labels: Vec<&str> = Vec::new();
    for category in Dictionary::rows().map(|row| row.category) {
        if labels.contains(&category.label()) {
            continue;
        }
        labels.push(category.label());
        let rows = || Dictionary::rows().filter(move |row| row.category == category);
        let access = match category.access() {
            _ if rows().all(|row| row.access == Access::ReadOnly) => "by the drive alone",
            Access::Live => "live",
            _ => "stopped",
        };
        writeln!(out, "| {} | {access} |", category.label()).unwrap();
    }
    out
}

fn parameters(numbers: std::ops::Range<u16>) -> String {
    let mut out = String::from(
        "| no. | cat. | name | unit | type | step | range | factory | write | acts | meaning |\n\
         |---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for row in Dictionary::rows().filter(|row| numbers.contains(&row.number)) {
        writeln!(out, "{}", parameter(row)).unwrap();
    }
    out
}

fn parameter(row: &Parameter) -> String {
    let value = |digits| Decimal { digits, exponent: row.exponent };
    let access = row.access.label();
    let acts = match (row.access, row.command, row.effect) {
        (Access::ReadOnly, ..) => "",
        (_, true, Effect::NextStart) => "on a rising edge, at the next start",
        (_, true, _) => "on a rising edge",
        (_, _, Effect::Immediately) => "at once",
        (_, _, Effect::NextStart) => "at the next start",
        (_, _, Effect::Reboot) => "after store and reboot",
    };
    format!(
        "| {} | {} | {} | {} | {} | {} | {} to {} | {} | {access} | {acts} | {} |",
        row.number,
        row.category.label().split('-').next().unwrap(),
        row.name(),
        row.unit(),
        row.kind.label(),
        value(1),
        value(row.min()),
        value(row.max()),
        value(row.default()),
        row.description(),
    )
}

#[test]
fn generated_tables_are_up_to_date() {
    check_blocks(&BLOCKS);
}

/// The message table is written by hand: each identifier must match its opcode and type.
#[test]
fn identifiers_in_the_message_table_agree_with_the_code() {
    let text = protocol();
    let mut found = Vec::new();
    for line in text.lines() {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let [_, opcode, _, kind, identifier, direction, ..] = cells[..] else { continue };
        let (Ok(opcode), Ok(kind), Ok(raw)) =
            (opcode.parse::<u16>(), kind.parse::<u8>(), u32::from_str_radix(identifier, 16))
        else {
            continue;
        };
        if !["M to D", "D to M"].contains(&direction) {
            continue;
        }
        let id = MessageId::decode(Id::extended(raw).unwrap()).unwrap();
        assert_eq!((id.opcode.raw(), id.kind as u8), (opcode, kind), "{line}");
        let composed = match direction {
            "D to M" => Addresses::FACTORY.from_drive(id.opcode),
            _ => Addresses::FACTORY.to_drive(id.kind, id.opcode),
        };
        assert_eq!(id, composed, "{line}");
        found.push((cells[2].to_owned(), id));
    }
    let table: Vec<_> =
        MESSAGES.iter().map(|row| (row.name.to_owned(), row.id(Addresses::FACTORY))).collect();
    assert_eq!(
        found.len(),
        33 + 11,
        "the 32 identifiers of Figure 14, the request of REBOOT, and programming"
    );
    assert!(table.iter().all(|row| found.contains(row)) && table.len() == found.len());
}

/// The meaning of each code of an update is in the document, where it is written by hand.
#[test]
fn codes_of_an_update_are_told() {
    let text = protocol();
    let codes = NAMES.iter().find(|names| names.of == "update code").unwrap().values;
    for (code, name) in codes {
        let row = format!("| {code} {name} | ");
        assert!(text.lines().any(|line| line.starts_with(&row)), "{row}");
    }
}
