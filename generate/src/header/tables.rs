//! Parts of the header from core's tables: messages with their fields, the fields' named values, faults with
//! their causes, and the TX-Driver's entries.

use narx_core::bus::narmotion::{Field, MESSAGES, Meaning, Message, NAMES, Opcode};
use narx_core::eddycan::OBJECTS;
use narx_core::motor::guard::fault::{Cause, FaultWord};
use narx_host::can_log::{identifier, message_name};
use std::fmt::Write;

/// Renders the definitions in C99.
pub(super) fn definitions() -> String {
    let mut out = String::new();
    let meanings: Vec<Meaning> = messages().flat_map(Message::fields).map(|field| field.meaning).collect();
    let named = NAMES.iter().filter(|names| meanings.contains(&Meaning::Named(names)));
    for names in named.filter(|names| names.values.len() > 2) {
        let of = constant(names.of);
        let values =
            names.values.iter().map(|(value, name)| (format!("{of}_{}", constant(name)), u32::from(*value)));
        enumeration(&mut out, &format!("Values of the field \"{}\".", names.of), &of.to_lowercase(), values);
    }
    let faults = FaultWord::all();
    for (name, flag) in faults.iter_names() {
        define(&mut out, "Bit of the fault word (Table 9).", &format!("FAULT_{name}"), flag.bits());
    }
    for row in Cause::TABLE {
        let name = format!("CAUSE_{}", constant(&spaced(&format!("{:?}", row.cause))));
        define(
            &mut out,
            &format!("Extended fault code: {}.", row.meaning),
            &name,
            u32::from(row.cause as u16),
        );
    }
    for object in &OBJECTS {
        let name = format!("TX_ENTRY_{}", constant(&spaced(&format!("{:?}", object.entry))));
        let address = match object.subindex {
            Some(subindex) => format!("{:04X}h.{subindex}", object.index),
            None => format!("{:04X}h", object.index),
        };
        let about =
            format!("{address} {}, {} to {}. {}", object.name, object.min, object.max, object.description);
        define(&mut out, &about, &name, object.entry as u32);
    }
    let kinds = messages().map(|message| {
        let kind = (message.kind as u32) << 9 | u32::from(message.opcode.raw());
        (format!("MESSAGE_{}", constant(&message_name(message))), kind)
    });
    let about = "Which message: type and opcode, the low 11 bits of its identifier (PROTOCOL.md, section 2).";
    enumeration(&mut out, about, "message_kind", kinds);
    fields(&mut out);
    out
}

/// Messages that the library knows: it is built without programming (feature `update` of core).
fn messages() -> impl Iterator<Item = &'static Message> {
    let update = Opcode::UPDATE_DEVICE.raw()..=Opcode::UPDATE_CONFIRM.raw();
    MESSAGES.iter().filter(move |message| !update.contains(&message.opcode.raw()))
}

/// Writes the union of all messages' fields, which the library knows as `narx_fields_t`: words.
fn fields(out: &mut String) {
    let most = messages().map(|message| message.fields().count()).max().unwrap_or(0);
    define(out, "Fields that a message has at most.", "FIELDS_MAX", most as u32);
    out.push_str(
        "/// The fields of a message: those of its own kind count. Raw numbers, with scale and unit beside each.\n\
         typedef union narx_fields_t {\n    /// In the order of their bits; a signed one as its bits.\n    \
         uint32_t raw[NARX_FIELDS_MAX];\n",
    );
    for message in messages().filter(|message| message.fields().next().is_some()) {
        line(out, format_args!("    /// Fields of {}.", message_name(message)));
        out.push_str("    struct {\n");
        for field in message.fields() {
            let kind = if field.signed { "int32_t" } else { "uint32_t" };
            line(out, format_args!("        {kind} {};{}", member(&field), about(&field)));
        }
        line(out, format_args!("    }} {};", message_name(message).to_lowercase()));
    }
    out.push_str("} narx_fields_t;\n\n");
}

fn member(field: &Field) -> String {
    identifier(field.name).to_lowercase()
}

/// Comment after a member: scale, unit and meaning.
fn about(field: &Field) -> String {
    let unit = field.unit.replace('°', "deg ");
    let text = match field.meaning {
        Meaning::Number if field.unit == "-" => String::new(),
        Meaning::Number if field.exponent == 0 => unit,
        Meaning::Number => format!("10^{} {unit}", field.exponent),
        Meaning::Named(names) if names.values.len() > 2 => {
            format!("a narx_{}_t", constant(names.of).to_lowercase())
        }
        Meaning::Named(names) => {
            names.values.iter().map(|(value, name)| format!("{value} {name}")).collect::<Vec<_>>().join(", ")
        }
        Meaning::Faults => String::from("sum of NARX_FAULT_*"),
        Meaning::ParameterNumber => String::from("a NARX_PARAMETER_*"),
        Meaning::ParameterValue => String::from("its unit and scale: PROTOCOL.md"),
    };
    if text.is_empty() { text } else { format!(" ///< {text}") }
}

fn enumeration(out: &mut String, about: &str, name: &str, values: impl Iterator<Item = (String, u32)>) {
    line(out, format_args!("/// {about}\ntypedef enum narx_{name}_t {{"));
    for (name, value) in values {
        line(out, format_args!("    NARX_{name} = {value},"));
    }
    line(out, format_args!("}} narx_{name}_t;\n"));
}

fn define(out: &mut String, about: &str, name: &str, value: u32) {
    let value = if value > 9 { format!("0x{value:X}u") } else { value.to_string() };
    line(out, format_args!("/// {about}\n#define NARX_{name} {value}\n"));
}

/// Spells a name as a constant of C.
fn constant(name: &str) -> String {
    identifier(name).to_uppercase()
}

/// Separates words: `NodeId` as `Node Id`, `Filter1` as `Filter 1`.
fn spaced(name: &str) -> String {
    let mut out = String::new();
    for letter in name.chars() {
        if !out.is_empty() && (letter.is_ascii_uppercase() || letter.is_ascii_digit()) {
            out.push(' ');
        }
        out.push(letter);
    }
    out
}

fn line(out: &mut String, text: std::fmt::Arguments<'_>) {
    // Writing to a string cannot fail.
    let _ = writeln!(out, "{text}");
}
