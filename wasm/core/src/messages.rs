//! Decoded frames: messages with named fields.

use js_sys::{Array, Object};
use narx_core::bus::narmotion::{Field, MESSAGES, Meaning, Message, MessageKind, Words};
use narx_core::bus::{Frame, Id};
use narx_core::dictionary::{Decimal, Dictionary};
use narx_core::motor::FaultWord;
use narx_host::can_log::{Value, message_name, node};
use narx_wasm_values::frame;
use narx_wasm_values::options::set;
use wasm_bindgen::prelude::*;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** A message of the drive or its master. `name` determines the type of `values`. */
export type DriveMessage = {
    [Name in keyof DriveValues]: {
        readonly protocol: "narmotion";
        /** Name in the CAN database. */
        readonly name: Name;
        readonly opcode: number;
        /** True if a drive sends it, false if its master does. */
        readonly fromDrive: boolean;
        readonly source: number;
        readonly destination: number;
        /** Values by field: numbers in their units, names of named values. */
        readonly values: DriveValues[Name];
        /** Units by field; empty for plain numbers. */
        readonly units: { readonly [Field in keyof DriveValues[Name]]: string };
    };
}[keyof DriveValues];

/** A message of a TX-Driver or its master (eddyCAN). */
export type NodeMessage = {
    [Name in keyof NodeValues]: {
        readonly protocol: "eddycan";
        /** Name in Table 3 of the specification. */
        readonly name: Name;
        /** True if a node sends it, false if its master does. */
        readonly fromNode: boolean;
        /** Values by signal. Signals that a PDO does not carry are absent. */
        readonly values: NodeValues[Name];
        readonly units: { readonly [Signal in keyof NodeValues[Name]]: string };
    };
}[keyof NodeValues];
"#;

/// Decodes a frame, by the tables of PROTOCOL.md: of the drive with 29 bits, of TX-Drivers with 11;
/// `undefined` if neither protocol has such a frame. `encoder`: PDOs of 8 bytes contain the encoder, which
/// the frame itself does not show.
#[wasm_bindgen(unchecked_return_type = "DriveMessage | NodeMessage | undefined")]
pub fn decode(
    #[wasm_bindgen(unchecked_param_type = "Frame")] frame: &JsValue,
    encoder: Option<bool>,
) -> Result<JsValue, JsValue> {
    let frame = frame::parse(frame)?;
    let found = match frame.id() {
        Id::Extended { .. } => drive_message(&frame),
        Id::Standard { .. } => node_message(&frame, encoder.unwrap_or(false)),
    };
    Ok(found.map_or(JsValue::UNDEFINED, JsValue::from))
}

fn drive_message(frame: &Frame) -> Option<Object> {
    let (id, words) = Words::of(frame).ok()?;
    let message = Message::of(id)?;
    let (values, units) = fields(message, words);
    let shaped = Object::new();
    set(&shaped, "protocol", "narmotion");
    set(&shaped, "name", message_name(message));
    set(&shaped, "opcode", message.opcode.raw());
    set(&shaped, "fromDrive", message.kind == MessageKind::SlaveTx);
    set(&shaped, "source", id.source);
    set(&shaped, "destination", id.destination);
    set(&shaped, "values", values);
    set(&shaped, "units", units);
    Some(shaped)
}

fn node_message(frame: &Frame, encoder: bool) -> Option<Object> {
    let decoded = node::decode(frame, encoder).ok()?;
    let message = node::MESSAGES.get(decoded.place)?;
    let (values, units) = (Object::new(), Object::new());
    for (signal, value) in node::signals(decoded.place).iter().zip(decoded.values()) {
        match *value {
            Value::Quantity(value) if value.is_nan() => continue,
            Value::Quantity(value) => set(&values, signal.name, value),
            Value::Number(value) => set(&values, signal.name, value as f64),
            Value::Code(value) => match signal.names.iter().find(|(number, _)| *number == value) {
                Some((_, name)) => set(&values, signal.name, *name),
                None => set(&values, signal.name, value),
            },
        }
        set(&units, signal.name, signal.unit);
    }
    let shaped = Object::new();
    set(&shaped, "protocol", "eddycan");
    set(&shaped, "name", message.name);
    set(&shaped, "fromNode", message.from_node);
    set(&shaped, "values", values);
    set(&shaped, "units", units);
    Some(shaped)
}

/// Returns values and units by field.
pub(crate) fn fields(message: &Message, words: Words) -> (Object, Object) {
    let (values, units) = (Object::new(), Object::new());
    let mut parameter = None;
    for field in message.fields() {
        let raw = field.raw(words);
        if field.meaning == Meaning::ParameterNumber {
            parameter = u16::try_from(raw).ok().and_then(Dictionary::row);
        }
        match (field.meaning, parameter) {
            (Meaning::ParameterValue, Some(row)) => {
                set(&values, field.name, float(row.engineering(raw as i32)));
                set(&units, field.name, unit(row.unit()));
            }
            _ => {
                set(&values, field.name, value(&field, raw));
                set(&units, field.name, unit(field.unit));
            }
        }
    }
    (values, units)
}

/// Returns the fields of STATUS_WORD.
pub(crate) fn status(bits: u32) -> JsValue {
    let words = Words([(bits >> 16) as u16, bits as u16, 0, 0]);
    let found = MESSAGES.iter().find(|message| message.name == "STATUS_WORD");
    found.map_or(JsValue::UNDEFINED, |message| fields(message, words).0.into())
}

fn value(field: &Field, raw: i64) -> JsValue {
    match field.meaning {
        Meaning::Named(names) => match names.values.iter().find(|(number, _)| i64::from(*number) == raw) {
            Some((_, name)) => (*name).into(),
            None => (raw as f64).into(),
        },
        Meaning::Faults => faults(FaultWord::from_bits_retain(raw as u32)).into(),
        _ => float(Decimal { digits: raw, exponent: field.exponent }).into(),
    }
}

/// Returns the names of the set bits.
pub(crate) fn faults(faults: FaultWord) -> Array {
    faults.iter_names().map(|(name, _)| JsValue::from(name.to_ascii_lowercase())).collect()
}

/// Returns the nearest 64-bit float.
pub(crate) fn float(value: Decimal) -> f64 {
    let power = (0..value.exponent.unsigned_abs()).fold(1.0, |power, _| power * 10.0);
    if value.exponent < 0 { value.digits as f64 / power } else { value.digits as f64 * power }
}

/// Returns the unit, or "" where the tables have "-".
pub(crate) fn unit(unit: &'static str) -> &'static str {
    if unit == "-" { "" } else { unit }
}
