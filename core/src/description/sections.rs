//! The lines of the document: a head, the rows of each table between its tags, and the end.
//!
//! Texts of the tables are written without escaping: none has a character of markup
//! (`tests/protocol/description.rs`).

use super::{Document, FORMAT, LOG_RECORD, LogEntry};
use crate::bus::narmotion::{Field, MESSAGES, Meaning, MessageKind, NAMES, Names};
use crate::dictionary::{Category, Decimal, Dictionary, Effect, PARAMETER_COUNT, Parameter};
use crate::motor::guard::fault::{Cause, FaultWord};
use crate::motor::machine::state::State;
use crate::motor::signal::{DRIVE_SIGNALS, SignalRow};
use bitflags::Flags;
use core::fmt::{self, Write};

/// A table of the document.
struct Section {
    /// Name of the element around its rows.
    name: &'static str,
    /// Number of its rows.
    rows: usize,
    /// Writes a row; nothing for one that is not there.
    write: fn(&Document, usize, &mut dyn Write) -> fmt::Result,
}

const SECTIONS: [Section; 9] = [
    section("categories", Category::ALL.len(), |_, row, out| {
        Category::ALL.get(row).map_or(Ok(()), |row| category(*row, out))
    }),
    section("parameters", PARAMETER_COUNT, |_, row, out| {
        Dictionary::rows().nth(row).map_or(Ok(()), |row| parameter(row, out))
    }),
    section("messages", MESSAGES.len(), message),
    section("meanings", NAMES.len(), |_, row, out| NAMES.get(row).map_or(Ok(()), |row| names(row, out))),
    section("states", State::ALL.len(), |_, row, out| {
        State::ALL.get(row).map_or(Ok(()), |row| state(*row, out))
    }),
    section("faults", FaultWord::FLAGS.len(), fault),
    section("causes", Cause::TABLE.len(), cause),
    section("scope", DRIVE_SIGNALS.len(), |_, row, out| {
        DRIVE_SIGNALS.get(row).map_or(Ok(()), |signal| scope_signal(row, signal, out))
    }),
    section("log", LOG_RECORD.len(), |_, row, out| {
        LOG_RECORD.get(row).map_or(Ok(()), |row| log_entry(row, out))
    }),
];

/// Lines of the document: head, end, and of each section its rows and two tags.
pub(super) const LINES: usize = {
    let mut lines = 2;
    let mut index = 0;
    while index < SECTIONS.len() {
        lines += SECTIONS[index].rows + 2;
        index += 1;
    }
    lines
};

impl Document {
    /// Writes a line with its end; nothing behind the last one.
    pub(super) fn write_line(&self, line: u16, out: &mut dyn Write) -> fmt::Result {
        let Some(mut row) = usize::from(line).checked_sub(1) else { return self.head(out) };
        for section in &SECTIONS {
            let (name, end) = (section.name, section.rows + 1);
            if row == 0 {
                return writeln!(out, "<{name}>");
            } else if row < end {
                return (section.write)(self, row - 1, out);
            } else if row == end {
                return writeln!(out, "</{name}>");
            }
            row -= end + 1;
        }
        if row == 0 { writeln!(out, "</description>") } else { Ok(()) }
    }

    fn head(&self, out: &mut dyn Write) -> fmt::Result {
        let Self { identity, addresses, tick_rate } = self;
        writeln!(
            out,
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<description format=\"{FORMAT}\" build=\"{}\" modified=\"{}\" \
             date=\"{}\" hardware=\"{}\" software=\"{}.{}\" drive=\"{}\" master=\"{}\" rate=\"{tick_rate}\">",
            identity.build_number,
            u8::from(identity.source_modified),
            identity.build_date,
            identity.hardware_release,
            identity.software_release >> 8,
            identity.software_release & 0xFF,
            addresses.drive,
            addresses.master,
        )
    }
}

const fn section(
    name: &'static str,
    rows: usize,
    write: fn(&Document, usize, &mut dyn Write) -> fmt::Result,
) -> Section {
    Section { name, rows, write }
}

fn category(category: Category, out: &mut dyn Write) -> fmt::Result {
    let (number, name) = number_and_name(category);
    writeln!(out, "<category number=\"{number}\" name=\"{}\"/>", name)
}

/// The two halves of the printed label.
fn number_and_name(category: Category) -> (&'static str, &'static str) {
    let label = category.label();
    let hyphen = label.bytes().position(|byte| byte == b'-').unwrap_or(0);
    (label.get(..hyphen).unwrap_or(""), label.get(hyphen + 1..).unwrap_or(""))
}

fn parameter(row: &Parameter, out: &mut dyn Write) -> fmt::Result {
    let value = |digits| Decimal { digits, exponent: row.exponent };
    let (category, _) = number_and_name(row.category);
    write!(
        out,
        "<parameter number=\"{}\" category=\"{category}\" name=\"{}\"{} type=\"{}\" scale=\"{}\" min=\"{}\" max=\"{}\" \
         factory=\"{}\"",
        row.number,
        row.name(),
        Unit(row.unit()),
        row.kind.label(),
        value(1),
        value(row.min()),
        value(row.max()),
        value(row.default()),
    )?;
    write!(out, " access=\"{}\"", row.access.label())?;
    if row.command {
        out.write_str(" command=\"1\"")?;
    }
    if row.effect != Effect::Immediately {
        write!(out, " acts=\"{}\"", row.effect.label())?;
    }
    writeln!(out, ">{}</parameter>", row.description())
}

fn message(document: &Document, row: usize, out: &mut dyn Write) -> fmt::Result {
    let Some(message) = MESSAGES.get(row) else { return Ok(()) };
    let from = if message.kind == MessageKind::SlaveTx { "drive" } else { "master" };
    write!(
        out,
        "<message name=\"{}\" opcode=\"{}\" type=\"{}\" id=\"{}\" from=\"{from}\">",
        message.name,
        message.opcode.raw(),
        message.kind as u8,
        message.id(document.addresses).encode(),
    )?;
    message.fields().try_for_each(|row| field(&row, out))?;
    writeln!(out, "</message>")
}

fn field(field: &Field, out: &mut dyn Write) -> fmt::Result {
    write!(
        out,
        "<field name=\"{}\" bit=\"{}\" bits=\"{}\" type=\"{}\"",
        field.name,
        field.first_bit,
        field.bits,
        if field.signed { "int" } else { "uint" },
    )?;
    match field.meaning {
        Meaning::Number if field.unit == "-" => Ok(()),
        Meaning::Number => {
            write!(out, "{} scale=\"{}\"", Unit(field.unit), Decimal { digits: 1, exponent: field.exponent })
        }
        Meaning::Named(names) => write!(out, " names=\"{}\"", names.of),
        Meaning::Faults => out.write_str(" refers=\"faults\""),
        Meaning::ParameterNumber => out.write_str(" refers=\"parameter number\""),
        Meaning::ParameterValue => out.write_str(" refers=\"parameter value\""),
    }?;
    out.write_str("/>")
}

fn names(names: &Names, out: &mut dyn Write) -> fmt::Result {
    write!(out, "<meaning name=\"{}\">", names.of)?;
    for (value, name) in names.values {
        write!(out, "<value number=\"{value}\" name=\"{}\"/>", name)?;
    }
    writeln!(out, "</meaning>")
}

fn state(state: State, out: &mut dyn Write) -> fmt::Result {
    let (number, driving) = (state as u8, u8::from(state.is_driving()));
    writeln!(out, "<state number=\"{number}\" name=\"{}\" driving=\"{driving}\"/>", state.name())
}

fn fault(_: &Document, row: usize, out: &mut dyn Write) -> fmt::Result {
    let Some(flag) = FaultWord::FLAGS.get(row) else { return Ok(()) };
    let critical = if *flag.value() == FaultWord::TEMPERATURE_WARNING {
        "never"
    } else if FaultWord::FORCED.contains(*flag.value()) {
        "always"
    } else {
        "masked"
    };
    let bit = flag.value().bits().trailing_zeros();
    writeln!(out, "<fault bit=\"{bit}\" name=\"{}\" critical=\"{critical}\"/>", flag.name())
}

fn cause(_: &Document, row: usize, out: &mut dyn Write) -> fmt::Result {
    let Some(row) = Cause::TABLE.get(row) else { return Ok(()) };
    let (code, qualification) =
        (row.cause as u16, Decimal { digits: row.qualification.into(), exponent: -6 });
    writeln!(
        out,
        "<cause code=\"{code}\" bit=\"{}\" unit=\"s\" qualification=\"{qualification}\">{}</cause>",
        code >> 8,
        row.meaning
    )
}

fn scope_signal(bit: usize, signal: &SignalRow, out: &mut dyn Write) -> fmt::Result {
    let SignalRow { name, unit, base, .. } = signal;
    writeln!(out, "<signal bit=\"{bit}\" name=\"{}\"{} base=\"{base}\"/>", name, Unit(unit))
}

fn log_entry(entry: &LogEntry, out: &mut dyn Write) -> fmt::Result {
    let LogEntry { name, kind, unit, parameters, per_value } = *entry;
    write!(out, "<entry name=\"{name}\" type=\"{}\"{}", kind.label(), Unit(unit))?;
    if let Some((first, last)) = parameters {
        write!(out, " first=\"{first}\" last=\"{last}\"")?;
    }
    if per_value {
        out.write_str(" per=\"value\"")?;
    }
    out.write_str("/>\n")
}

/// The attribute `unit`, where there is one.
struct Unit(&'static str);

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0 == "-" { Ok(()) } else { write!(f, " unit=\"{}\"", self.0) }
    }
}
