//! `docs/narx.dbc`: every message and signal as a CAN database, made from core's tables, at the factory
//! addresses.

use crate::{Made, decoded};
use narx_core::bus::narmotion::{Addresses, Field, MESSAGES, Meaning, Message, MessageKind};
use narx_core::dictionary::{Decimal, Dictionary, Kind, Parameter};
use narx_core::motor::guard::fault::FaultWord;
use narx_host::can_log::{identifier, message_name};
use std::fmt::Write;
use std::path::Path;

/// Makes the database.
///
/// # Errors
/// None.
pub fn make(_: &Path) -> Result<Made, String> {
    let text = render();
    let summary = format!("{} messages, {} bytes", MESSAGES.len(), text.len());
    Ok(Made { files: vec![("docs/narx.dbc".into(), text)], summary })
}

/// Longest name that every reader of the format accepts.
const NAME_MAX: usize = 32;

/// One signal of the database.
struct Signal {
    name: String,
    /// `M` for the multiplexer, `m7` for a signal that the value 7 selects.
    multiplex: String,
    /// Position of the highest bit, 0..=63 as [`Field::first_bit`].
    first_bit: u8,
    bits: u8,
    signed: bool,
    exponent: i8,
    range: (i64, i64),
    unit: &'static str,
    values: Vec<(u32, &'static str)>,
    comment: String,
}

/// Renders the database as text.
pub fn render() -> String {
    let mut out = String::from("VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: Master Drive\n");
    let mut comments = String::new();
    let mut values = String::new();
    for message in &MESSAGES {
        // Bit 31 marks a 29-bit identifier.
        let id = message.id(Addresses::FACTORY).encode().raw() | 1 << 31;
        let (sender, receiver) =
            if message.kind == MessageKind::SlaveTx { ("Drive", "Master") } else { ("Master", "Drive") };
        line(&mut out, format_args!("\nBO_ {id} {}: 8 {sender}", message_name(message)));
        for signal in message.fields().flat_map(|field| signals(&field)) {
            line(&mut out, format_args!(" SG_ {} {receiver}", signal.declaration()));
            if !signal.comment.is_empty() {
                line(
                    &mut comments,
                    format_args!("CM_ SG_ {id} {} \"{}\";", signal.name, quoted(&signal.comment)),
                );
            }
            if !signal.values.is_empty() {
                let list: String = signal
                    .values
                    .iter()
                    .map(|(value, name)| format!(" {value} \"{}\"", quoted(name)))
                    .collect();
                line(&mut values, format_args!("VAL_ {id} {}{list} ;", signal.name));
            }
        }
    }
    out + "\n" + &comments + "\n" + &values
}

/// Physical values of the database's signals in a message, from the raw values that the decoder read.
pub fn physical(message: &Message, values: &[decoded::Value]) -> Vec<(String, Decimal)> {
    let raw = |name| values.iter().find(|(known, _)| *known == name).map(|(_, value)| *value);
    let row = raw("Number").and_then(|number| Dictionary::row(number as u16));
    let mut physical = Vec::new();
    for field in message.fields() {
        let Some(value) = raw(field.name) else { continue };
        match (field.meaning, row) {
            (Meaning::Faults, _) => {
                let faults = FaultWord::from_bits_retain(value as u32);
                physical.extend(FaultWord::all().iter_names().map(|(name, flag)| {
                    (name.to_owned(), Decimal { digits: faults.contains(flag).into(), exponent: 0 })
                }));
            }
            (Meaning::ParameterValue, Some(row)) => {
                physical.push((parameter(&field, row).name, row.engineering(value as i32)));
            }
            _ => physical.push((identifier(field.name), Decimal { digits: value, exponent: field.exponent })),
        }
    }
    physical
}

/// Signals of a field in the database: one, one for each fault, or one for each parameter.
fn signals(field: &Field) -> Vec<Signal> {
    let range = match (field.signed, field.bits) {
        (true, bits) => (-(1 << (bits - 1)), (1 << (bits - 1)) - 1),
        (false, bits) => (0, (1 << bits) - 1),
    };
    let plain = Signal {
        name: identifier(field.name),
        multiplex: String::new(),
        first_bit: field.first_bit,
        bits: field.bits,
        signed: field.signed,
        exponent: field.exponent,
        range,
        unit: field.unit,
        values: Vec::new(),
        comment: String::new(),
    };
    match field.meaning {
        Meaning::Number => vec![plain],
        Meaning::Named(names) => {
            let values: Vec<_> =
                names.values.iter().map(|(value, name)| (u32::from(*value), *name)).collect();
            let last = values.iter().map(|(value, _)| *value).max().unwrap_or(0);
            vec![Signal { values, range: (0, last.into()), ..plain }]
        }
        Meaning::Faults => {
            FaultWord::all().iter_names().map(|(name, flag)| fault(field, name, flag)).collect()
        }
        Meaning::ParameterNumber => vec![Signal { multiplex: " M".into(), ..plain }],
        Meaning::ParameterValue => Dictionary::rows().map(|row| parameter(field, row)).collect(),
    }
}

fn fault(field: &Field, name: &str, flag: FaultWord) -> Signal {
    Signal {
        name: name.to_owned(),
        multiplex: String::new(),
        first_bit: field.first_bit + flag.bits().leading_zeros() as u8,
        bits: 1,
        signed: false,
        exponent: 0,
        range: (0, 1),
        unit: "-",
        values: Vec::new(),
        comment: String::new(),
    }
}

fn parameter(field: &Field, row: &Parameter) -> Signal {
    let mut name = format!("P{}_{}", row.number, identifier(row.name()));
    name.truncate(NAME_MAX);
    Signal {
        name: name.trim_end_matches('_').to_owned(),
        multiplex: format!(" m{}", row.number),
        first_bit: field.first_bit,
        bits: field.bits,
        signed: row.kind == Kind::I32,
        exponent: row.exponent,
        range: (row.min(), row.max()),
        unit: row.unit(),
        values: Vec::new(),
        comment: format!("{}: {}", row.name(), row.description()),
    }
}

impl Signal {
    fn declaration(&self) -> String {
        let Self { name, multiplex, bits, exponent, range: (min, max), .. } = self;
        // The format counts bits from the lowest of byte 0, and bytes from the left; it places a
        // big-endian signal by its highest bit.
        let start = self.first_bit / 8 * 8 + 7 - self.first_bit % 8;
        let sign = if self.signed { '-' } else { '+' };
        let scaled = |digits| Decimal { digits, exponent: *exponent };
        // The format uses the one-byte characters of Western Windows; files of this project use UTF-8.
        let unit = self.unit.replace("°C", "degC");
        let unit = if unit == "-" { "" } else { &unit };
        format!(
            "{name}{multiplex} : {start}|{bits}@0{sign} ({},0) [{}|{}] \"{unit}\"",
            scaled(1),
            scaled(*min),
            scaled(*max)
        )
    }
}

fn quoted(text: &str) -> String {
    text.replace('"', "'")
}

fn line(out: &mut String, text: std::fmt::Arguments<'_>) {
    // Writing to a string cannot fail.
    let _ = writeln!(out, "{text}");
}
