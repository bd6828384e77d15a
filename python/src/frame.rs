//! Frames and their messages.

use crate::error;
use crate::master;
use narx_core::bus::narmotion::{Field, MESSAGES, Meaning, Message, MessageId, MessageKind, Opcode, Words};
use narx_core::bus::{Frame, Id};
use narx_core::dictionary::{Decimal, Dictionary};
use narx_core::motor::FaultWord;
use narx_host::can_log::{Value, node};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyFrozenSet};

/// A frame in Python: identifier, extended, remote, data. A remote frame has as many zeros as it requests
/// bytes.
pub(crate) type Parts<'py> = (u32, bool, bool, Bound<'py, PyBytes>);

/// Builds a frame of its parts.
pub(crate) fn new(id: u32, extended: bool, remote: bool, data: &[u8]) -> PyResult<Frame> {
    let number = if extended { Id::extended(id) } else { u16::try_from(id).ok().and_then(Id::standard) };
    let bits = if extended { 29 } else { 11 };
    let number =
        number.ok_or_else(|| error::parameter(format!("identifier {id:#x}: must have {bits} bits")))?;
    let frame = if remote { Frame::remote(number, data.len() as u8) } else { Frame::data(number, data) };
    let frame = frame.filter(|_| data.len() <= 8);
    frame.ok_or_else(|| error::parameter(format!("data of {} bytes: must have at most 8", data.len())))
}

/// Returns the parts of a frame.
pub(crate) fn parts<'py>(py: Python<'py>, frame: &Frame) -> Parts<'py> {
    let zeros = [0; 8];
    let data = if frame.is_remote() { &zeros[..usize::from(frame.dlc().min(8))] } else { frame.payload() };
    (frame.id().raw(), matches!(frame.id(), Id::Extended { .. }), frame.is_remote(), PyBytes::new(py, data))
}

/// A decoded message: name, opcode, true if the drive sends it, source, destination, values and units by
/// field.
type Decoded<'py> = (&'static str, u16, bool, u8, u8, Bound<'py, PyDict>, Bound<'py, PyDict>);

/// Decodes a frame, by the tables of PROTOCOL.md; `None` if the drive's protocol has no such frame.
#[pyfunction]
pub(crate) fn decode<'py>(
    py: Python<'py>,
    id: u32,
    extended: bool,
    remote: bool,
    data: &[u8],
) -> PyResult<Option<Decoded<'py>>> {
    let frame = new(id, extended, remote, data)?;
    let Ok((id, words)) = Words::of(&frame) else { return Ok(None) };
    let Some(message) = find(&id) else { return Ok(None) };
    let (values, units) = fields(py, message, words)?;
    let from_drive = message.kind == MessageKind::SlaveTx;
    Ok(Some((message.name, message.opcode.raw(), from_drive, id.source, id.destination, values, units)))
}

/// A decoded message of eddyCAN: name, true if the node sends it, values and units by signal.
type NodeDecoded<'py> = (&'static str, bool, Bound<'py, PyDict>, Bound<'py, PyDict>);

/// Decodes a frame of a TX-Driver or its master, with an 11-bit identifier; `None` if eddyCAN has no such
/// frame. encoder: PDOs of 8 bytes contain the encoder's value.
#[pyfunction]
pub(crate) fn decode_node<'py>(
    py: Python<'py>,
    id: u32,
    remote: bool,
    data: &[u8],
    encoder: bool,
) -> PyResult<Option<NodeDecoded<'py>>> {
    let frame = new(id, false, remote, data)?;
    let Ok(decoded) = node::decode(&frame, encoder) else { return Ok(None) };
    let message = &node::MESSAGES[decoded.place];
    let (values, units) = (PyDict::new(py), PyDict::new(py));
    for (signal, value) in node::signals(decoded.place).iter().zip(decoded.values()) {
        // Values that the layout does not carry are left out.
        match *value {
            Value::Quantity(value) if value.is_nan() => continue,
            Value::Quantity(value) => values.set_item(signal.name, value)?,
            Value::Number(value) => values.set_item(signal.name, value)?,
            Value::Code(value) => match signal.names.iter().find(|(number, _)| *number == value) {
                Some((_, name)) => values.set_item(signal.name, name)?,
                None => values.set_item(signal.name, value)?,
            },
        }
        units.set_item(signal.name, signal.unit)?;
    }
    Ok(Some((message.name, message.from_node, values, units)))
}

/// Returns the fields of a STATUS_WORD.
pub(crate) fn status(py: Python<'_>, bits: u32) -> PyResult<Bound<'_, PyDict>> {
    let words = Words([(bits >> 16) as u16, bits as u16, 0, 0]);
    match MESSAGES.iter().find(|message| message.opcode == Opcode::STATUS_WORD) {
        Some(message) => Ok(fields(py, message, words)?.0),
        None => Ok(PyDict::new(py)),
    }
}

fn find(id: &MessageId) -> Option<&'static Message> {
    MESSAGES.iter().find(|message| message.opcode == id.opcode && message.kind == id.kind)
}

fn fields<'py>(
    py: Python<'py>,
    message: &Message,
    words: Words,
) -> PyResult<(Bound<'py, PyDict>, Bound<'py, PyDict>)> {
    let (values, units) = (PyDict::new(py), PyDict::new(py));
    let mut parameter = None;
    for field in message.fields() {
        let raw = field.raw(words);
        if field.meaning == Meaning::ParameterNumber {
            parameter = u16::try_from(raw).ok().and_then(Dictionary::row);
        }
        let unit = match (field.meaning, parameter) {
            (Meaning::ParameterValue, Some(row)) => row.unit(),
            _ => field.unit,
        };
        units.set_item(field.name, if unit == "-" { "" } else { unit })?;
        match (field.meaning, parameter) {
            (Meaning::ParameterValue, Some(row)) => {
                set(&values, field.name, row.engineering(raw as i32))?;
            }
            _ => value(py, &values, &field, raw)?,
        }
    }
    Ok((values, units))
}

fn value<'py>(py: Python<'py>, values: &Bound<'py, PyDict>, field: &Field, raw: i64) -> PyResult<()> {
    match field.meaning {
        Meaning::Named(names) => match names.values.iter().find(|(number, _)| i64::from(*number) == raw) {
            Some((_, name)) => values.set_item(field.name, name),
            None => values.set_item(field.name, raw),
        },
        Meaning::Faults => {
            let faults = master::names(FaultWord::from_bits_retain(raw as u32));
            values.set_item(field.name, PyFrozenSet::new(py, faults)?)
        }
        _ => set(values, field.name, Decimal { digits: raw, exponent: field.exponent }),
    }
}

/// Sets a value; whole numbers stay whole.
fn set(values: &Bound<'_, PyDict>, name: &str, value: Decimal) -> PyResult<()> {
    if value.exponent == 0 {
        values.set_item(name, value.digits)
    } else {
        values.set_item(name, float(value))
    }
}

/// Returns the nearest 64-bit float.
pub(crate) fn float(value: Decimal) -> f64 {
    let power = (0..value.exponent.unsigned_abs()).fold(1.0, |power, _| power * 10.0);
    if value.exponent < 0 { value.digits as f64 / power } else { value.digits as f64 * power }
}
